"""What a person looks like: the meshes, and where each stands on the links of the body.

Forms are drawn once, at 1.80 m of stature (`bones`, `flesh`); here they are sized by the
subject's own spine nodes and lengths, so that bones always meet at the joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import bones, flesh
from posture_ik.body.arms import ARM_STATURE
from posture_ik.body.arms import size as arm_size
from posture_ik.body.parts import ZERO, vector
from posture_ik.body.scaling import Scale
from posture_ik.body.solids import Mesh, mirrored, write_obj
from posture_ik.body.urdf import Visual
from posture_ik.problem import SPINE

_FORMS: tuple[Callable[[], Mesh], ...] = (
    *(bones.atlas, bones.cervical, bones.thoracic, bones.lumbar, bones.disc, bones.sacrum),
    *(bones.pelvis, bones.rib, bones.false_rib, bones.sternum, bones.femur, bones.tibia),
    *(flesh.head, flesh.thigh, flesh.shank, flesh.foot),
)
#: Forms of the arms, which are drawn for the right and mirrored for the left.
_ARM_FORMS: tuple[Callable[[], Mesh], ...] = (
    *(bones.clavicle, bones.scapula, bones.humerus, bones.ulna, bones.radius),
    *(flesh.upper_arm, flesh.forearm_ulna, flesh.forearm_radius, flesh.hand),
)
#: Stature that the forms are drawn for, m.
STATURE = 1.80
#: Depth and width of vertebral bodies, m; the levels between lie on straight lines.
_BODIES = {
    "S1": (0.032, 0.048),
    "L5": (0.035, 0.050),
    "L1": (0.032, 0.042),
    "T12": (0.031, 0.039),
    "T6": (0.027, 0.029),
    "T1": (0.018, 0.028),
    "C7": (0.018, 0.026),
    "C2": (0.016, 0.019),
}
#: Depth, width and height that each kind of vertebra is drawn with, m.
_DRAWN = {
    "cervical": (0.016, 0.020, 0.012),
    "thoracic": (0.028, 0.031, 0.022),
    "lumbar": (0.034, 0.046, 0.027),
}
#: Share of the distance between two vertebrae that is bone; the rest is disc.
_BONE = 0.74
#: Half the width of the rib cage, m; the levels between lie on straight lines.
_RIB_WIDTH = {"T1": 0.055, "T2": 0.085, "T3": 0.104, "T5": 0.124, "T8": 0.137, "T10": 0.130}
#: Depth and fall of the ribs that do not reach the sternum, m.
_FALSE_RIBS = {"T8": (0.168, 0.098), "T9": (0.160, 0.098), "T10": (0.142, 0.090)}
#: Notch of the sternum; how far below it the first rib ends and each next one, m; the sternum's
#: slope: how far it comes forward over its fall.
_NOTCH = (0.068, 0.0, 0.588)
_FIRST_RIB, _RIB_STEP, _STERNUM_SLOPE = 0.012, 0.0272, 0.36
#: How deep a true rib's end lies, over its fall: its cartilage rises again.
_RIB_RISE = 0.86
#: The form of a vertebra, by its name or else its first letter.
_FORM_OF = {"S1": "sacrum", "L": "lumbar", "T": "thoracic", "C": "cervical", "C1": "atlas"}
#: How far ahead of the hip's frame a thigh starts, and its length and a shank's as drawn, m.
_THIGH_START, _THIGH, _SHANK = 0.03, 0.44, 0.42

Colour = tuple[float, float, float, float]
BONE: Colour = (0.93, 0.90, 0.83, 1.0)
CARTILAGE: Colour = (0.78, 0.82, 0.85, 1.0)
FLESH: Colour = (0.74, 0.77, 0.80, 1.0)
GLASS: Colour = (0.56, 0.66, 0.74, 0.42)


def meshes() -> dict[str, Mesh]:
    """Every mesh by the name of its file: `head`, `hand_r`, `hand_l` ..."""
    found = {form.__name__: form() for form in _FORMS}
    for form in _ARM_FORMS:
        right = form()
        found |= {f"{form.__name__}_r": right, f"{form.__name__}_l": mirrored(right, axis=2)}
    return found


def write_meshes(folder: Path) -> None:
    """Write every mesh as OBJ into a folder that exists."""
    for name, shape in meshes().items():
        write_obj(shape, folder / f"{name}.obj")


def visuals(nodes: Mapping[str, Array], scale: Scale) -> list[Visual]:
    """Stand the forms on the links of a body.

    Args:
        nodes: place of every spine body in the reference shape, (3,), m; axes of its link are
            parallel to the world's there.
        scale: The subject over the reference subject: bones grow with stature, ribs with the
            chest's height, they and flesh across with its depth, arms with their own length.
    """
    girth, _, chest = scale.length["thoracic"]
    height = scale.stature
    return [
        Visual("Head", _mesh("head"), (height,) * 3, rgba=FLESH),
        *_spine(nodes, height),
        *_chest(nodes, girth, chest),
        *_legs(girth, height),
        *_arms(girth, arm_size(scale)),
    ]


def _mesh(name: str) -> str:
    return f"meshes/{name}.obj"


def _between(table: Mapping[str, float | tuple[float, float]], level: str) -> Array:
    """A table's value at a level, straight lines between the levels it names."""
    at = [SPINE.index(name) for name in table]
    order = np.argsort(at)
    rows = np.array([np.atleast_1d(value) for value in table.values()])[order]
    return np.array([np.interp(SPINE.index(level), np.sort(at), column) for column in rows.T])


