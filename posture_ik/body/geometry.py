"""A subject's body as plain data: points, joints, inertias, springs and ranges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import radians

from posture_ik.arrays import Array
from posture_ik.body import arms, spine
from posture_ik.body.laws import scale_of
from posture_ik.body.parts import Inertia, Joint
from posture_ik.body.scaling import REFERENCE, Scale, region_of_joint
from posture_ik.body.tables import table
from posture_ik.problem import Subject

DOFS = (*spine.SPINE_DOFS, *(f"{joint}_{side}" for side in arms.SIDES for joint in arms.ARM_JOINTS))
#: Damping over stiffness of the arms' joints, s (assumed, as the source's for the buttocks).
ARM_DAMPING_TIME = 0.025
#: The legs over stature, for the eye only: the hip's place, then down the chain to knee and ankle
#: (segment lengths after Drillis & Contini 1966; the hip so that a level thigh lies on the seat).
_HIP, _THIGH, _SHANK = (0.010 / 1.8, 0.09 / 1.8, 0.09 / 1.8), 0.245, 0.246


@dataclass(frozen=True)
class BodyGeometry:
    """Everything a URDF and the springs of a body are written from.

    Attributes:
        subject: Who.
        scale: Factors over the reference subject.
        nodes: Points of table 8 by label, (3,), m, in the reference shape.
        joints: Every joint, fixed ones too; a parent stands before its children.
        inertias: By link; other links have no mass.
        lower: Limit by degree of freedom, m or rad.
        upper: Limit by degree of freedom, m or rad.
        stiffness: By degree of freedom, N/m or N m/rad.
        damping: By degree of freedom, N s/m or N m s/rad.
        reference: Reference shape by degree of freedom: spine at 0, hands on the thighs.
    """

    subject: Subject
    scale: Scale
    nodes: Mapping[str, Array]
    joints: tuple[Joint, ...]
    inertias: Mapping[str, Inertia]
    lower: Mapping[str, float]
    upper: Mapping[str, float]
    stiffness: Mapping[str, float]
    damping: Mapping[str, float]
    reference: Mapping[str, float]

    @classmethod
    def of(cls, subject: Subject) -> BodyGeometry:
        """The body of a subject."""
        scale = scale_of(subject)
        nodes = spine.nodes(scale)
        stiffness, damping = _springs(scale)
        ranges = {dof: _range(dof, scale) for dof in DOFS}
        return cls(
            subject,
            scale,
            nodes,
            (
                *spine.joints(nodes),
                *arms.joints(nodes, arms.size(scale)),
                *_legs(scale.stature * REFERENCE.stature),
            ),
            spine.inertias(scale) | arms.inertias(scale),
            {dof: low for dof, (low, _) in ranges.items()},
            {dof: high for dof, (_, high) in ranges.items()},
            stiffness,
            damping,
            {dof: _reference(dof) for dof in DOFS},
        )


def _springs(scale: Scale) -> tuple[dict[str, float], dict[str, float]]:
    """Stiffness and damping of each degree of freedom (tables 11 and 10, §4.2.3; arms assumed)."""
    stiffness, damping = {}, {}
    for joint in spine.SPINE_JOINTS:
        for i, component in zip("3456", spine.COMPONENTS, strict=True):
            dof = f"{joint}_{component}"
            per = "m" if component == "axial" else "m_rad"
            per_speed = "s_m" if component == "axial" else "m_s_rad"
            if dof not in DOFS:
                continue
            if joint == "buttocks_S1":
                k = table("buttocks")[dof][f"stiffness_N_{per}"]
                c = table("buttocks")[dof][f"damping_N_{per_speed}"]
            else:
                k = table("table_11_stiffness")[joint][f"k{i}{i}_N_{per}"]
                c = table("table_10_damping")[joint][f"c{i}{i}_N_{per_speed}"]
            region = region_of_joint(joint)
            stiffness[dof] = float(k) * scale.stiffness(region, component)
            damping[dof] = float(c) * scale.damping(region, component)
    for dof in DOFS:
        if dof not in stiffness:
            stiffness[dof] = float(table("arm_springs")[dof[:-2]]["stiffness_N_m_rad"])
            damping[dof] = ARM_DAMPING_TIME * stiffness[dof]
    return stiffness, damping


def _range(dof: str, scale: Scale) -> tuple[float, float]:
    """Limits of a degree of freedom, m (grown with the spine's height there) or rad."""
    rows = table("joint_ranges")
    row = rows[dof] if dof in rows else rows[dof[:-2]]
    if row["lower_mm"]:
        per_mm = 1e-3 * scale.length[region_of_joint(dof)][2]
        return per_mm * float(row["lower_mm"]), per_mm * float(row["upper_mm"])
    return radians(float(row["lower_deg"])), radians(float(row["upper_deg"]))


def _reference(dof: str) -> float:
    """The reference shape: table 8's spine is where every spine joint stands at 0."""
    if dof in spine.SPINE_DOFS:
        return 0.0
    return radians(float(table("arm_springs")[dof[:-2]]["reference_deg"]))


def _legs(stature: float) -> Iterator[Joint]:
    """Thighs forward and shanks down, fixed to the seat; they carry shapes, no mass."""
    for side, sign in (("r", -1.0), ("l", 1.0)):
        x, y, z = (stature * value for value in _HIP)
        knee, ankle = (stature * _THIGH, 0.0, 0.0), (0.0, 0.0, -stature * _SHANK)
        yield Joint(f"hip_{side}", "fixed", "seat", f"thigh_{side}", (x, sign * y, z))
        yield Joint(f"knee_{side}", "fixed", f"thigh_{side}", f"shank_{side}", knee)
        yield Joint(f"ankle_{side}", "fixed", f"shank_{side}", f"foot_{side}", ankle)
