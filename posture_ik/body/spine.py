"""The spine, head and viscera of tables 8 and 9: 25 joints of 4 degrees of freedom, one of 3."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body.parts import Inertia, Joint, X, Y, Z, vector
from posture_ik.body.scaling import Scale, region_of
from posture_ik.body.tables import numbers, table
from posture_ik.problem import SPINE

#: Components of a spine joint, lower body to upper, in the order of the chain.
COMPONENTS = ("axial", "rx", "ry", "rz")
_AXES = {"axial": Z, "rx": X, "ry": Y, "rz": Z}

SPINE_JOINTS = ("buttocks_S1", *(f"{upper}_{lower}" for lower, upper in pairwise(SPINE)))
SPINE_DOFS = (
    *(f"buttocks_S1_{component}" for component in COMPONENTS[:3]),
    *(f"{joint}_{component}" for joint in SPINE_JOINTS[1:] for component in COMPONENTS),
)
VISCERA = tuple(f"{body}V" for body in SPINE[SPINE.index("T10") :: -1])[::-1]


def nodes(scale: Scale) -> dict[str, Array]:
    """The points of table 8, each (3,), m, of a scaled subject in the reference shape.

    The spine's axis swings by `scale.curve`; viscera keep their depth ahead of their vertebra, and
    shoulders stand to T1, at whose height they are in the table, as the subject's do.
    """
    rows = table("table_8_nodes")
    places = np.array([numbers(row, "x_m", "y_m", "z_m") for row in rows.values()])
    points = places * (scale.curve, 1.0, 1.0)
    points[:, 2] = scale.heights(places[:, 2])
    at = dict(zip(rows, places, strict=True))
    found = dict(zip(rows, points, strict=True))
    for viscus in VISCERA:
        vertebra = viscus.removesuffix("V")
        ahead = at[viscus][0] - at[vertebra][0]
        found[viscus][0] = found[vertebra][0] + scale.length[region_of(viscus)][0] * ahead
    for arm in ("L_arm", "R_arm"):
        found[arm][1:] = at[arm][1:] * np.array(scale.shoulders)
    return found


def inertias(scale: Scale) -> dict[str, Inertia]:
    """The masses of table 9 but for the arms' (63, 64), which the arms' own bodies replace."""
    return {
        name: scale.inertia(
            Inertia(
                float(row["mass_kg"]),
                np.array(numbers(row, "offset_x_m", "offset_y_m", "offset_z_m")),
                np.diag(numbers(row, "ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2")),
            ),
            region_of(name),
        )
        for name, row in table("table_9_masses").items()
        if name not in ("L_arm", "R_arm") and float(row["mass_kg"]) > 0.0
    }


def joints(nodes: Mapping[str, Array]) -> Iterator[Joint]:
    """The chain from the seat to the head, and the viscera fixed to their vertebrae.

    A bushing's frame stands between two vertebrae, at the identified fraction from the lower node
    to the upper one, its z axis along the line through both: the local tangent of the spine's axis.
    The vertebra's own frame stands at its node, parallel to the world's in the reference shape.
    """
    fraction = float(table("identified")["bushing_fraction"]["value"])
    start = nodes["butt_up"]
    yield from _bushing("buttocks_S1", "seat", "S1", start, 0.0, nodes["S1"] - start)
    for lower, upper in pairwise(SPINE):
        chord = nodes[upper] - nodes[lower]
        pitch = float(np.arctan2(chord[0], chord[2]))
        along = np.array([0.0, 0.0, np.linalg.norm(chord)])
        yield from _bushing(
            f"{upper}_{lower}", lower, upper, fraction * chord, pitch, (1 - fraction) * along
        )
    for viscus in VISCERA:
        vertebra = viscus.removesuffix("V")
        offset = vector(nodes[viscus] - nodes[vertebra])
        yield Joint(f"{viscus}_node", "fixed", vertebra, viscus, offset)


def _bushing(
    joint: str, lower: str, upper: str, start: Array, pitch: float, end: Array
) -> Iterator[Joint]:
    """A bushing's slide and hinges at `start` in `lower`, pitched; `upper` at `end` beyond them."""
    parent, xyz, rpy = lower, vector(start), (0.0, pitch, 0.0)
    for component in COMPONENTS[: 3 if joint == "buttocks_S1" else 4]:
        dof = f"{joint}_{component}"
        yield Joint(
            dof,
            "prismatic" if component == "axial" else "revolute",
            parent,
            f"{dof}_link",
            xyz,
            rpy,
            _AXES[component],
        )
        parent, xyz, rpy = f"{dof}_link", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    yield Joint(f"{upper}_node", "fixed", parent, upper, vector(end), (0.0, -pitch, 0.0))
