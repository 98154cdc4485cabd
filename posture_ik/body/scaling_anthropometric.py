"""Placeholder."""

from __future__ import annotations

from posture_ik.body.scaling import Scale
from posture_ik.body.scaling_thesis import thesis
from posture_ik.problem import Subject


def anthropometric(subject: Subject) -> Scale:
    """The factors of a subject."""
    return thesis(subject)
