"""The posture solve against SciPy on Pinocchio's kinematics, and against what physics demands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from pinocchio_recline import PinocchioRecline

import posture_ik as pik
from posture_ik.posture.solve import Posture

EXAMPLES = [
    "upright",
    "reclined_15",
    "reclined_30",
    "reclined_45",
    "reclined_15_gravity",
    "look_left",
    "slouched",
    "pilot",
]
RECLINED = ["reclined_15", "reclined_30", "reclined_45"]


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module")
def postures(body: pik.Body) -> dict[str, Posture]:
    return {name: pik.solve_posture(body, pik.load_problem(name)) for name in EXAMPLES}


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_is_certified(postures: dict[str, Posture], name: str) -> None:
    posture = postures[name]
    assert posture.primal_residual() <= 1e-9
    assert posture.dual_residual() <= 1e-8
    assert posture.reduced_curvature() > 0
    assert posture.certificate.holds
    assert posture.certificate.rank == posture.certificate.held


# --- the same minimum from elsewhere ---------------------------------------------------------


@pytest.mark.parametrize("name", [*RECLINED, "reclined_15_gravity"])
def test_one_energy_from_random_starts(
    body: pik.Body, postures: dict[str, Posture], name: str
) -> None:
    """20 starts anywhere in the joint ranges; 1e-8 J because IPOPT stops at 1e-11 in √J."""
    rng = np.random.default_rng(7)
    problem = pik.load_problem(name)
    for _ in range(20):
        start = rng.uniform(body.lower, body.upper)
        again = pik.solve_posture(body, problem, start)
        assert again.energy == pytest.approx(postures[name].energy, abs=1e-8)


@pytest.mark.parametrize("name", RECLINED)
def test_scipy_on_pinocchio_finds_the_same_posture(
    body: pik.Body, postures: dict[str, Posture], name: str
) -> None:
    """SLSQP stops at 1e-14 J of change; 1e-8 J on the energy is what the issue asks."""
    posture = postures[name]
    oracle = PinocchioRecline(body, posture.problem)
    np.testing.assert_allclose(oracle.residual(posture.q), 0.0, atol=1e-9)
    q, found = oracle.minimise(posture.stiffness, posture.q_ergo, body.lower, body.upper)
    assert np.max(np.abs(oracle.residual(q))) < 1e-9
    assert found.fun == pytest.approx(posture.energy, abs=1e-8)
    np.testing.assert_allclose(q, posture.q, atol=1e-5)


# --- what physics demands --------------------------------------------------------------------


def test_energy_is_zero_upright_and_grows_with_recline(postures: dict[str, Posture]) -> None:
    energies = [postures[name].energy for name in ["upright", *RECLINED]]
    assert energies[0] == pytest.approx(0.0, abs=1e-16)
    assert np.all(np.diff(energies) > 1.0)


@pytest.mark.parametrize("name", ["upright", *RECLINED, "slouched"])
def test_sagittal_tasks_move_nothing_sideways(
    body: pik.Body, postures: dict[str, Posture], name: str
) -> None:
    frames = postures[name].frames
    for frame, pose in frames.items():
        if frame.endswith(("_link", "_l")):
            continue
        mirror = frames[frame[:-1] + "l"] if frame.endswith("_r") else pose
        sideways = pose.translation[1] + mirror.translation[1]
        assert abs(sideways) < 1e-9, f"{frame} moves sideways"


@pytest.mark.parametrize("turn", [np.radians(35), np.radians(-120)])
def test_turning_seat_and_targets_together_leaves_the_energy(
    body: pik.Body, postures: dict[str, Posture], turn: float
) -> None:
    """Everything is turned about the vertical and carried 2 m away: the root and all targets."""
    problem = pik.load_problem("look_left")
    carry = pin.SE3(pin.utils.rotate("z", turn), np.array([2.0, -1.0, 0.5]))
    model = body.model.copy()
    model.jointPlacements[1] = carry * model.jointPlacements[1]
    for frame in model.frames:
        if frame.parentJoint == 0:
            frame.placement = carry * frame.placement
    moved = replace(body, model=model)
    posture = postures["look_left"]
    targets = {c.label: c.target.copy() for c in posture.constraints}
    turned = _solve_with_targets(
        moved, problem, {k: _carried(k, t, carry) for k, t in targets.items()}
    )
    assert turned.energy == pytest.approx(posture.energy, abs=1e-9)
    np.testing.assert_allclose(turned.q, posture.q, atol=1e-7)


def _carried(label: str, target: np.ndarray, carry: pin.SE3) -> np.ndarray:
    """Carry a target: mean or position, axes, and for the backrest each arm and rotation."""
    moved = target.copy()
    moved[:3] = carry.act(target[:3])
    moved[3:12] = (carry.rotation @ target[3:12].reshape(3, 3).T).T.ravel()
    for start in range(13, len(target), 12):
        moved[start : start + 3] = carry.rotation @ target[start : start + 3]
        goal = target[start + 3 : start + 12].reshape(3, 3).T
        moved[start + 3 : start + 12] = (carry.rotation @ goal).T.ravel()
    return moved


def _solve_with_targets(
    body: pik.Body, problem: pik.Problem, targets: dict[str, np.ndarray]
) -> Posture:
    from posture_ik.posture import statement

    stated = statement.constraints_of
    try:
        statement.constraints_of = lambda frames, problem: tuple(
            replace(c, target=targets[c.label]) for c in stated(frames, problem)
        )
        return pik.solve_posture(body, problem)
    finally:
        statement.constraints_of = stated


def test_gravity_is_balanced_by_what_touches_the_person(
    body: pik.Body, postures: dict[str, Posture]
) -> None:
    """Seat springs, seat rigid reactions, contacts and holds sum to the weight: 1e-6 N, N m."""
    posture = postures["reclined_15_gravity"]
    mass = sum(inertia.mass for inertia in body.model.inertias)
    weight = mass * body.model.gravity.linear
    centre = pin.centerOfMass(body.model, body.model.createData(), posture.q)
    acting = (*posture.wrenches, posture.seat)
    force = sum(w.force for w in acting) + weight
    moment = sum(w.moment + np.cross(w.point, w.force) for w in acting) + np.cross(centre, weight)
    np.testing.assert_allclose(force, 0.0, atol=1e-6)
    np.testing.assert_allclose(moment, 0.0, atol=1e-6)
    # The seat's vertical force is the buttocks' spring alone: a check that is no identity.
    spring = posture.prestrain_force[body.dofs.index("buttocks_S1_axial")]
    assert posture.seat.force[2] == pytest.approx(spring, abs=1e-6)
    assert weight[2] == pytest.approx(-(spring + posture.wrenches[0].force[2]), abs=1e-6)


def test_under_gravity_the_heavier_arm_tells(postures: dict[str, Posture]) -> None:
    """Table 9 makes the left arm 10 g heavier: a lean of microns to the left, and no more."""
    lean = postures["reclined_15_gravity"].frames["T1"].translation[1]
    assert 0 < lean < 1e-4


def test_contact_pushes_and_never_pulls(postures: dict[str, Posture]) -> None:
    posture = postures["reclined_15_gravity"]
    normal = posture.constraints[0].target[:3]
    assert posture.contacts, "nothing touches the backrest"
    for contact in posture.contacts:
        assert contact.force @ normal > 0
        np.testing.assert_allclose(np.cross(contact.force, normal), 0.0, atol=1e-9)
    heights = [posture.frames[f].translation @ normal for f in posture.constraints[0].frames]
    assert min(heights) == pytest.approx(posture.constraints[0].target[3], abs=1e-9)


@pytest.mark.parametrize("name", ["reclined_30", "look_left", "pilot", "reclined_15_gravity"])
def test_holding_forces_balance_the_springs_by_virtual_work(
    body: pik.Body, postures: dict[str, Posture], name: str
) -> None:
    """Jᵀ of Pinocchio's frame Jacobians with the reported wrenches equals the springs' forces."""
    posture = postures[name]
    model, data = body.model, body.model.createData()
    pin.computeJointJacobians(model, data, posture.q)
    pin.framesForwardKinematics(model, data, posture.q)
    total = posture.prestrain_force - posture.limit_multipliers
    if posture.problem.posture.gravity:
        total -= pin.computeGeneralizedGravity(model, data, posture.q)
    names = [frame for constraint in posture.constraints for frame in constraint.frames]
    for frame, wrench in zip(names, posture.frame_wrenches, strict=True):
        index = model.getFrameId(frame)
        jacobian = pin.getFrameJacobian(model, data, index, pin.LOCAL_WORLD_ALIGNED)
        total += jacobian.T @ wrench[:2].ravel()
    np.testing.assert_allclose(total / np.sqrt(posture.stiffness), 0.0, atol=1e-8)


def test_multipliers_are_the_derivative_of_energy(body: pik.Body) -> None:
    """dE/d(recline) by central differences against the backrest's power: the envelope theorem."""
    step = 1e-3

    def at(angle: float) -> Posture:
        return pik.solve_posture(
            body, pik.load_problem("reclined_15", (f"seat.recline_deg={angle!r}",))
        )

    slope = (at(15 + step).energy - at(15 - step).energy) / (2 * np.radians(step))
    posture = at(15.0)
    backrest = posture.wrenches[0]
    # Reclining turns the backrest's target about -y through the seat's origin.
    power = -(backrest.moment + np.cross(backrest.point, backrest.force))[1]
    assert slope == pytest.approx(power, rel=1e-6)


