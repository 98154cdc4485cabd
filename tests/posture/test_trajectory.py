"""Reaches against closed forms, an independent boundary-value solver, and Pinocchio's dynamics."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import quad, solve_bvp, solve_ivp
from scipy.linalg import expm, solve_continuous_lyapunov

import posture_ik as pik
from posture_ik.kinematics import Kinematics, frame_poses
from posture_ik.posture.collocation import Points, radau
from posture_ik.posture.control import SMOOTHNESS
from posture_ik.posture.mesh import Question, program_on
from posture_ik.posture.tasks import constraints_of
from posture_ik.posture.trajectory import InfeasibleReach, Trajectory

# What the issue asks of the closed forms, relative.
CLOSE = 1e-4
GRAVITY = 9.81


def reach(
    body: pik.Body,
    problem: pik.Problem,
    start: np.ndarray | None = None,
    intervals: int | None = None,
    **asked: Any,
) -> Trajectory:
    """Reach from the reference shape, asked for by keywords in place of a [trajectory] block."""
    block = pik.TrajectoryBlock(**asked)
    problem = problem.model_copy(update={"trajectory": block})
    first = body.q_reference if start is None else start
    return pik.reach(body, problem, start=first, intervals=intervals)


def machine(joint: pin.JointModel, mass: float, length: float, **springs: float) -> pik.Body:
    """One joint with a point mass `length` below it (m), as a body; the frame `bob` is the mass."""
    model = pin.Model()
    index = model.addJoint(0, joint, pin.SE3.Identity(), "joint")
    bob = pin.SE3(np.eye(3), np.array([0.0, 0.0, -length]))
    model.appendBodyToJoint(
        index, pin.Inertia(mass, bob.translation, np.zeros((3, 3))), bob.Identity()
    )
    model.addFrame(pin.Frame("bob", index, 0, bob, pin.FrameType.BODY), False)
    model.lowerPositionLimit, model.upperPositionLimit = np.array([-10.0]), np.array([10.0])
    numbers = [np.array([springs.get(name, 0.0)]) for name in ("stiffness", "damping")]
    return pik.Body(pik.Subject(), model, "", *numbers, np.zeros(1))


def slide_to(distance: float) -> pik.Problem:
    held = pik.Frame(frame="bob", components=("x",), position=(distance, 0.0, 0.0))
    return pik.Problem(task=(held,))


def swing_to(degrees: float) -> pik.Problem:
    held = pik.Frame(frame="bob", components=("rx", "ry", "rz"), rotation_deg=(0.0, degrees, 0.0))
    return pik.Problem(task=(held,))


# --- closed forms ----------------------------------------------------------------------------


@pytest.mark.parametrize("intervals", [8, 7])
def test_double_integrator_in_minimum_time_is_bang_bang(intervals: int) -> None:
    """T = 2 sqrt(d m / f); with 7 intervals the switch lies within one and has to be found."""
    cart = machine(pin.JointModelPX(), mass=2.0, length=0.0)
    found = reach(
        cart, slide_to(0.5), joints=["joint"], cost="time", torque=3.0, intervals=intervals
    )
    assert found.duration == pytest.approx(2 * np.sqrt(0.5 * 2.0 / 3.0), rel=CLOSE)
    middle = found.duration / 2
    before, after = found.time[1:] < 0.98 * middle, found.time[1:] > 1.02 * middle
    np.testing.assert_allclose(found.tau[1:][before], 3.0, rtol=1e-3)
    np.testing.assert_allclose(found.tau[1:][after], -3.0, rtol=1e-3)


def test_double_integrator_with_least_effort_is_a_cubic() -> None:
    """f = 6 m d / T² (1 - 2 t / T), x = d (3 s² - 2 s³), cost 12 m² d² / T³."""
    mass, distance, duration = 2.0, 0.5, 1.5
    cart = machine(pin.JointModelPX(), mass, length=0.0)
    found = reach(cart, slide_to(distance), joints=["joint"], duration=duration, smoothness=0.0)
    share = found.time / duration
    force = 6 * mass * distance / duration**2 * (1 - 2 * share)
    np.testing.assert_allclose(found.tau[:, 0], force, atol=1e-9)
    np.testing.assert_allclose(found.q[:, 0], distance * (3 * share**2 - 2 * share**3), atol=1e-9)
    assert found.effort == pytest.approx(12 * mass**2 * distance**2 / duration**3, rel=1e-9)
    assert found.cost == pytest.approx(found.effort, rel=1e-9)


def test_spring_and_damper_with_least_effort_by_the_gramian() -> None:
    """x' = A x + B f moved with f = Bᵀ e^{Aᵀ(T-t)} W⁻¹ x_T, of cost x_Tᵀ W⁻¹ x_T."""
    mass, stiffness, damping, duration = 2.0, 50.0, 3.0, 1.2
    cart = machine(pin.JointModelPX(), mass, 0.0, stiffness=stiffness, damping=damping)
    found = reach(
        cart, slide_to(0.5), joints=["joint"], duration=duration, smoothness=0.0, intervals=20
    )
    A = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
    B, goal = np.array([[0.0], [1.0 / mass]]), np.array([0.5, 0.0])
    passed = expm(A * duration)
    gramian = solve_continuous_lyapunov(A, passed @ B @ B.T @ passed.T - B @ B.T)
    costate = np.linalg.solve(gramian, goal)
    force = [B[:, 0] @ expm(A.T * (duration - t)) @ costate for t in found.time]
    assert found.effort == pytest.approx(goal @ costate, rel=CLOSE)
    np.testing.assert_allclose(found.tau[:, 0], force, atol=CLOSE * np.max(np.abs(force)))


