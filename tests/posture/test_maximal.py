"""The projections once more in the source's own coordinates: six a body, joints as phi(q) = 0.

Unknown are the twists V of all bodies. A joint leaves free only its axis S, so that the parts of
the relative twist along the five directions N orthogonal to S vanish (eqs 23, 28), and the tasks
hold as rows B with B X = J, where V = X v is what the joints allow.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import block_diag, null_space

import posture_ik as pik
from posture_ik.arrays import call
from posture_ik.posture.projection import Projection, task_rates

MOVING = ["task.head.looking.nod_deg", "seat.recline_deg"]


class Maximal:
    """KKT system over the twists of all bodies, each in its own frame, at one state."""

    def __init__(self, model: pin.Model, q: np.ndarray, v: np.ndarray) -> None:
        data = model.createData()
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        pin.computeJointJacobians(model, data, q)
        count = model.njoints - 1
        self.mass = block_diag(*[model.inertias[i].matrix() for i in range(1, count + 1)])
        rows = np.zeros((5 * count, 6 * count))
        self.bias = np.zeros(5 * count)
        blocks = []
        for i in range(1, count + 1):
            jacobian = pin.getJointJacobian(model, data, i, pin.LOCAL)
            blocks.append(jacobian)
            axis = jacobian[:, model.joints[i].idx_v]
            free = null_space(axis[None])  # (6, 5), the directions the joint holds
            here = slice(5 * (i - 1), 5 * i)
            rows[here, 6 * (i - 1) : 6 * i] = free.T
            parent = model.parents[i]
            if parent:
                carry = data.liMi[i].inverse().action
                rows[here, 6 * (parent - 1) : 6 * parent] = -free.T @ carry
            # Across a hinge or slide: a_i = X a_parent + S a + V_i x (S v).
            rate = axis * v[model.joints[i].idx_v]
            product = pin.Motion(data.v[i]).cross(pin.Motion(rate)).vector
            self.bias[here] = -free.T @ product
        self.rows = rows
        self.joints = np.vstack(blocks)  # X (6 bodies, n)
        self.accelerations = np.concatenate([data.a[i].vector for i in range(1, count + 1)])

    def project(self, guess: np.ndarray, tasks: np.ndarray, joints: np.ndarray, asked: np.ndarray):
        constraints = np.vstack([self.rows, tasks])
        count, held = constraints.shape[1], constraints.shape[0]
        system = np.block([[self.mass, constraints.T], [constraints, np.zeros((held, held))]])
        right = np.concatenate([self.mass @ guess, joints, asked])
        return np.linalg.solve(system, right)[:count]


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def test_minimal_and_maximal_coordinates_agree(body: pik.Body) -> None:
    """Velocities and accelerations of all bodies to 1e-8 of the largest."""
    rng = np.random.default_rng(8)
    model = body.model
    posture = pik.solve_posture(body, pik.load_problem("recline_sweep"))
    q, statement = posture.q, posture.statement
    rates, drift_of = task_rates(statement.program)
    signals = [0.0, 15.0], [30.0, 20.0], [5.0, -8.0]
    targets, first, second = (x.full().ravel() for x in statement.along(MOVING)(*signals))
    p = statement.at(statement.problem, targets).parameters
    jacobian, moving = call(rates, q, p, first)
    data = model.createData()
    upper = np.triu(pin.crba(model, data, q))
    projection = Projection(upper + np.triu(upper, 1).T, jacobian, np.ones(model.nv, dtype=bool))
    v_guess, a_guess = rng.normal(size=(2, model.nv))
    v = projection(v_guess, moving)[0]
    (drift,) = call(drift_of, q, v, p, first, second)
    a = projection(a_guess, drift)[0]

    maximal = Maximal(model, q, v)
    tasks = jacobian @ np.linalg.pinv(maximal.joints)
    twists = maximal.project(maximal.joints @ v_guess, tasks, np.zeros(len(maximal.bias)), -moving)
    expected = maximal.joints @ v
    np.testing.assert_allclose(twists, expected, atol=1e-8 * np.abs(expected).max())

    # The bodies' accelerations are X a plus what v alone brings; a guess carries both.
    coasting = maximal.accelerations
    asked = -drift + tasks @ coasting
    found = maximal.project(maximal.joints @ a_guess + coasting, tasks, -maximal.bias, asked)
    expected = maximal.joints @ a + coasting
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())
