"""A reach as a sparse nonlinear program: direct collocation at Radau points.

Time is scaled, t = T s with s from 0 to 1, and the unknowns at every collocation point are q and
its derivatives u = dq/ds and w = d²q/ds². On an interval of length h, u and q are the polynomials
whose derivatives pass through the w and u of its d points (Radau IIA, stiffly accurate, so that
the last point is the interval's end and a constraint along the path stays met):

    u_i = u_0 + h Σ A_ij w_j,    q_i = q_0 + h Σ A_ij u_j.

These equations are linear, in free time too: T enters through v = u / T and a = w / T² alone,
and so only in what is asked of each point by itself,

    L = T [ effort Σ (tau / strength)² + smoothness Σ a² + time ],    tau, v, tasks along the path,

with tau = M a + b(q, v) + K (q - q_ref) + D v what muscles supply. One SX graph of a point, with
its first and exact second derivatives, is mapped over all of them.

Where actuators drive the joints, their activations and a reserve torque are unknowns of each point
too, tau = torque(q, v, activation) + reserve, and instead of effort L counts

    Σ activation² + price Σ reserve².

Where the activations lag, their derivatives in s are unknowns as well, and what integrates u
integrates them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import ClassVar, NamedTuple, TypeAlias

import casadi as ca
import numpy as np
import numpy.typing as npt

from posture_ik.arrays import Array
from posture_ik.kinematics import Kinematics, inverse_dynamics, torque_derivatives
from posture_ik.posture.actuators import RESERVE_PRICE, Actuators
from posture_ik.posture.tasks import Constraint

Mask: TypeAlias = npt.NDArray[np.bool_]

#: Collocation points an interval; the ends of intervals are right to order 2 d - 1.
DEGREE = 4


@cache
def radau() -> tuple[Array, Array]:
    """Points c (d,) in (0, 1] and the matrix A (d, d) that integrates from 0 to each of them."""
    points = ca.collocation_points(DEGREE, "radau")
    slopes = ca.collocation_coeff(points)[0].full()
    return np.array(points), np.linalg.inv(slopes[1:].T)


class Points:
    """The graph of one collocation point, shared by all bodies, targets and limits of a structure.

    Attributes:
        size: number n of joints that move.
        parts: of z, the sizes of q, u, w, and with actuators of activation and reserve, and of the
            activations' derivatives where they lag.
        powers: z is (q, v, a, controls) times these powers of T, (r,).
        states, rates: which of z are integrated, and which are their derivatives.
        value: (z, T, p) -> L (1,), c (m,). The rows c are tau, then v, each where limited, then
            what actuators leave of tau and how far their excitations are within 0 and 1, then the
            tasks along the path.
        lower, upper: of the rows that are the actuators'.
        slope, jacobian: (z, T, p) -> L or c, and its derivatives with respect to z and to T.
        second: (z, T, p, weight, lambda) -> Hessian of weight L + lambdaᵀc, upper triangle, as
            its parts zz, zT, TT.
        end, end_second: (q, p) -> residual of the tasks at the end and Jacobian; (q, p, lambda)
            -> Hessian of lambdaᵀ residual, upper triangle.
        overturn: (q, p) -> 1 - cos(phi) of every orientation held in full at the end.
        torque: (q, v, a, p) -> tau.
        path: as `end`, of the tasks along the path.
        one_sided: which rows of the tasks at the end, and of those along the path, are >= 0
            rather than = 0.
    """

    _known: ClassVar[dict[tuple[object, ...], Points]] = {}

    @classmethod
    def of(
        cls,
        kinematics: Kinematics,
        ends: Sequence[Constraint],
        along: Sequence[Constraint],
        limited: tuple[bool, bool],
        actuators: Actuators | None = None,
    ) -> Points:
        """Give the graph for tasks at the end and along the path, built once for all.

        Args:
            kinematics: the twin of the joints that move.
            ends: tasks at the end.
            along: tasks along the path.
            limited: whether torque and speed have limits.
            actuators: what drives the joints, if they do not move at will.
        """
        structures = (tuple(task.structure() for task in tasks) for tasks in (ends, along))
        key = (kinematics, limited, actuators and actuators.structure(), *structures)
        if key not in cls._known:
            cls._known[key] = cls(kinematics, ends, along, limited, actuators)
        return cls._known[key]

    def __init__(
        self,
        kinematics: Kinematics,
        ends: Sequence[Constraint],
        along: Sequence[Constraint],
        limited: tuple[bool, bool],
        actuators: Actuators | None,
    ) -> None:
        self.size = n = len(kinematics.motions)
        q, v, a, duration = kinematics.q, ca.SX.sym("v", n), ca.SX.sym("a", n), ca.SX.sym("T")
        stiffness, rest, damping = (ca.SX.sym(name, n) for name in ("K", "rest", "D"))
        strength, weights = ca.SX.sym("strength", n), ca.SX.sym("weights", 3)
        targets = [ca.SX.sym("target", task.target.size) for task in (*ends, *along)]
        driven = _Driven.of(actuators, q, v)
        self.lower, self.upper = driven.lower, driven.upper
        tau = inverse_dynamics(kinematics, v, a) + stiffness * (q - rest) + damping * v
        residuals, overturns = [], []
        for task, target in zip((*ends, *along), targets, strict=True):
            poses = {frame: kinematics.pose(frame) for frame in task.frames}
            residuals.append(task.residual(poses, target))
            overturns.append(task.overturn(poses, target))
        end, path = (
            ca.vertcat(ca.SX(0, 1), *part)
            for part in (residuals[: len(ends)], residuals[len(ends) :])
        )
        overturn = ca.vertcat(*overturns[: len(ends)])
        self.one_sided = tuple(
            np.array([task.one_sided for task in tasks for _ in task.rows], bool)
            for tasks in (ends, along)
        )

        # Of the twin's numbers, most place frames that nothing here asks for.
        needed = {str(s) for s in ca.symvar(ca.vertcat(tau, end, path))}
        names = [str(s) for s in ca.vertsplit(kinematics.parameters)]
        self._used = [i for i, name in enumerate(names) if name in needed]
        p = ca.vertcat(
            kinematics.parameters[self._used],
            *(stiffness, rest, damping, strength, weights, driven.numbers, *targets),
        )
        self.torque = ca.Function("torque", [q, v, a, p], [tau])

        # In physical time y = (q, v, a, controls), in scaled time z = y T^power.
        y = ca.vertcat(q, v, a, *driven.controls)
        sizes = [n, n, n, *(part.numel() for part in driven.controls)]
        self.powers = power = np.repeat([0, 1, 2, 0, 0, 1][: len(sizes)], sizes)
        self.parts, cuts = sizes, np.append(0, np.cumsum(sizes))
        first = [0, 1, 3][: 2 + (len(sizes) == 6)]
        following = [1, 2, 5][: len(first)]
        self.states, self.rates = (
            np.concatenate([np.arange(cuts[i], cuts[i + 1]) for i in each])
            for each in (first, following)
        )
        z = ca.SX.sym("z", y.numel())

        effort, smoothness, time = ca.vertsplit(weights)
        other_cost = smoothness * ca.sumsqr(a) + driven.cost
        cost = effort * ca.sumsqr(tau / strength) + other_cost + time
        left = tau[: driven.torque.numel(), :] - driven.torque
        asked = [tau[: n * limited[0], :], v[: n * limited[1], :], left, driven.lags, path]
        weight, lam = ca.SX.sym("weight"), ca.SX.sym("lambda", sum(row.numel() for row in asked))
        on = ca.vertsplit(lam, [0, *np.cumsum([row.numel() for row in asked]).tolist()])
        on_tau = sum((ca.vertcat(each, ca.SX(n - each.numel(), 1)) for each in (on[0], on[2])), 0)

        # Derivatives in y of the rows, and of weight L + lambdaᵀ rows: those of tau by
        # recursion, the others by CasADi.
        pressed = 2 * weight * duration * effort * tau / strength**2
        by_joints, by_joints_twice = torque_derivatives(kinematics, v, a, pressed + on_tau)
        by_joints[:, : 2 * n] += ca.horzcat(ca.diag(stiffness), ca.diag(damping))
        more = y.numel() - 3 * n
        tau_y = ca.horzcat(by_joints, ca.SX(n, more))
        others = ca.dot(on[1], asked[1]) - ca.dot(on[2], driven.torque)
        others += ca.dot(on[3], driven.lags) + ca.dot(on[4], path)
        rows_y = ca.vertcat(
            tau_y[: n * limited[0], :],
            ca.jacobian(asked[1], y),
            tau_y[: left.numel(), :] - ca.jacobian(driven.torque, y),
            ca.jacobian(ca.vertcat(driven.lags, path), y),
        )
        bent, _ = ca.hessian(others + weight * duration * other_cost, y)
        by_joints_twice = ca.triu(by_joints_twice) + ca.triu(by_joints_twice, False).T
        bent += ca.diagcat(by_joints_twice, ca.SX(more, more))
        stiff = 2 * weight * duration * effort / strength**2  # for the rest, tau_yᵀ stiff tau_y
        cost_slope = tau_y.T @ pressed + ca.gradient(weight * duration * other_cost, y)
        slope = cost_slope + tau_y.T @ on_tau + ca.gradient(others, y)

        # ... and in z and T, of which y = stretch z: y_T, z_T and their derivatives.
        stretch = ca.vertcat(*[1 / duration ** int(k) for k in power])
        along_t, along_tt = -power * y / duration, power * (power + 1) * y / duration**2
        tau_t = tau_y @ along_t
        bent_t = bent @ along_t + tau_y.T @ (stiff * tau_t)
        mixed = stretch * (bent_t + (cost_slope - power * slope) / duration)
        second = [
            ca.triu(ca.diag(stretch) @ bent @ ca.diag(stretch)),
            ca.densify(mixed),
            ca.dot(along_t, bent_t)
            + 2 * ca.dot(cost_slope, along_t) / duration
            + ca.dot(slope, along_tt),
            ca.densify(tau_y @ ca.diag(stretch)),
            stiff,
        ]
        jacobian = [ca.mtimes(rows_y, ca.diag(stretch)), ca.densify(rows_y @ along_t)]

        def in_scaled_time(*terms: ca.SX) -> list[ca.SX]:
            return ca.cse(ca.substitute(list(terms), [y], [stretch * z]))

        cost, rows = in_scaled_time(duration * cost, ca.vertcat(*asked))
        gradient = ca.gradient(cost, ca.vertcat(z, duration))
        point = [z, duration, p]
        self.value = ca.Function("value", point, [cost, rows])
        self.slope = ca.Function(
            "slope", point, ca.cse([cost, gradient[:-1].T, ca.densify(gradient[-1])])
        )
        self.jacobian = ca.Function("jacobian", point, [rows, *in_scaled_time(*jacobian)])
        arguments = [*point, weight, lam]
        self.second = _with_square(ca.Function("part", arguments, in_scaled_time(*second)))
        self.end = ca.Function("end", [q, p], [end, ca.jacobian(end, q)])
        self.path = ca.Function("path", [q, p], [path, ca.jacobian(path, q)])
        lam = ca.SX.sym("lambda", end.numel())
        bent, _ = ca.hessian(ca.dot(lam, end), q)
        self.end_second = ca.Function("end_second", [q, p, lam], [ca.triu(bent)])
        self.overturn = ca.Function("overturn", [q, p], [overturn])

    def parameters(self, twin_numbers: Array, *rest: Array) -> Array:
        """Put p together: of the twin's numbers those needed, then the rest in order."""
        return np.concatenate([twin_numbers[self._used], *rest])


