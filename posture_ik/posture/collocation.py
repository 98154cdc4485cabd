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
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import ClassVar, TypeAlias

import casadi as ca
import numpy as np
import numpy.typing as npt

from posture_ik.arrays import Array
from posture_ik.kinematics import Kinematics, inverse_dynamics, torque_derivatives
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
        value: (z, T, p) -> L (1,), c (m,), with z = (q, u, w). The rows c are tau, then v, each
            where limited, then the tasks along the path.
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
    ) -> Points:
        """Give the graph for tasks at the end and along the path, built once for all.

        Args:
            kinematics: the twin of the joints that move.
            ends: tasks at the end.
            along: tasks along the path.
            limited: whether torque and speed have limits.
        """
        structures = (tuple(task.structure() for task in tasks) for tasks in (ends, along))
        key = (kinematics, limited, *structures)
        if key not in cls._known:
            cls._known[key] = cls(kinematics, ends, along, limited)
        return cls._known[key]

    def __init__(
        self,
        kinematics: Kinematics,
        ends: Sequence[Constraint],
        along: Sequence[Constraint],
        limited: tuple[bool, bool],
    ) -> None:
        self.size = n = len(kinematics.motions)
        q, u, w, duration = kinematics.q, ca.SX.sym("u", n), ca.SX.sym("w", n), ca.SX.sym("T")
        v, a = ca.SX.sym("v", n), ca.SX.sym("a", n)
        stiffness, rest, damping = (ca.SX.sym(name, n) for name in ("K", "rest", "D"))
        strength, weights = ca.SX.sym("strength", n), ca.SX.sym("weights", 3)
        targets = [ca.SX.sym("target", task.target.size) for task in (*ends, *along)]
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
            *(stiffness, rest, damping, strength, weights, *targets),
        )
        self.torque = ca.Function("torque", [q, v, a, p], [tau])

        effort, smoothness, time = ca.vertsplit(weights)
        z, at = ca.vertcat(q, u, w), [u / duration, w / duration**2]
        cost = effort * ca.sumsqr(tau / strength) + smoothness * ca.sumsqr(a) + time
        asked = ca.vertcat(*[row for row, is_in in zip((tau, v), limited, strict=True) if is_in])
        weight, lam = ca.SX.sym("weight"), ca.SX.sym("lambda", asked.numel() + path.numel())
        on_tau, on_v, on_path = _shares(lam, n, limited)

        # Derivatives in y = (q, v, a) of the rows, and of weight L + lambdaᵀ rows.
        pressed = 2 * weight * duration * effort * tau / strength**2
        tau_y, bent = torque_derivatives(kinematics, v, a, pressed + on_tau)
        tau_y[:, : 2 * n] += ca.horzcat(ca.diag(stiffness), ca.diag(damping))
        path_bent, path_slope = ca.hessian(ca.dot(on_path, path), q)
        still = ca.SX(n, n)
        rows_y = ca.vertcat(
            *[tau_y] * limited[0],
            *[ca.horzcat(still, ca.SX.eye(n), still)] * limited[1],
            ca.horzcat(ca.jacobian(path, q), ca.SX(path.numel(), 2 * n)),
        )
        rough = 2 * weight * duration * smoothness
        bent += ca.diagcat(path_bent, still, rough * ca.SX.eye(n))
        stiff = 2 * weight * duration * effort / strength**2  # for the rest, tau_yᵀ stiff tau_y
        cost_slope = tau_y.T @ pressed + ca.vertcat(ca.SX(2 * n, 1), rough * a)
        slope = cost_slope + tau_y.T @ on_tau + ca.vertcat(path_slope, on_v, ca.SX(n, 1))

        # ... and in z and T, of which y = stretch z: y_T, z_T and their derivatives.
        ones = ca.SX.ones(n)
        stretch = ca.vertcat(ones, ones / duration, ones / duration**2)
        once, twice = (ca.vertcat(0 * q, b * v, c * a) for b, c in ((-1, -2), (2, 6)))
        along_t, along_tt = once / duration, twice / duration**2
        bent = ca.triu(bent) + ca.triu(bent, False).T
        tau_t = tau_y @ along_t
        bent_t = bent @ along_t + tau_y.T @ (stiff * tau_t)
        mixed = stretch * (bent_t + cost_slope / duration)
        mixed += stretch * ca.vertcat(0 * q, -slope[n : 2 * n], -2 * slope[2 * n :]) / duration
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
            return ca.cse(ca.substitute(list(terms), [v, a], at))

        cost, rows = in_scaled_time(duration * cost, ca.vertcat(asked, path))
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


def _shares(lam: ca.SX, n: int, limited: tuple[bool, bool]) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Multipliers of the torques, of the speeds (zero where not limited), and of the path."""
    cuts = [0, n * limited[0], n * sum(limited), lam.numel()]
    on_tau, on_v, on_path = ca.vertsplit(lam, cuts)
    none = ca.SX(n, 1)
    return on_tau if limited[0] else none, on_v if limited[1] else none, on_path