@pytest.mark.parametrize("degrees", [60.0, 110.0])
def test_pendulum_in_minimum_time(degrees: float) -> None:
    """Bang-bang under gravity: energy gives the switch, an elliptic integral the time."""
    mass, length, most = 1.5, 0.6, 14.0  # most exceeds the weight's moment: no swinging up
    pendulum = machine(pin.JointModelRY(), mass, length)
    found = reach(pendulum, swing_to(degrees), joints=["joint"], cost="time", torque=most)
    goal, inertia, weight = np.radians(degrees), mass * length**2, mass * GRAVITY * length
    switch = (goal + weight * (1 - np.cos(goal)) / most) / 2

    def speed(angle: float, from_end: bool) -> float:
        """From rest at the nearer end, by the work of the torque and the weight."""
        work = most * (goal - angle if from_end else angle)
        fall = np.cos(angle) - (np.cos(goal) if from_end else 1.0)
        return float(np.sqrt(2 * (work + weight * fall) / inertia))

    # angle = x² from either end takes the integrable singularity away
    up = quad(lambda x: 2 * x / speed(x**2, False), 0, np.sqrt(switch))[0]
    down = quad(lambda x: 2 * x / speed(goal - x**2, True), 0, np.sqrt(goal - switch))[0]
    assert found.duration == pytest.approx(up + down, rel=CLOSE)
    turn = np.interp(0.0, -np.sign(found.tau[1:, 0]), found.q[1:, 0])
    assert turn == pytest.approx(switch, abs=0.02)


def test_pendulum_with_least_effort_by_the_maximum_principle() -> None:
    """q'' = (u - m g l sin q) / I with u = -p_v / 2 I, as a boundary-value problem for SciPy."""
    mass, length, goal, duration = 1.5, 0.6, np.radians(110.0), 0.8
    pendulum = machine(pin.JointModelRY(), mass, length)
    found = reach(pendulum, swing_to(110.0), joints=["joint"], duration=duration, smoothness=0.0)
    inertia, weight = mass * length**2, mass * GRAVITY * length

    def slope(t: np.ndarray, y: np.ndarray) -> np.ndarray:
        q, v, costate_q, costate_v = y
        u = -costate_v / (2 * inertia)
        return np.array(
            [
                v,
                (u - weight * np.sin(q)) / inertia,
                costate_v * weight * np.cos(q) / inertia,
                -costate_q,
            ]
        )

    ends = lambda a, b: np.array([a[0], a[1], b[0] - goal, b[1]])  # noqa: E731
    time = np.linspace(0, duration, 30)
    guess = np.zeros((4, 30))
    guess[0] = goal * time / duration
    oracle = solve_bvp(slope, ends, time, guess, tol=1e-9, max_nodes=20000)
    assert oracle.success
    torque = -oracle.sol(found.time)[3] / (2 * inertia)
    np.testing.assert_allclose(found.tau[:, 0], torque, atol=CLOSE * np.max(np.abs(torque)))
    np.testing.assert_allclose(found.q[:, 0], oracle.sol(found.time)[0], atol=CLOSE)


