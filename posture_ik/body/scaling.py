"""What a law of scaling gives: a subject over the reference subject, region by region.

The tables describe the reference subject: male, 30 years, 1.80 m, 80 kg. Another subject is that
one stretched: each region of the trunk by λx in depth, λy in breadth and λz in height. By the
reasoning of eq 57, with E the elastic modulus, A the section's area, I its second moments, J the
polar one and L the height between vertebrae:

    axial            E A / L       [N/m]      e λx λy / λz
    bending about x  E ∫y² dA / L  [N m/rad]  e λx λy³ / λz
    bending about y  E ∫x² dA / L  [N m/rad]  e λx³ λy / λz
    torsion          G J / L       [N m/rad]  e (λx³ λy + λx λy³) / (2 λz)

with e the modulus over the reference subject's. Damping (N s/m and N m s/rad) scales likewise by a
viscous modulus of its own. Masses scale by a factor for each region, their offsets by the λ's, and
inertias (kg m²) as mass times length times length. A body grown alike in all directions by f, of
the same tissue, then has masses f³, axial springs f, bending and torsion f³ and inertias f⁵ as
large.

The spine's axis is one smooth curve: heights grow by λz within each region, and the slope of what
they grow by changes gradually from one region to the next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from posture_ik.arrays import Array
from posture_ik.body.parts import Inertia, Vector
from posture_ik.problem import Subject

REFERENCE = Subject(gender="male", age=30.0, weight=80.0, stature=1.80)
#: Height at which each region of the trunk ends in the reference subject, m (table 8): halfway
#: between its last vertebra and the next, the last one at the head's node.
REGIONS = {
    "pelvis": 0.12508,
    "lumbar": 0.26255,
    "thoracic": 0.60785,
    "cervical": 0.69528,
    "head": 0.75375,
}


@dataclass(frozen=True)
class Scale:
    """A subject over the reference subject: all factors are 1 for the reference subject.

    Attributes:
        length: (λx, λy, λz) of each of `REGIONS`: depth, breadth and height.
        curve: On how far the spine's axis swings forward and back.
        shoulders: (λy, λz) of the shoulders' centres: half their distance, and their height.
        arm: On all lengths of the arms.
        stature: On the legs and whatever else is drawn.
        mass: On the masses of each of `REGIONS`, and of the `arm`.
        modulus: Elastic modulus of spine, buttocks and viscera.
        viscosity: Their viscous modulus.
    """

    length: Mapping[str, Vector]
    curve: float
    shoulders: tuple[float, float]
    arm: float
    stature: float
    mass: Mapping[str, float]
    modulus: float = 1.0
    viscosity: float = 1.0

    @classmethod
    def alike(cls, length: Vector, mass: float, modulus: float = 1.0) -> Scale:
        """One stretch (λx, λy, λz) and one factor on mass for all of the body."""
        x, y, z = length
        regions = dict.fromkeys(REGIONS, length)
        masses = dict.fromkeys((*REGIONS, "arm"), mass)
        return cls(regions, x, (y, z), z, z, masses, modulus, modulus)

    def heights(self, z: Array) -> Array:
        """Heights above the seat (n,), m, of the reference subject, moved to this one's."""
        ends = np.array([0.0, *REGIONS.values()])
        growth = [self.length[region][2] - 1.0 for region in REGIONS]
        risen = np.array([0.0, *np.cumsum(growth * np.diff(ends))])
        return np.asarray(z + PchipInterpolator(ends, risen)(z))

    def inertia(self, inertia: Inertia, region: str) -> Inertia:
        """An inertia of the reference subject stretched with its region.

        Its second moments of mass, S = ½ tr(I) 1 − I, scale as mass times length times length.
        Seven of table 9's tensors are no body's: one moment exceeds the sum of the other two, and
        S has a negative part that a stretch would bring out. They scale by the mean square length.
        """
        length, mass = self.length[region], self.mass[region]
        tensor = np.asarray(inertia.tensor)
        moments = np.trace(tensor) / 2 * np.eye(3) - tensor
        if np.linalg.eigvalsh(moments)[0] < 0.0:
            scaled = tensor * np.mean(np.square(length))
        else:
            moments = moments * np.outer(length, length)
            scaled = np.trace(moments) * np.eye(3) - moments
        return Inertia(mass * inertia.mass, np.asarray(inertia.centre) * length, mass * scaled)

    def stiffness(self, region: str, component: str) -> float:
        """Factor on the stiffness of a region's `axial`, `rx`, `ry` or `rz` springs."""
        return self.modulus * self._section(region, component)

    def damping(self, region: str, component: str) -> float:
        """Factor on the damping of a region's `axial`, `rx`, `ry` or `rz` dampers."""
        return self.viscosity * self._section(region, component)

    def _section(self, region: str, component: str) -> float:
        x, y, z = self.length[region]
        return {
            "axial": x * y / z,
            "rx": x * y**3 / z,
            "ry": x**3 * y / z,
            "rz": (x**3 * y + x * y**3) / (2 * z),
        }[component]


def region_of(body: str) -> str:
    """The region that a node or link of the trunk belongs to; the viscera are the lumbar's."""
    if body == "Head":
        return "head"
    if body.startswith(("butt", "S1")):
        return "pelvis"
    if body.endswith("V"):
        return "lumbar"
    return {"C": "cervical", "T": "thoracic", "L": "lumbar"}[body[0]]


def region_of_joint(joint: str) -> str:
    """The region whose section a spine joint has: that of its upper body, for the head the neck."""
    upper = joint.split("_")[0]
    return "cervical" if upper == "Head" else region_of(upper)
