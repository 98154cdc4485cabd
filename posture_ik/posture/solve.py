"""Solve a posture: problem and body in, certified `Posture` out."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.errors import PostureNotFound
from posture_ik.posture.diagnose import nearest_attempt
from posture_ik.posture.ipopt import solve_with_ipopt
from posture_ik.posture.newton import solve_with_newton
from posture_ik.posture.result import Posture
from posture_ik.posture.statement import Statement
from posture_ik.problem import Problem

#: How often to start: afresh from a point that meets the tasks, or downhill from a saddle.
_TRIES = 3


def solve_posture(body: Body, problem: Problem, start: Array | None = None) -> Posture:
    """Find the posture of least energy that meets the tasks of a problem (eqs 16-20).

    Args:
        body: who.
        problem: the tasks, the seat, and how to solve.
        start: configuration to start from, (n,), rad and m; the ergonomic shape if not given.

    Raises:
        InfeasiblePosture: no posture within the joint ranges meets the tasks; names the task, its
            miss and the limits in the way.
        PostureNotFound: the solver stopped early, or at a point that is not a minimum.
        BadProblem: the problem names a link or joint that the body does not have.
    """
    statement = Statement.of(body, problem)
    return solve_statement(statement, statement.q_ergo if start is None else np.asarray(start))


def solve_statement(
    statement: Statement,
    start: Array,
    multipliers: Array | None = None,
    limit_multipliers: Array | None = None,
) -> Posture:
    """Solve a problem posed already from a start (n,), with its multipliers where a guess is known.

    Raises:
        InfeasiblePosture, PostureNotFound: as `solve_posture`.
    """
    tick = perf_counter()
    body = statement.body
    lower, upper = statement.x_of(body.lower), statement.x_of(body.upper)
    x, pressure = statement.x_of(start), None
    if limit_multipliers is not None:
        pressure = limit_multipliers / statement.scale
    for _ in range(_TRIES):
        first = np.clip(x, lower, upper)
        found = solve_with_newton(statement, first, lower, upper, multipliers, pressure)
        if not found.converged:
            found = solve_with_ipopt(statement, first, lower, upper)
        posture = Posture(
            statement=statement,
            q=np.clip(statement.q_ergo + found.x / statement.scale, body.lower, body.upper),
            multipliers=found.multipliers,
            limit_multipliers=found.bound_multipliers * statement.scale,
            iterations=found.iterations,
            status=found.status,
            seconds=perf_counter() - tick,
        )
        if not found.converged or posture.overturned():
            attempt = nearest_attempt(statement)
            if not attempt.reaches:
                raise attempt.error()
            x, multipliers, pressure = statement.x_of(attempt.q), None, None
            continue
        downhill = None if found.minimum else posture.downhill()
        if downhill is None:
            break
        x = found.x + downhill  # a saddle: leave it along its descending direction
        multipliers = pressure = None
    else:
        raise PostureNotFound(
            f"the tasks can be reached, but the solver ended with {found.status!r}, or where the "
            "person would buckle; hold the pelvis or the back by a task, or soften what resists"
        )
    return posture
