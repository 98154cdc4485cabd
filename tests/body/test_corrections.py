"""What changes beside geometry: nothing in the reference subject, and never out of bounds."""

from __future__ import annotations

import numpy as np
import pytest

from posture_ik.body.corrections import Corrections
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.scaling_anthropometric import anthropometric, seated_share
from posture_ik.problem import Subject

NOTHING = Corrections(0.0, 0.0, 0.0, 0.0)


def test_reference_subject_needs_no_correction():
    corrections = Corrections.identified()
    assert corrections.share(REFERENCE) == 1.0
    assert corrections.modulus(REFERENCE, 1.0) == 1.0
    assert corrections.viscosity(REFERENCE, 1.0) == 1.0
    assert anthropometric(REFERENCE) == anthropometric(REFERENCE, NOTHING)


@pytest.mark.parametrize("gender", ["male", "female"])
@pytest.mark.parametrize("stature", [1.40, 1.71, 2.10])
@pytest.mark.parametrize("thigh", [0.0, 0.58, 1.0])
def test_heavier_people_load_the_seat_more_by_a_smaller_share(gender, stature, thigh):
    people = [
        Subject(gender=gender, stature=stature, bmi=bmi, thigh_on_seat=thigh)
        for bmi in np.linspace(14.0, 55.0, 12)
    ]
    shares = np.array([seated_share(person) for person in people])
    assert np.all(np.diff(shares) <= 0.0)
    assert shares.max() <= 1.0
    assert shares.min() > 0.3
    assert np.all(np.diff(shares * [person.weight for person in people]) > 0.0)


def test_old_people_and_tense_people_are_stiffer():
    def modulus(**of):
        return anthropometric(REFERENCE.model_copy(update=of)).modulus

    assert modulus(age=60.0) > modulus(age=40.0) > 1.0
    assert modulus(tension=1.2) == pytest.approx(1.2)


def test_stiffness_follows_the_load_and_not_the_section():
    """Of the pelvis, with no other correction: axial stiffness over mass is that of the tables."""
    for weight in (60.0, 100.0):
        scale = anthropometric(REFERENCE.model_copy(update={"weight": weight}), NOTHING)
        mass = weight / REFERENCE.weight
        assert scale.stiffness("pelvis", "axial") == pytest.approx(mass, rel=1e-12)
        assert scale.damping("pelvis", "axial") == pytest.approx(mass, rel=1e-12)
