"""Modes change no torque, ranges end at a bound, and the extremes are the linear program's."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from posture_ik.errors import PostureIKError
from posture_ik.muscle.activation import recruit
from posture_ik.muscle.hill import LAWS
from posture_ik.muscle.modes import Modes, extremes


@pytest.fixture(scope="module")
def capacity(muscles, postures):
    _, lengths, jacobians, _ = postures
    rest, full = np.zeros(25), np.ones(25)
    return -jacobians[0].T * LAWS["pennestri"](muscles, lengths[0], rest, full).d_activation


def test_eighteen_modes_without_torque(capacity):
    modes = Modes.of(capacity)
    assert modes.basis.shape == (25, 18)
    np.testing.assert_allclose(modes.basis.T @ modes.basis, np.eye(18), atol=1e-13)
    np.testing.assert_allclose(capacity @ modes.basis, 0.0, atol=1e-9)
    direction = np.linspace(-1, 1, 25)
    within = modes.part(direction)
    # what is cut off is made of the rows of the capacity alone
    rest, *_ = np.linalg.lstsq(capacity.T, direction - within, rcond=None)
    np.testing.assert_allclose(capacity.T @ rest, direction - within, atol=1e-10)


def test_a_joint_without_muscles_leaves_a_mode_more(capacity):
    cut = capacity.copy()
    cut[5] = 0.0
    assert Modes.of(cut).basis.shape == (25, 19)


def test_moving_along_modes_keeps_torque_and_bounds(capacity):
    """Torque to 1e-9 N m at both ends of the range of every mode, one muscle at a bound."""
    modes = Modes.of(capacity)
    activation = np.full(25, 0.3)
    for mode in modes.basis.T:
        for end, sign in zip(modes.range(activation, mode), (-1, 1), strict=True):
            assert sign * end > 0
            there = activation + end * mode
            np.testing.assert_allclose(capacity @ there, capacity @ activation, atol=1e-9)
            assert np.min(there) > -1e-12
            assert np.max(there) < 1 + 1e-12
            assert np.min(np.minimum(there, 1 - there)) == pytest.approx(0.0, abs=1e-12)


def test_a_muscle_at_its_bound_ends_the_range(capacity):
    modes = Modes.of(capacity)
    activation = np.full(25, 0.3)
    activation[7] = 0.0
    mode = modes.part(np.eye(25)[7])
    assert mode[7] > 0
    back, forth = modes.range(activation, mode)
    assert back == 0.0
    assert forth > 0
    with pytest.raises(PostureIKError, match="direction is 0"):
        modes.range(activation, np.zeros(25))


def test_the_level_rises_along_the_modes(capacity):
    """From eq 32's answer upwards: the same torque, more activation, no step across the modes."""
    demand = capacity @ np.full(25, 0.1)
    answers = [recruit(capacity, demand, level=level) for level in np.linspace(0, 1, 11)]
    sums = [answer.activation.sum() for answer in answers]
    assert np.all(np.diff(sums) > 0)
    modes = Modes.of(capacity)
    for before, after in pairwise(answers):
        step = after.activation - before.activation
        np.testing.assert_allclose(capacity @ step, 0.0, atol=1e-9)
        np.testing.assert_allclose(modes.part(step), step, atol=1e-10)


def test_extremes_are_optimal(capacity):
    """Torques to 1e-9 N m, and multipliers y of the torques that prove it: where an activation is
    between its bounds slope = Cᵀ y, at 0 the slope is above that, at 1 below (1e-9 of the slope).
    """
    random = np.random.default_rng(3)
    for _ in range(30):
        activation = random.uniform(0, 1, 25) ** 2
        slope = random.uniform(-0.2, 1.0, 25) * 10 ** random.uniform(-1, 2)
        least, most = extremes(capacity, activation, slope)
        assert slope @ least < slope @ activation < slope @ most
        for end, sign in ((least, 1), (most, -1)):
            assert np.all((end >= 0) & (end <= 1))
            np.testing.assert_allclose(capacity @ end, capacity @ activation, atol=1e-9)
            free = (end > 1e-9) & (end < 1 - 1e-9)
            y = np.linalg.lstsq(capacity[:, free].T, sign * slope[free], rcond=None)[0]
            reduced = (sign * slope - capacity.T @ y) / np.abs(slope).max()
            np.testing.assert_allclose(reduced[free], 0.0, atol=1e-9)
            assert np.all(reduced[end <= 1e-9] >= -1e-9)
            assert np.all(reduced[end >= 1 - 1e-9] <= 1e-9)


def test_at_the_end_of_strength_nothing_is_left_to_choose(capacity):
    """Beyond strength the torque given is the most there is along the demand."""
    answer = recruit(capacity, capacity @ np.ones(25) * 3.0)
    slope = np.linspace(-1.0, 1.0, 25)
    least, most = extremes(capacity, answer.activation, slope)
    assert slope @ least <= slope @ answer.activation + 1e-9 <= slope @ most + 2e-9


def test_extremes_of_activations_out_of_bounds_are_refused(capacity):
    with pytest.raises(PostureIKError, match="no optimum found"):
        extremes(capacity, np.full(25, 5.0), np.ones(25))
