"""The cascade from posture or motion to muscles, against Pinocchio and finite differences."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.errors import PostureIKError
from posture_ik.muscle.activity import ARMS, _bearing, _jacobian
from posture_ik.muscle.hill import LAWS


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def held(body: pik.Body, name: str, *settings: str) -> pik.Activity:
    problem = pik.load_problem(name, settings)
    return pik.solve_activation(body, pik.solve_posture(body, problem), problem)


@pytest.fixture(scope="module")
def cyclic(body: pik.Body) -> pik.Activity:
    problem = pik.load_problem("pilot_cyclic", ("motion.rate=20",))
    return pik.solve_activation(body, pik.move(body, problem), problem)


def test_the_demand_is_pinocchios_with_the_load_on_the_hands(body: pik.Body) -> None:
    """`rnea` with external forces on the hands, in their own frames, 1e-10 N m."""
    loads = "activation.hand_force={right=[5, -10, -20], left=[0, 8, 3]}"
    activity = held(body, "pilot", loads)
    model = activity.shown.body.model
    data = model.createData()
    q, rest = activity.q[0], np.zeros(model.nv)
    pin.framesForwardKinematics(model, data, q)
    outer = [pin.Force.Zero() for _ in range(model.njoints)]
    for side, force in (("right", [5.0, -10.0, -20.0]), ("left", [0.0, 8.0, 3.0])):
        frame = model.frames[model.getFrameId(f"grip_{side[0]}")]
        at = pin.SE3(np.eye(3), data.oMf[model.getFrameId(f"grip_{side[0]}")].translation)
        wrench = at.act(pin.Force(np.array(force), np.zeros(3)))
        outer[frame.parentJoint] += data.oMi[frame.parentJoint].actInv(wrench)
    torque = pin.rnea(model, data, q, rest, rest, outer)[activity.paths.rows]
    np.testing.assert_allclose(activity.demand[0], torque, atol=1e-10)


def test_muscles_give_the_torque_and_its_power(cyclic: pik.Activity) -> None:
    """-Lᵀ f is the demand, and what muscles do by shortening the joints receive (1e-8, 1e-10)."""
    rows = cyclic.paths.rows
    held_sides = cyclic.demand.copy()
    for k, q in enumerate(cyclic.q):
        jacobian = cyclic.paths.evaluate(q)[1]
        torque = -jacobian.T @ cyclic.force[k]
        np.testing.assert_allclose(torque, held_sides[k] - cyclic.reserve[k], atol=1e-8)
        power = -cyclic.force[k] @ cyclic.rate[k]
        assert power == pytest.approx(torque @ cyclic.shown.v[k, rows], abs=1e-10)
    assert cyclic.shortfalls == ()
    assert max(cyclic.worst_certificate()) < 1e-8
    assert np.all((cyclic.activation >= 0.0) & (cyclic.activation <= 1.0))
    assert np.ptp(cyclic.activation, axis=0)[:25].max() > 0.01


def test_an_arm_that_holds_nothing_rests(cyclic: pik.Activity) -> None:
    """The left hand of `pilot_cyclic` is in no task: no activation, and nothing is lacking."""
    assert np.all(cyclic.activation[:, 25:] == 0.0)
    assert np.all(cyclic.reserve[:, 7:] == 0.0)


def test_a_lever_that_follows_loads_the_hand(body: pik.Body) -> None:
    """The force on the hand turns the lever's hinges as spring and weight ask, and no more."""
    activity = held(body, "pilot_push")
    shown = activity.shown
    model, data = shown.body.model, shown.body.model.createData()
    names = ["lever_cyclic_fore_aft", "lever_cyclic_lateral"]
    rows = [shown.body.dofs.index(name) for name in names]
    weight = pin.computeGeneralizedGravity(model, data, shown.q)[rows]
    springs = (shown.body.stiffness * (shown.q - shown.body.q_reference))[rows]
    jacobian = _jacobian(shown.body, data, shown.q, "lever_cyclic_grip")[:3, rows]
    force = activity.hand_force[0, 0]
    np.testing.assert_allclose(jacobian.T @ -force, weight + springs, atol=1e-10)
    stick = data.oMf[model.getFrameId("lever_cyclic_grip")].translation - [0.42, 0.0, -0.17]
    assert force @ stick == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("law", ["pennestri", "de_groote"])
@pytest.mark.parametrize("cost", ["squares", "volume", "fatigue"])
def test_beyond_strength_the_reserve_is_named(body: pik.Body, law: str, cost: str) -> None:
    activity = held(
        body,
        "pilot",
        "activation.hand_force.right=[0, 0, -500]",
        f"activation.law={law}",
        f"activation.cost={cost}",
    )
    assert np.all(np.isfinite(activity.activation))
    assert activity.shortfalls[0].joint.endswith("_r")
    assert abs(activity.shortfalls[0].torque) > 50.0
    assert "lacks" in str(activity.shortfalls[0])
    hold = activity.hold("right")
    assert np.all(np.isfinite(hold.endpoint.stiffness))