# --- the arm ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module")
def to_the_cyclic() -> pik.Problem:
    """The right hand of `pilot`, on the stick."""
    hands = [task for task in pik.load_problem("pilot").task if isinstance(task, pik.Hand)]
    return pik.Problem(task=tuple(hand for hand in hands if hand.side == "right"))


@pytest.fixture(scope="module")
def arm(body: pik.Body, to_the_cyclic: pik.Problem) -> Trajectory:
    return reach(body, to_the_cyclic, duration=1.0)


@pytest.fixture(scope="module")
def question(arm: Trajectory, to_the_cyclic: pik.Problem) -> Question:
    """The reach in free time with limits on torque and speed, as the solver is given it."""
    part = arm.limb.part
    twin = Kinematics.of(part.model)
    tasks = constraints_of(frame_poses(part.model, part.q_reference), to_the_cyclic)
    points = Points.of(twin, tasks, tasks, (True, True))
    spring = (part.stiffness, part.q_reference, part.damping)
    weights = np.array([1.0, 0.1, 2.0])
    targets = [task.target for task in (*tasks, *tasks)]
    parameters = points.parameters(
        twin.values(part.model), *spring, np.linspace(1, 2, 7), weights, *targets
    )
    held = np.ones(5, bool)
    most = np.full(7, 10.0)
    return Question(
        points, parameters, arm.q[0], part.lower, part.upper, most, most, None, None, (held, held)
    )


def grip(body: pik.Body, q: np.ndarray) -> pin.SE3:
    return frame_poses(body.model, q)["grip_r"]


def test_arm_arrives_at_rest_on_the_stick(arm: Trajectory, body: pik.Body) -> None:
    found = grip(body, arm.configurations(np.array([arm.duration]))[0])
    np.testing.assert_allclose(found.translation, [0.38, 0.0, 0.30], atol=1e-8)
    lean = np.radians(15)
    np.testing.assert_allclose(found.rotation[:, 2], [np.sin(lean), 0, np.cos(lean)], atol=1e-8)
    assert np.all(arm.v[[0, -1]] == 0.0)
    np.testing.assert_array_equal(arm.q[0], body.q_reference[list(arm.limb.rows)])
    assert len(arm.limb.joints) == 7
    assert arm.status == "Solve_Succeeded"
    assert arm.primal <= 1e-9
    assert arm.dual <= 1e-8


def test_integrated_controls_reach_the_stick(arm: Trajectory, body: pik.Body) -> None:
    """One open-loop run of the reduced arm, apart from the code under test: end within 1 mm."""
    rows = list(arm.limb.rows)
    fixed = [i for i in range(1, body.model.njoints) if i - 1 not in rows]
    model = pin.buildReducedModel(body.model, fixed, body.q_reference)
    data = model.createData()

    def rate(t: float, state: np.ndarray) -> np.ndarray:
        q, v = state[:7], state[7:]
        passive = body.stiffness[rows] * (q - body.q_reference[rows]) + body.damping[rows] * v
        tau = arm.at(np.array([t])).tau[0]
        return np.concatenate([v, pin.aba(model, data, q, v, tau - passive)])

    start = np.append(body.q_reference[rows], np.zeros(7))
    found = solve_ivp(rate, (0.0, arm.duration), start, "DOP853", rtol=1e-8, atol=1e-8)
    q = body.q_reference.copy()
    q[rows] = found.y[:7, -1]
    missed = grip(body, q).translation - [0.38, 0.0, 0.30]
    assert np.linalg.norm(missed) < 1e-3
    assert arm.end_error < 1e-3
    np.testing.assert_allclose(arm.shoot()[-1], found.y[:, -1], atol=1e-4)


