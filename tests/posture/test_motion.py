"""Motions: projections, differences, inverse dynamics and energy against what they must obey."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.arrays import call
from posture_ik.errors import BadProblem, MotionStopped
from posture_ik.posture.motion import Motion, move
from posture_ik.posture.projection import Projection, task_rates
from posture_ik.posture.statement import Statement
from posture_ik.problem import with_numbers


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


def moved(body: pik.Body, name: str, *settings: str) -> Motion:
    return move(body, pik.load_problem(name, settings))


@pytest.fixture(scope="module")
def nod(body: pik.Body) -> Motion:
    """A gentle nod that meets no joint limit, under gravity: everything is smooth and loaded."""
    return moved(
        body,
        "nod",
        "motion.rate=100",
        "motion.duration=0.5",
        "motion.signal.1.amplitude=4",
        "posture.gravity=true",
        "posture.stiffness=tissue",
    )


@pytest.fixture(scope="module")
def sweep(body: pik.Body) -> Motion:
    return moved(body, "recline_sweep", "motion.rate=40")


@pytest.fixture(scope="module")
def push(body: pik.Body) -> Motion:
    """A hand that takes a lever along: a loop with bodies and springs of its own."""
    return moved(body, "pilot_push", "motion.rate=20", "posture.gravity=true")


@pytest.mark.parametrize("name", ["nod", "sweep", "push"])
def test_tasks_are_respected_at_every_level(name: str, request: pytest.FixtureRequest) -> None:
    motion: Motion = request.getfixturevalue(name)
    position, velocity, acceleration = motion.worst_residuals()
    assert position <= 1e-9
    assert velocity <= 1e-10 * max(1.0, np.abs(motion.v).max())
    assert acceleration <= 1e-10 * max(1.0, np.abs(motion.a).max())
    assert motion.redundant == ()


def test_the_correction_is_m_orthogonal_to_the_free_motions(body: pik.Body) -> None:
    """(v - v0)ᵀ M z = 0 for every z with J z = 0; relative to the largest entry, 1e-10."""
    rng = np.random.default_rng(2)
    q = body.q_reference + 0.05 * rng.normal(size=body.model.nv)
    statement = Statement.of(body, pik.load_problem("nod"))
    nodding = statement.along(["task.head.looking.nod_deg"])
    targets, moved, _ = (x.full().ravel() for x in nodding(3.0, 50.0, 0.0))
    p = statement.at(statement.problem, targets).parameters
    jacobian, moving = call(task_rates(statement.program)[0], q, p, moved)
    data = body.model.createData()
    upper = np.triu(pin.crba(body.model, data, q))
    mass = upper + np.triu(upper, 1).T
    free = np.ones(body.model.nv, bool)
    free[[5, 40]] = False
    guess = rng.normal(size=body.model.nv)
    v, multipliers = Projection(mass, jacobian, free)(guess, moving)
    np.testing.assert_allclose(jacobian @ v + moving, 0.0, atol=1e-12)
    assert np.all(v[~free] == 0.0)
    start = np.where(free, guess, 0.0)
    momentum = (mass @ (v - start))[free]
    _, values, vectors = np.linalg.svd(jacobian[:, free])
    null = vectors[len(values) :]
    assert np.abs(null @ momentum).max() <= 1e-10 * np.abs(momentum).max()
    np.testing.assert_allclose(
        momentum + jacobian[:, free].T @ multipliers, 0.0, atol=1e-10 * np.abs(momentum).max()
    )


def test_the_drift_is_pinocchios_classical_acceleration(body: pik.Body) -> None:
    """J a + drift of a frame held at a fixed place is its classical, not spatial, acceleration."""
    problem = pik.Problem(
        task=(pik.Frame(frame="hand_r", components=("x", "y", "z"), position=(0.3, -0.2, 0.2)),)
    )
    statement = Statement.of(body, problem)
    rates, drift = task_rates(statement.program)
    rng = np.random.default_rng(4)
    q, v, a = rng.uniform(0.5 * body.lower, 0.5 * body.upper), *rng.normal(size=(2, body.model.nv))
    p, still = statement.parameters, np.zeros(statement.program.targets)
    ours = call(rates, q, p, still)[0] @ a + call(drift, q, v, p, still, still)[0]
    data = body.model.createData()
    pin.forwardKinematics(body.model, data, q, v, a)
    frame = body.model.getFrameId("hand_r")
    world = pin.LOCAL_WORLD_ALIGNED
    classical = pin.getFrameClassicalAcceleration(body.model, data, frame, world).linear
    np.testing.assert_allclose(ours, classical, atol=1e-10 * np.abs(classical).max())
    spatial = pin.getFrameAcceleration(body.model, data, frame, world).linear
    assert np.abs(ours - spatial).max() > 0.1


def test_targets_in_time_are_those_of_the_problem_at_that_instant(body: pik.Body) -> None:
    """All at once and one by one; their rates by central differences, 1e-7 of a step of 1e-4 s."""
    problem = pik.load_problem("recline_sweep")
    signal, moving = problem.motion.signal[0], Statement.of(body, problem)
    follow = moving.along([signal.of])
    times = 0.3 + np.array([-1e-4, 0.0, 1e-4])
    targets, rates, bends = (x.full().T for x in follow(*[c[None] for c in signal.at(times)]))
    still = with_numbers(problem, {signal.of: signal.at(times)[0][1]})
    ours, afresh = moving.at(still, targets[1]), Statement.of(body, still)
    np.testing.assert_allclose(ours.parameters, afresh.parameters, atol=1e-14)
    for one, other in zip(ours.constraints, afresh.constraints, strict=True):
        np.testing.assert_allclose(one.target, other.target, atol=1e-14)
    assert np.abs(rates[1]).max() > 0.01
    np.testing.assert_allclose((targets[2] - targets[0]) / 2e-4, rates[1], atol=1e-7)
    np.testing.assert_allclose((rates[2] - rates[0]) / 2e-4, bends[1], atol=1e-6)


def test_projected_rates_converge_to_those_of_the_positions(body: pik.Body) -> None:
    """At one instant, steps of 1/25, 1/50, 1/100 s: the gap falls by four, order 2."""
    settings = ("motion.signal.1.amplitude=4", "motion.duration=0.4")
    motions = [moved(body, "nod", f"motion.rate={rate}", *settings) for rate in (25, 50, 100)]
    fine = moved(body, "nod", "motion.rate=2000", "motion.duration=0.202", settings[0])
    k = np.searchsorted(fine.time, 0.2 - 1e-9)
    h = fine.time[1]
    exact_v = (8 * (fine.q[k + 1] - fine.q[k - 1]) - (fine.q[k + 2] - fine.q[k - 2])) / (12 * h)
    gaps = []
    for motion in motions:
        at = np.searchsorted(motion.time, 0.2 - 1e-9)
        gaps.append(np.abs(motion.v[at] - exact_v).max())
    assert 3.5 < gaps[0] / gaps[1] < 4.5
    assert 3.5 < gaps[1] / gaps[2] < 4.5
    exact_a = (
        -fine.q[k + 2] + 16 * fine.q[k + 1] - 30 * fine.q[k] + 16 * fine.q[k - 1] - fine.q[k - 2]
    ) / (12 * h**2)
    gaps = []
    for motion in motions:
        at = np.searchsorted(motion.time, 0.2 - 1e-9)
        gaps.append(np.abs(motion.a[at] - exact_a).max())
    assert 3.0 < gaps[0] / gaps[1] < 5.0


@pytest.mark.parametrize("name", ["nod", "push"])
def test_forward_dynamics_gives_the_acceleration_back(
    name: str, request: pytest.FixtureRequest
) -> None:
    """Pinocchio's aba under tau, springs, dampers and the tasks' wrenches on their frames.

    What a joint limit carries is a torque as well.
    """
    motion: Motion = request.getfixturevalue(name)
    model, data = motion.body.model, motion.body.model.createData()
    for k in (0, 13, 31):
        posture = motion.postures[k]
        torque = motion.tau[k] - motion.limit_load[k] + posture.prestrain_force
        torque -= motion.body.damping * motion.v[k]
        pin.framesForwardKinematics(model, data, motion.q[k])
        outer = [pin.Force.Zero() for _ in range(model.njoints)]
        names = [frame for c in posture.constraints for frame in c.frames]
        for name, wrench in zip(names, posture.frame_wrenches, strict=True):
            frame = model.frames[model.getFrameId(name)]
            at = pin.SE3(np.eye(3), posture.frames[name].translation)
            outer[frame.parentJoint] += data.oMi[frame.parentJoint].actInv(
                at.act(pin.Force(*wrench[:2]))
            )
        a = pin.aba(model, data, motion.q[k], motion.v[k], torque, outer)
        largest = max(1.0, np.abs(motion.a[k]).max())
        np.testing.assert_allclose(a, motion.a[k], atol=1e-8 * largest)


@pytest.mark.parametrize("name", ["nod", "push"])
def test_power_is_the_rate_of_energy(name: str, request: pytest.FixtureRequest) -> None:
    """Joints, dampers and moving tasks against the rate of kinetic + weight + spring energy.

    The rate is a central difference along the parabola that v and a give; 1e-6 W of 1 W.
    """
    motion: Motion = request.getfixturevalue(name)
    model, data = motion.body.model, motion.body.model.createData()
    largest, worst = 0.0, 0.0
    for k in range(len(motion.time)):
        q, v, a, posture = motion.q[k], motion.v[k], motion.a[k], motion.postures[k]
        h = 1e-5

        def energy(shift: float, q=q, v=v, a=a, posture=posture) -> float:
            moved_q = q + shift * v + shift**2 / 2 * a
            stretch = moved_q - posture.q_ergo
            kinetic = pin.computeKineticEnergy(model, data, moved_q, v + shift * a)
            weight = pin.computePotentialEnergy(model, data, moved_q)
            return kinetic + weight + posture.stiffness @ stretch**2 / 2

        rate = (energy(h) - energy(-h)) / (2 * h)
        supplied = motion.tau[k] @ v - v @ (motion.body.damping * v)
        pin.computeJointJacobians(model, data, q)
        pin.framesForwardKinematics(model, data, q)
        names = [frame for c in posture.constraints for frame in c.frames]
        for name, wrench in zip(names, posture.frame_wrenches, strict=True):
            jacobian = pin.getFrameJacobian(
                model, data, model.getFrameId(name), pin.LOCAL_WORLD_ALIGNED
            )
            supplied += wrench[:2].ravel() @ jacobian @ v
        largest, worst = max(largest, abs(rate)), max(worst, abs(rate - supplied))
    assert worst < 1e-6 * max(largest, 1.0)


def test_at_rest_the_joints_supply_nothing(body: pik.Body) -> None:
    """A motion that stands still is the posture: no torque, and the posture's own reactions."""
    still = moved(
        body,
        "nod",
        "motion.rate=20",
        "motion.duration=0.2",
        'motion.signal.1={ of="task.head.looking.nod_deg", kind="constant", value=10 }',
    )
    posture = pik.solve_posture(body, pik.load_problem("nod", ("task.head.looking={nod_deg=10}",)))
    scale = np.sqrt(posture.stiffness)
    assert np.abs(still.v).max() < 1e-9
    np.testing.assert_allclose(still.tau / scale, 0.0, atol=1e-8)
    np.testing.assert_allclose(still.multipliers[2], posture.multipliers, atol=1e-6)
    np.testing.assert_allclose(still.limit_load[2], posture.limit_multipliers, atol=1e-6)
    np.testing.assert_allclose(still.seat_force[2], posture.seat.force, atol=1e-6)
    np.testing.assert_allclose(still.seat_moment[2], posture.seat.moment, atol=1e-6)


