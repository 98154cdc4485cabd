"""The backrest: the mean motion of vertebrae at a point behind T7, and what holds it there.

The mean is Nastran's RBE3, `network.average`: rotations weigh by the mean distance of the vertebrae
from that point. The posture's backrest task (`posture_ik.posture.tasks.Averaged`) has no such
point, and weighs them by the distance from the vertebrae's own mean; where a body is rigid both
give the same. A law is taken as the foam that it is for small motions about its preload.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError
from posture_ik.posture import Posture
from posture_ik.problem import COMPONENTS, FoamBack, LawBack, RigidBack
from posture_ik.vibration.network import Spring, average, carry
from posture_ik.vibration.seat import law_stiffness

#: How far behind T7 the mean motion is taken, m (§5.2).
BEHIND = 0.1
#: Places of the components across and along the back.
_ACROSS, _ALONG = COMPONENTS.index("x"), COMPONENTS.index("z")


class Leaning(NamedTuple):
    """A back against a backrest, over the n coordinates and given motions of a model.

    Attributes:
        held: motions (5, n) of which a rigid backrest leaves nothing; (0, n) of foam.
        holds: which of the backrest's six they are, one in each row; (5, 6) or (0, 6).
        pad: springs and dampers against it, of the components `at`.
        carried: from the motion of the seat at its origin to the backrest's, (6, 6).
    """

    held: Array
    holds: Array
    pad: Spring
    at: list[int]
    carried: Array


def backrest_axes(recline: float) -> Array:
    """Axes of a backrest reclined by an angle, rad: square to it, left, and along it; (3, 3)."""
    c, s = np.cos(recline), np.sin(recline)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def lean(
    back: RigidBack | FoamBack,
    recline: float,
    points: Mapping[str, Array],
    motions: Mapping[str, Array],
    seat: Array,
    own: Array,
) -> Leaning:
    """Set the mean motion of a back's vertebrae against the backrest's, along its axes.

    Args:
        back: which vertebrae, and what they meet.
        recline: of the backrest, rad.
        points: of the vertebrae and T7, (3,) each, m.
        motions: of the vertebrae, (6, n) each, in the world's axes.
        seat: motion of the seat at its origin, (6, n), which carries the backrest.
        own: the backrest's motion beside it, along its axes, (6, n).
    """
    axes = backrest_axes(recline)
    at = points["T7"] - BEHIND * axes[:, 0]
    mean = average([motions[b] for b in back.bodies], [points[b] for b in back.bodies], at)
    turned = scipy.linalg.block_diag(axes.T, axes.T)
    carried = turned @ carry(at)
    motion = turned @ mean - carried @ seat - own
    places = [_ALONG]
    stiffness, damping = [back.tangential_stiffness], [back.tangential_damping]
    if isinstance(back, FoamBack):
        places.append(_ACROSS)
        stiffness.append(back.stiffness)
        damping.append(back.damping)
    pad = Spring(motion[places], np.array(stiffness), np.array(damping))
    holds = np.delete(np.eye(6), _ALONG, axis=0)
    holds = holds if isinstance(back, RigidBack) else holds[:0]
    return Leaning(holds @ motion, holds, pad, places, carried)


def at_preload(
    back: RigidBack | FoamBack | LawBack, posture: Posture | None = None
) -> RigidBack | FoamBack:
    """A backrest for small motions: of a law, the foam that it is about its preload.

    Args:
        back: the backrest.
        posture: whose force on the backrest is the preload where none is given.

    Raises:
        PostureIKError: the law does not bear the preload, or there is none to take.
    """
    if not isinstance(back, LawBack):
        return back
    preload = back.preload
    if preload is None:
        preload = _pressed(posture)
    return FoamBack(
        bodies=back.bodies,
        stiffness=law_stiffness(preload, back.bilateral, back.length),
        damping=back.damping,
        tangential_stiffness=back.tangential_stiffness,
        tangential_damping=back.tangential_damping,
    )


def _pressed(posture: Posture | None) -> float:
    """Force with which a posture's back presses square on its backrest, N."""
    wrenches = posture.wrenches if posture else ()
    forces = [w.force for w in wrenches if w.label in ("backrest", "backrest contact")]
    if posture is None or not forces:
        raise PostureIKError(
            "seat.backrest: no preload is given, and no task leans the posture on a backrest to "
            "take it from; write preload = and a force in N."
        )
    axes = backrest_axes(float(np.radians(posture.problem.seat.recline_deg)))
    return float(axes[:, 0] @ np.sum(forces, axis=0))
