"""What moves in a mode, in words: by the names of a model's coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from posture_ik.problem import SPINE
from posture_ik.vibration.system import Complex, LinearSystem

#: What a mode moves is told from the largest share down to this.
_TOLD = 0.15
#: Joints between bodies bend or stretch, bodies on their own move.
_BENDS = {
    "axial": "stretch of",
    "rx": "lateral bending of",
    "ry": "fore-and-aft bending of",
    "rz": "twist of",
}
_MOVES = {
    "x": "fore-and-aft motion of",
    "y": "lateral motion of",
    "z": "vertical motion of",
    "rx": "roll of",
    "ry": "pitch of",
    "rz": "twist of",
    "axial": "vertical motion of",
}


def is_odd(coordinate: str) -> bool:
    """Whether a coordinate changes its sign in the mirror that swaps left and right."""
    return _joined(coordinate).endswith(("_y", "_rx", "_rz", "_lateral"))


def told(system: LinearSystem, shapes: Complex) -> list[str]:
    """What moves in each mode: shares of its energy, and which way the head goes.

    Energy is that of the springs where coordinates are those of joints, which would all share in
    one body's motion, and else that of motion.

    Args:
        system: whose modes.
        shapes: phi of each, (n, m).
    """
    of_joints = any(name.endswith("_axial") for name in system.coordinates)
    matrix = system.stiffness if of_joints else system.mass
    energies = np.abs((shapes.conj() * (matrix @ shapes)).real)
    parts = [_part(name) for name in system.coordinates]
    known = sorted(set(parts))
    gather = np.array([[part == of for part in parts] for of in known], dtype=float)
    shares = gather @ (energies / np.maximum(energies.sum(axis=0), np.finfo(float).tiny))
    heads = _of_head(system, shapes)
    words = []
    for share, head in zip(shares.T, heads, strict=True):
        ranked = np.argsort(-share)
        most = [i for i in ranked if share[i] >= _TOLD] or ranked[:1]
        words.append(", ".join(f"{known[i]} ({share[i]:.0%})" for i in most) + head)
    return words


def _of_head(system: LinearSystem, shapes: Complex) -> Sequence[str]:
    place = {port.name: i for i, port in enumerate(system.outputs)}
    said = ("fore and aft", "sideways", "up and down")
    for order, name in ((0, "Head"), (2, "Head acceleration")):
        ways = [f"{name} {axis}" for axis in "xyz"]
        if place.keys() >= set(ways):
            travel = np.abs(system.Y[order, [place[way] for way in ways]] @ shapes)
            return [f"; the head goes {said[i]}" for i in np.argmax(travel, axis=0)]
    return [""] * shapes.shape[1]


def _joined(coordinate: str) -> str:
    """A coordinate's name as the joints' are: of `Head y`, a body's own motion, `Head_y`."""
    return coordinate.replace(" ", "_")


def _part(name: str) -> str:
    """What a coordinate moves: `fore-and-aft bending of the lumbar spine`."""
    if name.startswith("lever_"):
        return "swing of a lever"
    body, _, component = _joined(name).rpartition("_")
    upper = body.partition("_")[0]
    if component in ("l", "r"):
        return "swing of the arms"
    if upper.endswith("V") and upper[:-1] in SPINE:
        return f"{_MOVES.get(component, 'motion of')} the viscera"
    if upper == "buttocks":
        return f"{_MOVES[component]} the pelvis on the buttocks"
    if upper == "Head" or upper in SPINE:
        words = _BENDS if "_" in body else _MOVES
        where = _region(body) if "_" in body else _place(upper)
        return f"{words.get(component, 'motion of')} the {where}"
    if name in ("seat z", "cushion z"):
        return f"{_MOVES['z']} the {body}"
    return f"motion of {name}"


def _region(joint: str) -> str:
    """Where a joint between two bodies lies."""
    lower = joint.partition("_")[2]
    if lower.startswith("C") or joint == "C7_T1":
        return "neck"
    return "thoracic spine" if lower.startswith("T") else "lumbar spine"


def _place(body: str) -> str:
    if body == "Head":
        return "head"
    return {"C": "neck", "T": "thoracic spine", "L": "lumbar spine", "S": "pelvis"}[body[0]]
