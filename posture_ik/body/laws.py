"""The laws of scaling, by the name that a problem gives as `scaling` under `[subject]`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from posture_ik.body.scaling import Scale
from posture_ik.body.scaling_anthropometric import anthropometric
from posture_ik.body.scaling_thesis import thesis
from posture_ik.problem import Subject

LAWS: Mapping[str, Callable[[Subject], Scale]] = {
    "anthropometric": anthropometric,
    "thesis": thesis,
}


def scale_of(subject: Subject) -> Scale:
    """A subject over the reference subject, by the law that the subject names."""
    return LAWS[subject.scaling](subject)
