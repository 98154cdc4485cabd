"""The backrest: the mean motion of vertebrae behind one of them, and what holds it there.

The mean is Nastran's RBE3, `network.average`: rotations weigh by the mean distance of the vertebrae
from that point. The posture's backrest task (`posture_ik.posture.tasks.Averaged`) has no such
point, and weighs them by the distance from the vertebrae's own mean; where a body is rigid both
give the same. A law is taken as the foam that it is for small motions about its preload.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError
from posture_ik.posture import Posture
from posture_ik.problem import COMPONENTS, FoamBack, LawBack, RigidBack
from posture_ik.vibration.network import Link, Mean, average, carry
from posture_ik.vibration.seat import law_stiffness

#: How far behind its vertebra the mean motion is taken, m (§5.2).
BEHIND = 0.1
#: Places of the components across and along the back.
_ACROSS, _ALONG = COMPONENTS.index("x"), COMPONENTS.index("z")


def backrest_axes(recline: float) -> Array:
    """Axes of a backrest reclined by an angle, rad: square to it, left, and along it; (3, 3)."""
    c, s = np.cos(recline), np.sin(recline)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def rest_on(back: RigidBack | FoamBack, recline: float, vertebra: Array) -> tuple[Mean, Link]:
    """The mean motion that meets a backrest, and what holds it there.

    Args:
        back: which vertebrae, and what they meet.
        recline: of the backrest, rad.
        vertebra: where the one is that it stands behind, (3,), m.
    """
    axes = backrest_axes(recline)
    point = vertebra - BEHIND * axes[:, 0]
    stiffness, damping = np.zeros(6), np.zeros(6)
    stiffness[_ALONG], damping[_ALONG] = back.tangential_stiffness, back.tangential_damping
    if isinstance(back, FoamBack):
        stiffness[_ACROSS], damping[_ACROSS] = back.stiffness, back.damping
    # A rigid one leaves the slide along the back alone.
    rigid = tuple(i for i in range(6) if i != _ALONG) if isinstance(back, RigidBack) else ()
    mean = Mean("back", point, axes, back.bodies)
    return mean, Link("backrest", "seat", "back", point, axes, stiffness, damping, rigid)


def lean(
    mean: Mean, points: Mapping[str, Array], motions: Mapping[str, Array], seat: Array, own: Array
) -> tuple[Array, Array]:
    """The mean motion of a back over the backrest's, along its axes.

    Args:
        mean: of which vertebrae, and where.
        points: of the vertebrae, (3,) each, m.
        motions: of the vertebrae, (6, n) each, in the world's axes.
        seat: motion of the seat at its origin, (6, n), which carries the backrest.
        own: the backrest's motion beside it, along its axes, (6, n).

    Returns:
        The motion (6, n), and what takes the seat's motion to the backrest's, (6, 6).
    """
    turned = scipy.linalg.block_diag(mean.axes.T, mean.axes.T)
    carried = turned @ carry(mean.point)
    back = average([motions[b] for b in mean.of], [points[b] for b in mean.of], mean.point)
    return turned @ back - carried @ seat - own, carried


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
        at=back.at,
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
