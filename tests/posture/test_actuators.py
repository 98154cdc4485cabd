"""Reaches driven by actuators against a closed form, a convex program, and CasADi's own slopes."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import daqp
import numpy as np
import pinocchio as pin
import pytest

import posture_ik as pik
from posture_ik.kinematics import Kinematics, frame_poses
from posture_ik.posture import control
from posture_ik.posture.actuators import Lag
from posture_ik.posture.collocation import Points, radau
from posture_ik.posture.mesh import Question, program_on
from posture_ik.posture.tasks import constraints_of
from posture_ik.posture.trajectory import Trajectory

MASS, DISTANCE = 2.0, 0.5
STRENGTH = 10.0


@dataclass(frozen=True)
class Pair:
    """Two that pull a cart, one forward and one back."""

    lag: Lag | None = None
    names = ("forward", "back")

    @property
    def numbers(self) -> np.ndarray:
        return np.array([STRENGTH])

    @property
    def start(self) -> np.ndarray:
        return np.array([0.05, 0.05])

    def structure(self) -> object:
        return self

    def torque(self, q: ca.SX, v: ca.SX, activation: ca.SX, numbers: ca.SX) -> ca.SX:
        return numbers * (activation[0] - activation[1])

    def torque_at(self, q: np.ndarray, v: np.ndarray, activation: np.ndarray) -> np.ndarray:
        return STRENGTH * (activation[:1] - activation[1:])


@dataclass(frozen=True)
class Crossed(Pair):
    """A pair whose pull depends on everything there is, to try derivatives on."""

    def torque(self, q: ca.SX, v: ca.SX, activation: ca.SX, numbers: ca.SX) -> ca.SX:
        force = numbers * ca.exp(-v) * activation * ca.cos(q + ca.SX([0.3, -0.2]))
        return ca.cos(q) * force[0] - ca.sin(2 * q) * force[1]


def cart(joint: pin.JointModel | None = None, stiffness: float = 0.0) -> pik.Body:
    """A mass on rails, or on a rod, as a body; the frame `bob` is the mass."""
    model = pin.Model()
    joint = joint or pin.JointModelPX()
    index = model.addJoint(0, joint, pin.SE3.Identity(), "joint")
    bob = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.4]))
    inertia = pin.Inertia(MASS, bob.translation, np.zeros((3, 3)))
    model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
    model.addFrame(pin.Frame("bob", index, 0, bob, pin.FrameType.BODY), False)
    model.lowerPositionLimit, model.upperPositionLimit = np.array([-10.0]), np.array([10.0])
    springs = np.array([stiffness])
    return pik.Body(pik.Subject(), model, "", springs, springs / 10, np.zeros(1))


def push(
    pair: Pair, duration: float, body: pik.Body | None = None, intervals: int = 8
) -> Trajectory:
    """Move the cart by DISTANCE."""
    held = pik.Frame(frame="bob", components=("x",), position=(DISTANCE, 0.0, 0.0))
    block = pik.TrajectoryBlock(
        cost="activation", joints=("joint",), duration=duration, smoothness=0.0
    )
    problem = pik.Problem(task=(held,), trajectory=block)
    return control.reach(
        body or cart(), problem, start=np.zeros(1), intervals=intervals, drive=lambda limb: pair
    )


def test_a_pair_shares_the_force_of_least_effort() -> None:
    """f = 6 m d / T² (1 - 2 t / T); who pulls that way alone does: cost 12 m² d² / (T³ F²)."""
    duration = 1.5
    # a spring that is not to help
    found = push(Pair(), duration, cart(stiffness=100.0))
    share = 6 * MASS * DISTANCE / duration**2 * (1 - 2 * found.time / duration) / STRENGTH
    # at the middle, where neither is to pull, the barrier keeps both off zero: √(1e-9 / 2 weight)
    np.testing.assert_allclose(
        found.activation, np.maximum(np.column_stack([share, -share]), 0.0), atol=3e-4
    )
    cost = 12 * MASS**2 * DISTANCE**2 / duration**3 / STRENGTH**2
    assert found.cost == pytest.approx(cost, rel=1e-5)
    # the reserve takes its part, 1e-4 / strength² of the force
    np.testing.assert_allclose(found.reserve[:, 0], share / (1e4 * STRENGTH), atol=1e-9)
    assert found.imbalance < 1e-9
    np.testing.assert_array_equal(found.excitation, found.activation)


def test_a_pair_that_lags_against_a_convex_program() -> None:
    """Activations linear over 200 steps: least squares with linear constraints, for DAQP."""
    duration, lag, steps = 1.2, Lag(rise=0.15, fall=0.4), 200
    found = push(Pair(lag), duration, intervals=30)
    h, place = duration / steps, np.arange(steps + 1)
    weights = h * np.ones(steps + 1)
    weights[[0, -1]] /= 2
    # v and x at the end, by the steps' linear acceleration, exactly
    arm = weights * (duration - h * place)
    arm[[0, -1]] = h * (duration / 2 - h / 6), h * h / 6
    pull = STRENGTH / MASS * np.array([1.0, -1.0])
    ends = np.vstack([np.kron(pull, weights), np.kron(pull, arm)])
    first = np.kron(np.eye(2), np.eye(1, steps + 1))
    slope = (np.eye(steps, steps + 1, 1) - np.eye(steps, steps + 1)) / h
    middle = (np.eye(steps, steps + 1, 1) + np.eye(steps, steps + 1)) / 2
    rows = np.vstack(
        [ends, first, *(np.kron(np.eye(2), middle + constant * slope) for constant in lag)]
    )
    fixed, free = np.array([0.0, DISTANCE, 0.05, 0.05]), np.full(2 * steps, 1e30)
    size = 2 * (steps + 1)
    mass = h / 6 * (4 * np.eye(steps + 1) + np.eye(steps + 1, k=1) + np.eye(steps + 1, k=-1))
    mass[[0, -1], [0, -1]] = h / 3  # ∫ a² of a linear course
    x, cost, flag, _ = daqp.solve(
        2 * np.kron(np.eye(2), mass),
        np.zeros(size),
        rows,
        np.concatenate([np.ones(size), fixed, np.ones(2 * steps), free]),
        np.concatenate([np.zeros(size), fixed, -free, np.zeros(2 * steps)]),
        np.concatenate(
            [np.zeros(size), np.full(4, 5), np.zeros(4 * steps)], dtype=np.int32, casting="unsafe"
        ),
    )
    assert flag == 1
    # both know the course to the length of a step or of an interval at its kinks
    assert found.cost == pytest.approx(cost, rel=2e-3)
    courses = [np.interp(found.time, h * place, each) for each in np.split(x, 2)]
    np.testing.assert_allclose(found.activation, np.transpose(courses), atol=0.01)
    # it costs more than at once, so that the lag is felt at all
    assert found.cost > 1.2 * push(Pair(), duration).cost
    rate = found.controls[1:, -2:]
    a = found.activation[1:]
    assert np.all(rate >= -a / lag.fall - 1e-7)
    assert np.all(rate <= (1 - a) / lag.rise + 1e-7)
    # the rates are those of the activations: over each interval by its quadrature
    weights = found.duration * np.kron(found.mesh, radau()[1][-1])
    grown = np.add.reduceat(weights[:, None] * rate, np.arange(0, len(weights), 4))
    np.testing.assert_allclose(np.diff(found.activation[::4], axis=0), grown, atol=1e-8)


@pytest.mark.parametrize("lag", [None, Lag(0.1, 0.3)])
def test_derivatives_equal_casadis_own(lag: Lag | None) -> None:
    """Automatic differentiation of the same f and g, in free time, with all kinds of rows."""
    body = cart(pin.JointModelRY())
    twin, pair = Kinematics.of(body.model), Crossed(lag)
    tasks = constraints_of(
        frame_poses(body.model, np.zeros(1)),
        pik.Problem(task=(pik.Frame(frame="bob", components=("x",), position=(0.1, 0, 0)),)),
    )
    points = Points.of(twin, tasks, tasks, (True, True), pair)
    one = np.ones(1)
    parameters = points.parameters(
        twin.values(body.model),
        *(3 * one, 0.2 * one, 0.7 * one, 2 * one),
        np.array([0.5, 0.1, 2.0]),
        pair.numbers,
        *(task.target for task in (*tasks, *tasks)),
    )
    held = np.ones(1, bool)
    question = Question(points, parameters, 0 * one, -one, one, one, one, None, pair, (held, held))
    program = program_on(question, np.array([0.4, 0.6]))
    x, p, f, g = (program.nlp[key] for key in ("x", "p", "f", "g"))
    sigma, lam = ca.MX.sym("sigma"), ca.MX.sym("lam", g.numel())
    hessian, _ = ca.hessian(sigma * f + ca.dot(lam, g), x)
    own = ca.Function(
        "own", [x, p, sigma, lam], [ca.gradient(f, x), ca.jacobian(g, x), ca.triu(hessian)]
    )
    rng = np.random.default_rng(2)
    at = np.append(rng.normal(size=x.numel() - 1), 0.7)
    numbers = (at, parameters, 0.3, rng.normal(size=g.numel()))
    ours = (
        program.grad_f(*numbers[:2])[1],
        program.jac_g(*numbers[:2])[1],
        program.hess_lag(*numbers),
    )
    for mine, theirs in zip(ours, own(*numbers), strict=True):
        np.testing.assert_allclose(
            mine.full(), theirs.full(), atol=1e-11 * np.abs(theirs.full()).max()
        )


def test_activation_needs_actuators() -> None:
    held = pik.Frame(frame="bob", components=("x",), position=(DISTANCE, 0.0, 0.0))
    block = pik.TrajectoryBlock(cost="activation", joints=("joint",), duration=1.0)
    with pytest.raises(pik.PostureIKError, match="'activation' needs actuators"):
        control.reach(cart(), pik.Problem(task=(held,), trajectory=block), start=np.zeros(1))
