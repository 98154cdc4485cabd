"""Which part of the person carries what: strain energy by link, and the colour that shows it."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import NamedTuple

import numpy as np

from posture_ik.posture import Posture

#: Colours from no strain energy to the most, 0 to 1; darker throughout, for eyes of every kind.
RAMP = (
    (0.95, 0.91, 0.80),
    (0.97, 0.77, 0.36),
    (0.90, 0.42, 0.20),
    (0.74, 0.13, 0.22),
    (0.38, 0.04, 0.20),
)


class Part(NamedTuple):
    """A link, and the joints between it and the shown link before it.

    Attributes:
        joint: the joints' common name, such as `L4_L5` or `elbow_flexion_r`.
        energy: strain energy of their springs, J.
        dofs: their degrees of freedom, in the order of the model.
    """

    joint: str
    energy: float
    dofs: tuple[int, ...]


def parts_of(posture: Posture, shown: Set[str]) -> dict[str, Part]:
    """The joints that each shown link hangs on, by link; links on no joint are left out.

    Args:
        posture: whose energies count.
        shown: links that can be seen.
    """
    model = posture.body.model
    joint_of = {frame.name: frame.parentJoint for frame in model.frames if frame.name in shown}
    owners = set(joint_of.values())
    parts = {}
    for link, joint in joint_of.items():
        chain: list[int] = []
        while joint and (not chain or joint not in owners):
            chain.append(joint - 1)  # joint 0 is the universe; every other has one coordinate
            joint = model.parents[joint]
        if chain:
            dofs = chain[::-1]
            name = _name([posture.body.dofs[i] for i in dofs])
            parts[link] = Part(name, float(posture.energies[dofs].sum()), tuple(dofs))
    return parts


def _name(dofs: list[str]) -> str:
    """Name a joint by what its degrees of freedom share: `L4_L5`, `shoulder_r`."""
    if len(dofs) == 1:
        return dofs[0]
    side = dofs[0][-2:] if dofs[0].endswith(("_r", "_l")) else ""
    words = [dof.removesuffix(side).split("_") for dof in dofs]
    shared = [group[0] for group in zip(*words, strict=False) if len(set(group)) == 1]
    return "_".join(shared or words[0]) + side


def action(dof: str) -> str:
    """What a degree of freedom does, in words."""
    words = {
        "axial": "stretch",
        "rx": "bending to the right",
        "ry": "flexion",
        "rz": "turn to the left",
    }
    stem, _, last = dof.rpartition("_")
    return words.get(last) or stem.replace("_", " ")


def full_scale(parts: Mapping[str, Part]) -> float:
    """The energy at the dark end of the scale: 1, 2 or 5 times a power of ten, J; 0 if all is 0."""
    largest = max((part.energy for part in parts.values()), default=0.0)
    if largest < 1e-9:
        return 0.0
    decade = 10.0 ** np.floor(np.log10(largest))
    return float(next(m * decade for m in (1, 2, 5, 10) if m * decade >= largest * (1 - 1e-9)))


def place_on_scale(energy: float, full: float) -> float:
    """Where an energy stands on the scale, 0 to 1: it goes with the root.

    Energies of joints differ by orders of magnitude; what people compare, displacement and moment,
    goes as the root.
    """
    return float(np.sqrt(energy / full)) if full > 0.0 else 0.0


def colour(energy: float, full: float, pale: tuple[float, ...]) -> tuple[float, ...]:
    """The colour of a part, grown from its own pale one with the energy of its joint."""
    t = place_on_scale(energy, full)
    ramp = [
        np.interp(t, np.linspace(0.0, 1.0, len(RAMP)), channel)
        for channel in zip(*RAMP, strict=True)
    ]
    share = min(t / 0.12, 1.0)
    return tuple(float((1 - share) * p + share * r) for p, r in zip(pale, ramp, strict=True))
