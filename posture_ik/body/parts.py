"""What a body is put together from: joints and inertias, as plain data."""

from __future__ import annotations

from typing import Literal, NamedTuple

from posture_ik.arrays import Array

Vector = tuple[float, float, float]

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
ZERO: Vector = (0.0, 0.0, 0.0)


class Joint(NamedTuple):
    """A joint as URDF has it.

    Attributes:
        name: Name of the joint; of a degree of freedom unless fixed.
        kind: What it lets move.
        parent: Link it hangs on.
        child: Link it carries.
        xyz: Its frame's origin in the parent's frame, m.
        rpy: Its frame's rotation, about the parent's fixed x, then y, then z, rad.
        axis: Along or about which it moves, in its own frame; unit length.
    """

    name: str
    kind: Literal["fixed", "prismatic", "revolute"]
    parent: str
    child: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO
    axis: Vector = Z


class Inertia(NamedTuple):
    """Mass (kg), its centre in the link's frame (3,), m, and tensor about it (3, 3), kg m²."""

    mass: float
    centre: Array
    tensor: Array


def vector(values: Array) -> Vector:
    """Three numbers as a tuple, without minus zeros."""
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
