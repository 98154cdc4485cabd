"""The source's law (§5.1): one stretch of the whole body by λx, λy and λz (eq 56).

    λz = stature / 1.80 m          λx = λy = √((weight / 80 kg) / λz)

so that volume, and with it every mass, grows as weight / 80 kg. Age and gender change nothing: the
source ties them to the shape of the rib cage (eq 55), which its tables do not give.
"""

from __future__ import annotations

from math import sqrt

from posture_ik.body.scaling import REFERENCE, Scale
from posture_ik.problem import Subject


def thesis(subject: Subject) -> Scale:
    """The factors of a subject by the source's law."""
    mass = subject.weight / REFERENCE.weight
    z = subject.stature / REFERENCE.stature
    across = sqrt(mass / z)
    return Scale.alike((across, across, z), mass)
