"""The skin of the trunk and neck: rings about the spine that follow the vertebrae."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.interpolate import PchipInterpolator

from posture_ik.arrays import Array
from posture_ik.body.solids import Mesh, loft
from posture_ik.problem import SPINE

#: Height above the seat, back, front and half width of the skin at 1.80 m and 80 kg, m; by eye.
_RINGS = np.array(
    [
        (-0.002, -0.085, 0.110, 0.145),
        (0.030, -0.116, 0.138, 0.178),
        (0.090, -0.120, 0.138, 0.180),
        (0.160, -0.104, 0.140, 0.160),
        (0.220, -0.088, 0.140, 0.148),
        (0.300, -0.094, 0.148, 0.152),
        (0.360, -0.102, 0.158, 0.158),
        (0.420, -0.108, 0.162, 0.163),
        (0.480, -0.106, 0.155, 0.168),
        (0.530, -0.100, 0.138, 0.172),
        (0.570, -0.092, 0.112, 0.172),
        (0.600, -0.082, 0.088, 0.163),
        (0.622, -0.070, 0.074, 0.138),
        (0.638, -0.060, 0.067, 0.104),
        (0.654, -0.051, 0.066, 0.076),
        (0.674, -0.044, 0.067, 0.061),
        (0.694, -0.044, 0.064, 0.056),
        (0.735, -0.052, 0.040, 0.046),
    ]
)
_COUNT, _SIDES = 44, 44
#: How square the rings are: 2 is an ellipse.
_SQUARENESS = 2.35
#: Heights of the chest over which the back leans on a backrest, m.
_BACK = (0.25, 0.58)


class Ride(NamedTuple):
    """How the skin rides on the spine.

    Attributes:
        rest: the skin in the reference shape.
        lower: for every vertex the level below it, (n,): 0 is the seat, then `SPINE`.
        share: how far towards the next level, (n,), 0 to 1.
    """

    rest: Mesh
    lower: npt.NDArray[np.int64]
    share: Array


def ride(reference: Mapping[str, pin.SE3], girth: float) -> Ride:
    """Tie each ring of the skin to the two vertebrae it lies between.

    Args:
        reference: pose of every link in the reference shape, by name.
        girth: how much wider than the reference subject.
    """
    rest, height = _rest(reference, girth)
    levels = [0.0, *(reference[name].translation[2] for name in SPINE)]
    place = np.interp(height, levels, np.arange(len(levels)))
    lower = np.minimum(place.astype(int), len(levels) - 2)
    return Ride(rest, lower, place - lower)


def skin(reference: Mapping[str, pin.SE3], now: Mapping[str, pin.SE3], girth: float) -> Mesh:
    """The skin in a posture: each ring rides on the two vertebrae it lies between.

    Args:
        reference: pose of every link in the reference shape, by name.
        now: the same in the posture.
        girth: how much wider than the reference subject.
    """
    rest, lower, share = ride(reference, girth)
    levels = [pin.SE3.Identity(), *(reference[name] for name in SPINE)]
    moved = [pin.SE3.Identity(), *(now[name] for name in SPINE)]
    weight = share[:, None]
    carried = np.array([(b * a.inverse()).homogeneous for a, b in zip(levels, moved, strict=True)])
    points = np.column_stack([rest.vertices, np.ones(len(rest.vertices))])
    below = np.einsum("nij,nj->ni", carried[lower], points)
    above = np.einsum("nij,nj->ni", carried[lower + 1], points)
    return Mesh(((1 - weight) * below + weight * above)[:, :3], rest.faces)


def back_of(shape: Mesh, reference: Mapping[str, pin.SE3], girth: float) -> Array:
    """The points (k, 3) of a skin that can lean on a backrest: those of the chest's height."""
    height = _rest(reference, girth)[1] / _tall(reference)
    return shape.vertices[(height > _BACK[0]) & (height < _BACK[1])]


def _tall(reference: Mapping[str, pin.SE3]) -> float:
    """How much taller than the reference subject, by the head's height of table 8."""
    return float(reference["Head"].translation[2]) / 0.75375


def _rest(reference: Mapping[str, pin.SE3], girth: float) -> tuple[Mesh, Array]:
    """The skin in the reference shape, and the height (n,) of every vertex, m."""
    at = np.linspace(0.0, 1.0, _COUNT)
    spaced = np.linspace(0.0, 1.0, len(_RINGS))
    z, back, front, half = PchipInterpolator(spaced, _RINGS)(at).T
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    cos, sin = np.cos(angle), np.sin(angle)
    x = np.sign(cos) * np.abs(cos) ** (2 / _SQUARENESS)
    y = np.sign(sin) * np.abs(sin) ** (2 / _SQUARENESS)
    middle, depth = (front + back) / 2, (front - back) / 2
    rings = np.stack(
        [
            girth * (middle[:, None] + depth[:, None] * x),
            girth * half[:, None] * y,
            np.broadcast_to(_tall(reference) * z[:, None], (_COUNT, _SIDES)),
        ],
        axis=-1,
    )
    shape = loft(rings)
    return shape, shape.vertices[:, 2]
