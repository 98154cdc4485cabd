"""Stiffness and damping against differences of torques, and the hand against compliance."""

from __future__ import annotations

import numpy as np
import pytest

from posture_ik.errors import PostureIKError
from posture_ik.muscle.hill import LAWS, working_length
from posture_ik.muscle.reflex import (
    SHORT_RANGE,
    endpoint,
    joint_damping,
    joint_stiffness,
    muscle_damping,
    muscle_stiffness,
    trace_slope,
)

KP, KD = 1.5, 0.4


class Strings:
    """Made-up paths over 7 joints: l(q) = middle + B q + sum_j A_j sin(q_j + phase)."""

    def __init__(self, muscles, seed=4):
        random = np.random.default_rng(seed)
        self.muscles = muscles
        self.middle = muscles.slack_length + random.uniform(0.8, 1.3, 25) * working_length(muscles)
        self.arms = random.uniform(-0.02, 0.02, (25, 7))
        self.waves = random.uniform(-0.01, 0.01, (25, 7, 7))
        self.phase = random.uniform(-1, 1, 7)
        self.mixed = random.normal(size=(7, 7))

    def length(self, q):
        angle = self.mixed @ q + self.phase
        return self.middle + self.arms @ q + self.waves[:, 0] @ (np.sin(angle) - np.sin(self.phase))

    def jacobian(self, q):
        return self.arms + self.waves[:, 0] * np.cos(self.mixed @ q + self.phase) @ self.mixed

    def curvature(self, q, weights):
        bow = -(weights @ self.waves[:, 0]) * np.sin(self.mixed @ q + self.phase)
        return self.mixed.T @ (bow[:, None] * self.mixed)


@pytest.fixture(scope="module")
def strings(muscles):
    return Strings(muscles)


def held(strings, law, seed=0):
    random = np.random.default_rng(seed)
    q, activation = random.uniform(-0.3, 0.3, 7), random.uniform(0, 1, 25)
    force = law(strings.muscles, strings.length(q), np.zeros(25), activation)
    return q, activation, force


def reflexive_torque(strings, law, q0, activation):
    """Torque of q and q' with the reflex at work about q0, the muscle law unlinearised."""
    muscles = strings.muscles
    rest = strings.length(q0)

    def torque(q, rate):
        jacobian = strings.jacobian(q)
        length, speed = strings.length(q), jacobian @ rate
        stretch = (length - rest) / working_length(muscles)
        a = activation + KP * stretch + KD * speed / muscles.fastest
        return -jacobian.T @ law(muscles, length, speed, a).force

    return torque


def five_points(function, step):
    """Derivative at 0 by a difference wrong by the fourth power of the step."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def slope(function, step):
    """d function / d each of 7 numbers at 0, (7, 7)."""
    return np.array([five_points(lambda s, e=e: function(s * e), step) for e in np.eye(7)]).T


@pytest.mark.parametrize("law", LAWS.values())
def test_stiffness_and_damping_are_those_of_the_torque(strings, law):
    """All parts with the reflex: 1e-7 of their size from differences of 1e-3 rad, 1e-3 rad/s."""
    q, activation, force = held(strings, law)
    muscles, jacobian = strings.muscles, strings.jacobian(q)
    bent = strings.curvature(q, force.force)
    K = joint_stiffness(muscle_stiffness(muscles, force, KP), jacobian, bent)
    D = joint_damping(muscle_damping(muscles, force, KD), jacobian)
    torque = reflexive_torque(strings, law, q, activation)
    by_angle = -slope(lambda e: torque(q + e, np.zeros(7)), 1e-3)
    by_rate = -slope(lambda e: torque(q, e), 1e-3)
    assert np.max(np.abs(K.geometric)) > 0.01 * np.max(np.abs(K.total))
    np.testing.assert_allclose(K.total, by_angle, atol=1e-7 * np.max(np.abs(by_angle)))
    np.testing.assert_allclose(D.total, by_rate, atol=1e-7 * np.max(np.abs(by_rate)))
    for part in (*K, *D, K.total, D.total):
        np.testing.assert_allclose(part, part.T, atol=1e-12 * np.max(np.abs(part)))


@pytest.mark.parametrize("law", LAWS.values())
def test_linear_force_is_the_derivative(muscles, strings, law):
    """Eq 34 against eq 30 with the reflex of eq 33 in it, muscle by muscle, to 1e-7 of f0."""
    q, activation, force = held(strings, law, 1)
    length, l0, v0 = strings.length(q), working_length(muscles), muscles.fastest
    k = sum(muscle_stiffness(muscles, force, KP))
    c = sum(muscle_damping(muscles, force, KD))

    def reflexive(x, v):
        return law(muscles, length + x * l0, v * v0, activation + KP * x + KD * v).force

    by_x = five_points(lambda x: reflexive(x, 0.0), 1e-3)
    by_v = five_points(lambda v: reflexive(0.0, v), 1e-3)
    f0 = muscles.peak_force
    np.testing.assert_allclose(k * l0 / f0, by_x / f0, atol=1e-7)
    np.testing.assert_allclose(c * v0 / f0, by_v / f0, atol=1e-7)


@pytest.mark.parametrize("law", LAWS.values())
def test_passive_stiffness_is_that_of_an_energy(strings, law):
    """At rest the tissues' torques come from a potential: their differences are symmetric."""
    muscles = strings.muscles
    q, _, _ = held(strings, law, 2)
    nothing = np.zeros(25)

    def torque(at):
        force = law(muscles, strings.length(at), nothing, nothing)
        return -strings.jacobian(at).T @ force.force

    by_angle = -slope(lambda e: torque(q + e), 1e-3)
    force = law(muscles, strings.length(q), nothing, nothing)
    bent = strings.curvature(q, force.force)
    K = joint_stiffness(muscle_stiffness(muscles, force), strings.jacobian(q), bent)
    assert not K.active.any()
    assert not K.reflexive.any()
    size = np.max(np.abs(by_angle))
    np.testing.assert_allclose(K.total, by_angle, atol=1e-7 * size)
    np.testing.assert_allclose(by_angle, by_angle.T, atol=1e-7 * size)


