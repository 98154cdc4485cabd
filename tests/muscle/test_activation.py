"""The optimum against solvers that are not ours, its certificate, and demands beyond strength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from arm_muscles import JOINTS, RANGES
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, lsq_linear, minimize, nnls

from posture_ik.errors import PostureIKError
from posture_ik.muscle.activation import recruit, volumes
from posture_ik.muscle.hill import LAWS


def capacities(muscles, lengths, jacobians, law="pennestri"):
    rest, full = np.zeros_like(lengths), np.ones_like(lengths)
    active = LAWS[law](muscles, lengths, rest, full).d_activation
    return -np.swapaxes(jacobians, 1, 2) * active[:, None, :]


@pytest.fixture(scope="module")
def strengths(muscles, postures):
    _, lengths, jacobians, _ = postures
    return capacities(muscles, lengths, jacobians)


@pytest.fixture(scope="module")
def loads(postures):
    """Torques against 1000 random forces at the hand, of 0 to 60 N."""
    random = np.random.default_rng(6)
    forces = random.normal(size=(1000, 3))
    forces *= random.uniform(0, 60, (1000, 1)) / np.linalg.norm(forces, axis=1, keepdims=True)
    return np.einsum("kij,ki->kj", postures[3], forces)


def least_squares(capacity, demand):
    """The same optimum as a least-distance problem by non-negative least squares.

    Lawson & Hanson (1974), chapter 23; SciPy's own active set. None where no activation gives it.
    """
    m = capacity.shape[1]
    size = np.abs(capacity).max(axis=1, keepdims=True)
    rows, right = capacity / size, demand / size[:, 0]
    upright = np.vstack([rows, -rows, np.eye(m), -np.eye(m)])
    height = np.concatenate([right, -right, np.zeros(m), -np.ones(m)])
    matrix = np.vstack([upright.T, height])
    target = np.append(np.zeros(m), 1.0)
    residual = matrix @ nnls(matrix, target, maxiter=5000)[0] - target
    return None if abs(residual[-1]) < 1e-9 else -residual[:-1] / residual[-1]


def test_optimum_of_1000_postures_and_loads(strengths, loads):
    """Objective to 1e-7 of SciPy's, torque to 1e-8 N m, and the same verdict on strength."""
    beyond = 0
    for capacity, demand in zip(strengths, loads, strict=True):
        answer = recruit(capacity, demand)
        theirs = least_squares(capacity, demand)
        assert answer.answered == (theirs is not None)
        assert answer.certificate.holds
        assert np.all((answer.activation >= 0) & (answer.activation <= 1))
        if theirs is None:
            beyond += 1
            continue
        assert answer.objective == pytest.approx(theirs @ theirs, abs=1e-7)
        np.testing.assert_allclose(capacity @ answer.activation, demand, atol=1e-8)
        assert not answer.reserve.any()
    assert 10 < beyond < 500  # both verdicts are put to the test


