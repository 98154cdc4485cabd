"""Newton's method on the active set: a handful of exact steps where IPOPT takes a dozen.

Each step solves the KKT system of the program linearised about (x, lambda), with the joints that
press against a limit held there, which are read off x and what presses them together (a
primal-dual active set, that is a semismooth Newton method):

    [ H  Jᵀ  ] [  dx    ]     [   grad f    ]   [ 0 ]
    [ J  -δ  ] [ lambda ]  = -[ psi - alpha ] - δ [ lambda before ]

Tasks may repeat each other: what one holds another may hold too. Then J has rows that the others
imply and no lambda is the only one. The small δ, which the step from one lambda to the next alone
pays for (the proximal method of multipliers, Rockafellar 1976), keeps the system regular and picks
a lambda near the last; where the steps end it has no part in the answer. Tasks that contradict each
other drive lambda on and on while x rests where they are missed, so the misses count too.

One-sided rows join as the small quadratic program that the step leaves for their forces, which
may only push. Those that carried load in the step before also stiffen H, along themselves alone:
weight is held by its contacts, and without them H falls over.

Where the joints would turn far, only a part of psi - alpha is asked for in one step. Where the
factor's inertia is not that of a minimum (as many negative pivots as equations, the second-order
condition) and contacts may yet stop the fall, the step is taken with the springs' Hessian alone,
the identity. There is no line search: where there are no contacts, or the steps do not end, the
method gives up and IPOPT has the word.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dsytrf, dsytrs
from scipy.optimize import nnls

from posture_ik.arrays import BLOCK, Array
from posture_ik.posture.optimum import Optimum
from posture_ik.posture.statement import Statement

#: A step in x (√J) below this is the last: the next would be its square.
_LAST_STEP = 1e-8
_MOST_STEPS = 25
#: The farthest that a step may carry a joint towards the tasks, rad and m.
_FARTHEST = 0.4
#: ... where the tasks are missed by no more than this, m or rad.
_LAST_MISS = 1e-8
#: What a multiplier pays for each step it takes, δ: small beside J H⁻¹ Jᵀ, large beside rounding.
_HOLD = 1e-10
#: What a contact that carries load adds to H, N/m.
_CONTACT = 1e5


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
    contact = program.one_sided

    for iteration in range(1, _MOST_STEPS + 1):
        evaluate()
        high, low = x + pressure > upper, x + pressure < lower
        fixed = np.flatnonzero(high | low)
        toward = np.where(high, upper - x, np.where(low, lower - x, 0.0))
        shut = contact & (multipliers < 0)
        tangent, pull = hessian, slope
        if shut.any():
            tangent = hessian + _CONTACT * jacobian[shut].T @ jacobian[shut]
            pull = slope + _CONTACT * jacobian[shut].T @ residual[shut]
        held = jacobian[~contact]
        factor, pivots, sound = _factored(tangent, held, fixed)
        if not sound and not contact.any():
            break  # the posture buckles
        if not sound:
            tangent, pull = np.eye(n), slope
            factor, pivots, _ = _factored(tangent, held, fixed)

        # What relaxes the springs, what meets the tasks, and what a unit push of each contact does.
        sides = np.zeros((n + len(held), 2 + np.count_nonzero(contact)), order="F")
        sides[:n, 0] = -pull - tangent @ toward
        sides[n:, 0] = -_HOLD * multipliers[~contact]
        sides[n:, 1] = -residual[~contact] - held @ toward
        sides[:n, 2:] = jacobian[contact].T
        sides[fixed] = 0.0
        solution = dsytrs(factor, pivots, sides, lower=1)[0]
        # Far targets are approached in parts: each part is a posture of least energy of its own.
        turn = np.max(np.abs(solution[:n, 1] / statement.scale))
        free = solution[:, :2] @ [1.0, min(1.0, _FARTHEST / turn) if turn else 1.0]
        free[:n] += toward
        pushes = solution[:, 2:]
        try:
            gap = residual[contact] + jacobian[contact] @ free[:n]
            push = _pushes(jacobian[contact] @ pushes[:n], gap, -multipliers[contact])
        except (ValueError, RuntimeError):
            break  # the steps have run away
        free += pushes @ push
        step = free[:n]
        x += step
        settled = np.array_equal(push > 0, shut[contact])
        multipliers[~contact], multipliers[contact] = free[n:], -push
        pressure = -(pull + tangent @ step + jacobian.T @ multipliers)
        pressure[~(high | low)] = 0.0
        # A limit that pulls is none: one more step lets the joint go.
        settled &= not np.any(pressure * (1.0 * low - high) > 0)
        missed = np.where(contact, np.minimum(residual, 0.0), residual)
        met = np.max(np.abs(missed), initial=0.0) < _LAST_MISS
        if np.max(np.abs(step)) < _LAST_STEP and met and settled:
            x = np.clip(x, lower, upper)
            return Optimum(x, multipliers, pressure, True, sound, "Newton_Converged", iteration)
    return Optimum(x, multipliers, pressure, False, False, "Newton_Did_Not_Converge", iteration)


def _factored(
    tangent: Array, held: Array, fixed: npt.NDArray[np.intp]
) -> tuple[Array, npt.NDArray[np.int32], bool]:
    """Bunch-Kaufman factor of the KKT matrix, its pivots, and whether its inertia is a minimum's.

    Each 2x2 block (its pivot below 0, twice) has one negative eigenvalue.
    """
    count = len(tangent)
    size = count + len(held)
    system = np.zeros((size, size), order="F")
    system[:count, :count], system[count:, :count] = tangent, held
    np.fill_diagonal(system[count:, count:], -_HOLD)
    # What is fixed keeps its place, with a one on the diagonal and nothing beside it.
    system[fixed], system[:, fixed], system[fixed, fixed] = 0.0, 0.0, 1.0
    factor, pivots, singular = dsytrf(system, lower=1, overwrite_a=1, lwork=BLOCK * size)
    single = pivots > 0
    negative = np.count_nonzero(np.diag(factor)[single] < 0) + np.count_nonzero(~single) // 2
    return factor, pivots, not singular and negative == len(held)


def _pushes(give: Array, gap: Array, before: Array) -> Array:
    """Least forces f >= 0 of the contacts that leave no overlap: gap + give f >= 0, f·that = 0.

    Raises:
        ValueError, RuntimeError: `give`, what a unit push of each contact does at all of them, is
            not positive definite, or something is not finite.
    """
    if not len(gap):
        return np.zeros(0)
    root = np.linalg.cholesky((give + give.T) / 2 + _HOLD * np.eye(len(gap)))
    force: Array = nnls(root.T, np.linalg.solve(root, _HOLD * before - gap))[0]
    return force
