"""The twin's inverse dynamics against Pinocchio: random trees of every joint it knows, our body."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from test_kinematics import random_tree

import posture_ik as pik
from posture_ik.kinematics import Kinematics, inverse_dynamics, torque_derivatives

# Both sides do the same sums in double precision, relative to the largest force in the tree.
TOLERANCE = 1e-10


def compare(model: pin.Model, seed: int) -> None:
    twin = Kinematics.of(model)
    v, a = ca.SX.sym("v", model.nv), ca.SX.sym("a", model.nv)
    tau = ca.Function("tau", [twin.q, v, a, twin.parameters], [inverse_dynamics(twin, v, a)])
    pin.seed(seed)
    q = pin.randomConfiguration(model)
    rng = np.random.default_rng(seed)
    velocity, acceleration = rng.normal(size=(2, model.nv))
    numbers, data = twin.values(model), model.createData()

    expected = pin.rnea(model, data, q, velocity, acceleration)
    got = tau(q, velocity, acceleration, numbers).full().ravel()
    np.testing.assert_allclose(got, expected, rtol=0, atol=TOLERANCE * np.abs(expected).max())

    bias = pin.nonLinearEffects(model, data, q, velocity)
    got = tau(q, velocity, np.zeros(model.nv), numbers).full().ravel()
    np.testing.assert_allclose(got, bias, rtol=0, atol=TOLERANCE * np.abs(bias).max())


@pytest.mark.parametrize("seed", range(20))
def test_equals_rnea_on_random_trees(seed: int) -> None:
    compare(random_tree(seed), seed)


@pytest.mark.parametrize("seed", range(3))
def test_equals_rnea_on_the_person(seed: int) -> None:
    compare(pik.build_body(pik.Subject()).model, seed)


def test_power_is_the_rate_of_change_of_energy() -> None:
    """tau·v = d/dt (kinetic + potential), by central differences along a motion."""
    model = pik.build_body(pik.Subject()).model
    twin = Kinematics.of(model)
    v, a = ca.SX.sym("v", model.nv), ca.SX.sym("a", model.nv)
    tau = ca.Function("tau", [twin.q, v, a, twin.parameters], [inverse_dynamics(twin, v, a)])
    rng = np.random.default_rng(0)
    q, velocity, acceleration = 0.1 * rng.normal(size=(3, model.nv))
    data, step = model.createData(), 1e-4

    def energy(t: float) -> float:
        at = q + t * velocity + t**2 / 2 * acceleration
        return float(pin.computeMechanicalEnergy(model, data, at, velocity + t * acceleration))

    power = velocity @ tau(q, velocity, acceleration, twin.values(model)).full().ravel()
    assert power == pytest.approx((energy(step) - energy(-step)) / (2 * step), rel=1e-6)


def hinged_tree(seed: int) -> pin.Model:
    """A branching tree of nine turns and slides about any axes, each with a body."""
    rng = np.random.default_rng(seed)
    pin.seed(seed)
    model = pin.Model()
    chain = [0]  # Pinocchio's derivatives want a branch finished before the next begins
    for i in range(9):
        axis = rng.normal(size=3)
        kind = pin.JointModelPrismaticUnaligned if rng.random() < 0.3 else None
        joint = (kind or pin.JointModelRevoluteUnaligned)(axis / np.linalg.norm(axis))
        if i and rng.random() < 0.3:
            chain = chain[: int(rng.integers(1, len(chain)))]
        index = model.addJoint(chain[-1], joint, pin.SE3.Random(), f"joint_{i}")
        chain.append(index)
        model.appendBodyToJoint(index, pin.Inertia.Random(), pin.SE3.Random())
    return model


def arm_and_back() -> pin.Model:
    """The right arm and some joints of the back, the rest of the person fixed."""
    body = pik.build_body(pik.Subject())
    moves = [dof for dof in body.dofs if dof.endswith("_r") or dof.startswith(("L3_L4", "T5_T6"))]
    fixed = [i for i in range(1, body.model.njoints) if body.dofs[i - 1] not in moves]
    return pin.buildReducedModel(body.model, fixed, body.q_reference)


@pytest.mark.parametrize("model", [*map(hinged_tree, range(8)), arm_and_back()])
def test_derivatives_equal_pinocchios(model: pin.Model) -> None:
    """The first exactly, the second by central differences of Pinocchio's first."""
    n, data, twin = model.nv, model.createData(), Kinematics.of(model)
    v, a, mu = (ca.SX.sym(name, n) for name in ("v", "a", "mu"))
    outputs = torque_derivatives(twin, v, a, mu)
    ours = ca.Function("ours", [twin.q, v, a, mu, twin.parameters], outputs)
    rng = np.random.default_rng(0)
    at, weights = rng.normal(size=3 * n), rng.normal(size=n)

    def first(z: np.ndarray) -> np.ndarray:
        pin.computeRNEADerivatives(model, data, *np.split(z, 3))
        mass = np.triu(data.M) + np.triu(data.M, 1).T
        return np.hstack([data.dtau_dq, data.dtau_dv, mass])

    jacobian, hessian = (x.full() for x in ours(*np.split(at, 3), weights, twin.values(model)))
    expected = first(at)
    np.testing.assert_allclose(jacobian, expected, atol=TOLERANCE * np.abs(expected).max())
    step = 1e-5
    bent = np.array(
        [(weights @ (first(at + h) - first(at - h))) / (2 * step) for h in step * np.eye(3 * n)]
    )
    # differences: step² from the third derivative, and 1e-16 / step of rounding
    np.testing.assert_allclose(hessian, np.triu(bent), atol=1e-7 * np.abs(bent).max())
