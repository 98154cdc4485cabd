"""Reaches by muscles: held still, integrated forward, with activations that lag, and refused."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

import posture_ik as pik
from posture_ik.body.arms import ARM_JOINTS
from posture_ik.kinematics import frame_poses
from posture_ik.muscle.activation import recruit
from posture_ik.muscle.hill import LAWS

RIGHT = tuple(f"{joint}_r" for joint in ARM_JOINTS)
#: Where all joints of an arm are well within the strength of their muscles, rad.
BENT = np.radians([30.0, 10.0, 20.0, 80.0, 10.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module")
def bent(body: pik.Body) -> np.ndarray:
    q = body.q_reference.copy()
    q[[body.dofs.index(joint) for joint in RIGHT]] = BENT
    return q


def reach(
    body: pik.Body,
    start: np.ndarray,
    change: np.ndarray,
    law: str = "pennestri",
    intervals: int | None = None,
    **asked: Any,
) -> pik.Trajectory:
    """Bring the right hand by least activation to where a change of all joints would take it."""
    q = start.copy()
    q[[body.dofs.index(joint) for joint in asked.get("joints", RIGHT)]] += change
    place = frame_poses(body.model, q)["grip_r"].translation
    held = pik.Frame(frame="grip_r", components=("x", "y", "z"), position=tuple(place))
    if len(asked.get("joints", RIGHT)) < 3:
        held = held.model_copy(update={"components": ("x", "z")[: len(asked["joints"])]})
    block = pik.TrajectoryBlock(cost="activation", **asked)
    problem = pik.Problem(task=(held,), trajectory=block, activation=pik.ActivationBlock(law=law))
    return pik.reach(body, problem, start=start, intervals=intervals)


@pytest.mark.parametrize("law", LAWS)
def test_held_still_activations_are_those_of_recruitment(
    body: pik.Body, bent: np.ndarray, law: str
) -> None:
    """The quadratic program of `recruit`, by another solver, on Pinocchio's weight of the arm."""
    still = reach(body, bent, np.zeros(7), law, 2, joints=RIGHT, duration=0.2, speed=1e-6)
    paths, muscles = pik.Paths.of(body), pik.Muscles.of(body)
    length, jacobian = paths.evaluate(bent)
    none = LAWS[law](muscles, length, np.zeros(50), np.zeros(50))
    weight = pin.computeGeneralizedGravity(body.model, body.model.createData(), bent)[paths.rows]
    right = slice(0, 7), slice(0, 25)
    capacity = np.ascontiguousarray((-jacobian.T * none.d_activation)[right])
    held = recruit(capacity, (weight + jacobian.T @ none.passive)[:7])
    assert held.answered
    assert held.activation.max() > 0.02
    assert still.actuators is not None
    assert still.actuators.names == muscles.names[:25]
    # interior points stay some 1e-4 off a bound that hardly presses, and there is a reserve
    np.testing.assert_allclose(
        still.activation[1:], np.tile(held.activation, (len(still.time) - 1, 1)), atol=3e-4
    )
    assert still.cost / still.duration == pytest.approx(held.objective, rel=1e-5)
    assert np.abs(still.reserve).max() < 1e-5


@pytest.fixture(scope="module")
def arm(body: pik.Body, bent: np.ndarray) -> pik.Trajectory:
    change = np.array([0.5, 0.1, 0.2, -0.7, 0.2, 0.0, 0.1])
    return reach(body, bent, change, joints=RIGHT, duration=0.6)