def test_middle_of_the_range_is_the_rest(body: pik.Body) -> None:
    problem = pik.load_problem("upright", ("posture.ergonomic=middle",))
    posture = pik.solve_posture(body, problem)
    np.testing.assert_allclose(posture.q_ergo, (body.lower + body.upper) / 2)
    assert posture.energy > 0.1
    assert posture.certificate.holds


def test_uniform_stiffness_spreads_the_turn_evenly(body: pik.Body) -> None:
    problem = pik.load_problem("look_left", ("posture.stiffness=uniform",))
    posture = pik.solve_posture(body, problem)
    assert set(posture.stiffness) == {500.0, 1e6}
    assert posture.certificate.holds


# --- what must not pass ----------------------------------------------------------------------


def test_a_target_out_of_reach_is_named_with_its_miss(body: pik.Body) -> None:
    problem = pik.load_problem("pilot", ("task.3.position=[1.2, 0.0, 0.3]",))
    with pytest.raises(pik.InfeasiblePosture, match=r"'right hand'.*misses.*mm.*limit") as caught:
        pik.solve_posture(body, problem)
    worst = caught.value.misses[0]
    assert (worst.task, worst.unit) == ("right hand", "m")
    assert 0.1 < worst.size < 1.0
    assert caught.value.limits


