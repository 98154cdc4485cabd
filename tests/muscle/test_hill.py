"""Both laws at their landmarks, against finite differences, and where a muscle hangs slack."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from posture_ik.muscle.hill import LAWS, de_groote, pennestri, working_length


def unit(muscles, count):
    """Muscles of 1 N, 1 m and 1 m/s without tendon or pennation: lengths are x, rates v."""
    ones, zeros = np.ones(count), np.zeros(count)
    return replace(
        muscles,
        peak_force=ones,
        optimal_length=ones,
        slack_length=zeros,
        pennation=zeros,
        fastest=ones,
    )


def sampled(muscles, seed, count=400):
    """Lengths from short to stretched, rates within ±0.9 v0, activations; (count, 25) each."""
    random = np.random.default_rng(seed)
    x = random.uniform(0.4, 1.7, (count, 25))
    v = random.uniform(-0.9, 0.9, (count, 25))
    length = muscles.slack_length + working_length(muscles) * x
    return length, v * muscles.fastest, random.uniform(0, 1, (count, 25))


def slope(function, at, step):
    """Five-point difference: wrong by the fourth power of the step."""
    return (
        function(at - 2 * step)
        - 8 * function(at - step)
        + 8 * function(at + step)
        - function(at + 2 * step)
    ) / (12 * step)


def test_pennestri_at_its_landmarks(muscles):
    x = np.array([0.95, 0.95 + np.sqrt(1 / 80), 1.22, 1.0])
    force = pennestri(unit(muscles, 4), x, np.zeros(4), np.ones(4))
    hold = 1.6 * (1 - np.exp(-1))
    assert hold == pytest.approx(1.0114, abs=5e-5)
    active = (force.force - force.passive) / hold
    # the optimum, the printed curve's own maximum at its root of 1/80, and one strain of the tissue
    np.testing.assert_allclose(active[:2], [1.0, np.exp(1 / 160)], rtol=1e-14)
    assert force.passive[2] == pytest.approx(1.3 * np.arctan(0.1), rel=1e-14)
    assert force.d_activation[0] == pytest.approx(hold, rel=1e-14)


def test_f2_rises_smoothly_to_1_6(muscles):
    """Singular at v = 1 as printed: value and slope there, before and beyond, and no jump."""
    v = np.linspace(-1.5, 3.0, 4501)
    one = unit(muscles, v.size)
    f2 = pennestri(one, np.full(v.size, 0.95), v, np.ones(v.size))
    active = f2.force - f2.passive
    assert np.all(np.isfinite(f2.d_rate))
    assert np.all(active <= 1.6)
    assert np.all(np.diff(active) >= 0)
    np.testing.assert_array_equal(active[v >= 1], 1.6)
    assert np.all(f2.d_rate[v >= 1] == 0)
    # slope and its own slope are bounded by the curve's: a kink would show as a jump of 1
    assert np.max(np.abs(np.diff(f2.d_rate))) < 0.02


def test_de_groote_at_its_landmarks(muscles):
    """As its authors state: 1 at optimum and at rest, nothing at -v0, peak force at 60 % strain."""
    x, v = np.array([1.0, 1.0, 1.6]), np.array([0.0, -1.0, 0.0])
    force = de_groote(unit(muscles, 3), x, v, np.ones(3))
    np.testing.assert_allclose(force.d_activation[0], 1.0, atol=1e-6)
    np.testing.assert_allclose(force.d_activation[1], 0.0, atol=1e-12)
    np.testing.assert_allclose(force.passive[2], 1.0, rtol=1e-14)


@pytest.mark.parametrize("law", LAWS.values())
def test_strength_at_the_optimum(muscles, law):
    """Fibres of a pennate muscle are at their optimum at x = 1 in both laws."""
    length = muscles.slack_length + working_length(muscles)
    active = law(muscles, length, np.zeros(25), np.ones(25)).d_activation
    share = np.cos(muscles.pennation) if law is de_groote else 1.0114 * np.exp(0.05**2)
    np.testing.assert_allclose(active, muscles.peak_force * share, rtol=3e-4)


@pytest.mark.parametrize("law", LAWS.values())
def test_derivatives_are_those_of_the_force(muscles, law):
    """Relative to f0 by l0, v0 and 1: 1e-7 of five-point differences over 1e-3 of the range."""
    length, rate, activation = sampled(muscles, 1)
    # de_groote's passive curve has its kink where nothing pulls, below x = 0.2
    force = law(muscles, length, rate, activation)
    f0, l0, v0 = muscles.peak_force, working_length(muscles), muscles.fastest
    by_length = slope(lambda z: law(muscles, z, rate, activation).force, length, 5e-4 * l0)
    by_rate = slope(lambda z: law(muscles, length, z, activation).force, rate, 5e-4 * v0)
    by_activation = slope(lambda z: law(muscles, length, rate, z).force, activation, 1e-3)
    passive = slope(lambda z: law(muscles, z, rate, activation).passive, length, 5e-4 * l0)
    np.testing.assert_allclose(force.d_length * l0 / f0, by_length * l0 / f0, atol=1e-7)
    np.testing.assert_allclose(force.d_rate * v0 / f0, by_rate * v0 / f0, atol=1e-7)
    np.testing.assert_allclose(force.d_activation / f0, by_activation / f0, atol=1e-10)
    np.testing.assert_allclose(force.d_passive * l0 / f0, passive * l0 / f0, atol=1e-7)


@pytest.mark.parametrize("law", LAWS.values())
def test_force_is_affine_in_activation(muscles, law):
    length, rate, activation = sampled(muscles, 2)
    force = law(muscles, length, rate, activation)
    scale = muscles.peak_force
    affine = force.passive + activation * force.d_activation
    np.testing.assert_allclose(force.force / scale, affine / scale, atol=1e-13)
    rest = law(muscles, length, rate, np.zeros_like(rate))
    np.testing.assert_array_equal(rest.force, force.passive)
    np.testing.assert_array_equal(rest.d_length, force.d_passive)


@pytest.mark.parametrize("law", LAWS.values())
def test_slack_muscles_hang_loose(muscles, law):
    """From a path shorter than its tendon to one at thrice its optimum: finite, pulling only."""
    x = np.linspace(-1.0, 3.0, 801)[:, None] * np.ones(25)
    length = muscles.slack_length + working_length(muscles) * x
    rate = np.linspace(-1.0, 5.0, 801)[:, None] * muscles.fastest
    force = law(muscles, length, rate, np.ones_like(length))
    for part in force:
        assert np.all(np.isfinite(part))
    assert np.all(force.force >= 0)
    assert np.all(force.passive >= 0)
    assert np.all(np.diff(force.passive, axis=0) >= 0)
    loose = x < 0
    assert np.max((force.force / muscles.peak_force)[loose]) < 0.005
    # de_groote's fibres of 1 µm still stretch across the tendon
    np.testing.assert_allclose((force.passive / muscles.peak_force)[loose], 0.0, atol=1e-6)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_laws_of_symbols_are_those_of_numbers(muscles, law):
    """One formula, two modules: also where fibres hang slack, and where a curve is held at 0."""
    length, rate, activation = sampled(muscles, seed=6)
    length[0], rate[1], rate[2] = muscles.slack_length - 0.01, -2.5 * muscles.fastest, 3.0
    symbols = [ca.SX.sym(name, 25) for name in ("l", "v", "a")]
    graph = ca.Function("law", symbols, list(law(muscles, *symbols, ca)))
    found = graph.map(len(length))(length.T, rate.T, activation.T)
    expected = law(muscles, length, rate, activation)
    for part, ours, theirs in zip(expected._fields, found, expected, strict=True):
        whole = np.broadcast_to(theirs, length.shape)
        scale = np.abs(whole).max()
        np.testing.assert_allclose(ours.full().T, whole, atol=1e-12 * scale, err_msg=part)