def test_the_muscles_give_what_pinocchio_asks(arm: pik.Trajectory) -> None:
    """At the points; springs and dampers of the arm play no part, the rest of the body is firm."""
    assert arm.imbalance < 1e-8
    body, data = arm.body, arm.body.model.createData()
    step = 10
    q = arm.configurations(arm.time[step : step + 1])[0]
    v, a = np.zeros((2, body.model.nv))
    v[list(arm.limb.rows)], a[list(arm.limb.rows)] = arm.v[step], arm.a[step]
    asked = pin.rnea(body.model, data, q, v, a)[list(arm.limb.rows)]
    np.testing.assert_allclose(arm.tau[step], asked, atol=1e-9)
    paths, muscles = pik.Paths.of(body), pik.Muscles.of(body)
    length, jacobian = paths.evaluate(q)
    activation = np.append(arm.activation[step], np.zeros(25))
    force = LAWS["pennestri"](muscles, length, jacobian @ v[paths.rows], activation).force
    given = (-jacobian.T @ force)[:7] + arm.reserve[step]
    np.testing.assert_allclose(given, asked, atol=1e-7)
    assert np.abs(arm.reserve).max() < 1e-5
    assert arm.primal < 1e-8
    assert arm.dual < 1e-6


def test_activations_integrated_forward_bring_the_hand_there(arm: pik.Trajectory) -> None:
    """Pinocchio's forward dynamics under the muscles' own forces, from rest, without correction."""
    model, actuators = arm.limb.part.model, arm.actuators
    assert actuators is not None
    data = model.createData()

    def rate(time: float, state: np.ndarray) -> np.ndarray:
        q, v = np.split(state, 2)
        controls = arm.at(np.array([time])).controls[0]
        torque = actuators.torque_at(q, v, controls[:25]) + controls[25:32]
        return np.concatenate([v, pin.aba(model, data, q, v, torque)])

    edges = arm.duration * np.append(0.0, np.cumsum(arm.mesh))
    state = np.append(arm.q[0], arm.v[0])
    for before, after in pairwise(edges):
        state = solve_ivp(rate, (before, after), state, "DOP853", rtol=1e-8, atol=1e-8).y[:, -1]
    whole = arm.configurations(arm.time[-1:])[0]
    whole[list(arm.limb.rows)] = state[:7]
    there = np.array(arm.problem.task[0].position)
    missed = frame_poses(arm.body.model, whole)["grip_r"].translation - there
    assert np.linalg.norm(missed) < 3e-4  # m; the tolerance of the mesh is 1e-4 an interval
    start = frame_poses(arm.body.model, arm.limb.start)["grip_r"].translation
    assert np.linalg.norm(there - start) > 0.1


def test_activations_that_lag(body: pik.Body, bent: np.ndarray) -> None:
    """They start from what holds the arm, change within reach of an excitation, and cost more."""
    asked = {"joints": ("elbow_flexion_r",), "duration": 0.4}
    change = np.array([0.6])
    slow = reach(body, bent, change, activation_dynamics=True, **asked)
    quick = reach(body, bent, change, **asked)
    assert slow.actuators is not None
    assert set(slow.actuators.names) >= {"BIClong_r", "BRA_r", "TRIlong_r", "TRIlat_r"}
    assert {"DELT1_r", "INFSP_r", "PQ_r"}.isdisjoint(slow.actuators.names)
    q, v = slow.q[0], np.zeros(1)
    model = slow.limb.part.model
    weight = pin.computeGeneralizedGravity(model, model.createData(), q)
    held = slow.actuators.torque_at(q, v, slow.activation[0])
    np.testing.assert_allclose(held, weight, atol=1e-7)
    assert slow.cost > quick.cost
    a, e = slow.activation[1:], slow.excitation[1:]
    rate = slow.controls[1:, -a.shape[1] :]
    np.testing.assert_allclose(rate, (e - a) / np.where(rate > 0, 0.01, 0.04), atol=1e-4)
    written = slow.to_dataset()
    assert written["excitation"].dims == ("time", "muscle")
    assert float(written["activation"].max()) == slow.activation.max()
    assert "excitation" not in quick.to_dataset()


def test_only_arms_have_muscles(body: pik.Body, bent: np.ndarray) -> None:
    joints = ("L4_L5_ry", *RIGHT)
    with pytest.raises(pik.PostureIKError, match=r"'L4_L5_ry' has no muscles to move it; with"):
        reach(body, bent, np.zeros(8), joints=joints, duration=1.0)
