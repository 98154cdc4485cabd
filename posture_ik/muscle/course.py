"""Muscle paths as points in space, for the eye: straight pieces, and arcs sampled.

Every link of a body's arm is the reference arm's, grown, mirrored on the left, turned and moved;
so a path is followed in the reference arm's own frames and carried out from there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.muscle.arm import CHAIN, Element, trunk_frames
from posture_ik.muscle.wrap import Surface, lean, leg, plane, reflect, turned

#: Arcs are drawn by chords of at most this angle, rad.
_CHORD = np.radians(5.0)


class Place(NamedTuple):
    """From a link of the reference arm to the world: x -> shape x + origin."""

    shape: Array
    origin: Array

    def out(self, point: Array) -> Array:
        """A point of the link (3,), or several (k, 3), in the world."""
        return point @ self.shape.T + self.origin

    def back(self, point: Array) -> Array:
        """A point of the world (3,), or several (k, 3), in the link."""
        return np.asarray((point - self.origin) @ np.linalg.inv(self.shape).T)


def places(poses: Mapping[str, pin.SE3], side: str, scale: float) -> dict[str, Place]:
    """Where the links of the reference arm, `CHAIN`, lie as those of a side of a body.

    Args:
        poses: Of the body's links in the world, by name.
        side: `r` or `l`.
        scale: Size of the body's arm over the reference arm's.
    """
    size = scale * np.diag([1.0, 1.0, 1.0 if side == "r" else -1.0])
    found = {}
    for link in ("thorax", *list(CHAIN)[1:]):
        pose = poses[f"{link}_{side}"]
        found[link] = Place(pose.rotation @ size, pose.translation)
    thorax, in_trunk = found.pop("thorax"), trunk_frames()["thorax"].inverse()
    shape = thorax.shape @ in_trunk.rotation
    return {"trunk": Place(shape, thorax.out(in_trunk.translation)), **found}


def course(path: Sequence[Element], where: Mapping[str, Place]) -> list[tuple[str, Array]]:
    """A path in the world, element by element: the link that carries it, its points (k, 3), m."""
    ends = [
        where[element.link].out(element.place) if element.surface is None else np.zeros(3)
        for element in path
    ]
    found = []
    for i, element in enumerate(path):
        if element.surface is None:
            found.append((element.link, ends[i][None]))
        else:
            place = where[element.link]
            touching = _touching(place.back(ends[i - 1]), place.back(ends[i + 1]), element.surface)
            found.append((element.link, place.out(touching)))
    return found


def _touching(start: Array, end: Array, surface: Surface) -> Array:
    """Points (k, 3) between two points (3,) where a path lies on a surface, none if it does not."""
    across = plane(surface.axis) if surface.axis is not None else np.eye(3)
    p, s = across @ (start - surface.centre), across @ (end - surface.centre)
    angle = float(turned(ca.DM(p), ca.DM(s), surface)[0])
    squares = ca.DM(p @ p), ca.DM(s @ s)
    legs = [leg(square, surface.radius) for square in squares]
    theta = angle + float(lean(legs, surface.radius)) - np.pi
    inside = surface.kind == "inside"
    if (theta < 0.0) != inside:
        return np.zeros((0, 3))
    # In the plane of the path, the first direction towards its start.
    first = p / np.linalg.norm(p)
    if surface.axis is None:
        second = s - (s @ first) * first
        second /= np.linalg.norm(second)
    else:
        second = np.array([-first[1], first[0]])
    if inside:
        incidence = float(reflect(ca.DM(angle), squares, surface.radius))
        passing = surface.radius * np.sin(incidence)
        angles = np.array([incidence - np.arcsin(passing / np.linalg.norm(p))])
    else:
        leave = np.pi / 2 - float(lean(legs[:1], surface.radius))
        angles = leave + np.linspace(0.0, theta, 2 + int(theta / _CHORD))
    flat = surface.radius * (np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second))
    if surface.axis is None:
        return np.asarray(surface.centre + flat)
    run = float(legs[0]) + surface.radius * (angles - angles[0])
    share = run / (float(legs[0] + legs[1]) + surface.radius * theta)
    climb = (start - surface.centre) @ surface.axis + share * ((end - start) @ surface.axis)
    return np.asarray(surface.centre + flat @ across + np.outer(climb, surface.axis))
