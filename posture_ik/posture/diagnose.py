"""Where a solve fails: the nearest attempt at the tasks, what it misses and what is in its way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from posture_ik.arrays import Array, call
from posture_ik.errors import InfeasiblePosture, Miss
from posture_ik.posture.program import Program
from posture_ik.posture.statement import Statement

#: A task that the nearest attempt misses by less than this (m or rad) is within reach.
_REACHED = 1e-6
#: The springs' share in the attempt, 1/J: enough to choose among equals, too little to matter.
_SPRINGS = 1e-12
#: Limits within this share of their range count as met.
_AT_LIMIT = 1e-3
#: ... and are in the way where they are pressed by this share of the hardest pressed.
_HARD = 0.05


@dataclass(frozen=True)
class Attempt:
    """The nearest attempt at the tasks of a statement within the joint limits.

    Attributes:
        q: configuration (n,).
        missed: miss of every row, (m,), m or rad.
        overturn: 1 - cos(phi) of every orientation held in full.
        push: how hard the misses press each joint, (n,), in the springs' norm; only signs and
            order mean anything.
    """

    statement: Statement
    q: Array
    missed: Array
    overturn: Array
    push: Array

    @property
    def reaches(self) -> bool:
        """Whether every task is met."""
        return bool(np.max(np.abs(self.missed)) < _REACHED and np.all(self.overturn < 1.0))

    def error(self) -> InfeasiblePosture:
        """Name the tasks that are missed, by how much, and the limits that hold them back."""
        body = self.statement.body
        margin = _AT_LIMIT * (body.upper - body.lower)
        hard = np.abs(self.push) > _HARD * np.max(np.abs(self.push))
        low = hard & (self.q < body.lower + margin) & (self.push < 0)
        high = hard & (self.q > body.upper - margin) & (self.push > 0)
        limits = [
            f"{body.dofs[i]} at its {'upper' if high[i] else 'lower'} limit"
            for i in np.argsort(-np.abs(self.push))
            if low[i] or high[i]
        ]
        misses = sorted(self._misses(), key=lambda miss: -miss.size)
        return InfeasiblePosture(misses, limits)

    def _misses(self) -> Iterator[Miss]:
        """The worst row of every task that is missed."""
        start = 0
        for constraint in self.statement.constraints:
            sizes = np.abs(self.missed[start : start + len(constraint.rows)])
            start += len(sizes)
            row = constraint.rows[int(np.argmax(sizes))]
            size = float(np.max(sizes))
            if size < _REACHED:
                continue
            if row.startswith("r"):
                angle = float(np.arcsin(min(1.0, size)))
                far = np.any(self.overturn > 1.0)
                yield Miss(
                    constraint.label, row, np.degrees(np.pi - angle if far else angle), "deg"
                )
            else:
                yield Miss(constraint.label, row, size, "m")


def nearest_attempt(statement: Statement) -> Attempt:
    """Come as near to all tasks as the joint limits allow: least squares with a trace of springs.

    Every row may be missed by a slack s, whose square is what is minimised, so that the program
    always has a solution. 1 - cos(phi) joins the sin(phi) n of the rows: together they grow with
    the angle all the way to the half turn.
    """
    program, body = statement.program, statement.body
    lower, upper = statement.x_of(body.lower), statement.x_of(body.upper)
    free = np.full(statement.rows, np.inf)
    start = np.clip(np.zeros(len(lower)), lower, upper)
    found = _elastic(program)(
        x0=np.concatenate([start, np.zeros(statement.rows)]),
        p=statement.parameters,
        lbx=np.concatenate([lower, -free]),
        ubx=np.concatenate([upper, np.where(program.one_sided, 0.0, free)]),
        lbg=0.0,
        ubg=np.where(program.one_sided, np.inf, 0.0),
    )
    x, missed = np.split(found["x"].full().ravel(), [len(lower)])
    q = np.clip(statement.q_ergo + x / statement.scale, body.lower, body.upper)
    (overturn,) = call(program.overturn, q, statement.parameters)
    return Attempt(statement, q, missed, overturn, found["lam_x"].full().ravel()[: len(lower)])


@cache
def _elastic(program: Program) -> ca.Function:
    """The least-squares program, IPOPT on CasADi's own derivatives: failure may take its time."""
    x, slack = program.nlp["x"], ca.SX.sym("s", program.nlp["g"].numel())
    return ca.nlpsol(
        "attempt",
        "ipopt",
        {
            "x": ca.vertcat(x, slack),
            "p": program.nlp["p"],
            "f": (ca.sumsqr(slack) + ca.sumsqr(program.overturn_of_x) + _SPRINGS * ca.sumsqr(x))
            / 2,
            "g": program.nlp["g"] - slack,
        },
        {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10}},
    )