def test_sagittal_motions_stay_sagittal(nod: Motion) -> None:
    """10 g between the arms (table 9) is all that leans: microns."""
    sideways = [posture.frames["Head"].translation[1] for posture in nod.postures]
    assert np.abs(sideways).max() < 1e-4


def test_the_dataset_names_what_it_holds(sweep: Motion) -> None:
    data = sweep.to_dataset()
    for name in ("q", "v", "a", "tau"):
        assert data[name].dims == ("time", "dof")
    for name in ("multiplier", "residual", "velocity_residual", "acceleration_residual"):
        assert data[name].dims == ("time", "constraint")
    for name in ("twist", "body_acceleration"):
        assert data[name].dims == ("time", "body", "component")
    assert data["force"].sizes == {"time": len(sweep.time), "task": 3, "axis": 3}
    assert all("units" in data[name].attrs for name in data.data_vars)


def test_rows_that_others_imply_are_named(body: pik.Body) -> None:
    problem = pik.load_problem("nod", ("motion.rate=20", "motion.duration=0.2"))
    # The frame's turn about z is already among the head's.
    frame = pik.Frame(frame="Head", components=("rz",))
    problem = problem.model_copy(update={"task": (*problem.task, frame)})
    motion = move(body, problem)
    assert len(motion.redundant) == 1
    assert motion.redundant[0].endswith("rz")
    assert motion.worst_residuals()[1] < 1e-10


