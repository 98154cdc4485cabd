"""Parameter sets: what multiplies the stiffness and damping of tables 10 and 11.

`source` takes the tables as they are. `calibrated` multiplies a few groups of them, so that the
model answers as measured people do (§7.2 of the source asks for that); `identify` found by how
much, and `data/calibrated.csv` tells. A joint's share of a group is the same at every level.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body.tables import read_table
from posture_ik.problem import COMPONENTS, SPINE
from posture_ik.vibration.seat import DATA


class Factors(NamedTuple):
    """Factors on groups of springs, and on the dampers beside them; all 1 is the source.

    Attributes:
        neck_flexion, trunk_flexion: on the stiffness of bending about y from the head to T1, and
            from T1 to S1; `lateral_bending`: about x, of both.
        flexion_damping, lateral_damping: on the damping of all these joints about y, about x.
        buttocks, buttocks_damping: on the stiffness and damping of the buttocks along z, and with
            it of their tilt.
        buttocks_shear: on their stiffness and damping along x; the multibody person, whose
            buttocks do not shear, has no such spring.
    """

    neck_flexion: float = 1.0
    trunk_flexion: float = 1.0
    lateral_bending: float = 1.0
    flexion_damping: float = 1.0
    lateral_damping: float = 1.0
    buttocks: float = 1.0
    buttocks_damping: float = 1.0
    buttocks_shear: float = 1.0

    @classmethod
    def of(cls, parameters: str) -> Factors:
        """The factors of a parameter set, `source` or `calibrated`."""
        if parameters == "source":
            return cls()
        rows = read_table(DATA / f"{parameters}.csv")
        return cls(*(float(rows[name]["value"]) for name in cls._fields))

    def of_joint(self, joint: str) -> tuple[Array, Array]:
        """On the stiffness and on the damping of a joint (`L4_L5`) or the buttocks; (6,), x to rz.

        Joints are named as in table 11, or as the body names them.
        """
        if joint.startswith("butt"):
            z, c = self.buttocks, self.buttocks_damping
            shear = self.buttocks_shear
            return np.array([shear, 1.0, z, z, z, 1.0]), np.array([shear, 1.0, c, c, c, 1.0])
        flexion = self.neck_flexion if joint.startswith(("Head", "C")) else self.trunk_flexion
        stiffness = np.array([1.0, 1.0, 1.0, self.lateral_bending, flexion, 1.0])
        return stiffness, np.array([1.0, 1.0, 1.0, self.lateral_damping, self.flexion_damping, 1.0])

    def of_coordinates(self, coordinates: Sequence[str]) -> tuple[Array, Array]:
        """On the springs and on the dampers of the body's coordinates (`L4_L5_ry`), (n,) each.

        Those of arms, levers and viscera are left as they are.
        """
        found = np.ones((2, len(coordinates)))
        for i, name in enumerate(coordinates):
            joint, _, suffix = name.rpartition("_")
            component = "z" if suffix == "axial" else suffix
            upper = joint.partition("_")[0]
            if component in COMPONENTS and upper in (*SPINE, "buttocks"):
                found[:, i] = [own[COMPONENTS.index(component)] for own in self.of_joint(joint)]
        return found[0], found[1]


#: The tables as they are.
SOURCE = Factors()
