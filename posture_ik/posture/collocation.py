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
from posture_ik.kinematics import Kinematics, inverse_dynamics
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
        end, path = (ca.vertcat(*part) for part in (residuals[: len(ends)], residuals[len(ends) :]))
        overturn = ca.vertcat(*overturns[: len(ends)])
        self.one_sided = tuple(
            np.array([task.one_sided for task in tasks for _ in task.rows], bool)
            for tasks in (ends, along)
        )

        # Of the twin's numbers, most place frames that nothing here asks for.
        asked = {str(s) for s in ca.symvar(ca.vertcat(tau, end, path))}
        names = [str(s) for s in ca.vertsplit(kinematics.parameters)]
        self._used = [i for i, name in enumerate(names) if name in asked]
        p = ca.vertcat(
            kinematics.parameters[self._used],
            *(stiffness, rest, damping, strength, weights, *targets),
        )
        self.torque = ca.Function("torque", [q, v, a, p], [tau])

        z = ca.vertcat(q, u, w)
        cost = weights[0] * ca.sumsqr(tau / strength) + weights[1] * ca.sumsqr(a) + weights[2]
        rows = ca.vertcat(*[row for row, is_in in zip((tau, v), limited, strict=True) if is_in])
        cost, rows = ca.substitute(
            [duration * cost, ca.vertcat(rows, path)],
            [v, a],
            [u / duration, w / duration**2],
        )
        arguments = ca.vertcat(z, duration)
        gradient, jacobian = ca.gradient(cost, arguments), ca.jacobian(rows, arguments)
        at = [z, duration, p]
        self.value = ca.Function("value", at, ca.cse([cost, rows]))
        self.slope = ca.Function("slope", at, ca.cse([cost, *_parts(gradient.T)]))
        self.jacobian = ca.Function("jacobian", at, ca.cse([rows, *_parts(jacobian)]))
        weight, lam = ca.SX.sym("weight"), ca.SX.sym("lambda", rows.numel())
        hessian, _ = ca.hessian(weight * cost + ca.dot(lam, rows), arguments)
        along_z, along_t = _parts(hessian)
        self.second = ca.Function(
            "second",
            [*at, weight, lam],
            [ca.triu(along_z[: 3 * n, :]), along_t[: 3 * n], along_t[3 * n]],
        )
        self.end = ca.Function("end", [q, p], [end, ca.jacobian(end, q)])
        self.path = ca.Function("path", [q, p], [path, ca.jacobian(path, q)])
        lam = ca.SX.sym("lambda", end.numel())
        bent, _ = ca.hessian(ca.dot(lam, end), q)
        self.end_second = ca.Function("end_second", [q, p, lam], [ca.triu(bent)])
        self.overturn = ca.Function("overturn", [q, p], [overturn])

    def parameters(self, twin_numbers: Array, *rest: Array) -> Array:
        """Put p together: of the twin's numbers those needed, then the rest in order."""
        return np.concatenate([twin_numbers[self._used], *rest])


def _parts(derivative: ca.SX) -> list[ca.SX]:
    """A derivative with respect to (z, T) as its part in z and its, dense, part in T."""
    last = derivative.shape[1] - 1
    return [derivative[:, :last], ca.densify(derivative[:, last])]
