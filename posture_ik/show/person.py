"""The seated person as a line drawing, from the side or from the front.

Vertebrae and joints stand where the kinematics puts them. Skin, ribs and limbs are for the eye:
fixed proportions (metres at a stature of 1.80 m) that ride on the frames of the body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from posture_ik.kinematics import frame_poses
from posture_ik.posture import Posture, Wrench
from posture_ik.problem import SPINE
from posture_ik.show.forces import draw_forces
from posture_ik.show.paper import Array, Paper, View, arrow, sheet, text

#: Height of the head's frame above the seat at a stature of 1.80 m (table 8).
_HEAD_HEIGHT = 0.75375
#: Skin around a vertebra in its own axes: front, back, half width (m).
_SKIN = {
    "S1": (0.125, 0.105, 0.180),
    "L5": (0.145, 0.108, 0.170),
    "L3": (0.130, 0.112, 0.148),
    "L1": (0.135, 0.105, 0.142),
    "T11": (0.160, 0.088, 0.146),
    "T8": (0.172, 0.070, 0.156),
    "T5": (0.148, 0.080, 0.165),
    "T3": (0.110, 0.088, 0.180),
    "T1": (0.062, 0.078, 0.120),
    "C6": (0.054, 0.070, 0.062),
    "C3": (0.058, 0.062, 0.056),
    "C1": (0.060, 0.048, 0.056),
}
#: Outline of the head about its frame: the profile (x, z) and half the face (y, z), m.
_PROFILE = (
    *((-0.062, -0.080), (-0.090, -0.030), (-0.100, 0.030), (-0.086, 0.085), (-0.045, 0.120)),
    *((0.010, 0.130), (0.060, 0.116), (0.089, 0.080), (0.096, 0.045), (0.095, 0.022)),
    *((0.119, -0.018), (0.101, -0.028), (0.104, -0.048), (0.095, -0.062), (0.098, -0.090)),
    *((0.078, -0.106), (0.030, -0.088), (0.000, -0.090)),
)
_FACE = (
    *((0.0, 0.130), (0.045, 0.118), (0.072, 0.075), (0.078, 0.020)),
    *((0.070, -0.035), (0.052, -0.080), (0.020, -0.106)),
)
_EYE = (0.080, 0.032, 0.018)
#: Limbs: from, to, and the radius at either end (m); frames of an arm, points of the left leg.
_ARM = (
    ("humerus", "ulna", 0.050, 0.040),
    ("ulna", "hand", 0.040, 0.027),
    ("hand", "grip", 0.030, 0.030),
)
_LEG = (
    ((0.02, 0.095, 0.082), (0.47, 0.12, 0.068), 0.080, 0.062),
    ((0.47, 0.12, 0.068), (0.50, 0.12, -0.36), 0.058, 0.042),
)
#: Number of the rib against its depth and half width (m).
_RIBS = ((1, 3, 8, 10), (0.050, 0.095, 0.150, 0.135), (0.060, 0.105, 0.135, 0.125))
#: Half the depth of a vertebra's body, and how far its process reaches back (m).
_VERTEBRA = {
    "cervical": (0.009, 0.038),
    "thoracic": (0.014, 0.052),
    "lumbar": (0.018, 0.060),
    "pelvis": (0.018, 0.040),
}
#: Outline of the pelvis about S1: from the side (x, z), and its left half from the front (y, z), m.
_PELVIS_SIDE = (
    *((-0.055, 0.030), (-0.020, 0.058), (0.040, 0.050), (0.072, 0.022), (0.060, -0.012)),
    *((0.072, -0.045), (0.020, -0.070), (-0.020, -0.062), (-0.028, -0.025)),
)
_PELVIS_FRONT = (
    *((0.0, 0.012), (0.045, 0.030), (0.095, 0.060), (0.132, 0.048), (0.128, 0.010)),
    *((0.095, -0.025), (0.075, -0.068), (0.050, -0.062), (0.035, -0.035), (0.0, -0.035)),
)

Frames = Mapping[str, pin.SE3]


def region(name: str) -> str:
    """Name the region of a joint or of a vertebra: `L4_L5_ry` and `L4` are lumbar."""
    if name.startswith("lever_"):
        return "levers"
    if name.startswith(("Head", "C")):
        return "cervical"
    return {"T": "thoracic", "L": "lumbar", "S": "pelvis", "b": "pelvis"}.get(name[0], "arms")


@dataclass(frozen=True)
class _Scene:
    """What a drawing shows: frames now and in the reference shape, the seat, what holds them."""

    now: Frames
    reference: Frames
    recline: float
    wrenches: Sequence[Wrench]
    paper: Paper
    size: float

    def placed(self, frame: pin.SE3, points: ArrayLike) -> Array:
        """Carry points (k, 3) of a frame, sized for the subject, into the world."""
        local = self.size * np.atleast_2d(np.asarray(points, float))
        return np.asarray(frame.translation + local @ frame.rotation.T)


def draw_before(posture: Posture, view: View) -> str:
    """Draw the reference shape on the upright seat as an SVG element with equal axes in m."""
    return _draw(posture, view, before=True)


def draw_after(posture: Posture, view: View) -> str:
    """Draw the posture found, what holds it, and the reference shape as a dashed line."""
    return _draw(posture, view, before=False)


def draw_moments(
    postures: Sequence[Posture], titles: Sequence[str], ways: Mapping[str, Array]
) -> list[str]:
    """Draw moments of a motion from the side, all in one window, with ways (k, 3) by name."""
    return [
        _draw(posture, "side", False, title, postures, ways)
        for posture, title in zip(postures, titles, strict=True)
    ]


def _draw(
    posture: Posture,
    view: View,
    before: bool,
    title: str = "",
    moments: Sequence[Posture] = (),
    ways: Mapping[str, Array] | None = None,
) -> str:
    reference = frame_poses(posture.body.model, posture.body.q_reference)
    scene = _Scene(
        now=reference if before else posture.frames,
        reference=reference,
        recline=0.0 if before else np.radians(posture.problem.seat.recline_deg),
        wrenches=() if before or moments else (*posture.wrenches, posture.seat),
        paper=Paper(view),
        size=float(reference["Head"].translation[2]) / _HEAD_HEIGHT,
    )
    layers = [_seat(scene), _flesh(scene), _bones(scene)]
    if not before:
        layers.append(_ghost(scene))
    shown = [reference, *(each.frames for each in moments or (posture,))]
    on = scene.paper.project([pose.translation for frames in shown for pose in frames.values()])
    # Room for forces and their labels, where there are any.
    beside = 230.0 if moments else 400.0 if view == "side" else 200.0
    margin = scene.size * np.array([beside, 200.0])
    low, high = on.min(axis=0) - margin, on.max(axis=0) + margin
    high[1] = 240.0 * scene.size
    if view == "side":
        high[0] = max(on.max(axis=0)[0] + 200.0, 640.0 * scene.size)
    layers += [_spine(scene), _gaze(scene), draw_forces(scene.paper, scene.wrenches, low, high)]
    for name, way in (ways or {}).items():
        layers.append(scene.paper.curve(way, f"way {name.replace(' ', '-')}"))
    title = title or ("Before" if before else "After") + f", from the {view}"
    axes = "metres " + ("forward" if view == "side" else "to the person's left") + " and up"
    return sheet("".join(layers), low, high, title, axes)


def _seat(scene: _Scene) -> str:
    """Seat pan, and a backrest turned back about the seat by the recline."""
    turn = pin.SE3(pin.utils.rotate("y", -scene.recline), np.zeros(3))
    here = pin.SE3.Identity()
    pan: list[tuple[float, float, float]]
    rest: list[tuple[float, float, float]]
    if scene.paper.view == "side":
        pan = [(-0.13, 0, 0), (0.41, 0, 0), (0.41, 0, -0.05), (-0.13, 0, -0.05)]
        rest = [(-0.094, 0, 0.11), (-0.094, 0, 0.68), (-0.134, 0, 0.68), (-0.134, 0, 0.11)]
    else:
        pan = [(0, -0.24, 0), (0, 0.24, 0), (0, 0.24, -0.05), (0, -0.24, -0.05)]
        rest = [(-0.1, -0.21, 0.05), (-0.1, 0.21, 0.05), (-0.1, 0.21, 0.68), (-0.1, -0.21, 0.68)]
    shapes = ((turn, rest), (here, pan))
    return "".join(scene.paper.polygon(scene.placed(at, p), "seat") for at, p in shapes)


def _trunk(scene: _Scene, frames: Frames) -> Array:
    """The skin of trunk and neck, from the seat up one side and down the other, (k, 3)."""
    side = scene.paper.view == "side"
    rows = [
        [(-back, 0, 0), (front, 0, 0)] if side else [(0, -half, 0), (0, half, 0)]
        for front, back, half in _SKIN.values()
    ]
    ends = [scene.placed(frames[body], row) for body, row in zip(_SKIN, rows, strict=True)]
    near, far = np.swapaxes(ends, 0, 1)
    bottom = (
        [(0.06, 0, 0.004), (-0.05, 0, 0), (-0.09, 0, 0.03)]
        if side
        else [(0, 0.16, 0), (0, -0.16, 0)]
    )
    return np.vstack([scene.size * np.array(bottom), near, far[::-1]])


def _head(scene: _Scene, frames: Frames) -> tuple[Array, Array]:
    """Closed outlines of the head, (k, 3): its profile and its face."""
    profile = [(x, 0.0, z) for x, z in _PROFILE]
    return scene.placed(frames["Head"], profile), scene.placed(frames["Head"], _mirrored(_FACE))


def _mirrored(half: Sequence[tuple[float, float]]) -> list[tuple[float, float, float]]:
    """A closed outline across the body from its left half (y, z)."""
    left = [(0.0, y, z) for y, z in half]
    return left + [(0.0, -y, z) for y, z in reversed(half) if y > 0.0]


def _flesh(scene: _Scene) -> str:
    """Left arm, then trunk, head and legs, then right arm: each group outlined as one shape."""
    paper, size = scene.paper, scene.size

    def limb(start: ArrayLike, end: ArrayLike, a: float, b: float) -> str:
        return paper.limb(start, end, (a * size, b * size), "{}")

    outlines = (_trunk(scene, scene.now), *_head(scene, scene.now))
    trunk = [paper.curve(outline, "{}", closed=True) for outline in outlines]
    trunk += [
        limb(np.multiply(start, mirror), np.multiply(end, mirror), a, b)
        for mirror in ((size, size, size), (size, -size, size))
        for start, end, a, b in _LEG
    ]
    left, right = (
        [
            limb(scene.now[f"{a}_{s}"].translation, scene.now[f"{b}_{s}"].translation, *radii)
            for a, b, *radii in _ARM
        ]
        for s in ("l", "r")
    )
    # Edges first, fillings over them, so that lines inside a group vanish.
    return "".join(
        "".join(group).replace("{}", f"{layer} {name}")
        for name, group in (("far", left), ("trunk", trunk), ("near", right))
        for layer in ("edge", "flesh")
    )


def _bones(scene: _Scene) -> str:
    """The pelvis, and ten pairs of ribs: each half an ellipse that sinks towards the front."""
    side_view = scene.paper.view == "side"
    outline = [(x, 0.0, z) for x, z in _PELVIS_SIDE] if side_view else _mirrored(_PELVIS_FRONT)
    drawn = [scene.paper.curve(scene.placed(scene.now["S1"], outline), "hip", closed=True)]
    turn = np.linspace(0.0, 0.85 * np.pi, 9)
    numbers, depths, halves = _RIBS
    for number in range(1, 11):
        depth, half = np.interp(number, numbers, depths), np.interp(number, numbers, halves)
        forward, down = depth * (1.0 - np.cos(turn)) / 2.0, -0.07 * turn / np.pi
        for side in (-half, half):
            rib = np.column_stack([forward, side * np.sin(turn), down])
            drawn.append(scene.paper.curve(scene.placed(scene.now[f"T{number}"], rib), "rib"))
    return "".join(drawn)


def _spine(scene: _Scene) -> str:
    """Each vertebra as a box along the spine's axis, from the side with its spinous process."""
    nodes = np.array([scene.reference[name].translation for name in SPINE])
    gaps = np.linalg.norm(np.diff(nodes, axis=0), axis=1) / scene.size
    drawn = []
    for i, name in enumerate(SPINE[:-1]):
        chord = nodes[i + 1] - nodes[max(i - 1, 0)]
        up = chord / np.linalg.norm(chord)
        forward = np.array([up[2], 0.0, -up[0]])
        height = 0.36 * min(gaps[max(i - 1, 0)], gaps[i])
        depth, reach = _VERTEBRA[region(name)]
        corners = [
            depth * (a * forward + np.array([0.0, 1.25 * b, 0.0])) + c * height * up
            for a in (-1, 1)
            for b in (-1, 1)
            for c in (-1, 1)
        ]
        if scene.paper.view == "side":
            process = scene.placed(scene.now[name], [(0, 0, 0), (-reach, 0, -0.3 * reach)])
            drawn.append(scene.paper.curve(process, f"process {region(name)}"))
        box = scene.placed(scene.now[name], corners)
        drawn.append(scene.paper.hull(box, f"vertebra {region(name)}"))
    return "".join(drawn)


def _ghost(scene: _Scene) -> str:
    profile, face = _head(scene, scene.reference)
    head = profile if scene.paper.view == "side" else face
    nodes = [scene.reference[name].translation for name in SPINE]
    outlines = (_trunk(scene, scene.reference), head)
    lines = [scene.paper.curve(outline, "ghost", closed=True) for outline in outlines]
    return scene.paper.curve(nodes, "ghost") + "".join(lines)


def _gaze(scene: _Scene) -> str:
    """Eyes, and the line of sight where it does not point at the reader."""
    x, y, z = _EYE
    head = scene.now["Head"]
    drawn = scene.paper.dots(scene.placed(head, [(x, y, z), (x, -y, z)]), 0.006, "eye")
    tail, tip = scene.paper.project(scene.placed(head, [(x + 0.05, 0, z), (x + 0.28, 0, z)]))
    if np.linalg.norm(tip - tail) < 60.0:
        return drawn
    return drawn + arrow(tail, tip, "sight") + text(tip + np.array([0.0, 9.0]), "gaze", "sight")
