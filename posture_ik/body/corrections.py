"""What a person's age, weight and build change beside geometry, identified on measurements.

Toward and Griffin's apparent masses, as far as the source quotes them (tables 15, 17 and 24), tell
four numbers of the `anthropometric` law (`tools/identify_corrections.py`; docs/scaling.md has the
residuals, the confidence intervals and the error on rows left out). None changes anything in the
reference subject.

    share of the weight on the seat   ∝ (BMI / BMI₀)^s, and at most all of it
    elastic modulus                   ∝ l (BMI / BMI₀)^b exp(a (age − 30)/10)
    viscous modulus                   ∝ l (BMI / BMI₀)^d

Here l is the mean pressure under the trunk: the mass on the seat over what the pelvis's section and
height (λx λy / λz) make of stiffness, both over the reference subject's. Soft tissue stiffens with
what it bears: by Fung's exponential law its tangent modulus is proportional to the stress, and so
the resonance hardly knows a person's size. (Sought too, the power of l came out as 1.2 ± 0.3.) Fat
is soft; muscles that hold the trunk are tenser in the old.
"""

from __future__ import annotations

from math import exp
from typing import NamedTuple

from posture_ik.body.scaling import REFERENCE
from posture_ik.body.tables import table
from posture_ik.problem import Subject

#: From this age on, years, the measurements tell no more: the oldest group of table 24 is of 53.
OLDEST = 65.0


class Corrections(NamedTuple):
    """The law's numbers; `identified()` gives those that ship.

    Attributes:
        share_bmi: s.
        stiffness_bmi: b.
        stiffness_per_decade: a.
        damping_bmi: d.
    """

    share_bmi: float
    stiffness_bmi: float
    stiffness_per_decade: float
    damping_bmi: float

    @classmethod
    def identified(cls) -> Corrections:
        """The values that meet the open measurements best."""
        rows = table("corrections")
        return cls(*(float(rows[name]["value"]) for name in cls._fields))

    def share(self, subject: Subject) -> float:
        """Factor on the share of the weight that the seat carries."""
        return float(_heavier(subject) ** self.share_bmi)

    def modulus(self, subject: Subject, pressure: float) -> float:
        """Factor on stiffness, posture's tension included."""
        decades = (min(subject.age, OLDEST) - REFERENCE.age) / 10
        aged = exp(self.stiffness_per_decade * decades)
        return subject.tension * aged * self._tissue(subject, pressure, self.stiffness_bmi)

    def viscosity(self, subject: Subject, pressure: float) -> float:
        """Factor on damping."""
        return self._tissue(subject, pressure, self.damping_bmi)

    def _tissue(self, subject: Subject, pressure: float, power: float) -> float:
        return float(pressure * _heavier(subject) ** power)


def _heavier(subject: Subject) -> float:
    return subject.body_mass_index / REFERENCE.body_mass_index