def test_a_gaze_out_of_range_is_named_with_its_miss(body: pik.Body) -> None:
    problem = pik.load_problem("look_left", ("task.head.looking={ turn_deg = 150 }",))
    with pytest.raises(
        pik.InfeasiblePosture, match=r"'head'.*deg.*C1_C2_rz at its upper"
    ) as caught:
        pik.solve_posture(body, problem)
    assert caught.value.misses[0].unit == "deg"


def test_contradictory_tasks_are_infeasible(body: pik.Body) -> None:
    problem = pik.Problem(
        task=(
            pik.Head(),
            pik.Frame(frame="Head", components=("ry",), rotation_deg=(0, 20, 0)),
        )
    )
    with pytest.raises(pik.InfeasiblePosture):
        pik.solve_posture(body, problem)


def test_redundant_tasks_show_in_the_rank(body: pik.Body) -> None:
    problem = pik.Problem(task=(pik.Head(), pik.Frame(frame="Head", components=("ry",))))
    certificate = pik.solve_posture(body, problem).certificate
    assert (certificate.rank, certificate.held) == (3, 4)


# Statures at which rounding used to decide whether rows that repeat each other could be solved.
@pytest.mark.parametrize("stature", [1.40, 1.55, 1.75, 1.83, 2.10])
@pytest.mark.parametrize("name", ["reclined_15", "reclined_30_buckling"])
def test_tasks_may_repeat_each_other(stature: float, name: str) -> None:
    """With a row said twice the posture is that without; what is implied is named.

    Newton finds both to 1e-8 in x; where the spine buckles, IPOPT stops at 1e-11 in the gradient.
    """
    problem = pik.load_problem("reclined_15")
    if name == "reclined_30_buckling":
        problem = pik.load_problem("reclined_30", ("posture.stiffness=tissue",))
    body = pik.build_body(pik.Subject(stature=stature))
    once = pik.solve_posture(body, problem)
    again = problem.model_copy(
        update={"task": (*problem.task, pik.Frame(frame="Head", components=("ry",)))}
    )
    twice = pik.solve_posture(body, again)
    assert twice.certificate.holds
    assert twice.certificate.held - twice.certificate.rank == 1
    assert len(twice.redundant) == 1
    assert twice.redundant[0].endswith("ry")
    assert once.redundant == ()
    assert twice.energy == pytest.approx(once.energy, rel=1e-8)


def test_contacts_may_repeat_each_other(body: pik.Body) -> None:
    """Between two backrests in one place what each carries is open, but not their sum.

    Newton stops at steps of 1e-8 in x; forces are some hundred newtons.
    """
    problem = pik.Problem(
        task=(pik.BackrestContact(), pik.Head()),
        posture={"gravity": True},
        seat={"recline_deg": 20},
    )
    once = pik.solve_posture(body, problem)
    problem = problem.model_copy(update={"task": (problem.task[0], *problem.task)})
    twice = pik.solve_posture(body, problem)
    assert twice.certificate.holds
    np.testing.assert_allclose(twice.q, once.q, atol=1e-8)
    both = twice.wrenches[0].force + twice.wrenches[1].force
    np.testing.assert_allclose(both, once.wrenches[0].force, atol=1e-5)


def test_a_saddle_is_left_for_a_minimum(body: pik.Body) -> None:
    """On the stiff buttocks 30 degrees buckle the spine sideways: symmetry is a saddle there."""
    problem = pik.load_problem("reclined_30", ("posture.stiffness=tissue",))
    posture = pik.solve_posture(body, problem)
    assert posture.reduced_curvature() > 0
    assert posture.certificate.holds


@pytest.mark.parametrize("gravity", [False, True])
def test_without_tasks_springs_rest_or_balance_the_weight(gravity: bool) -> None:
    """A program of no equations at all, which a reach of the whole body begins from."""
    body = pik.build_body(pik.Subject())
    problem = pik.load_problem("upright", (f"posture.gravity={str(gravity).lower()}",))
    posture = pik.solve_posture(body, problem.model_copy(update={"task": ()}))
    if not gravity:
        np.testing.assert_allclose(posture.q, body.q_reference, atol=1e-12)
    data = body.model.createData()
    weight = pin.computeGeneralizedGravity(body.model, data, posture.q) if gravity else 0.0
    balance = posture.prestrain_force - weight - posture.limit_multipliers
    np.testing.assert_allclose(balance, 0.0, atol=1e-6)