def test_at_joint_limits_every_answer_is_finite(body: pik.Body) -> None:
    """All corners are too many: each arm joint at each of its limits, the rest in between."""
    problem = pik.load_problem("pilot")
    posture = pik.solve_posture(body, problem)
    rows = pik.Paths.of(body).rows
    for row in rows[:7]:
        for limit in (body.lower[row], body.upper[row]):
            q = posture.q.copy()
            q[row] = limit
            activity = pik.solve_activation(body, replace(posture, q=q), problem)
            assert np.all(np.isfinite(activity.activation))
            assert max(activity.worst_certificate()) < 1e-7


def test_weight_and_load_stiffen_as_their_torque_changes(body: pik.Body) -> None:
    """-d(h - Jᵀ F)/dq by central differences, 1e-6 of the largest."""
    problem = pik.load_problem("pilot")
    q = pik.solve_posture(body, problem).q
    model, data = body.model, body.model.createData()
    rows, force = pik.Paths.of(body).rows[:7], np.array([10.0, -20.0, 30.0])

    def torque(q: np.ndarray) -> np.ndarray:
        jacobian = _jacobian(body, data, q, "grip_r")[:3]
        return (pin.computeGeneralizedGravity(model, data, q) - jacobian.T @ force)[rows]

    bearing = _bearing(body, data, q, _jacobian(body, data, q, "grip_r"), rows, force)
    step = 1e-5
    for i, row in enumerate(rows):
        shift = np.zeros(len(q))
        shift[row] = step
        slope = (torque(q + shift) - torque(q - shift)) / (2 * step)
        np.testing.assert_allclose(bearing[:, i], slope, atol=1e-6 * np.abs(bearing).max())


def test_stiffness_is_the_slope_of_the_torque_at_fixed_activation(body: pik.Body) -> None:
    """K of `hold` against central differences of -Lᵀ f along the paths, 1e-5 of the largest."""
    activity = held(body, "pilot", "activation.short_range=false")
    law, muscles, paths = LAWS["pennestri"], activity.muscles, activity.paths

    def torque(q: np.ndarray) -> np.ndarray:
        length, jacobian = paths.evaluate(q)
        force = law(muscles, length, np.zeros(50), activity.activation[0]).force
        return -jacobian.T @ force

    step = 1e-5
    for side, (_, joints) in ARMS.items():
        stiffness = activity.hold(side).stiffness.total
        for i, row in enumerate(paths.rows[joints]):
            shift = np.zeros(activity.q.shape[1])
            shift[row] = step
            slope = -(torque(activity.q[0] + shift) - torque(activity.q[0] - shift)) / (2 * step)
            scale = np.abs(stiffness).max()
            np.testing.assert_allclose(stiffness[:, i], slope[joints], atol=1e-5 * scale)


def test_co_contraction_stiffens_and_turns_nothing(body: pik.Body) -> None:
    """By attached cross-bridges; the slope of the force-length curve alone may well fall."""
    relaxed, tense = (
        held(body, "pilot", "activation.short_range=true", f"activation.co_contraction={level}")
        for level in (0.0, 0.4)
    )
    np.testing.assert_allclose(tense.delivered, relaxed.delivered, atol=1e-8)
    for side in ARMS:
        loose, stiff = relaxed.hold(side), tense.hold(side)
        assert np.trace(stiff.stiffness.total) > np.trace(loose.stiffness.total)
        assert loose.modes.basis.shape == (25, 18)
        torque = loose.recruitment.capacity @ loose.recruitment.activation
        for end in (loose.softest, loose.stiffest):
            np.testing.assert_allclose(loose.recruitment.capacity @ end, torque, atol=1e-7)


def test_the_dataset_names_what_it_holds(cyclic: pik.Activity) -> None:
    data = cyclic.to_dataset()
    assert data["activation"].dims == ("time", "muscle")
    assert data["demand"].dims == ("time", "dof")
    assert all("units" in data[name].attrs for name in data.data_vars)
    assert data.attrs["primal_residual"] < 1e-8


def test_a_body_without_arms_is_refused(body: pik.Body, tmp_path: Path) -> None:
    problem = pik.load_problem("reclined_15")
    hinge = r'"((?:shoulder|elbow|pronation|wrist)\w*_l)" type="revolute"'
    text = re.sub(hinge, r'"\1" type="fixed"', body.urdf)
    path = tmp_path / "one_arm.urdf"
    path.write_text(text, encoding="utf-8")
    one_armed = pik.build_body(pik.Subject(), path)
    posture = pik.solve_posture(one_armed, problem)
    with pytest.raises(PostureIKError, match="no joint 'shoulder_flexion_l'"):
        pik.solve_activation(one_armed, posture, problem)
