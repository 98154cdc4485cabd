"""IPOPT on the program's exact derivatives: the judge, and the way where Newton gives up."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from posture_ik.arrays import Array, call
from posture_ik.posture.optimum import Optimum
from posture_ik.posture.program import Program
from posture_ik.posture.projection import implied
from posture_ik.posture.statement import Statement

# Residuals are metres and radians near one, gradients in x are sqrt(J) near one: no scaling needed.
# Limits are hard, hence no relaxation of bounds.
_IPOPT: dict[str, Any] = {
    "expand": False,
    "print_time": False,
    "ipopt": {
        "print_level": 0,
        "sb": "yes",
        "linear_solver": "mumps",
        "tol": 1e-11,
        "constr_viol_tol": 1e-12,
        "acceptable_iter": 0,
        "nlp_scaling_method": "none",
        "bound_relax_factor": 0.0,
        "max_iter": 300,
    },
}
#: How far what is implied may be missed, m or rad.
_MISSED = 1e-9
_solvers: dict[Program, ca.Function] = {}


def solve_with_ipopt(statement: Statement, start: Array, lower: Array, upper: Array) -> Optimum:
    """Minimise from a start within bounds, all in x (n,); any other solver fits this seam.

    Multipliers have CasADi's sign: grad f + Jᵀ multipliers + bound_multipliers = 0. Equations that
    others imply at the start have no bounds and so no part in it: of multipliers that are not the
    only ones IPOPT never finds any. Where they are missed in the end they were not implied.
    """
    program = statement.program
    q = statement.q_ergo + start / statement.scale
    (jacobian,) = call(program.jacobian, q, statement.parameters)
    equations = np.flatnonzero(~program.one_sided)
    idle = np.zeros(statement.rows, dtype=bool)
    idle[equations[implied(jacobian[equations] / statement.scale)]] = True
    if program not in _solvers:
        _solvers[program] = ca.nlpsol("posture", "ipopt", program.nlp, _IPOPT | program.derivatives)
    solver = _solvers[program]
    floor = np.where(idle, -np.inf, 0.0)
    ceiling = np.where(program.one_sided | idle, np.inf, 0.0)
    found = solver(x0=start, p=statement.parameters, lbx=lower, ubx=upper, lbg=floor, ubg=ceiling)
    stats = solver.stats()
    missed = np.abs(found["g"].full().ravel()[idle]).max(initial=0.0)
    return Optimum(
        x=found["x"].full().ravel(),
        multipliers=found["lam_g"].full().ravel(),
        bound_multipliers=found["lam_x"].full().ravel(),
        converged=bool(stats["success"]) and missed < _MISSED,
        minimum=stats["iterations"]["regularization_size"][-1] == 0.0,
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
    )
