"""Peaks against the closed form of one mass on a spring, and against SciPy's search."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from posture_ik.vibration import build_lumped, frequency_response, load_lumped
from posture_ik.vibration.lumped import LumpedModel
from posture_ik.vibration.peak import Magnitude, follow_peak, highest_peaks, magnitude

MASS = Magnitude("seat force z", "seat z", -2)
HEAD = Magnitude("Head acceleration z", "seat z", -2)


def one_mass(mass: float = 50.0, stiffness: float = 50e3, damping: float = 800.0) -> LumpedModel:
    link = {"between": ("m", "seat"), "stiffness": stiffness, "damping": damping}
    return LumpedModel.model_validate(
        {"title": "one", "head": "m", "masses": {"m": mass}, "link": (link,)}
    )


@pytest.mark.parametrize("damping", [40.0, 800.0, 3000.0])
def test_one_mass_peaks_where_the_textbook_says(damping: float) -> None:
    """The transmissibility is largest at r² = (sqrt(1 + 8 ζ²) - 1) / 4 ζ²; to rounding."""
    ratio = damping / (2.0 * np.sqrt(50e3 * 50.0))
    r = np.sqrt((np.sqrt(1.0 + 8.0 * ratio**2) - 1.0) / (4.0 * ratio**2))
    frequency = r * np.sqrt(50e3 / 50.0) / (2.0 * np.pi)
    height = np.sqrt((1 + (2 * ratio * r) ** 2) / ((1 - r**2) ** 2 + (2 * ratio * r) ** 2))
    system = build_lumped(one_mass(damping=damping))
    for of, size in ((MASS, 50.0 * height), (HEAD, height)):
        for found in (
            follow_peak(system, of, 1.3 * frequency),
            follow_peak(system, of, 0.7 * frequency),
            *highest_peaks(system, [of], np.arange(0.1, 20.0, 0.1)),
        ):
            assert found.frequency == pytest.approx(frequency, rel=1e-10)
            assert found.value == pytest.approx(size, rel=1e-12)


def test_highest_of_several_peaks() -> None:
    """Against a search of the response itself; it finds a flat top to half the digits."""
    system = build_lumped(load_lumped("wan_schimmels"))

    def size(frequency: float) -> float:
        response = frequency_response(system, [frequency], "direct")
        found = response["response"].sel(output=HEAD.output, input=HEAD.input)
        return float(abs(found.values[0]) * frequency**-2)

    _, found = highest_peaks(system, [MASS, HEAD], np.arange(0.5, 20.0, 0.05))
    near = (found.frequency - 0.5, found.frequency + 0.5)
    top = minimize_scalar(
        lambda f: -size(f), bounds=near, method="bounded", options={"xatol": 1e-9}
    )
    assert found.frequency == pytest.approx(top.x, abs=1e-6)
    assert found.value == pytest.approx(-top.fun / (2 * np.pi) ** 2, rel=1e-12)
    assert magnitude(system, HEAD, found.frequency) == pytest.approx(found.value, rel=1e-12)
    grid = np.arange(0.5, 20.0, 0.5)
    assert max(size(f) for f in grid) / (2 * np.pi) ** 2 <= found.value


def test_no_peak_is_not_a_number() -> None:
    system = build_lumped(one_mass())
    (found,) = highest_peaks(system, [MASS], np.arange(10.0, 20.0, 0.1))
    assert np.isnan(found.frequency)
