"""The backrest: the mean motion of vertebrae at a point behind one, and what holds it there.

Nastran's RBE3 for small motions: with s_i the positions from their mean c, L the mean of |s_i| and
the motions u_i, theta_i of the vertebrae, the mean rotation and the motion of the point r are

    W theta = sum_i [ s_i x u_i + L² theta_i ],    W = sum_i [ (|s_i|² + L²) 1 - s_i s_iᵀ ],
    u = mean u_i + theta x (r - c),

the linearisation of the backrest task's average (`posture_ik.posture.tasks.Averaged`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array

#: How far behind its vertebra the mean motion is taken, m (§5.2).
BEHIND = 0.1


def mean_motion(positions: Sequence[Array], point: Array) -> Array:
    """Mean motion at a point, from the motions of N bodies.

    Args:
        positions: of the bodies, (3,) each, m.
        point: where the mean is taken, (3,), m.

    Returns:
        (6, 6 N): from each body's translation and rotation in turn to the mean's.
    """
    count, centre = len(positions), np.mean(positions, axis=0)
    arms = [position - centre for position in positions]
    square = np.mean([np.linalg.norm(arm) for arm in arms]) ** 2
    weight = sum((arm @ arm + square) * np.eye(3) - np.outer(arm, arm) for arm in arms)
    rotation = np.hstack([np.hstack([pin.skew(arm), square * np.eye(3)]) for arm in arms])
    rotation = np.linalg.solve(weight, rotation)
    translation = np.tile(np.hstack([np.eye(3), np.zeros((3, 3))]) / count, count)
    return np.vstack([translation - pin.skew(point - centre) @ rotation, rotation])


def rigid_motion(arm: Array) -> Array:
    """Motion (6, 6) of a point at `arm` (3,), m, on a body that moves: u + theta x arm, theta."""
    motion = np.eye(6)
    motion[:3, 3:] = -pin.skew(arm)
    return motion


def turned(axes: Array) -> Array:
    """A motion (6, 6) seen along the columns of `axes` (3, 3)."""
    seen = np.zeros((6, 6))
    seen[:3, :3] = seen[3:, 3:] = axes.T
    return seen