def _with_square(part: ca.Function) -> ca.Function:
    """Add the torques' Jᵀ stiff J to a Hessian in z: as a product of matrices, a small graph."""
    arguments = part.mx_in()
    bent, mixed, twice, jacobian, stiff = part(*arguments)
    square = ca.mtimes(jacobian.T, ca.repmat(stiff, 1, jacobian.shape[1]) * jacobian)
    return ca.Function("second", arguments, [bent + ca.triu(square), mixed, twice])


class _Driven(NamedTuple):
    """What actuators add to a point; nothing where there are none.

    `controls` are activation and reserve, and the activations' rates where they lag; `torque` is
    what they give, `lags` are rows a + rise a' and a + fall a', of which one is the excitation,
    `lower` and `upper` are bounds of the rows tau - torque = 0 and of `lags`.
    """

    controls: tuple[ca.SX, ...]
    numbers: ca.SX
    torque: ca.SX
    lags: ca.SX
    cost: ca.SX
    lower: Array
    upper: Array

    @classmethod
    def of(cls, actuators: Actuators | None, q: ca.SX, v: ca.SX) -> _Driven:
        none = ca.SX(0, 1)
        if actuators is None:
            return cls((), none, none, none, ca.SX(0), np.zeros(0), np.zeros(0))
        m, n, lag = len(actuators.names), q.numel(), actuators.lag
        activation, reserve = ca.SX.sym("activation", m), ca.SX.sym("reserve", n)
        numbers = ca.SX.sym("numbers", actuators.numbers.size)
        torque = actuators.torque(q, v, activation, numbers) + reserve
        cost = ca.sumsqr(activation) + RESERVE_PRICE * ca.sumsqr(reserve)
        still = np.zeros(n)
        if lag is None:
            return cls((activation, reserve), numbers, torque, none, cost, still, still)
        rate = ca.SX.sym("rate", m)
        lags = ca.vertcat(activation + lag.rise * rate, activation + lag.fall * rate)
        lower = np.concatenate([still, np.full(m, -np.inf), np.zeros(m)])
        upper = np.concatenate([still, np.ones(m), np.full(m, np.inf)])
        return cls((activation, reserve, rate), numbers, torque, lags, cost, lower, upper)