def _lean(lower: Array, upper: Array) -> float:
    """Pitch about y that turns z onto the line from one node to another, rad."""
    rise = upper - lower
    return float(np.arctan2(rise[0], rise[2]))


def _spine(nodes: Mapping[str, Array], size: float) -> Iterator[Visual]:
    """Vertebrae along the tangent of the spine, and between them discs that fill the gaps.

    A disc hangs on its upper vertebra, as the coordinates of its joint do.
    """
    place = np.array([nodes[name] for name in SPINE])
    gap = np.linalg.norm(np.diff(place, axis=0), axis=1)
    height = _BONE * np.array([gap[0], *(gap[:-1] + gap[1:]) / 2, gap[-1] / 2])
    yield Visual("S1", _mesh("pelvis"), (size,) * 3, rgba=BONE)
    for i, name in enumerate(SPINE[:-1]):
        turn = (0.0, _lean(place[max(i - 1, 0)], place[i + 1]), 0.0)
        breadth = size * _between(_BODIES, name)
        form = _FORM_OF.get(name) or _FORM_OF[name[0]]
        scale = (size,) * 3
        if form in _DRAWN:
            scale = vector(np.array([*breadth, height[i]]) / _DRAWN[form])
        yield Visual(name, _mesh(form), scale, rpy=turn, rgba=BONE)
        along = (place[i + 1] - place[i]) / gap[i]
        low, high = place[i] + along * height[i] / 2, place[i + 1] - along * height[i + 1] / 2
        # A little thicker than the gap, so that no light falls between disc and bone.
        thickness = float((high - low) @ along) + 0.0015
        yield Visual(
            SPINE[i + 1],
            _mesh("disc"),
            vector(np.array([*(0.98 * breadth), thickness])),
            vector((low + high) / 2 - place[i + 1]),
            (0.0, _lean(low, high), 0.0),
            CARTILAGE,
        )


def _chest(nodes: Mapping[str, Array], girth: float, height: float) -> Iterator[Visual]:
    """Ten pairs of ribs on their vertebrae, and the sternum on T4."""
    notch = np.array([girth, girth, height]) * _NOTCH
    yield Visual("T4", _mesh("sternum"), (height,) * 3, vector(notch - nodes["T4"]), rgba=BONE)
    for i in range(1, 11):
        name = f"T{i}"
        width = girth * float(_between(_RIB_WIDTH, name)[0])
        if name in _FALSE_RIBS:
            form = "false_rib"
            depth, fall = np.multiply(_FALSE_RIBS[name], (girth, height))
        else:
            form = "rib"
            down = height * (_FIRST_RIB + _RIB_STEP * (i - 1))
            depth = notch[0] + _STERNUM_SLOPE * down - nodes[name][0]
            fall = (nodes[name][2] - notch[2] + down) / _RIB_RISE
        yield Visual(name, _mesh(form), (float(depth), width, float(fall)), rgba=BONE)


def _legs(girth: float, height: float) -> Iterator[Visual]:
    """Thighs on the seat, shanks and feet on the floor: they do not move."""
    thigh = height * (0.245 * STATURE - _THIGH_START) / _THIGH
    shank = height * 0.246 * STATURE / _SHANK
    start = (height * _THIGH_START, 0.0, 0.0)
    for side in ("r", "l"):
        for part, bone, along, begin in (
            ("thigh", "femur", (thigh, girth, height), start),
            ("shank", "tibia", (girth, girth, shank), ZERO),
        ):
            yield Visual(f"{part}_{side}", _mesh(bone), (height,) * 3, rgba=BONE)
            yield Visual(f"{part}_{side}", _mesh(part), along, begin, rgba=GLASS)
        yield Visual(f"foot_{side}", _mesh("foot"), (height,) * 3, rgba=FLESH)


def _arms(girth: float, size: float) -> Iterator[Visual]:
    """Bones and flesh of both arms, with the shoulders."""
    across = girth * STATURE / ARM_STATURE
    stout = (across, size, across)
    for side in ("r", "l"):
        for link, form, scale, colour in (
            ("clavicle", "clavicle", (size,) * 3, BONE),
            ("scapula", "scapula", (size,) * 3, BONE),
            ("humerus", "humerus", (size,) * 3, BONE),
            ("ulna", "ulna", (size,) * 3, BONE),
            ("radius", "radius", (size,) * 3, BONE),
            ("humerus", "upper_arm", stout, GLASS),
            ("ulna", "forearm_ulna", stout, GLASS),
            ("radius", "forearm_radius", stout, GLASS),
            ("hand", "hand", (size,) * 3, FLESH),
        ):
            yield Visual(f"{link}_{side}", _mesh(f"{form}_{side}"), scale, rgba=colour)
