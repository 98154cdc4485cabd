"""From the reference subject to any other.

The tables describe the reference subject: male, 30 years, 1.80 m, 80 kg. Another subject is that
one stretched, by λz along z and by λx = λy across it, with density and elastic modulus unchanged
(§5.1):

    λz = stature / 1.80 m          λx = λy = √((weight / 80 kg) / λz)

so that volume, and with it every mass, grows as weight / 80 kg. By the reasoning of eq 57, with A
the section's area, I its second moments, J the polar one and L the height between vertebrae:

    axial            E A / L       λx λy / λz
    bending about x  E ∫y² dA / L  λx λy³ / λz
    bending about y  E ∫x² dA / L  λx³ λy / λz
    torsion          G J / L       (λx³ λy + λx λy³) / (2 λz)

Damping scales as the stiffness beside it, the buttocks as the spine. Age and gender change nothing
yet: the source ties them to the shape of the rib cage (eq 55), which its tables do not give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body.parts import Inertia
from posture_ik.problem import Subject

REFERENCE = Subject(gender="male", age=30.0, weight=80.0, stature=1.80)


@dataclass(frozen=True)
class Scale:
    """A subject over the reference subject.

    Attributes:
        length: (λx, λy, λz).
        mass: Factor on every mass.
    """

    length: tuple[float, float, float]
    mass: float

    @classmethod
    def of(cls, subject: Subject) -> Scale:
        """The factors of a subject."""
        mass = subject.weight / REFERENCE.weight
        z = subject.stature / REFERENCE.stature
        across = float(np.sqrt(mass / z))
        return cls((across, across, z), mass)

    def point(self, point: Array) -> Array:
        """A point or offset (3,) of the reference subject, moved to this one's."""
        return np.asarray(point) * self.length

    def inertia(self, inertia: Inertia) -> Inertia:
        """An inertia of the reference subject stretched with its body.

        Its second moments of mass, S = ½ tr(I) 1 − I, scale as mass times length times length.
        Seven of table 9's tensors are no body's: one moment exceeds the sum of the other two, and
        S has a negative part that a stretch would bring out. They scale by the mean square length.
        """
        tensor = np.asarray(inertia.tensor)
        moments = np.trace(tensor) / 2 * np.eye(3) - tensor
        if np.linalg.eigvalsh(moments)[0] < 0.0:
            scaled = tensor * np.mean(np.square(self.length))
        else:
            moments = moments * np.outer(self.length, self.length)
            scaled = np.trace(moments) * np.eye(3) - moments
        centre = self.point(inertia.centre)
        return Inertia(self.mass * inertia.mass, centre, self.mass * scaled)

    def stiffness(self, component: str) -> float:
        """Factor on the stiffness and damping of a spine joint's `axial`, `rx`, `ry` or `rz`."""
        x, y, z = self.length
        return {
            "axial": x * y / z,
            "rx": x * y**3 / z,
            "ry": x**3 * y / z,
            "rz": (x**3 * y + x * y**3) / (2 * z),
        }[component]
