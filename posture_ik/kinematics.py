"""The CasADi twin of a `pin.Model`: the same kinematics, written as one symbolic graph.

The twin is symbolic in the configuration and in the geometry: joint placements, frame placements,
inertias and gravity are entries of a parameter vector, so a scaled body needs no rebuild. Only
structure is fixed in the graph: the tree, the kinds and axes of its joints, and which placements
are identities or bodies without mass (most of the spine's, and what keeps the graph small).

Poses follow the recursion oM_i = oM_parent · placement_i · M_i(q). Each degree of freedom k is
kept as a motion in the world: an angular axis w_k, a linear axis a_k and an origin o_k, so that a
point p carried by it has the velocity a_k + w_k x (p - o_k). Jacobians, mass matrix and, in
`posture_ik.posture`, second derivatives are sums over these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError, UnsupportedJoint, nearest


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
class _Joint:
    """What the graph must know of a joint: its kind, its axis, and the parts of a composite."""

    kind: str
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    parts: tuple[tuple[bytes, _Joint], ...] = ()


def _read_joint(joint: Any, name: str) -> _Joint:
    """Tell a Pinocchio joint's kind and axis from its type's name."""
    short = joint.shortname().removeprefix("JointModel")
    match short:
        case "RX" | "RY" | "RZ":
            return _Joint("revolute", _AXES[short[-1]])
        case "PX" | "PY" | "PZ":
            return _Joint("prismatic", _AXES[short[-1]])
        case "RUBX" | "RUBY" | "RUBZ":
            return _Joint("continuous", _AXES[short[-1]])
        case "RevoluteUnaligned" | "RevoluteUnboundedUnaligned":
            kind = "continuous" if "Unbounded" in short else "revolute"
            return _Joint(kind, _slanted_axis(joint)[3:])
        case "PrismaticUnaligned":
            return _Joint("prismatic", _slanted_axis(joint)[:3])
        case "Spherical" | "FreeFlyer" | "Translation" | "Planar":
            return _Joint(short.lower())
        case "Composite":
            composite = joint.extract() if hasattr(joint, "extract") else joint
            return _Joint(
                "composite",
                parts=tuple(
                    (placement.homogeneous.tobytes(), _read_joint(part, name))
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


def _joint_motion(joint: _Joint, q: ca.SX) -> tuple[Pose, list[Motion]]:
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
        pose = _compose(pose, Pose(ca.SX(homogeneous[:3, :3]), ca.SX(homogeneous[:3, 3])))
        across, part_motions = _joint_motion(part, q[start:])
        motions += [_move(motion, pose) for motion in part_motions]
        pose = _compose(pose, across)
        start += _size(part)
    return pose, motions


def _size(joint: _Joint) -> int:
    """Number of configuration coordinates of a joint."""
    sizes = {"continuous": 2, "translation": 3, "planar": 4, "spherical": 4, "freeflyer": 7}
    if joint.kind == "composite":
        return sum(_size(part) for _, part in joint.parts)
    return sizes.get(joint.kind, 1)


def _compose(first: Pose, second: Pose) -> Pose:
    return Pose(first.rotation @ second.rotation, first.position + first.rotation @ second.position)


def _move(motion: Motion, pose: Pose) -> Motion:
    return Motion(
        pose.rotation @ motion.angular,
        pose.rotation @ motion.linear,
        pose.position + pose.rotation @ motion.origin,
    )


@dataclass(frozen=True)
class _Structure:
    """What two models must share to share a graph; hashable, the key of the cache."""

    parents: tuple[int, ...]
    joints: tuple[_Joint, ...]
    turned: tuple[bool, ...]
    shifted: tuple[bool, ...]
    heavy: tuple[bool, ...]
    frames: tuple[tuple[str, int, bool, bool], ...]


def _turned(placement: pin.SE3) -> bool:
    return not np.array_equal(placement.rotation, np.eye(3))


def _shifted(placement: pin.SE3) -> bool:
    return bool(np.any(placement.translation))


def _structure(model: pin.Model) -> _Structure:
    return _Structure(
        parents=tuple(model.parents),
        joints=tuple(_read_joint(model.joints[i], model.names[i]) for i in range(1, model.njoints)),
        turned=tuple(_turned(placement) for placement in model.jointPlacements),
        shifted=tuple(_shifted(placement) for placement in model.jointPlacements),
        heavy=tuple(inertia.mass > 0 for inertia in model.inertias),
        frames=tuple(
            (f.name, f.parentJoint, _turned(f.placement), _shifted(f.placement))
            for f in model.frames
        ),
    )


class Kinematics:
    """The twin of every `pin.Model` of one structure.

    Attributes:
        q: configuration, SX (nq,), in the model's order.
        parameters: geometry, inertias and gravity, SX (np,); `values(model)` gives the numbers.
        joint_poses: pose of each joint in the world, the universe first.
        motions: each degree of freedom in the world, in the order of the velocity, length nv.
        carriers: the joint that each degree of freedom belongs to.
    """

    _by_structure: ClassVar[dict[_Structure, Kinematics]] = {}
    _by_model: ClassVar[WeakKeyDictionary[pin.Model, Kinematics]] = WeakKeyDictionary()

    @classmethod
    def of(cls, model: pin.Model) -> Kinematics:
        """Give the twin of a model, built once for all models of its structure.

        A model's numbers may change afterwards, its structure (joints, axes, which placements
        are identities) may not: edit a copy.

        Raises:
            UnsupportedJoint: the model holds a joint outside revolute, continuous, prismatic,
                translation, planar, spherical, free-flyer and composites of these.
        """
        if model not in cls._by_model:
            structure = _structure(model)
            if structure not in cls._by_structure:
                cls._by_structure[structure] = cls(structure)
            cls._by_model[model] = cls._by_structure[structure]
        return cls._by_model[model]

    def __init__(self, structure: _Structure) -> None:
        self._structure = structure
        self._symbols: list[ca.SX] = []
        self.parents = structure.parents
        sizes = [_size(joint) for joint in structure.joints]
        self.q = ca.SX.sym("q", sum(sizes))
        self.joint_poses = [Pose(ca.SX.eye(3), ca.SX.zeros(3))]
        self.motions: list[Motion] = []
        self.carriers: list[int] = []
        start = 0
        for i, joint in enumerate(structure.joints, 1):
            base = self._place(
                self.joint_poses[self.parents[i]], structure.turned[i], structure.shifted[i]
            )
            across, motions = _joint_motion(joint, self.q[start : start + sizes[i - 1]])
            self.motions += [_move(motion, base) for motion in motions]
            self.carriers += [i] * len(motions)
            self.joint_poses.append(_compose(base, across))
            start += sizes[i - 1]
        self._frames = {
            name: self._place(self.joint_poses[parent], turned, shifted)
            for name, parent, turned, shifted in structure.frames
        }
        self._frame_parents = {name: parent for name, parent, _, _ in structure.frames}
        heavy = [i for i, is_heavy in enumerate(structure.heavy) if is_heavy]
        self._bodies = [
            (i, self._symbol("m", 1), self._symbol("c", 3), self._symbol("I", 3, 3)) for i in heavy
        ]
        self.gravity = self._symbol("g", 3)
        self.parameters = ca.vertcat(*map(ca.vec, self._symbols))

    def _symbol(self, name: str, *shape: int) -> ca.SX:
        symbol = ca.SX.sym(f"{name}{len(self._symbols)}", *shape)
        self._symbols.append(symbol)
        return symbol

    def _place(self, pose: Pose, turned: bool, shifted: bool) -> Pose:
        """Carry a pose across a placement whose non-trivial parts become parameters."""
        rotation, position = pose
        if shifted:
            position = position + rotation @ self._symbol("t", 3)
        if turned:
            rotation = rotation @ self._symbol("R", 3, 3)
        return Pose(rotation, position)

    def values(self, model: pin.Model) -> Array:
        """Read the parameter vector (np,) off a model of this structure."""
        structure = self._structure
        numbers: list[Array] = []

        def place(placement: pin.SE3, turned: bool, shifted: bool) -> None:
            if shifted:
                numbers.append(placement.translation)
            if turned:
                numbers.append(placement.rotation.T.ravel())

        for i in range(1, model.njoints):
            place(model.jointPlacements[i], structure.turned[i], structure.shifted[i])
        for frame, (_, _, turned, shifted) in zip(model.frames, structure.frames, strict=True):
            place(frame.placement, turned, shifted)
        for i, *_ in self._bodies:
            inertia = model.inertias[i]
            numbers += [np.array([inertia.mass]), inertia.lever, inertia.inertia.T.ravel()]
        numbers.append(model.gravity.linear)
        return np.concatenate(numbers)

    def function(self, name: str, *outputs: ca.SX) -> ca.Function:
        """Make expressions of this twin callable as f(q, parameters)."""
        return ca.Function(name, [self.q, self.parameters], list(outputs))

    def pose(self, frame: str) -> Pose:
        """Pose of a frame in the world.

        Raises:
            PostureIKError: the model has no frame of this name.
        """
        if frame not in self._frames:
            raise PostureIKError(
                f"the body has no frame called {frame!r}; {nearest(frame, self._frames)}"
            )
        return self._frames[frame]

    def joint_of(self, frame: str) -> int:
        """The joint that carries a frame."""
        return self._frame_parents[frame]

    def carried_by(self, joint: int) -> list[int]:
        """Degrees of freedom between the universe and a joint, the innermost first."""
        path = []
        while joint:
            path.append(joint)
            joint = self.parents[joint]
        return [k for k, carrier in enumerate(self.carriers) if carrier in path]

    def support(self, frame: str) -> list[int]:
        """Degrees of freedom that move a frame, the innermost first."""
        return self.carried_by(self.joint_of(frame))

    def jacobian(self, frame: str) -> ca.SX:
        """Frame Jacobian (6, nv), linear above angular, in the world's axes at the frame.

        This is Pinocchio's `LOCAL_WORLD_ALIGNED`.
        """
        position = self.pose(frame).position
        jacobian = ca.SX(6, len(self.motions))
        for k in self.support(frame):
            motion = self.motions[k]
            jacobian[:3, k] = motion.linear + ca.cross(motion.angular, position - motion.origin)
            jacobian[3:, k] = motion.angular
        return jacobian

    def bodies(self) -> list[tuple[int, ca.SX, ca.SX]]:
        """Joint, mass (kg) and centre of mass in the joint's frame (m) of each body with mass."""
        return [(i, mass, lever) for i, mass, lever, _ in self._bodies]

    def centre_of_mass(self) -> ca.SX:
        """Centre of mass of the whole tree, (3,), m."""
        moment, total = ca.SX.zeros(3), ca.SX(0)
        for i, mass, lever in self.bodies():
            moment += mass * self._point(i, lever)
            total += mass
        return moment / total

    def potential_energy(self) -> ca.SX:
        """Potential of gravity, -sum m g·c, J."""
        return ca.SX(0) - sum(
            mass * ca.dot(self.gravity, self._point(i, lever)) for i, mass, lever in self.bodies()
        )

    def _point(self, joint: int, lever: ca.SX) -> ca.SX:
        rotation, position = self.joint_poses[joint]
        return position + rotation @ lever

    def mass_matrix(self) -> ca.SX:
        """Joint-space mass matrix (nv, nv) by composite rigid bodies about the world's origin."""
        n = len(self.parents)
        mass = [ca.SX(0)] * n
        first = [ca.SX.zeros(3)] * n
        second = [ca.SX.zeros(3, 3)] * n
        for i, m, lever, inertia in self._bodies:
            rotation = self.joint_poses[i].rotation
            c = self._point(i, lever)
            mass[i], first[i] = m, m * c
            second[i] = rotation @ inertia @ rotation.T - m * ca.skew(c) @ ca.skew(c)
        for i in range(n - 1, 0, -1):
            parent = self.parents[i]
            mass[parent] += mass[i]
            first[parent] = first[parent] + first[i]
            second[parent] = second[parent] + second[i]
        at_origin = [m.linear - ca.cross(m.angular, m.origin) for m in self.motions]
        matrix = ca.SX(len(self.motions), len(self.motions))
        for k, joint in enumerate(self.carriers):
            angular, linear = self.motions[k].angular, at_origin[k]
            momentum = mass[joint] * linear + ca.cross(angular, first[joint])
            moment = second[joint] @ angular + ca.cross(first[joint], linear)
            for i in self.carried_by(joint):
                entry = ca.dot(at_origin[i], momentum) + ca.dot(self.motions[i].angular, moment)
                matrix[i, k] = matrix[k, i] = entry
        return matrix


_data: WeakKeyDictionary[pin.Model, pin.Data] = WeakKeyDictionary()


def frame_poses(model: pin.Model, q: Array) -> dict[str, pin.SE3]:
    """Pose of every link of a model in the world, by name, at a configuration (nq,)."""
    if model not in _data:
        _data[model] = model.createData()  # slow enough to be worth keeping
    data = _data[model]
    pin.framesForwardKinematics(model, data, q)
    return {
        frame.name: data.oMf[i].copy()
        for i, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY
    }