def sequential(capacity, demand, start, cost, slope):
    size = np.abs(capacity).max(axis=1)
    found = minimize(
        cost,
        start,
        jac=slope,
        bounds=[(0, 1)] * len(start),
        constraints={
            "type": "eq",
            "fun": lambda a: (capacity @ a - demand) / size,
            "jac": lambda a: capacity / size[:, None],
        },
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert found.success
    return found


@pytest.mark.parametrize("level", [0.0, 0.3])
def test_weights_and_level_against_slsqp(muscles, strengths, level):
    random = np.random.default_rng(7)
    weights = volumes(muscles.peak_force, muscles.optimal_length)
    assert np.mean(weights) == pytest.approx(1.0)
    for capacity in strengths[:20]:
        feasible = random.uniform(0, 1, 25) ** 2
        answer = recruit(capacity, capacity @ feasible, weights, level=level)
        found = sequential(
            capacity,
            capacity @ feasible,
            feasible,
            lambda a: weights @ (a - level) ** 2,
            lambda a: 2 * weights * (a - level),
        )
        assert answer.certificate.holds
        assert answer.objective == pytest.approx(found.fun, abs=1e-7)


def test_even_share_is_the_linear_programs(strengths):
    """Highest activation to 1e-7 of HiGHS' least, which it gets to 1e-9 or so."""
    random = np.random.default_rng(8)
    for capacity in strengths[:100]:
        demand = capacity @ random.uniform(0, 1, 25) ** 2
        answer = recruit(capacity, demand, evenly=True)
        below = np.hstack([np.eye(25), -np.ones((25, 1))])
        size = np.abs(capacity).max(axis=1)
        least = linprog(
            np.append(np.zeros(25), 1.0),
            A_ub=below,
            b_ub=np.zeros(25),
            A_eq=np.hstack([capacity / size[:, None], np.zeros((7, 1))]),
            b_eq=demand / size,
            bounds=[(0, 1)] * 26,
        )
        assert answer.certificate.holds
        assert answer.ceiling == pytest.approx(least.fun, abs=1e-7)
        assert np.max(answer.activation) == pytest.approx(answer.ceiling, abs=1e-9)
        np.testing.assert_allclose(capacity @ answer.activation, demand, atol=1e-8)


def test_beyond_strength_the_reserve_is_the_least(strengths, postures):
    """500 N at the hand: the missing torque to 1e-4 N m of SciPy's bounded least squares."""
    random = np.random.default_rng(9)
    beyond = 0
    for capacity, hand in zip(strengths[:50], postures[3], strict=False):
        force = random.normal(size=3)
        demand = hand.T @ (500 * force / np.linalg.norm(force))
        answer = recruit(capacity, demand)
        assert answer.certificate.holds
        if answer.answered:  # along the bones
            continue
        beyond += 1
        least = lsq_linear(capacity, demand, (0, 1), method="bvls", tol=1e-14)
        assert np.linalg.norm(answer.reserve) == pytest.approx(
            np.linalg.norm(least.fun), abs=1e-4, rel=1e-7
        )
        np.testing.assert_allclose(
            capacity @ answer.activation + answer.reserve, demand, atol=1e-10
        )
        first = answer.shortfalls(JOINTS)[0]
        worst = int(np.argmax(np.abs(answer.reserve)))
        assert first == (JOINTS[worst], answer.reserve[worst])
        assert str(first).startswith(f"{JOINTS[worst]} lacks ")
        np.testing.assert_array_equal(
            recruit(capacity, demand, evenly=True).reserve, answer.reserve
        )


@pytest.mark.parametrize("evenly", [False, True])
def test_at_the_limit_of_strength(strengths, loads, evenly):
    """The farthest along a load that HiGHS finds, and a hair to either side: always an optimum.

    Multipliers grow without bound there, 1e6 and more; the verdict turns within 1e-6 of it.
    """
    for capacity, load in zip(strengths[:40], loads, strict=False):
        rows = np.hstack([capacity, -load[:, None]]) / np.abs(capacity).max(axis=1, keepdims=True)
        bounds = [(0, 1)] * 25 + [(0, 1e4)]
        farthest = linprog(np.append(np.zeros(25), -1), A_eq=rows, b_eq=np.zeros(7), bounds=bounds)
        for share in (0.99, 1 - 1e-6, 1 - 1e-9, 1, 1 + 1e-9, 1 + 1e-6):
            answer = recruit(capacity, share * farthest.x[-1] * load, evenly=evenly)
            assert answer.certificate.holds
            if abs(share - 1) >= 1e-6:
                assert answer.answered == (share < 1)


def test_a_joint_that_no_muscle_moves_names_its_reserve(strengths):
    capacity = strengths[0].copy()
    capacity[4] = 0.0
    demand = capacity @ np.full(25, 0.2)
    demand[4] = 3.0
    answer = recruit(capacity, demand)
    assert [shortfall.joint for shortfall in answer.shortfalls(JOINTS)] == [JOINTS[4]]
    assert answer.reserve[4] == pytest.approx(3.0, abs=1e-9)
    demand[4] = 0.0
    assert recruit(capacity, demand).certificate.holds
    assert recruit(capacity, demand).shortfalls(JOINTS) == ()


@pytest.mark.parametrize("law", LAWS)
def test_joint_limits_are_answered(arm, muscles, law):
    """Every corner of the piloting range, where muscles are shortest and most stretched."""
    for corner in range(128):
        q = np.array([RANGES[i, corner >> i & 1] for i in range(7)])
        length, jacobian, hand = arm(q)
        force = LAWS[law](muscles, length, np.zeros(25), np.ones(25))
        demand = hand.T @ [0.0, 0.0, 50.0] + jacobian.T @ force.passive
        answer = recruit(-jacobian.T * force.d_activation, demand)
        assert answer.certificate.holds
        assert np.all(np.isfinite(answer.activation))


@settings(deadline=None, max_examples=200)
@given(st.integers(0, 2**31), st.floats(0.0, 30.0), st.floats(0.0, 1.0), st.booleans())
def test_any_capacity_and_demand_is_answered(seed, much, level, evenly):
    """Joints from 0.1 to 100 N m, demands of nothing to thirty times strength: it is an optimum."""
    random = np.random.default_rng(seed)
    size = 10 ** random.uniform(-1, 2, (7, 1)) * 10 ** random.uniform(-1, 0.5, 25)
    capacity = random.normal(size=(7, 25)) * size
    demand = much * capacity @ random.uniform(0, 1, 25) ** 3
    answer = recruit(capacity, demand, level=0.0 if evenly else level, evenly=evenly)
    assert answer.certificate.holds
    assert answer.answered or much > 1


def test_multipliers_price_the_demand(strengths):
    """By differences of 1e-4 of it, central, exact for a quadratic while no bound changes."""
    capacity = strengths[3]
    demand = capacity @ np.linspace(0.0, 0.4, 25)
    answer = recruit(capacity, demand)
    assert np.any(answer.bound_multipliers < -1e-3)
    for i, step in enumerate(1e-4 * np.diag(np.abs(demand))):
        more, less = recruit(capacity, demand + step), recruit(capacity, demand - step)
        price = (more.objective - less.objective) / (2 * step[i])
        assert price == pytest.approx(-answer.multipliers[i], rel=1e-6, abs=1e-9)


def test_bound_multipliers_tell_who_would_give_more(strengths):
    """At full activation and pressed; a stronger one then costs less, a slack bound nothing."""
    capacity = strengths[3]
    way = capacity @ np.linspace(0.0, 0.4, 25)
    rows = np.hstack([capacity, -way[:, None]]) / np.abs(capacity).max(axis=1, keepdims=True)
    farthest = linprog(
        np.append(np.zeros(25), -1.0), A_eq=rows, b_eq=np.zeros(7), bounds=[(0, 1)] * 25 + [(0, 99)]
    )
    answer = recruit(capacity, 0.97 * farthest.x[-1] * way)
    assert answer.answered
    assert not recruit(capacity, 1.001 * farthest.x[-1] * way).answered
    pressed = answer.bound_multipliers > 1e-9
    assert pressed.any()
    np.testing.assert_allclose(answer.activation[pressed], 1.0, atol=1e-12)
    np.testing.assert_allclose(answer.activation[answer.bound_multipliers < -1e-9], 0.0, atol=1e-12)


def test_a_motion_starts_from_the_moment_before(strengths, postures):
    """Same answers in fewer iterations, whatever the start was an answer to."""
    demands = np.array([c @ np.full(25, 0.2) for c in strengths[:2]])
    path = np.linspace(0, 1, 200)
    last, cold, warm = None, 0, 0
    for s in path:
        capacity = (1 - s) * strengths[0] + s * strengths[1]
        demand = (1 - s) * demands[0] + s * demands[1]
        fresh = recruit(capacity, demand)
        last = recruit(capacity, demand, start=last)
        np.testing.assert_allclose(last.activation, fresh.activation, atol=1e-10)
        cold, warm = cold + fresh.iterations, warm + last.iterations
    assert warm < cold / 3
    for even in (True, False):
        far = recruit(strengths[2], 50 * demands[1], evenly=even, start=last)
        assert far.certificate.holds
        assert not far.answered
        back = recruit(strengths[0], demands[0], start=far)
        np.testing.assert_allclose(back.activation, recruit(strengths[0], demands[0]).activation)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_told(strengths, bad):
    demand = np.zeros(7)
    spoilt = strengths[0].copy()
    spoilt[2, 3] = bad
    with pytest.raises(PostureIKError, match="finite"):
        recruit(spoilt, demand)
    demand[5] = bad
    with pytest.raises(PostureIKError, match="finite"):
        recruit(strengths[0], demand)
    with pytest.raises(PostureIKError, match="positive"):
        recruit(strengths[0], np.zeros(7), np.full(25, bad))


def test_certificate_tells_a_wrong_answer(strengths):
    answer = recruit(strengths[0], strengths[0] @ np.full(25, 0.2))
    assert answer.certificate.holds
    other = np.clip(answer.activation + 1e-4, 0, 1)
    wrong = replace(answer, activation=other)
    assert not wrong.certificate.holds
    assert not replace(answer, multipliers=answer.multipliers * 1.001).certificate.holds