def test_a_motion_out_of_range_says_when(body: pik.Body) -> None:
    problem = pik.load_problem(
        "nod", ("motion.rate=20", "motion.duration=1", "motion.signal.1.amplitude=120")
    )
    with pytest.raises(MotionStopped, match=r"at 0\.\d+ s the task"):
        move(body, problem)


def test_a_problem_that_stands_still_cannot_move(body: pik.Body) -> None:
    with pytest.raises(BadProblem, match=r"say under .motion. how long to move"):
        move(body, pik.load_problem("upright"))


def test_the_bodies_move_as_their_poses_do(push: Motion) -> None:
    """Six coordinates a body against central differences of its pose: order 2 in the step."""
    data = push.to_dataset().sel(body=["Head", "hand_r", "lever_cyclic"])
    step = float(push.time[1])
    for name, rate in (("position", "twist"), ("twist", "body_acceleration")):
        values = data[name].values[..., :3]
        # within: at the ends an acceleration is one-sided, of first order
        slope = ((values[2:] - values[:-2]) / (2 * step))[3:-3]
        told = data[rate].values[4:-4, :, :3]
        # (pi step)² / 6 of a sine of 0.5 Hz at 20 Hz: 0.4 %
        np.testing.assert_allclose(slope, told, atol=0.02 * np.abs(told).max())
