"""The arms: seven hinges each, after the `myo-sim` arm, hung on T2 at table 8's arm nodes.

Frames are those of the `myo-sim` bodies, x forward, y up the hanging limb, z to the right, so that
its muscles attach unmoved. The left arm is the right one mirrored: equal joint values, mirrored
poses. The arm is that of a man of median stature; the reference subject's is longer by the ratio of
their statures, another's by the law of scaling on top of it. Masses are scaled to what table 9
lumps at the shoulder; inertias follow as mass times length². Scapula and clavicle are fixed, their
masses counted in the trunk's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.parts import ZERO, Inertia, Joint, Vector, vector
from posture_ik.body.scaling import REFERENCE, Scale
from posture_ik.body.tables import numbers, table

#: Stature of the man whose arm it is (the median of the 4082 men of ANSUR II), m.
ARM_STATURE = 1.755
SIDES = ("r", "l")
ARM_JOINTS = (
    *("shoulder_flexion", "shoulder_abduction", "shoulder_rotation", "elbow_flexion"),
    *("pronation", "wrist_deviation", "wrist_flexion"),
)
#: Links with a name of their own at the end of a joint; the others are massless in-betweens.
_LINKS = {
    "shoulder_rotation": "humerus",
    "elbow_flexion": "ulna",
    "pronation": "radius",
    "wrist_flexion": "hand",
}
#: From the axes of a vertebra to those of the hanging arm.
_HANGING: Vector = (float(np.pi / 2), 0.0, 0.0)
_MIRROR = np.array([1.0, 1.0, -1.0])


def size(scale: Scale) -> float:
    """Lengths of a subject's arms over those of the arm in the tables."""
    return scale.arm * REFERENCE.stature / ARM_STATURE


def joints(nodes: Mapping[str, Array], length: float) -> Iterator[Joint]:
    """Hinges and fixed frames of both arms of a subject with these nodes, of this `size`."""
    for side in SIDES:
        yield from _arm(side, nodes[f"{side.upper()}_arm"] - nodes["T2"], length)


def _arm(side: str, shoulder: Array, length: float) -> Iterator[Joint]:
    mirror = np.ones(3) if side == "r" else _MIRROR
    hanging = pin.rpy.rpyToMatrix(*_HANGING)
    grips = []
    for link, row in table("arm_frames").items():
        point = length * mirror * numbers(row, "x_m", "y_m", "z_m")
        R = np.array(numbers(row, *(f"r{i}{j}" for i in "123" for j in "123"))).reshape(3, 3)
        mount, child = f"{link}_{side}_mount", f"{link}_{side}"
        if link == "grip":
            # a frame of the world's axes on either side, so turned alike, not mirrored
            rpy = vector(pin.rpy.matrixToRpy(R))
            grips.append(Joint(mount, "fixed", f"hand_{side}", child, vector(point), rpy))
        else:
            rpy = vector(pin.rpy.matrixToRpy(hanging @ (R * np.outer(mirror, mirror))))
            place = vector(shoulder + hanging @ point)
            yield Joint(mount, "fixed", "T2", child, place, rpy)
    parent, rpy = "T2", _HANGING
    for name, row in table("arm_joints").items():
        point = length * mirror * numbers(row, "x_m", "y_m", "z_m")
        xyz = vector(shoulder + point if parent == "T2" else point)
        # an axis of rotation is a pseudovector: a mirror turns what lies in its plane
        axis = np.array(numbers(row, "axis_x", "axis_y", "axis_z")) * mirror * mirror.prod()
        child = f"{_LINKS[name]}_{side}" if name in _LINKS else f"{name}_{side}_link"
        unit = vector(axis / np.linalg.norm(axis))
        yield Joint(f"{name}_{side}", "revolute", parent, child, xyz, rpy, unit)
        parent, rpy = child, ZERO
    yield from grips


def inertias(scale: Scale) -> dict[str, Inertia]:
    """Of humerus, ulna, radius and hand of both arms."""
    lumped = table("table_9_masses")
    rows = table("arm_bodies")
    total = sum(float(row["mass_kg"]) for row in rows.values())
    length = size(scale)
    found = {}
    for side in SIDES:
        mirror = np.ones(3) if side == "r" else _MIRROR
        mass = scale.mass["arm"] * float(lumped[f"{side.upper()}_arm"]["mass_kg"]) / total
        for link, row in rows.items():
            centre = length * mirror * numbers(row, "x_m", "y_m", "z_m")
            xx, xy, xz, yy, yz, zz = numbers(
                row, *(f"i{ij}_kg_m2" for ij in ("xx", "xy", "xz", "yy", "yz", "zz"))
            )
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            tensor = mass * length**2 * tensor * np.outer(mirror, mirror)
            found[f"{link}_{side}"] = Inertia(mass * float(row["mass_kg"]), centre, tensor)
    return found
