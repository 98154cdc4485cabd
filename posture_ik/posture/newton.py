"""Newton's method on the active set: a handful of exact steps where IPOPT takes a dozen.

Each step solves the KKT system of the program linearised about (x, lambda), with the joints that
press against a limit held there and the contacts that carry load held shut; which do is read off
x and the multipliers together (a primal-dual active set, that is a semismooth Newton method):

    [ H  Jᵀ ] [  dx    ]     [   grad f    ]
    [ J  0  ] [ lambda ]  = -[ psi - alpha ]

Where the joints would turn far, only a part of psi - alpha is asked for in one step. There is no
line search: where the factor's inertia is not that of a minimum (as many negative pivots as rows,
the second-order condition) or the steps do not end, the method gives up and IPOPT has the word.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dsytrf, dsytrs

from posture_ik.arrays import BLOCK, Array
from posture_ik.posture.optimum import Optimum
from posture_ik.posture.statement import Statement

#: A step in x (√J) below this is the last: the next would be its square.
_LAST_STEP = 1e-8
_MOST_STEPS = 25
#: The farthest that a step may carry a joint towards the tasks, rad and m.
_FARTHEST = 0.4
#: Newtons that a metre of overlap counts for when contacts are told open from shut.
_CONTACT = 1e6


def solve_with_newton(
    statement: Statement,
    start: Array,
    lower: Array,
    upper: Array,
    multipliers: Array | None = None,
    pressure: Array | None = None,
) -> Optimum:
    """Minimise a statement's program from a start within bounds, all in x (n,).

    The multipliers of the rows (m,) and the pressure of the bounds (n,) start from zero unless
    they are known from nearby.

    Returns:
        The optimum; where `converged` is False the point is worth nothing.
    """
    program = statement.program
    n, m = program.size, statement.rows
    x, multipliers = start.copy(), np.zeros(m) if multipliers is None else multipliers.copy()
    pressure = np.zeros(n) if pressure is None else pressure
    residual, slope = np.zeros(m), np.zeros(n)
    jacobian, hessian = np.zeros((m, n), order="F"), np.zeros((n, n), order="F")
    buffer: Any
    buffer, evaluate = program.kkt.buffer()  # keeps clear of a conversion at each call
    for i, argument in enumerate((x, statement.parameters, multipliers)):
        buffer.set_arg(i, argument.data)
    for i, result in enumerate((residual, jacobian, slope, hessian)):
        buffer.set_res(i, result.reshape(-1, order="F").data)
    system, sides = np.zeros((n + m, n + m), order="F"), np.zeros((n + m, 2), order="F")

    for iteration in range(1, _MOST_STEPS + 1):
        evaluate()
        high, low = x + pressure > upper, x + pressure < lower
        shut = ~program.one_sided | (multipliers + _CONTACT * residual < 0)
        known = np.flatnonzero(np.concatenate([high | low, ~shut]))
        step = np.where(high, upper - x, np.where(low, lower - x, 0.0))
        sides[:n, 0], sides[n:, 0] = -slope - hessian @ step, 0.0
        sides[:n, 1], sides[n:, 1] = 0.0, -residual - jacobian @ step
        sides[known] = 0.0
        system[:n, :n], system[n:, :n], system[n:, n:] = hessian, jacobian, 0.0
        # What is known keeps its place, with a one on the diagonal and nothing beside it.
        system[known], system[:, known], system[known, known] = 0.0, 0.0, 1.0
        factor, pivots, singular = dsytrf(system, lower=1, overwrite_a=1, lwork=BLOCK * (n + m))
        if singular or _negative(factor, pivots) != np.count_nonzero(shut):
            break  # the tangent has a saddle, not a minimum
        solution = dsytrs(factor, pivots, sides, lower=1)[0]
        # Far targets are approached in parts: each part is a posture of least energy of its own.
        turn = np.max(np.abs(solution[:n, 1] / statement.scale))
        solution = solution @ [1.0, min(1.0, _FARTHEST / turn) if turn else 1.0]
        step += solution[:n]
        x += step
        multipliers[:] = solution[n:]
        pressure = -(slope + hessian @ step + jacobian.T @ multipliers)
        pressure[~(high | low)] = 0.0
        # A limit that pulls is none: one more step lets the joint go.
        if np.max(np.abs(step)) < _LAST_STEP and not np.any(pressure * (1.0 * low - high) > 0):
            x = np.clip(x, lower, upper)
            return Optimum(x, multipliers, pressure, True, True, "Newton_Converged", iteration)
    return Optimum(x, multipliers, pressure, False, False, "Newton_Did_Not_Converge", iteration)


def _negative(factor: Array, pivots: npt.NDArray[np.int32]) -> int:
    """Negative eigenvalues of a Bunch-Kaufman factor: each 2x2 block (pivot < 0, twice) has one."""
    single = pivots > 0
    return int(np.sum(np.diag(factor)[single] < 0) + np.count_nonzero(~single) // 2)
