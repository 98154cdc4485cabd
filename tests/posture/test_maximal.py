"""Joint and maximal coordinates, two formulations of one projection, must agree."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.arrays import call
from posture_ik.posture.maximal import Maximal
from posture_ik.posture.projection import Projection, task_rates

MOVING = ["task.head.looking.nod_deg", "seat.recline_deg"]


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.mark.parametrize("name", ["reclined_15", "pilot_push"])
def test_minimal_and_maximal_coordinates_agree(body: pik.Body, name: str) -> None:
    """Velocities, accelerations and multipliers, to 1e-8 of the largest, from the same guesses."""
    rng = np.random.default_rng(8)
    problem = pik.load_problem(name)
    posture = pik.solve_posture(body, problem)
    q, statement, model = posture.q, posture.statement, posture.body.model
    rates, drift_of = task_rates(statement.program)
    signals = [0.0, problem.seat.recline_deg], [30.0, 20.0], [5.0, -8.0]
    targets, first, second = (x.full().ravel() for x in statement.along(MOVING)(*signals))
    p = statement.at(statement.problem, targets).parameters
    jacobian, moving = call(rates, q, p, first)
    mass = pin.crba(model, model.createData(), q)
    projection = Projection(mass, jacobian, np.ones(model.nv, dtype=bool))
    v_guess, a_guess = rng.normal(size=(2, model.nv))
    v, impulses = projection(v_guess, moving)
    (drift,) = call(drift_of, q, v, p, first, second)
    a, forces = projection(a_guess, drift)

    maximal = Maximal(posture, v)
    bodies = maximal.jacobian
    np.testing.assert_allclose(maximal.tasks @ bodies, jacobian, atol=1e-10)
    found = maximal.project(bodies @ v_guess, np.zeros_like(maximal.drift), -moving)
    close(found.bodies, bodies @ v)
    close(found.multipliers, impulses)
    # The bodies' accelerations are X a plus what v alone brings; a guess carries both.
    coasting = maximal.coasting
    asked = -drift + maximal.tasks @ coasting
    found = maximal.project(bodies @ a_guess + coasting, maximal.drift, asked)
    close(found.bodies, bodies @ a + coasting)
    close(found.multipliers, forces)


def close(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found.ravel(), expected, atol=1e-8 * np.abs(expected).max())


def test_joints_act_on_both_bodies_alike(body: pik.Body) -> None:
    """Internal: over all bodies, moved to one point, what joints and seat do sums to the seat's."""
    posture = pik.solve_posture(body, pik.load_problem("reclined_15"))
    model, rng = body.model, np.random.default_rng(4)
    guess = rng.normal(size=6 * (model.njoints - 1))
    maximal = Maximal(posture, np.zeros(model.nv))
    rest = np.zeros_like(maximal.drift), np.zeros(len(maximal.tasks))
    found = maximal.project(guess, *rest)
    data = model.createData()
    pin.forwardKinematics(model, data, posture.q)
    total = pin.Force.Zero()
    for i in range(1, model.njoints):
        # M (V - V0) is what joints and tasks do to a body
        change = found.bodies[i - 1] - guess.reshape(-1, 6)[i - 1]
        given = model.inertias[i].matrix() @ change
        task = -(maximal.tasks[:, 6 * (i - 1) : 6 * i].T @ found.multipliers)
        np.testing.assert_allclose(given, found.joints[i - 1] + task, atol=1e-8)
        total += data.oMi[i].act(pin.Force(found.joints[i - 1]))
    # the seat leaves its three springs' directions free: up, about x, about y
    slide = data.oMi[1].rotation[:, 2]
    assert abs(total.linear @ slide) < 1e-8 * max(1.0, np.abs(total.linear).max())
