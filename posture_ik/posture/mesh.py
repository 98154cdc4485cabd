"""A reach on a mesh of intervals: the sparse program put together from its points, and solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from scipy import sparse

from posture_ik.arrays import Array
from posture_ik.posture.actuators import Actuators
from posture_ik.posture.collocation import DEGREE, Mask, Points, radau

#: The shortest and the longest free time, s.
SHORTEST, LONGEST = 0.02, 60.0


@dataclass(frozen=True)
class Question:
    """A reach to be solved on some mesh.

    Attributes:
        points: the graph of its points.
        parameters: the graph's numbers p.
        start: configuration (n,) at the start, at rest.
        lower, upper: range of the joints, (n,).
        speed, torque: their limits, (n,), to either side; None where no joint has one.
        duration: T, s; None where it is free.
        actuators: what drives the joints, if they do not move at will.
        held: which rows of the tasks at the end, and of those along the path, are asked for at
            the end; the others follow from these.
    """

    points: Points
    parameters: Array
    start: Array
    lower: Array
    upper: Array
    speed: Array | None
    torque: Array | None
    duration: float | None
    actuators: Actuators | None
    held: tuple[Mask, Mask]

    @property
    def activation(self) -> Array:
        """Activations before the start that lag, (m,) or none."""
        lagging = self.actuators is not None and self.actuators.lag is not None
        return self.actuators.start if self.actuators and lagging else np.zeros(0)


class Solution(NamedTuple):
    """Where IPOPT stopped: the points z (r, points) and T on a mesh, and its certificate.

    `primal` is the largest overrun of an equation or limit, `dual` the largest component of the
    Lagrangian's gradient.
    """

    mesh: Array
    z: Array
    duration: float
    cost: float
    converged: bool
    status: str
    iterations: int
    primal: float
    dual: float


class MeshProgram(NamedTuple):
    """The functions that IPOPT is given, and the right side of the collocation equations."""

    nlp: dict[str, Any]
    grad_f: ca.Function
    jac_g: ca.Function
    hess_lag: ca.Function
    right: Array


def solve_on_mesh(
    question: Question, mesh: Array, guess: tuple[Array, float], first_barrier: float
) -> Solution:
    """Solve a reach on one mesh.

    Args:
        question: the reach.
        mesh: lengths of the intervals in scaled time, (k,), of sum 1.
        guess: z (r, k d) and T to start from.
        first_barrier: IPOPT's first barrier parameter, small where the guess is near.
    """
    program = program_on(question, mesh)
    options: dict[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "linear_solver": "mumps",
        "tol": 1e-9,
        "constr_viol_tol": 1e-9,
        "bound_relax_factor": 0.0,
        "acceptable_iter": 0,
        "max_iter": 300,
        "mu_init": first_barrier,
    }
    settings: dict[str, Any] = {"print_time": False, "ipopt": options}
    settings |= {key: getattr(program, key) for key in ("grad_f", "jac_g", "hess_lag")}
    solver = ca.nlpsol("reach", "ipopt", program.nlp, settings)
    lbx, ubx, lbg, ubg = _bounds(question, DEGREE * len(mesh), program.right)
    p, x0 = question.parameters, np.append(guess[0].ravel(order="F"), guess[1])
    found = solver(x0=x0, p=p, lbx=lbx, ubx=ubx, lbg=lbg, ubg=ubg)
    stats = solver.stats()
    x = found["x"].full().ravel()
    rows, jacobian = program.jac_g(x, p)
    rows = rows.full().ravel()
    slope = program.grad_f(x, p)[1] + jacobian.T @ found["lam_g"] + found["lam_x"]
    over = np.concatenate([lbg - rows, rows - ubg, lbx - x, x - ubx])
    return Solution(
        mesh=mesh,
        z=x[:-1].reshape(guess[0].shape, order="F"),
        duration=float(x[-1]),
        cost=float(found["f"]),
        converged=bool(stats["success"]),
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
        primal=max(0.0, float(np.max(over))),
        dual=float(np.max(np.abs(slope.full()))),
    )


def program_on(question: Question, mesh: Array) -> MeshProgram:
    """Map the graph of a point over a mesh: cost, rows and their sparse derivatives."""
    points = question.points
    n, size, count = points.size, sum(points.parts), DEGREE * len(mesh)
    x, p = ca.MX.sym("x", size * count + 1), ca.MX.sym("p", len(question.parameters))
    z, total = ca.reshape(x[:-1], size, count), x[-1]
    weights = ca.DM(np.kron(mesh, radau()[1][-1]))
    linear, right = _collocation(question, mesh)
    once = [1, 2]  # T and p are the same at every point

    value, slope, slopes = (
        f.map(f.name(), "serial", count, once, [])(z, total, p)
        for f in (points.value, points.slope, points.jacobian)
    )
    end, end_jacobian = points.end(z[:n, -1], p)
    # Cost and rows come with their derivatives where those are asked for, and cheaply alone.
    f, f_again = (ca.dot(weights, cost.T) for cost in (value[0], slope[0]))
    g, g_again = (ca.vertcat(linear @ x[:-1], ca.vec(rows), end) for rows in (value[1], slopes[0]))
    by_row = ca.DM(np.repeat(weights.full(), size))
    gradient = ca.vertcat(slope[1].T * by_row, slope[2] @ weights)
    rest = ca.MX(end.numel(), size * (count - 1)), ca.MX(end.numel(), size - n + 1)
    jacobian = ca.vertcat(
        ca.horzcat(linear, ca.MX(linear.shape[0], 1)),
        ca.horzcat(ca.diagcat(*ca.horzsplit(slopes[1], size)), ca.vec(slopes[2])),
        ca.horzcat(rest[0], end_jacobian, rest[1]),
    )

    m = slopes[0].shape[0]
    sigma, lam = ca.MX.sym("sigma"), ca.MX.sym("lambda", g.numel())
    _, on_points, on_end = ca.vertsplit(
        lam, [0, linear.shape[0], linear.shape[0] + m * count, g.numel()]
    )
    second = points.second.map("second", "serial", count, once, [])
    zz, zt, tt = second(z, total, p, sigma * weights.T, ca.reshape(on_points, m, count))
    blocks = ca.horzsplit(zz, size)
    bent = points.end_second(z[:n, -1], p, on_end)
    blocks[-1] = blocks[-1] + ca.diagcat(bent, ca.MX(size - n, size - n))
    hessian = ca.vertcat(
        ca.horzcat(ca.diagcat(*blocks), ca.vec(zt)),
        ca.horzcat(ca.MX(1, size * count), ca.sum2(tt)),
    )
    return MeshProgram(
        {"x": x, "p": p, "f": f, "g": g},
        ca.Function("grad_f", [x, p], [f_again, gradient]),
        ca.Function("jac_g", [x, p], [g_again, jacobian]),
        ca.Function("hess_lag", [x, p, sigma, lam], [hessian]),
        right,
    )


def _bounds(question: Question, count: int, right: Array) -> tuple[Array, Array, Array, Array]:
    """Bounds of x and of the rows, lower and upper each."""
    points, n = question.points, question.points.size
    free = np.full(2 * n, np.inf)
    # Of activations the bounds are known, of reserves and rates there are none.
    kinds = [(0.0, 1.0), (-np.inf, np.inf), (-np.inf, np.inf)]
    rest = points.parts[3:]
    low_rest, high_rest = np.repeat(kinds[: len(rest)], rest, axis=0).reshape(-1, 2).T
    fixed = question.duration
    shortest, longest = (SHORTEST, LONGEST) if fixed is None else (fixed, fixed)
    low, high = (
        np.tile(np.concatenate(each), (count, 1))
        for each in ((question.lower, -free, low_rest), (question.upper, free, high_rest))
    )
    low[-1, n : 2 * n] = high[-1, n : 2 * n] = 0.0  # u of the last point: at rest
    lbx, ubx = np.append(low, shortest), np.append(high, longest)
    most = [limit for limit in (question.torque, question.speed) if limit is not None]
    end, path = (np.where(one_sided, np.inf, 0.0) for one_sided in points.one_sided)
    floor = np.concatenate([*(-limit for limit in most), points.lower, np.zeros(len(path))])
    ceiling = np.concatenate([*most, points.upper, path])
    floors, ceilings = np.tile(floor, (count, 1)), np.tile(ceiling, (count, 1))
    # Position at every point fixes the speed of what the path holds, and rest at the end is one
    # condition more: the last point but one gives way.
    paths = slice(len(floor) - len(path), None)
    floors[-2, paths][path == 0.0], ceilings[-2, paths][path == 0.0] = -np.inf, np.inf
    floors[-1, paths][~question.held[1]], ceilings[-1, paths][~question.held[1]] = -np.inf, np.inf
    low = np.where(question.held[0], 0.0, -np.inf)
    high = np.where(question.held[0], end, np.inf)
    lbg = np.concatenate([right, floors.ravel(), low])
    ubg = np.concatenate([right, ceilings.ravel(), high])
    return lbx, ubx, lbg, ubg


def _collocation(question: Question, mesh: Array) -> tuple[ca.DM, Array]:
    """The collocation equations of all points, G z = r: G (s k d, r k d) and r (s k d,)."""
    points, k = question.points, len(mesh)
    each = sparse.eye(sum(points.parts)).tocsr()
    state, rate = each[points.states], each[points.rates]
    last = np.zeros((DEGREE, DEGREE))
    last[:, -1] = 1.0
    before = sparse.kron(np.eye(k, k, -1), last)
    by_state = sparse.kron(sparse.eye(k * DEGREE) - before, state)
    whole = by_state - sparse.kron(sparse.kron(sparse.diags(mesh), radau()[1]), rate)
    first = np.concatenate([question.start, 0 * question.start, question.activation])
    r = np.zeros(len(first) * k * DEGREE)
    r[: len(first) * DEGREE] = np.tile(first, DEGREE)
    return ca.DM(whole.tocsc()), r