def test_torques_are_those_of_the_whole_body(arm: Trajectory, body: pik.Body) -> None:
    """Pinocchio's rnea of all 117 joints, the others at rest; springs and dampers taken off."""
    rows, data = list(arm.limb.rows), body.model.createData()
    for q, v, a, tau in zip(
        arm.configurations(arm.time[1:]), arm.v[1:], arm.a[1:], arm.tau[1:], strict=True
    ):
        velocity, acceleration = np.zeros((2, body.model.nv))
        velocity[rows], acceleration[rows] = v, a
        total = pin.rnea(body.model, data, q, velocity, acceleration)
        total += body.stiffness * (q - body.q_reference) + body.damping * velocity
        np.testing.assert_allclose(tau, total[rows], atol=1e-9)


def test_between_the_points_it_is_one_motion(arm: Trajectory) -> None:
    """The velocity interpolated is the position's derivative, the acceleration the velocity's."""
    edges = np.cumsum(arm.mesh) - arm.mesh
    inside = (edges[:, None] + arm.mesh[:, None] * [0.03, 0.3, 0.5, 0.8]).ravel()
    times, step = inside * arm.duration, 1e-5
    before, after, here = arm.at(times - step), arm.at(times + step), arm.at(times)
    # v is q's derivative at the points, and between them but for the order of the polynomials
    fastest, hardest = np.abs(arm.v).max(), np.abs(arm.a).max()
    np.testing.assert_allclose((after.q - before.q) / (2 * step), here.v, atol=5e-3 * fastest)
    np.testing.assert_allclose((after.v - before.v) / (2 * step), here.a, atol=1e-6 * hardest)
    again = arm.at(arm.time[1:])
    for ours, theirs in zip(again, (arm.q, arm.v, arm.a, arm.tau, arm.controls), strict=True):
        np.testing.assert_allclose(ours, theirs[1:], atol=1e-9)


def test_refinement_converges(body: pik.Body, to_the_cyclic: pik.Problem) -> None:
    """From a coarse mesh the defect falls below the tolerance, and the cost settles."""
    found = reach(body, to_the_cyclic, duration=1.0, intervals=4, tolerance=1e-5)
    defects = [each.defect for each in found.rounds]
    changes = np.abs(np.diff([each.cost for each in found.rounds])) / found.cost
    assert len(defects) >= 3
    assert all(later < earlier for earlier, later in pairwise(defects))
    assert defects[-1] == found.defect <= 1e-5
    assert changes[-1] < 1e-6 < changes[0]
    finer = reach(body, to_the_cyclic, duration=1.0, intervals=24, tolerance=1e-5)
    assert found.cost == pytest.approx(finer.cost, rel=1e-6)


def test_no_nearby_motion_is_cheaper(arm: Trajectory) -> None:
    """Bending the whole motion by t²(T-t)² in any joint but along the task costs more."""
    # a bump that vanishes with its slope at both ends leaves start, end and rest as they are
    s = arm.time / arm.duration
    bump = s**2 * (1 - s) ** 2
    slope = 2 * s * (1 - s) * (1 - 2 * s) / arm.duration
    bend = (2 - 12 * s + 12 * s**2) / arm.duration**2
    weights = arm.duration * np.kron(arm.mesh, radau()[1][-1])
    part = arm.limb.part
    data = part.model.createData()

    def price(way: np.ndarray) -> float:
        total = 0.0
        for k, weight in enumerate(weights, 1):
            q, v, a = (
                each[k] + shape[k] * way
                for each, shape in ((arm.q, bump), (arm.v, slope), (arm.a, bend))
            )
            tau = pin.rnea(part.model, data, q, v, a)
            tau += part.stiffness * (q - part.q_reference) + part.damping * v
            total += weight * (tau @ tau + SMOOTHNESS["effort"] * a @ a)
        return total

    least = price(np.zeros(7))
    assert least == pytest.approx(arm.cost, rel=1e-9)
    rng = np.random.default_rng(0)
    for way in 0.05 * rng.normal(size=(10, 7)):
        assert price(way) > least
        assert price(-way) > least


