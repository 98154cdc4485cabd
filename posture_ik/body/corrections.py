"""What a person's age, size and build change beside geometry, identified on measurements.

Toward and Griffin's apparent masses, as far as the source quotes them (tables 15, 17 and 24), tell
five numbers of the `anthropometric` law (`tools/identify_corrections.py`; docs/scaling.md has the
residuals, the confidence intervals and the error on rows left out). All change nothing in the
reference subject.

    share of the weight on the seat   ∝ 1 + s (BMI − BMI₀)
    elastic modulus                   ∝ exp(a (age − 30)/10) (BMI / BMI₀)^b (stature / 1.80 m)^h
    viscous modulus                   ∝ (BMI / BMI₀)^d

Muscles that hold the trunk up grow tenser with age, and with what they hold up, m g h; fat is soft
and damps little.
"""

from __future__ import annotations

from math import exp, log
from typing import NamedTuple

from posture_ik.body.scaling import REFERENCE
from posture_ik.body.tables import table
from posture_ik.problem import Subject


class Corrections(NamedTuple):
    """The law's numbers; `identified()` gives those that ship.

    Attributes:
        share_per_bmi: s, m²/kg.
        stiffness_per_decade: a.
        stiffness_bmi: b.
        stiffness_stature: h.
        damping_bmi: d.
    """

    share_per_bmi: float
    stiffness_per_decade: float
    stiffness_bmi: float
    stiffness_stature: float
    damping_bmi: float

    @classmethod
    def identified(cls) -> Corrections:
        """The values that meet the open measurements best."""
        rows = table("corrections")
        return cls(*(float(rows[name]["value"]) for name in cls._fields))

    def share(self, subject: Subject) -> float:
        """Factor on the share of the weight that the seat carries."""
        return 1.0 + self.share_per_bmi * (subject.body_mass_index - REFERENCE.body_mass_index)

    def modulus(self, subject: Subject) -> float:
        """Factor on stiffness, posture's tension included."""
        return subject.tension * exp(
            self.stiffness_per_decade * (subject.age - REFERENCE.age) / 10
            + self.stiffness_bmi * _heavier(subject)
            + self.stiffness_stature * log(subject.stature / REFERENCE.stature)
        )

    def viscosity(self, subject: Subject) -> float:
        """Factor on damping."""
        return exp(self.damping_bmi * _heavier(subject))


def _heavier(subject: Subject) -> float:
    return log(subject.body_mass_index / REFERENCE.body_mass_index)
