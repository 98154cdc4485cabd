"""The Pinocchio model of a scaled body: the reference subject's, with its numbers replaced.

Reading a URDF takes long; it is done once, and what subjects differ by, placements, inertias,
limits and damping, is written into copies. So all of them share one structure, and with it every
compiled function.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin

from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.load import load_model
from posture_ik.body.parts import Vector
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.urdf import write_urdf

_AXES = np.eye(3)


def model_of(geometry: BodyGeometry) -> pin.Model:
    """The model of a body as Pinocchio would read it from the URDF of this geometry."""
    model = _reference().copy()
    frames = {frame.name: frame for frame in model.frames}
    inertias = [pin.Inertia.Zero() for _ in range(model.njoints)]
    where = {"seat": (0, pin.SE3.Identity())}
    for joint in geometry.joints:
        carrier, place = where[joint.parent]
        place = place * pin.SE3(_rotation(joint.rpy), np.array(joint.xyz))
        weight = pin.Inertia.Zero()
        if joint.child in geometry.inertias:
            weight = pin.Inertia(*geometry.inertias[joint.child])
        if joint.kind == "fixed":
            frames[joint.name].placement = frames[joint.child].placement = place
            frames[joint.name].inertia = weight
            weight = place.act(weight)
        else:
            carrier = model.getJointId(joint.name)
            model.jointPlacements[carrier] = place
            place = pin.SE3.Identity()
        where[joint.child] = carrier, place
        inertias[carrier] += weight
    for i, inertia in enumerate(inertias):
        model.inertias[i] = inertia
    dofs = tuple(model.names)[1:]
    model.lowerPositionLimit = np.array([geometry.lower[dof] for dof in dofs])
    model.upperPositionLimit = np.array([geometry.upper[dof] for dof in dofs])
    model.damping = np.array([geometry.damping[dof] for dof in dofs])
    return model


def _rotation(rpy: Vector) -> pin.Quaternion:
    """By the quaternion that a URDF's reader makes of three angles, so equal to the last digit."""
    x, y, z = (pin.AngleAxis(angle, axis) for angle, axis in zip(rpy, _AXES, strict=True))
    turn = pin.Quaternion(z) * pin.Quaternion(y) * pin.Quaternion(x)
    turn.normalize()
    return turn


@cache
def _reference() -> pin.Model:
    return load_model(write_urdf(BodyGeometry.of(REFERENCE)), "seated_person.urdf")