def test_limits_are_kept_and_cost(
    body: pik.Body, to_the_cyclic: pik.Problem, arm: Trajectory
) -> None:
    fastest = np.abs(arm.v).max(axis=0)
    strongest = np.abs(arm.tau).max(axis=0)
    joint, other = int(np.argmax(fastest)), int(np.argmax(strongest))
    speed = {arm.limb.joints[joint]: 0.8 * fastest[joint]}
    torque = {arm.limb.joints[other]: 0.95 * strongest[other]}
    bound = reach(body, to_the_cyclic, duration=1.0, speed=speed, torque=torque)
    assert np.abs(bound.v[1:, joint]).max() <= 0.8 * fastest[joint] + 1e-8
    assert np.abs(bound.tau[1:, other]).max() <= 0.95 * strongest[other] + 1e-8
    assert np.all(bound.q >= bound.limb.part.lower - 1e-9)
    assert np.all(bound.q <= bound.limb.part.upper + 1e-9)
    assert bound.cost > arm.cost
    assert bound.end_error < 1e-3


def test_arm_in_least_time_uses_its_strength(body: pik.Body, to_the_cyclic: pik.Problem) -> None:
    most = {"shoulder_flexion_r": 40.0, "shoulder_abduction_r": 40.0, "shoulder_rotation_r": 30.0}
    most |= {"elbow_flexion_r": 30.0, "pronation_r": 8.0}
    most |= {"wrist_deviation_r": 8.0, "wrist_flexion_r": 8.0}
    quick = reach(body, to_the_cyclic, cost="time", torque=most)
    share = np.abs(quick.tau[1:]) / list(most.values())
    assert np.all(share <= 1 + 1e-8)
    # the critical joint is at its strength all the way but where it switches
    assert np.max(np.mean(share > 0.95, axis=0)) > 0.7
    assert quick.end_error < 1e-3
    with pytest.raises(InfeasibleReach, match=r"in 0.0[0-9]+ s within the limits; give more time"):
        reach(body, to_the_cyclic, duration=0.9 * quick.duration, torque=most)


def test_free_duration_of_least_effort_is_stationary(
    body: pik.Body, to_the_cyclic: pik.Problem
) -> None:
    free = reach(body, to_the_cyclic)
    for factor in (0.97, 1.03):
        assert reach(body, to_the_cyclic, duration=factor * free.duration).cost > free.cost


def test_derivatives_equal_casadis_own(arm: Trajectory, question: Question) -> None:
    """Automatic differentiation of the same f and g, free time and limits included."""
    program = program_on(question, np.array([0.4, 0.6]))
    x, p, f, g = (program.nlp[key] for key in ("x", "p", "f", "g"))
    sigma, lam = ca.MX.sym("sigma"), ca.MX.sym("lam", g.numel())
    hessian, _ = ca.hessian(sigma * f + ca.dot(lam, g), x)
    own = ca.Function(
        "own", [x, p, sigma, lam], [ca.gradient(f, x), ca.jacobian(g, x), ca.triu(hessian)]
    )
    rng = np.random.default_rng(1)
    at = np.append(rng.normal(size=x.numel() - 1), 0.7)
    numbers = (at, question.parameters, 0.3, rng.normal(size=g.numel()))
    expected = [value.full() for value in own(*numbers)]
    value, gradient = program.grad_f(*numbers[:2])
    rows, jacobian = program.jac_g(*numbers[:2])
    ours = [each.full() for each in (gradient, jacobian, program.hess_lag(*numbers))]
    for mine, theirs in zip(ours, expected, strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-11 * np.abs(theirs).max())
    plain = ca.Function("plain", [x, p], [f, g])(*numbers[:2])
    np.testing.assert_allclose(value.full(), plain[0].full(), rtol=1e-13)
    np.testing.assert_allclose(rows.full(), plain[1].full(), rtol=1e-12, atol=1e-12)


# --- tasks along the way ---------------------------------------------------------------------


