"""How fast a motion is: a step of the projections, a whole nod, and Pink's differential IK."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.arrays import call
from posture_ik.posture.projection import Projection, task_rates
from posture_ik.posture.statement import Statement

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type

NODDING = "task.head.looking.nod_deg"


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.mark.benchmark(group="projection step")
def test_projection_step(benchmark: Benchmark, body: pik.Body) -> None:
    """Mass matrix, task rates, one factor, velocity and acceleration projected."""
    model, data = body.model, body.model.createData()
    statement = Statement.of(body, pik.load_problem("nod"))
    rates, drift = task_rates(statement.program)
    course = statement.along([NODDING])(5.0, 30.0, 2.0)
    targets, first, second = (x.full().ravel() for x in course)
    p = statement.at(statement.problem, targets).parameters
    q, guess = body.q_reference, np.linspace(-1.0, 1.0, model.nv)
    free = np.ones(model.nv, dtype=bool)

    def step() -> np.ndarray:
        jacobian, moving = call(rates, q, p, first)
        projection = Projection(pin.crba(model, data, q), jacobian, free)
        v = projection(guess, moving)[0]
        (bend,) = call(drift, q, v, p, first, second)
        return projection(guess, bend)[0]

    benchmark(step)


@pytest.mark.benchmark(group="nod")
def test_nod_500_hz_2_s(benchmark: Benchmark, body: pik.Body) -> None:
    """1001 steps with positions, projections, inverse dynamics and reactions."""
    problem = pik.load_problem("nod")
    pik.solve_posture(body, problem)
    motion = benchmark.pedantic(pik.move, (body, problem), rounds=1)
    assert len(motion.time) == 1001


@pytest.mark.benchmark(group="nod, velocities of 20 steps against Pink")
def test_ours_20_steps(benchmark: Benchmark, body: pik.Body) -> None:
    problem = pik.load_problem("nod", ("motion.rate=500", "motion.duration=0.038"))
    benchmark.pedantic(pik.move, (body, problem), rounds=3, warmup_rounds=1)


@pytest.mark.benchmark(group="nod, velocities of 20 steps against Pink")
def test_pink_20_steps(benchmark: Benchmark, body: pik.Body) -> None:
    """Pink holding the head's pose by differential IK until each step is met to the same 1e-9."""
    pink = pytest.importorskip("pink", reason="pin-pink is not installed")
    settings = ("motion.rate=500", "motion.duration=0.038")
    motion = pik.move(body, pik.load_problem("nod", settings))
    springs = pink.tasks.PostureTask(cost=np.sqrt(body.stiffness))
    springs.set_target(body.q_reference)
    limits = [pink.limits.ConfigurationLimit(body.model, config_limit_gain=1.0)]
    heads = [posture.frames["Head"] for posture in motion.postures]
    task = pink.tasks.FrameTask("Head", position_cost=1.0, orientation_cost=1.0)

    def drive() -> np.ndarray:
        configuration = pink.Configuration(body.model, body.model.createData(), motion.q[0])
        for head in heads:
            task.set_target(head)
            for _ in range(50):
                velocity = pink.solve_ik(
                    configuration, [springs], 1.0, "daqp", limits=limits, constraints=[task]
                )
                configuration.integrate_inplace(velocity, 1.0)
                if np.abs(task.compute_error(configuration)).max() < 1e-9:
                    break
        return configuration.q

    benchmark.pedantic(drive, rounds=3, warmup_rounds=1)
    error = pin.log(motion.postures[-1].frames["Head"].actInv(heads[-1])).vector
    assert np.abs(error).max() < 1e-9
