"""Velocities and accelerations that respect the tasks: mass-weighted projections (eqs 21-29).

In minimal coordinates the joints' own constraints phi are built in, and what remains is

    minimise ½ (v - v0)ᵀ M (v - v0)  subject to  J v + psi_t = 0                 (eqs 22, 24)
    minimise ½ (a - a0)ᵀ M (a - a0)  subject to  J a + (J v + psi_t)' = 0        (eqs 27, 29)

with M and J the same in both, so one factor of the KKT matrix serves both. It is scaled by
diag(M)^-½ first: the mass seen by a wrist and by the pelvis differ by five orders.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.linalg import qr
from scipy.linalg.lapack import dsytrf, dsytrs

from posture_ik.arrays import Array
from posture_ik.kinematics import Kinematics
from posture_ik.posture.tasks import constraints_of
from posture_ik.problem import Problem, with_numbers


def task_rates(
    kinematics: Kinematics,
    reference: Mapping[str, pin.SE3],
    problem: Problem,
    moving: Sequence[str],
) -> tuple[ca.Function, ca.Function]:
    """Differentiate a problem's tasks in time, exactly, along numbers of it that move.

    With s (k,) the numbers named `moving`, the tasks' rates are J v + psi_t = 0 and, once more,
    J a + drift = 0; the drift holds all of the second derivative that is not J a.

    Returns:
        (theta, s, s', parameters) -> J (m, n) and psi_t (m,), and
        (theta, v, s, s', s'', parameters) -> drift (m,).
    """
    theta, v = kinematics.q, ca.SX.sym("v", kinematics.q.numel())
    s, rate, acceleration = (ca.SX.sym(name, len(moving)) for name in ("s", "ds", "dds"))
    symbols = dict(zip(moving, ca.vertsplit(s), strict=True))
    residual = ca.vertcat(
        *[
            constraint.residual(
                {f: kinematics.pose(f) for f in constraint.frames},
                ca.SX(ca.vertcat(*constraint.target)),
            )
            for constraint in constraints_of(reference, with_numbers(problem, symbols))
        ]
    )
    at, along = ca.vertcat(theta, s), ca.vertcat(v, rate)
    moved = ca.jtimes(residual, s, rate)
    drift = ca.jtimes(ca.jtimes(residual, at, along), at, along)
    drift += ca.jtimes(residual, s, acceleration)
    parameters = kinematics.parameters
    jacobian = ca.jacobian(residual, theta)
    return (
        ca.Function(
            "rates", [theta, s, rate, parameters], [ca.densify(jacobian), ca.densify(moved)]
        ),
        ca.Function("drift", [theta, v, s, rate, acceleration, parameters], [ca.densify(drift)]),
    )


class Projection:
    """The factored KKT matrix of one instant.

    Args:
        mass: mass matrix M (n, n).
        jacobian: J (m, n).
        free: which degrees of freedom may move, bool (n,); the rest, at their limits, stay.

    Attributes:
        dependent: rows of J that others imply, left out; (<= m,).
    """

    def __init__(self, mass: Array, jacobian: Array, free: npt.NDArray[np.bool_]) -> None:
        self.free = free
        self.mass = mass[np.ix_(free, free)]
        self.scale = 1.0 / np.sqrt(np.diag(self.mass))
        scaled = jacobian[:, free] * self.scale
        _, triangle, order = qr(scaled.T, mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        rank = int(np.sum(pivots > 1e-9 * pivots.max(initial=0.0)))
        self.rows = np.sort(order[:rank])
        self.dependent = np.sort(order[rank:])
        self.jacobian = jacobian[np.ix_(self.rows, np.flatnonzero(free))]
        count = len(self.scale)
        system = np.zeros((count + rank, count + rank))
        system[:count, :count] = self.mass * np.outer(self.scale, self.scale)
        system[count:, :count] = scaled[self.rows]
        self._factor, self._pivots, _ = dsytrf(system, lower=1)

    def __call__(self, guess: Array, offset: Array) -> tuple[Array, Array]:
        """Project a guess (n,) onto J x + offset = 0.

        Returns:
            The nearest x (n,) in the norm of M, and the multipliers (m,) of the rows with
            M (x - guess) + Jᵀ multipliers = 0.
        """
        x = np.where(self.free, guess, 0.0)
        missed = self.jacobian @ x[self.free] + offset[self.rows]
        right = np.concatenate([np.zeros(len(self.scale)), -missed])
        solution = dsytrs(self._factor, self._pivots, right, lower=1)[0]
        x[self.free] += self.scale * solution[: len(self.scale)]
        multipliers = np.zeros(len(offset))
        multipliers[self.rows] = solution[len(self.scale) :]
        return x, multipliers
