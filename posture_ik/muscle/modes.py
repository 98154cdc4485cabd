"""Activations that change no torque: modes, co-contraction, and the stiffest way to hold (§4.3).

Of 25 muscles on 7 joints, 18 directions in activation leave every torque as it is: the null space
of C = d tau/d a, read off its singular value decomposition. Along them an arm stiffens without
moving. Two ways through them are offered: a level that draws all activations up together
(`posture_ik.muscle.activation.recruit`), and the two ends of what they do to any quantity that is
linear in the activations, such as the trace of the joint stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError

#: Singular values below this share of the largest give no torque.
_RANK = 1e-10


@dataclass(frozen=True)
class Modes:
    """The torque-less modes of a posture.

    Attributes:
        capacity: C (n, m), N m per unit of activation.
        values: its singular values, (min(n, m),), N m, largest first.
        basis: modes as orthonormal columns, (m, m - rank).
    """

    capacity: Array
    values: Array
    basis: Array

    @classmethod
    def of(cls, capacity: Array) -> Modes:
        """Decompose a capacity (n, m)."""
        _, values, right = np.linalg.svd(capacity)
        rank = int(np.sum(values > _RANK * values.max(initial=0.0)))
        return cls(capacity, values, right[rank:].T)

    def part(self, direction: Array) -> Array:
        """What of a direction (m,) in activation changes no torque, (m,)."""
        part: Array = self.basis @ (self.basis.T @ direction)
        return part

    def range(self, activation: Array, direction: Array) -> tuple[float, float]:
        """How far one may go along a direction (m,) from activations (m,), back and forth.

        Returns:
            The least and the largest s with 0 <= activation + s direction <= 1; a muscle that is
            at its bound and would leave it makes one of them 0.

        Raises:
            PostureIKError: the direction is 0, which has no end.
        """
        moving = np.abs(direction) > 0
        if not moving.any():
            raise PostureIKError("modes: the direction is 0; give one that moves a muscle.")
        to_rest = -activation[moving] / direction[moving]
        to_full = (1 - activation[moving]) / direction[moving]
        return (
            float(np.minimum(to_rest, to_full).max()) + 0.0,
            float(np.maximum(to_rest, to_full).min()) + 0.0,
        )


def extremes(capacity: Array, activation: Array, slope: Array) -> tuple[Array, Array]:
    """Activations of the same torques with the least and the most of a linear quantity.

    minimise, maximise  slope·a  subject to  C a = C a0,  0 <= a <= 1: with the slope of the
    stiffness' trace (`posture_ik.muscle.reflex.trace_slope`), the softest and the stiffest way to
    hold the same posture against the same load.

    Args:
        capacity: C (n, m), N m.
        activation: a0 (m,), within 0 and 1, such as `recruit` finds.
        slope: (m,), of the quantity over the activations.

    Returns:
        The activations of the least and of the most, (m,) each.

    Raises:
        PostureIKError: no activations do, such as a0 out of its bounds.
    """
    torque = capacity @ activation
    ends = []
    for sign in (1.0, -1.0):
        # HiGHS, not DAQP: at the end of strength the activations themselves are all that is left.
        found = linprog(sign * slope, A_eq=capacity, b_eq=torque, bounds=(0.0, 1.0))
        if found.status != 0:
            raise PostureIKError(f"modes: no optimum found ({found.message})")
        ends.append(found.x)
    return ends[0], ends[1]
