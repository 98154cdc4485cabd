"""Modes against SciPy and closed forms, and what is said of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigvals

import posture_ik as pik
from posture_ik.errors import PostureIKError
from posture_ik.vibration import build_finite_element
from posture_ik.vibration.modes import mirror
from posture_ik.vibration.system import LinearSystem, Port

Models = Any  # of conftest.py


def oscillator(m: float, c: float, k: float) -> LinearSystem:
    one = np.ones((1, 1))
    B = np.stack([k * one, c * one, 0 * one])
    ports = (Port("seat z", "m"),), (Port("Head z", "m"),)
    return LinearSystem(
        ("m_z",), m * one, c * one, k * one, *ports, B, np.stack([one, 0 * one, 0 * one]), 0 * B
    )


@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.99])
def test_one_mass(ratio: float) -> None:
    m, k = 50.0, 50e3
    omega = np.sqrt(k / m)
    (mode,) = pik.damped_modes(oscillator(m, 2 * ratio * m * omega, k))
    assert mode.frequency == pytest.approx(omega / (2 * np.pi), rel=1e-12)
    assert mode.damping_ratio == pytest.approx(ratio, abs=1e-9)
    (mode,) = pik.undamped_modes(oscillator(m, 0.0, k))
    assert mode.eigenvalue == pytest.approx(1j * omega, rel=1e-12)
    assert abs(mode.shape[0]) == pytest.approx(m**-0.5, rel=1e-12)


def test_damped_modes_solve_the_quadratic_problem(models: Models) -> None:
    """Eigenvalues of SciPy's companion form, and (lambda² M + lambda C + K) phi = 0."""
    system = models("look_left", "vibration.gravity=true")
    modes = pik.damped_modes(system)
    n = len(system.coordinates)
    lower = np.linalg.solve(system.mass, np.hstack([-system.stiffness, -system.damping]))
    companion = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
    theirs = np.array([value for value in eigvals(companion) if value.imag >= 0.0])
    assert len(modes) == len(theirs)
    for mode in modes[:30]:
        nearest = np.min(np.abs(theirs - mode.eigenvalue))
        assert nearest < 1e-6 * abs(mode.eigenvalue)  # rounding of the companion's 1e6 1/s
        at, phi = mode.eigenvalue, mode.shape
        parts = [at**2 * system.mass @ phi, at * system.damping @ phi, system.stiffness @ phi]
        largest = max(np.max(np.abs(part)) for part in parts)
        assert np.max(np.abs(sum(parts))) < 1e-7 * largest
    assert [m.frequency for m in modes if m.eigenvalue.imag > 0] == sorted(
        m.frequency for m in modes if m.eigenvalue.imag > 0
    )


def test_effective_masses_are_all_the_mass_that_the_springs_carry(models: Models) -> None:
    """Vertically everything hangs on the buttocks' spring, so nothing is left out."""
    system = models("upright")
    masses = sum(mode.effective_mass for mode in pik.undamped_modes(system))
    total = pik.frequency_response(system, [1e-3], "direct").apparent_mass.values[0, 2, 2].real
    assert masses[2] == pytest.approx(total, rel=1e-5)


def test_the_first_modes_are_what_a_seated_person_does(models: Models) -> None:
    """The lowest bends fore and aft, then sideways; the one that heaves lies at 4 to 6 Hz.

    Cocco 2019, table 6, modes 1, 2 and 6 to 8, of another spine of the same tables.
    """
    first, second, *others = pik.undamped_modes(models("upright"))
    assert first.symmetry == "symmetric"
    assert first.words.startswith("fore-and-aft bending of the lumbar spine")
    assert first.words.endswith("the head goes fore and aft")
    assert second.symmetry == "anti-symmetric"
    assert second.words.startswith("lateral bending")
    heaving = max(others, key=lambda mode: mode.effective_mass[2])
    assert "vertical motion of the pelvis on the buttocks" in heaving.words
    assert 4.0 < heaving.frequency < 6.0


def test_the_mirror_is_of_the_body(models: Models) -> None:
    """Sides swapped it is the same person, but for the 10 g by which table 9's arms differ."""
    system = models("upright")
    places, signs = mirror(system.coordinates)
    image = np.zeros_like(system.mass)
    image[np.arange(len(places)), places] = signs
    for part in (system.mass, system.stiffness):
        scale = np.sqrt(np.outer(np.diag(part), np.diag(part)))
        assert np.max(np.abs(image.T @ part @ image - part) / scale) < 3e-3


def test_weight_makes_the_bare_spine_fall(models: Models) -> None:
    """Said with the mode; without it, and held by a backrest, everything comes to rest."""
    bare = models("upright", "vibration.gravity=true")
    falling = pik.stability(bare)
    assert not bare.stable
    assert pik.frequency_response(bare, [1.0]).stable == 0
    assert not falling.stable
    assert falling.worst.eigenvalue.real > 0
    assert str(falling).startswith("unstable, doubling every ")
    assert "fore-and-aft bending of the lumbar spine" in str(falling)
    held = models("reclined_15", "vibration.gravity=true", "seat.backrest.kind=rigid")
    assert held.stable
    assert pik.stability(held).stable
    standing = pik.stability(models("upright"))
    assert standing.stable
    assert standing.worst.eigenvalue.real < 0


def test_an_inverted_pendulum_falls_as_fast_as_it_must() -> None:
    m, c, k = 2.0, 0.0, -8.0
    falling = pik.stability(oscillator(m, c, k))
    assert not falling.stable
    assert falling.worst.eigenvalue == pytest.approx(2.0, rel=1e-9)
    assert not oscillator(m, c, k).stable
    assert oscillator(m, c, 8.0).stable
    assert not oscillator(m, -1e-3, 8.0).stable
    assert pik.stability(oscillator(m, c, 8.0)).stable  # it swings for ever, and no wider


def test_a_model_without_mass_has_no_modes() -> None:
    with pytest.raises(PostureIKError, match="needs a mass of its own"):
        pik.undamped_modes(oscillator(0.0, 1.0, 1.0))
    with pytest.raises(PostureIKError, match="needs a mass of its own"):
        pik.damped_modes(oscillator(0.0, 1.0, 1.0))


def test_finite_elements_are_told_as_the_multibody_person_is() -> None:
    """Its coordinates are bodies' own motions, `Head y`; a symmetric person's modes part in two."""
    system = build_finite_element()
    odd = np.array([name.split()[1] in ("y", "rx", "rz") for name in system.coordinates])
    kinds = set()
    for mode in pik.undamped_modes(system)[:14]:
        sideways = np.abs(mode.shape[odd]).max() > np.abs(mode.shape[~odd]).max()
        assert mode.symmetry == ("anti-symmetric" if sideways else "symmetric")
        assert mode.words.endswith("the head goes sideways") == sideways
        assert "of Head" not in mode.words
        kinds.add(mode.symmetry)
    assert len(kinds) == 2
