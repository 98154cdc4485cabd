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

from collections.abc import Mapping
from dataclasses import replace
from math import exp, log

from posture_ik.body.scaling import Scale
from posture_ik.body.tables import numbers, table
from posture_ik.problem import Subject

#: Whom the tables describe, by the source's §5.1.
KITAZAKI = Subject(gender="male", age=34.0, weight=84.0, stature=1.78)
COLUMNS = ("per_decade", "bmi", "stature", "female", "base")

_Rows = Mapping[str, Mapping[str, float]]


def thesis(subject: Subject) -> Scale:
    """The factors of a subject by the source's law."""
    rows = _identified()
    across, up = stretch(subject, rows["across"]), stretch(subject, rows["up"])
    return Scale.alike((across, across, up), across**2 * up)


def chapter_5(subject: Subject, rows: _Rows | None = None) -> Scale:
    """The factors that also make up for what the source's own model of that chapter has otherwise.

    Its results of tables 15, 17 and 25 suppose a model that is lighter, shorter and less damped
    before any scaling than tables 8-12 are here; the law knows nothing of that.

    Args:
        subject: Who.
        rows: Coefficients in place of the identified ones.
    """
    rows = rows or _identified()
    across, up = (
        stretch(subject, rows[name]) * exp(rows[name]["base"]) for name in ("across", "up")
    )
    scale = Scale.alike((across, across, up), across**2 * up)
    return replace(scale, viscosity=exp(rows["damping"]["base"]))


def stretch(subject: Subject, coefficients: Mapping[str, float]) -> float:
    """A λ of a subject."""
    heavier = subject.body_mass_index / KITAZAKI.body_mass_index
    return exp(
        coefficients["per_decade"] * (subject.age - KITAZAKI.age) / 10
        + coefficients["bmi"] * log(heavier)
        + coefficients["stature"] * log(subject.stature / KITAZAKI.stature)
        + coefficients["female"] * (subject.gender == "female")
    )


def _identified() -> _Rows:
    rows = table("thesis_scaling")
    return {
        name: dict(zip(COLUMNS, numbers(row, *COLUMNS), strict=True)) for name, row in rows.items()
    }
