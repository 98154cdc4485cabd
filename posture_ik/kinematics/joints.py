"""Joints of a `pin.Model` read for the twin: their poses and motions in CasADi."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from posture_ik.errors import UnsupportedJoint


class Pose(NamedTuple):
    """A frame in the world: `rotation` (3x3) and `position` (3, m), CasADi SX."""

    rotation: ca.SX
    position: ca.SX


class Motion(NamedTuple):
    """One degree of freedom: a unit rate moves a point p at linear + angular x (p - origin)."""

    angular: ca.SX
    linear: ca.SX
    origin: ca.SX


_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_SUPPORTED = (
    "revolute",
    "continuous",
    "prismatic",
    "translation",
    "planar",
    "spherical",
    "free-flyer",
    "composite",
    "fixed",
)


@dataclass(frozen=True)
class Joint:
    """What the graph must know of a joint: its kind, its axis, and the parts of a composite."""

    kind: str
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    parts: tuple[tuple[bytes, Joint], ...] = ()


def read_joint(joint: Any, name: str) -> Joint:
    """Tell a Pinocchio joint's kind and axis from its type's name."""
    short = joint.shortname().removeprefix("JointModel")
    match short:
        case "RX" | "RY" | "RZ":
            return Joint("revolute", _AXES[short[-1]])
        case "PX" | "PY" | "PZ":
            return Joint("prismatic", _AXES[short[-1]])
        case "RUBX" | "RUBY" | "RUBZ":
            return Joint("continuous", _AXES[short[-1]])
        case "RevoluteUnaligned" | "RevoluteUnboundedUnaligned":
            kind = "continuous" if "Unbounded" in short else "revolute"
            return Joint(kind, _slanted_axis(joint)[3:])
        case "PrismaticUnaligned":
            return Joint("prismatic", _slanted_axis(joint)[:3])
        case "Spherical" | "FreeFlyer" | "Translation" | "Planar":
            return Joint(short.lower())
        case "Composite":
            composite = joint.extract() if hasattr(joint, "extract") else joint
            return Joint(
                "composite",
                parts=tuple(
                    (placement.homogeneous.tobytes(), read_joint(part, name))
                    for placement, part in zip(
                        composite.jointPlacements, composite.joints, strict=True
                    )
                ),
            )
    raise UnsupportedJoint(name, short, _SUPPORTED)


def _slanted_axis(joint: Any) -> tuple[float, ...]:
    """The joint's motion subspace (6,), linear first: not every type gives its axis by name."""
    data = joint.createData()
    joint.calc(data, np.eye(joint.nq)[0])
    return tuple(float(value) for value in np.asarray(data.S).ravel())


def _rotation(axis: Sequence[float], cosine: ca.SX, sine: ca.SX) -> ca.SX:
    """Rodrigues' formula about a unit axis, (3, 3)."""
    a = ca.SX(ca.DM(axis))
    return cosine * ca.SX.eye(3) + sine * ca.skew(a) + (1 - cosine) * (a @ a.T)


def _quaternion(q: ca.SX) -> ca.SX:
    """Rotation of a unit quaternion stored x, y, z, w as Pinocchio stores it, (3, 3)."""
    skew = ca.skew(q[:3])
    return ca.SX.eye(3) + 2 * q[3] * skew + 2 * skew @ skew


def joint_motion(joint: Joint, q: ca.SX) -> tuple[Pose, list[Motion]]:
    """The pose across a joint and its degrees of freedom, seen from before the joint."""
    zero, eye = ca.SX.zeros(3), ca.SX.eye(3)
    axis = ca.SX(ca.DM(joint.axis))
    match joint.kind:
        case "revolute":
            rotation = _rotation(joint.axis, ca.cos(q[0]), ca.sin(q[0]))
            return Pose(rotation, zero), [Motion(axis, zero, zero)]
        case "continuous":
            return Pose(_rotation(joint.axis, q[0], q[1]), zero), [Motion(axis, zero, zero)]
        case "prismatic":
            return Pose(eye, axis * q[0]), [Motion(zero, axis, zero)]
        case "translation":
            return Pose(eye, q), [Motion(zero, eye[:, k], zero) for k in range(3)]
        case "planar":
            rotation = _rotation(_AXES["Z"], q[2], q[3])
            position = ca.vertcat(q[0], q[1], 0)
            slides = [Motion(zero, rotation[:, k], position) for k in range(2)]
            return Pose(rotation, position), [*slides, Motion(eye[:, 2], zero, position)]
        case "spherical":
            rotation = _quaternion(q)
            return Pose(rotation, zero), [Motion(rotation[:, k], zero, zero) for k in range(3)]
        case "freeflyer":
            rotation, position = _quaternion(q[3:]), q[:3]
            slides = [Motion(zero, rotation[:, k], position) for k in range(3)]
            turns = [Motion(rotation[:, k], zero, position) for k in range(3)]
            return Pose(rotation, position), slides + turns
    pose, motions = Pose(eye, zero), []
    start = 0
    for placement, part in joint.parts:
        homogeneous = np.frombuffer(placement).reshape(4, 4)
        pose = compose(pose, Pose(ca.SX(homogeneous[:3, :3]), ca.SX(homogeneous[:3, 3])))
        across, part_motions = joint_motion(part, q[start:])
        motions += [move(motion, pose) for motion in part_motions]
        pose = compose(pose, across)
        start += size(part)
    return pose, motions


def size(joint: Joint) -> int:
    """Number of configuration coordinates of a joint."""
    sizes = {"continuous": 2, "translation": 3, "planar": 4, "spherical": 4, "freeflyer": 7}
    if joint.kind == "composite":
        return sum(size(part) for _, part in joint.parts)
    return sizes.get(joint.kind, 1)


def compose(first: Pose, second: Pose) -> Pose:
    """Carry a pose seen from the first into where the first is seen from."""
    return Pose(first.rotation @ second.rotation, first.position + first.rotation @ second.position)


def move(motion: Motion, pose: Pose) -> Motion:
    """Carry a motion seen from a pose into where the pose is seen from."""
    return Motion(
        pose.rotation @ motion.angular,
        pose.rotation @ motion.linear,
        pose.position + pose.rotation @ motion.origin,
    )