def test_a_task_along_the_way_holds_all_the_way(body: pik.Body) -> None:
    """The grip moves 12 cm up while it keeps its side and all its angles."""
    at = grip(body, body.q_reference)
    angles = tuple(np.degrees(pin.rpy.matrixToRpy(at.rotation)))
    up = at.translation + np.array([0.0, 0.0, 0.12])
    # components run along the target's own axes, so the position is held by a frame of the world
    goal = pik.Hand(side="right", position=tuple(up), components=("x", "y", "z"))
    held = pik.Frame(frame="grip_r", components=("rx", "ry", "rz"), rotation_deg=angles)
    side = pik.Frame(
        frame="hand_r",
        components=("y",),
        position=tuple(frame_poses(body.model, body.q_reference)["hand_r"].translation),
    )
    found = reach(body, pik.Problem(task=(goal,)), duration=1.0, along=(held, side), tolerance=1e-4)
    for q in found.configurations(found.time):
        frames = frame_poses(body.model, q)
        turned = pin.log3(at.rotation.T @ frames["grip_r"].rotation)
        np.testing.assert_allclose(turned, 0.0, atol=1e-4)
        assert abs(frames["hand_r"].translation[1] - side.position[1]) < 1e-4
    np.testing.assert_allclose(
        grip(body, found.configurations(found.time)[-1]).translation, up, atol=1e-6
    )
    assert found.end_error < 1e-3


def test_a_task_along_the_way_must_hold_at_the_start(
    body: pik.Body, to_the_cyclic: pik.Problem
) -> None:
    """A target that the hand does not hold yet is one that it would have to jump to."""
    with pytest.raises(pik.errors.BadProblem, match="start: misses the right hand along the way"):
        reach(body, to_the_cyclic, along=to_the_cyclic.task, duration=1.0)


def test_a_task_along_the_way_settles_the_start(body: pik.Body) -> None:
    """Not given, the start is the posture that meets it, and what no moving joint can change."""
    held = pik.Frame(frame="grip_r", components=("x",), position=(0.40, 0.0, 0.0))
    aside = pik.Hand(side="right", position=(0.0, -0.25, 0.30), components=("y", "z"))
    block = pik.TrajectoryBlock(duration=0.8, along=(held,))
    problem = pik.Problem(task=(pik.Head(), aside), trajectory=block)
    problem = problem.model_copy(update={"seat": pik.Seat(recline_deg=10)})
    found = pik.reach(body, problem)
    alone = pik.Problem(task=(pik.Head(), held), seat=problem.seat)
    np.testing.assert_allclose(found.limb.start, pik.solve_posture(body, alone).q, atol=1e-9)
    for q in found.configurations(np.linspace(0.0, 0.8, 7)):
        assert abs(grip(body, q).translation[0] - 0.40) < 1e-4
    ahead = frame_poses(body.model, found.configurations(found.time[-1:])[0])["Head"].rotation
    reference = frame_poses(body.model, body.q_reference)["Head"].rotation
    np.testing.assert_allclose(ahead, reference, atol=1e-8)


# --- more joints, other starts ---------------------------------------------------------------


def test_trunk_and_arm_together(body: pik.Body) -> None:
    """A stick out of the arm's reach, with the lumbar spine bending forward and turning to it."""
    far = pik.Hand(side="right", position=(0.62, -0.15, 0.35), components=("x", "y", "z"))
    arm = [dof for dof in body.dofs if dof.endswith("_r")]
    with pytest.raises(pik.InfeasiblePosture):
        reach(body, pik.Problem(task=(far,)), joints=arm, duration=1.2)
    trunk = ["buttocks_S1_ry", "L5_S1_ry", "L3_L4_ry", "L1_L2_ry", "T11_T12_rz"]
    found = reach(
        body, pik.Problem(task=(far,)), joints=[*arm, *trunk], duration=1.2, tolerance=1e-3
    )
    assert len(found.limb.joints) == 12
    assert found.end_error < 1e-3
    at = grip(body, found.configurations(np.array([found.duration]))[0]).translation
    np.testing.assert_allclose(at, far.position, atol=1e-7)


