"""The laws of the backrest against differences and closed forms."""

import numpy as np
import pytest

from posture_ik.errors import PostureIKError
from posture_ik.vibration.seat import law, law_stiffness


@pytest.mark.parametrize("bilateral", [False, True])
@pytest.mark.parametrize("strain", [-0.9, -0.3, -0.05, 0.02, 0.4])
def test_the_slope_of_a_law_is_its_derivative(bilateral, strain):
    h = 1e-6
    difference = (law(strain + h, bilateral)[0] - law(strain - h, bilateral)[0]) / (2 * h)
    assert law(strain, bilateral)[1] == pytest.approx(difference, abs=1e-6)


def test_a_bilateral_law_is_cubic():
    """F = 500/3 ε³, so k = 500 ε² / l at ε = ∛(3 F / 500)."""
    for preload in (-100.0, -1.0, 0.0, 3.0, 150.0):
        strain = np.cbrt(3 * preload / 500)
        expected = 500 * strain**2 / 0.1
        assert law_stiffness(preload, bilateral=True) == pytest.approx(expected, abs=1e-6)


def test_a_unilateral_law_is_the_same_when_pressed_and_nothing_when_left():
    """At 50 N, ε = −0.67, tanh has run out to 1e-9; released, what it leaves of F is 1e-4 N."""
    assert law_stiffness(50.0) == pytest.approx(law_stiffness(50.0, bilateral=True), rel=1e-6)
    assert law_stiffness(0.0) == pytest.approx(0.0, abs=1e-9)
    assert abs(law(0.5)[0]) < 1e-4


@pytest.mark.parametrize(
    ("preload", "bilateral"), [(170.0, False), (-1.0, False), (-170.0, True), (np.nan, True)]
)
def test_a_preload_that_no_law_bears_is_refused(preload, bilateral):
    with pytest.raises(PostureIKError, match=f"preload = {preload:g} N: must be at least"):
        law_stiffness(preload, bilateral)
