"""What every solver of a posture returns."""

from __future__ import annotations

from dataclasses import dataclass

from posture_ik.arrays import Array


@dataclass(frozen=True)
class Optimum:
    """Where a solver stopped, in the program's x.

    Attributes:
        x: (n,), within the bounds.
        multipliers, bound_multipliers: of the rows (m,) and of the bounds (n,), with the sign
            grad f + Jᵀ multipliers + bound_multipliers = 0.
        converged: whether the solver's own tolerances are met.
        minimum: whether its last factor had the inertia of a minimum; otherwise the point has
            still to be told from a saddle.
    """

    x: Array
    multipliers: Array
    bound_multipliers: Array
    converged: bool
    minimum: bool
    status: str
    iterations: int
