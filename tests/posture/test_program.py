"""The program's analytic derivatives against CasADi's own, and the property they stand on."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import posture_ik as pik
from posture_ik.kinematics import Pose
from posture_ik.posture.statement import Statement

PROBLEMS = ["reclined_30", "reclined_15_gravity", "look_left", "slouched", "pilot", "pilot_push"]


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(params=PROBLEMS, scope="module")
def statement(request: pytest.FixtureRequest, body: pik.Body) -> Statement:
    return Statement.of(body, pik.load_problem(request.param))


@pytest.fixture(scope="module")
def point(statement: Statement) -> tuple[np.ndarray, np.ndarray]:
    """A configuration within the ranges and multipliers of the size that occurs."""
    rng = np.random.default_rng(3)
    q = rng.uniform(0.5 * statement.body.lower, 0.5 * statement.body.upper)
    return q, rng.normal(scale=100.0, size=statement.rows)


def test_derivatives_equal_casadis_own(
    statement: Statement, point: tuple[np.ndarray, np.ndarray]
) -> None:
    """Automatic differentiation of the same f and g; only rounding differs, hence 1e-11."""
    program, (q, multipliers) = statement.program, point
    x, p, f, g = (program.nlp[key] for key in ("x", "p", "f", "g"))
    lam = ca.SX.sym("lam", g.numel())
    lagrangian = f + ca.dot(lam, g)
    own = ca.Function(
        "own",
        [x, p, lam],
        [ca.jacobian(g, x), ca.gradient(lagrangian, x), ca.hessian(lagrangian, x)[0]],
    )
    numbers = (statement.x_of(q), statement.parameters, multipliers)
    jacobian, gradient, hessian = (value.full() for value in own(*numbers))
    _, j, grad, hess, _ = (v.full() for v in program.evaluate(q, statement.parameters, multipliers))
    np.testing.assert_allclose(j, jacobian, atol=1e-11 * np.abs(jacobian).max())
    np.testing.assert_allclose(grad, gradient, atol=1e-11 * np.abs(gradient).max())
    np.testing.assert_allclose(hess, hessian, atol=1e-11 * np.abs(hessian).max())
    triangle = program.derivatives["hess_lag"](*numbers[:2], 1.0, multipliers).full()
    np.testing.assert_allclose(triangle, np.triu(hessian), atol=1e-11 * np.abs(hessian).max())
    _, j, slope, h = (value.full() for value in program.kkt(*numbers))
    np.testing.assert_allclose(j, jacobian, atol=1e-11 * np.abs(jacobian).max())
    np.testing.assert_allclose(h, hessian, atol=1e-11 * np.abs(hessian).max())
    np.testing.assert_allclose(
        slope.ravel() + jacobian.T @ multipliers,
        gradient.ravel(),
        atol=1e-11 * np.abs(gradient).max(),
    )


def test_gradient_equals_central_differences(
    statement: Statement, point: tuple[np.ndarray, np.ndarray]
) -> None:
    """Along one direction at two steps: the error falls as the square of the step."""
    program, (q, multipliers) = statement.program, point
    direction = np.random.default_rng(5).normal(size=len(q))
    f = ca.Function("f", [program.nlp["x"], program.nlp["p"]], [program.nlp["f"], program.nlp["g"]])
    x = statement.x_of(q)

    def lagrangian(shift: float) -> float:
        value, residual = f(x + shift * direction, statement.parameters)
        return float(value) + multipliers @ residual.full().ravel()

    gradient = program.evaluate(q, statement.parameters, multipliers)[2].full().ravel()
    errors = [
        abs((lagrangian(h) - lagrangian(-h)) / (2 * h) - gradient @ direction) for h in (1e-2, 1e-3)
    ]
    assert errors[1] < 0.02 * errors[0]


def test_constraints_are_linear_in_the_poses(statement: Statement) -> None:
    """What the forces and the Hessian rest on: no second derivative by the pose of one frame."""
    for constraint in statement.constraints:
        poses = {f: Pose(ca.SX.sym("R", 3, 3), ca.SX.sym("p", 3)) for f in constraint.frames}
        target = ca.SX.sym("alpha", constraint.target.size)
        for pose in poses.values():
            numbers = ca.vertcat(pose.position, ca.vec(pose.rotation))
            jacobian = ca.jacobian(constraint.residual(poses, target), numbers)
            assert not ca.depends_on(jacobian, numbers), constraint.label


def test_residuals_vanish_at_the_reference_shape(body: pik.Body) -> None:
    statement = Statement.of(body, pik.load_problem("upright"))
    residual = statement.program.evaluate(
        body.q_reference, statement.parameters, np.zeros(statement.rows)
    )[0]
    np.testing.assert_allclose(residual.full(), 0.0, atol=1e-15)


def test_the_backrest_average_linearises_to_rbe3(body: pik.Body) -> None:
    """Nastran's RBE3 of small motions, translations and rotations of equal weight at length L."""
    statement = Statement.of(body, pik.load_problem("upright"))
    constraint = statement.constraints[0]
    rng = np.random.default_rng(11)
    target = constraint.target
    count, size = len(constraint.frames), 1e-7
    arms = [target[13 + 12 * i : 16 + 12 * i] for i in range(count)]
    moved, turned = rng.normal(size=(2, count, 3)) * size
    poses = {}
    for i, frame in enumerate(constraint.frames):
        skew = ca.DM(np.cross(turned[i], np.eye(3)).T)
        goal = ca.DM(target[16 + 12 * i : 25 + 12 * i].reshape(3, 3).T)
        rotation = (ca.DM.eye(3) + skew) @ goal
        poses[frame] = Pose(ca.SX(rotation), ca.SX(ca.DM(target[:3] + arms[i] + moved[i])))
    residual = ca.evalf(constraint.residual(poses, ca.SX(ca.DM(target)))).full().ravel()
    square = target[12] ** 2
    mean = moved.mean(axis=0)
    weight = sum(arm @ arm + square for arm in arms)
    moment = sum(
        np.cross(arm, u) + square * w for arm, u, w in zip(arms, moved, turned, strict=True)
    )
    expected = np.concatenate([mean[:2], moment / weight])  # upright: the axes are the world's
    np.testing.assert_allclose(residual, expected, atol=1e-13)
