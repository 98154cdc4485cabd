"""Anyone allowed can sit and be shaken: corners of the range and people in between."""

import numpy as np
import pytest

import posture_ik as pik

CORNERS = [
    {"gender": gender, "age": age, "stature": stature, "bmi": bmi}
    for gender, age in (("male", 18), ("female", 99))
    for stature in (1.40, 2.10)
    for bmi in (14, 55)
]


@pytest.fixture(scope="module")
def problem():
    return pik.load_problem("reclined_15")


def held_and_finite(subject, problem):
    body = pik.build_body(subject)
    posture = pik.solve_posture(body, problem)
    assert posture.certificate.holds
    system = pik.linearise(body, posture, problem)
    response = pik.frequency_response(system, np.array([0.6, 5.0, 20.0]))
    assert all(np.isfinite(response[name]).all() for name in response.data_vars)


@pytest.mark.parametrize("person", CORNERS)
def test_corners_of_the_range(person, problem):
    held_and_finite(pik.Subject(**person), problem)


def test_virtual_people(problem):
    for subject in pik.sample_people(6, seed=11):
        held_and_finite(subject, problem)
