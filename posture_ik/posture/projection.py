"""Velocities and accelerations that respect the tasks: mass-weighted projections (eqs 21-29).

In minimal coordinates the joints' own constraints phi are built in, and what remains is

    minimise ½ (v - v0)ᵀ M (v - v0)  subject to  J v + psi_t = 0                 (eqs 22, 24)
    minimise ½ (a - a0)ᵀ M (a - a0)  subject to  J a + (J v + psi_t)' = 0        (eqs 27, 29)

with M and J the same in both, so one factor of the KKT matrix serves both. It is scaled by
diag(M)^-½ first: the mass seen by a wrist and by the pelvis differ by five orders.
"""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dgeqp3, dsytrf, dsytrs

from posture_ik.arrays import BLOCK, Array
from posture_ik.posture.program import Program


@cache
def task_rates(program: Program) -> tuple[ca.Function, ca.Function]:
    """Differentiate a program's tasks in time, exactly, along targets alpha that move.

    Their rates are J v + psi_t = 0 and, once more, J a + drift = 0; the drift holds all of the
    second derivative that is not J a.

    Returns:
        (theta, p, alpha') -> J (m, n) and psi_t (m,), and
        (theta, v, p, alpha', alpha'') -> drift (m,); p are the program's numbers, alpha the last.
    """
    theta, v = ca.SX.sym("q", program.size), ca.SX.sym("v", program.size)
    fixed = ca.SX.sym("p", program.residual.size1_in(1) - program.targets)
    alpha, rate, acceleration = (
        ca.SX.sym(name, program.targets) for name in ("alpha", "rate", "acceleration")
    )
    p = ca.vertcat(fixed, alpha)
    residual = program.residual(theta, p)
    moved = ca.jtimes(residual, alpha, rate)
    at, along = ca.vertcat(theta, alpha), ca.vertcat(v, rate)
    drift = ca.jtimes(ca.jtimes(residual, at, along), at, along)
    drift += ca.jtimes(residual, alpha, acceleration)
    return (
        ca.Function("rates", [theta, p, rate], [program.jacobian(theta, p), ca.densify(moved)]),
        ca.Function("drift", [theta, v, p, rate, acceleration], [ca.densify(drift)]),
    )


def implied(rows: Array) -> npt.NDArray[np.intp]:
    """Which rows of a matrix (m, n) the others imply, by QR with pivoting, in order; (<= m,)."""
    triangle, order = dgeqp3(rows.T)[:2]
    pivots = np.abs(np.diag(triangle))
    rank = int(np.sum(pivots > 1e-9 * pivots.max(initial=0.0)))
    places: npt.NDArray[np.intp] = np.sort(order[rank:] - 1)
    return places


class Projection:
    """The factored KKT matrix of one instant.

    Args:
        mass: mass matrix M (n, n); its upper triangle is read.
        jacobian: J (m, n).
        free: which degrees of freedom may move, bool (n,); the rest, at their limits, stay.

    Attributes:
        dependent: rows of J that others imply, left out; (<= m,).
    """

    def __init__(self, mass: Array, jacobian: Array, free: npt.NDArray[np.bool_]) -> None:
        self.free = free
        self.jacobian = jacobian
        m, n = jacobian.shape
        self.scale = np.where(free, 1.0 / np.sqrt(np.diag(mass)), 0.0)
        columns = (jacobian * self.scale).T
        self.dependent = implied(columns.T)
        system = np.zeros((n + m, n + m), order="F")
        np.multiply(mass, self.scale, out=system[:n, :n])
        system[:n, :n] *= self.scale[:, None]
        system[:n, n:] = columns
        # What is held or left out keeps its place: a one on the diagonal and nothing beside it.
        system[:, n + self.dependent] = 0.0
        ones = np.concatenate([np.arange(n), n + self.dependent])
        system[ones, ones] = 1.0
        self._factor, self._pivots, _ = dsytrf(system, overwrite_a=1, lwork=BLOCK * (n + m))

    def __call__(self, guess: Array, offset: Array) -> tuple[Array, Array]:
        """Project a guess (n,) onto J x + offset = 0.

        Returns:
            The nearest x (n,) in the norm of M, and the multipliers (m,) of the rows with
            M (x - guess) + Jᵀ multipliers = 0.
        """
        x = np.where(self.free, guess, 0.0)
        missed = self.jacobian @ x + offset
        missed[self.dependent] = 0.0
        right = np.concatenate([np.zeros(len(x)), -missed])
        solution = dsytrs(self._factor, self._pivots, right)[0]
        return x + self.scale * solution[: len(x)], solution[len(x) :]
