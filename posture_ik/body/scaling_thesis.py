"""The source's law (§5.1): one stretch of the whole body by λx, λy and λz (eq 56).

The λ's compare a subject's rib cage with the reference person's: to the source the most probable
one for Kitazaki and Griffin's model, a man of 34 years, 1.78 m and 84 kg. Its rib cages come from a
statistical model (Shi et al., eq 55) that is not public. Here the λ's are identified instead, on
the source's own results of tables 15, 17 and 25 (`tools/fit_scaling_thesis.py`):

    ln λ = a (age − 34)/10 + b ln(BMI / BMI₀) + h ln(stature / 1.78 m) + w [a woman]

one such sum for λz, and one for λx = λy, which vertical vibration cannot tell apart. With elastic
and viscous moduli and density unchanged, stiffness and damping scale by eq 57 and its likes, masses
by λx λy λz, inertias by mass times length times length (`posture_ik.body.scaling`).
"""

from __future__ import annotations

from math import exp, log

from posture_ik.body.scaling import Scale
from posture_ik.body.tables import numbers, table
from posture_ik.problem import Subject

#: Whom the tables describe, by the source's §5.1.
KITAZAKI = Subject(gender="male", age=34.0, weight=84.0, stature=1.78)
COLUMNS = ("per_decade", "bmi", "stature", "female")


def thesis(subject: Subject) -> Scale:
    """The factors of a subject by the source's law."""
    across, up = (stretch(subject, numbers(row, *COLUMNS)) for row in _rows())
    return Scale.alike((across, across, up), across**2 * up)


def stretch(subject: Subject, coefficients: tuple[float, ...]) -> float:
    """A λ of a subject, by its four coefficients a, b, h and w."""
    decade, bmi, stature, female = coefficients
    return exp(
        decade * (subject.age - KITAZAKI.age) / 10
        + bmi * log(subject.body_mass_index / KITAZAKI.body_mass_index)
        + stature * log(subject.stature / KITAZAKI.stature)
        + female * (subject.gender == "female")
    )


def _rows() -> tuple[dict[str, str], dict[str, str]]:
    rows = table("thesis_scaling")
    return rows["across"], rows["up"]
