"""How fast an arm's muscles are: one program of activations, cold and warm, and their forces."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import opensim_arms as peer
import pytest
from arm_muscles import TABLE, Table
from scipy.optimize import minimize

import posture_ik as pik
from posture_ik.muscle.activation import recruit
from posture_ik.muscle.hill import LAWS
from posture_ik.muscle.modes import Modes, extremes

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type


@pytest.fixture(scope="module")
def capacity() -> np.ndarray:
    """Seven joints of up to some 20 N m a muscle, 25 muscles."""
    return 20 * np.random.default_rng(0).normal(size=(7, 25))


@pytest.fixture(scope="module")
def demand(capacity: np.ndarray) -> np.ndarray:
    return capacity @ np.random.default_rng(1).uniform(0, 0.4, 25)


@pytest.mark.benchmark(group="activation of an arm, 25 muscles")
def test_cold(benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray) -> None:
    assert benchmark(recruit, capacity, demand).answered


@pytest.mark.benchmark(group="activation of an arm, 25 muscles")
def test_warm(benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray) -> None:
    """From the answer to a demand 1 % less."""
    before = recruit(capacity, 0.99 * demand)
    assert benchmark(recruit, capacity, demand, start=before).answered


@pytest.mark.benchmark(group="activation of an arm, 25 muscles")
def test_beyond_strength(benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray) -> None:
    assert not benchmark(recruit, capacity, 20 * demand).answered


@pytest.mark.benchmark(group="activation of an arm, 25 muscles")
def test_evenly(benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray) -> None:
    assert benchmark(recruit, capacity, demand, evenly=True).answered


@pytest.mark.benchmark(group="activation of an arm, 25 muscles")
def test_slsqp(benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray) -> None:
    """SciPy, to a like accuracy."""

    def solve() -> Any:
        return minimize(
            lambda a: a @ a,
            np.zeros(25),
            jac=lambda a: 2 * a,
            bounds=[(0, 1)] * 25,
            constraints={
                "type": "eq",
                "fun": lambda a: (capacity @ a - demand) / 20,
                "jac": lambda a: capacity / 20,
            },
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 300},
        )

    found = benchmark.pedantic(solve, rounds=3)
    assert found.fun == pytest.approx(recruit(capacity, demand).objective, abs=1e-7)


@pytest.mark.benchmark(group="modes of an arm")
def test_modes(benchmark: Benchmark, capacity: np.ndarray) -> None:
    assert benchmark(Modes.of, capacity).basis.shape == (25, 18)


@pytest.mark.benchmark(group="modes of an arm")
def test_stiffest_and_softest(
    benchmark: Benchmark, capacity: np.ndarray, demand: np.ndarray
) -> None:
    activation = recruit(capacity, demand).activation
    least, most = benchmark(extremes, capacity, activation, np.linspace(0.1, 1.0, 25))
    assert least.sum() < most.sum()


@pytest.mark.benchmark(group="forces of an arm, 25 muscles")
@pytest.mark.parametrize("law", LAWS)
def test_forces(benchmark: Benchmark, law: str) -> None:
    """Forces and all their derivatives."""
    force, optimal, slack, pennation = np.array(list(TABLE.values())).T
    muscles = Table(tuple(TABLE), force, optimal, slack, np.radians(pennation), 10 * optimal)
    length, rate = slack + 1.1 * optimal, 0.2 * optimal
    result = benchmark(LAWS[law], muscles, length, rate, np.full(25, 0.3))
    assert np.all(result.force > 0)


@pytest.fixture(scope="module")
def stirring() -> tuple[pik.Body, pik.Motion, pik.Problem]:
    """51 instants of stirring the cyclic while the left hand carries half a kilogram."""
    body = pik.build_body(pik.Subject())
    settings = (
        "motion.rate=25",
        "activation.law=de_groote",
        "activation.cost=squares",
        "activation.hand_force.left=[0, 0, -5]",
    )
    problem = pik.load_problem("pilot_cyclic", settings)
    return body, pik.move(body, problem), problem


@pytest.mark.benchmark(group="activation of both arms, 50 muscles, 51 instants")
def test_ours_51_instants(
    benchmark: Benchmark, stirring: tuple[pik.Body, pik.Motion, pik.Problem]
) -> None:
    """Kinematics, inverse dynamics, paths with wrapping, forces and two programs an instant."""
    activity = benchmark(pik.solve_activation, *stirring)
    assert len(activity.activation) == 51
    assert activity.activation[:, 25:].any()


@pytest.mark.benchmark(group="activation of both arms, 50 muscles, 51 instants")
def test_opensim_51_instants(
    benchmark: Benchmark,
    stirring: tuple[pik.Body, pik.Motion, pik.Problem],
    opensim: ProcessPoolExecutor,
) -> None:
    """Its static optimisation as it comes, its model built beforehand.

    It holds the first posture 51 times, which is no less work, as it starts each from nothing. The
    paths are linear in the angles: with its wrapping it would take longer.
    """
    activity = pik.solve_activation(*stirring)
    arms = peer.arms_of(activity)

    def build() -> None:
        opensim.submit(peer.prepare, arms, activity.passive[0]).result()

    def solve() -> np.ndarray:
        return opensim.submit(peer.follow, 51).result()[0]

    activation = benchmark.pedantic(solve, setup=build, rounds=3)
    assert np.all(np.abs(activation - activity.activation[0]) < 0.05)