def test_tasks_of_joints_at_rest_count_if_they_are_met(body: pik.Body) -> None:
    """From the pilot's trunk, head and back are held already: only the hands are left to do."""
    problem = pik.load_problem("pilot")
    start = pik.solve_posture(body, problem).q.copy()
    arms = [i for i, dof in enumerate(body.dofs) if dof.endswith(("_r", "_l"))]
    start[arms] = body.q_reference[arms]
    found = reach(body, problem, start=start, duration=1.0)
    assert len(found.limb.joints) == 14
    assert found.end_error < 1e-3
    with pytest.raises(pik.InfeasiblePosture, match=r"'(head|backrest)'"):
        reach(body, problem, duration=1.0)


# --- what cannot be done ---------------------------------------------------------------------


def test_out_of_reach_is_named(body: pik.Body) -> None:
    far = pik.Hand(side="right", position=(1.5, 0.0, 0.3))
    with pytest.raises(pik.InfeasiblePosture, match="'right hand' cannot be met: at best"):
        reach(body, pik.Problem(task=(far,)), duration=1.0)


def test_an_unreachable_lever_is_named(body: pik.Body) -> None:
    problem = pik.load_problem("reach_cyclic", ("lever.cyclic.pivot=[1.1, 0.0, -0.17]",))
    with pytest.raises(pik.InfeasiblePosture, match="'right hand' cannot be met: at best") as told:
        pik.reach(body, problem)
    assert {miss.unit for miss in told.value.misses} == {"m"} or told.value.misses[0].size > 1.0


@pytest.mark.parametrize("frame", ["grip_r", "hand_r", "radius_r"])
def test_two_poses_for_one_hand_are_named(
    body: pik.Body, to_the_cyclic: pik.Problem, frame: str
) -> None:
    """The stick, and a link of the same arm held where the reference shape has it."""
    place = frame_poses(body.model, body.q_reference)[frame].translation + np.array([0.0, 0.1, 0.0])
    other = pik.Frame(frame=frame, components=("x", "y", "z"), position=tuple(place))
    both = pik.Problem(task=(*to_the_cyclic.task, other))
    with pytest.raises(pik.InfeasiblePosture, match="cannot be met together") as told:
        reach(body, both, duration=1.0)
    assert {miss.task for miss in told.value.misses} == {"right hand", f"frame {frame}"}


def test_an_end_against_the_way_is_named(body: pik.Body) -> None:
    """What holds along the way holds at the end too."""
    at = grip(body, body.q_reference).translation
    held = pik.Frame(frame="grip_r", components=("z",), position=tuple(at))
    above = pik.Hand(
        side="right", position=tuple(at + np.array([0.0, 0.0, 0.1])), components=("x", "y", "z")
    )
    with pytest.raises(pik.InfeasiblePosture, match="'frame grip_r along the way'"):
        reach(body, pik.Problem(task=(above,)), duration=1.0, along=(held,))


def test_too_weak_is_named(body: pik.Body, to_the_cyclic: pik.Problem) -> None:
    with pytest.raises(InfeasibleReach, match="widen the limits"):
        reach(body, to_the_cyclic, duration=1.0, torque=0.5)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"joints": ["elbow_r"]}, "no joint is called 'elbow_r'; did you mean 'elbow_flexion_r'"),
        ({"torque": {"elbow": 3.0}}, "no such joint moves; did you mean 'elbow_flexion_r'"),
        ({"strength": {"wrist_flexion_l": 3.0}}, "trajectory.strength.wrist_flexion_l: no such"),
        ({"start": 10.0}, "start of shoulder_flexion_r: 10 is not within"),
    ],
)
def test_bad_questions_are_named(
    body: pik.Body, to_the_cyclic: pik.Problem, keywords: dict[str, Any], message: str
) -> None:
    if "start" in keywords:
        keywords["start"] = np.full(body.model.nq, keywords["start"])
    with pytest.raises(pik.PostureIKError, match=message):
        reach(body, to_the_cyclic, **keywords)


def test_endless_reach_asks_for_a_duration() -> None:
    """A cart of no resistance costs less the longer it takes."""
    cart = machine(pin.JointModelPX(), 1.0, 0.0)
    with pytest.raises(InfeasibleReach, match="give a duration"):
        reach(cart, slide_to(0.5), joints=["joint"])
