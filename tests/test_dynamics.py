"""The twin's inverse dynamics against Pinocchio: random trees of every joint it knows, our body."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from test_kinematics import random_tree

import posture_ik as pik
from posture_ik.kinematics import Kinematics, inverse_dynamics

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