def test_muscles_of_an_arm_stiffen_it(muscles, arm, postures):
    """MuJoCo's moment arms: no part but the geometric can be negative, all are symmetric."""
    _, lengths, jacobians, _ = postures
    for length, jacobian in zip(lengths[:50], jacobians, strict=False):
        force = LAWS["pennestri"](muscles, length, np.zeros(25), np.full(25, 0.3))
        stiffness = muscle_stiffness(muscles, force, KP, short_range=True)
        K = joint_stiffness(stiffness, jacobian, np.zeros((7, 7)))
        for part in (K.active, K.passive, K.reflexive):
            np.testing.assert_allclose(part, part.T, atol=1e-12 * np.max(np.abs(part)))
            assert np.min(np.linalg.eigvalsh(part)) > -1e-9


def test_short_range_stiffness_follows_the_force(muscles, strings):
    _, _, force = held(strings, LAWS["pennestri"])
    k = muscle_stiffness(muscles, force, short_range=True)
    np.testing.assert_allclose(
        k.active * working_length(muscles), SHORT_RANGE * (force.force - force.passive)
    )
    np.testing.assert_array_equal(k.passive, muscle_stiffness(muscles, force).passive)


@pytest.mark.parametrize("short_range", [False, True])
@pytest.mark.parametrize("law", LAWS.values())
def test_trace_slope_is_the_traces(strings, law, short_range):
    """The stiffness' trace is affine in the activations: exact from two of them."""
    muscles = strings.muscles
    q, activation, _ = held(strings, law, 3)
    length, jacobian, nothing = strings.length(q), strings.jacobian(q), np.zeros(25)

    def trace(a):
        force = law(muscles, length, nothing, a)
        stiffness = muscle_stiffness(muscles, force, KP, short_range=short_range)
        bent = strings.curvature(q, force.force)
        return np.trace(joint_stiffness(stiffness, jacobian, bent).total)

    bend = np.array([np.trace(strings.curvature(q, unit)) for unit in np.eye(25)])
    full = law(muscles, length, nothing, np.ones(25))
    gain = trace_slope(muscles, full, jacobian, bend, short_range=short_range)
    assert trace(activation) == pytest.approx(trace(nothing) + gain @ activation, rel=1e-12)


def spd(seed):
    root = np.random.default_rng(seed).normal(size=(7, 7))
    return 20 * root @ root.T + np.eye(7)


def test_endpoint_is_the_compliance_inverted(postures):
    for seed, hand in enumerate(postures[3][:50]):
        K = spd(seed)
        felt = endpoint(K, hand)
        expected = np.linalg.inv(hand @ np.linalg.solve(K, hand.T))
        np.testing.assert_allclose(felt.stiffness, expected, rtol=1e-8, atol=1e-8)
        axes = felt.axes * felt.principal @ felt.axes.T
        np.testing.assert_allclose(axes, felt.stiffness, rtol=1e-10, atol=1e-8)
        assert felt.idle > 0


def test_endpoint_of_joints_that_nothing_stiffens(postures):
    """Limp about some joint: the limit of ever softer ones, where compliance has none."""
    hand = postures[3][0]
    K = spd(1)
    limp = np.eye(7) - np.outer(np.ones(7), np.ones(7)) / 7
    K = limp @ K @ limp
    soft = endpoint(K + 1e-6 * np.eye(7), hand)
    none = endpoint(K, hand)
    np.testing.assert_allclose(none.stiffness, soft.stiffness, rtol=1e-5, atol=1e-3)
    assert np.all(np.isfinite(endpoint(np.zeros((7, 7)), hand).stiffness))
    assert endpoint(-np.eye(7), hand).idle < 0


def test_ellipse_is_the_force_all_round(postures):
    felt = endpoint(spd(2), postures[3][0])
    ellipse = felt.ellipse((0, 2), 5)
    np.testing.assert_allclose(ellipse[0], felt.stiffness[[0, 2], 0])
    np.testing.assert_allclose(ellipse[1], felt.stiffness[[0, 2], 2], atol=1e-12)
    np.testing.assert_allclose(ellipse[0], ellipse[4])


def test_a_stretched_arm_is_told(postures):
    hand = postures[3][0].copy()
    hand[2] = 0.0
    with pytest.raises(PostureIKError, match="cannot move along"):
        endpoint(spd(3), hand)
