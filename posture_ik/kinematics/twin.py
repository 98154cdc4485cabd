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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from threading import local
from typing import ClassVar
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.errors import PostureIKError, nearest
from posture_ik.kinematics.joints import (
    Joint,
    Motion,
    Pose,
    compose,
    joint_motion,
    move,
    read_joint,
    size,
)


@dataclass(frozen=True)
class Structure:
    """What two models must share to share a graph; hashable, the key of the cache."""

    parents: tuple[int, ...]
    joints: tuple[Joint, ...]
    turned: tuple[bool, ...]
    shifted: tuple[bool, ...]
    heavy: tuple[bool, ...]
    frames: tuple[tuple[str, int, bool, bool], ...]


def _turned(placements: Sequence[pin.SE3]) -> tuple[bool, ...]:
    rotations = np.array([placement.rotation for placement in placements])
    return tuple(any(entries) for entries in (rotations != np.eye(3)).reshape(-1, 9).tolist())


def _shifted(placements: Sequence[pin.SE3]) -> tuple[bool, ...]:
    translations = np.array([placement.translation for placement in placements])
    return tuple(any(entries) for entries in translations.tolist())


def read_structure(model: pin.Model) -> Structure:
    """Read off a model what its graph depends on."""
    placements = [frame.placement for frame in model.frames]
    names = [(frame.name, frame.parentJoint) for frame in model.frames]
    return Structure(
        parents=tuple(model.parents),
        joints=tuple(read_joint(model.joints[i], model.names[i]) for i in range(1, model.njoints)),
        turned=_turned(model.jointPlacements),
        shifted=_shifted(model.jointPlacements),
        heavy=tuple(inertia.mass > 0 for inertia in model.inertias),
        frames=tuple(
            (*name, turned, shifted)
            for name, turned, shifted in zip(
                names, _turned(placements), _shifted(placements), strict=True
            )
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
        inertias: joint, mass, centre of mass and inertia about it of each body with mass, symbols
            in the joint's frame.
        structure: what the graph was built for.
    """

    _by_structure: ClassVar[dict[Structure, Kinematics]] = {}
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
            structure = read_structure(model)
            if structure not in cls._by_structure:
                cls._by_structure[structure] = cls(structure)
            cls._by_model[model] = cls._by_structure[structure]
        return cls._by_model[model]

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self._symbols: list[ca.SX] = []
        self.parents = structure.parents
        sizes = [size(joint) for joint in structure.joints]
        self.q = ca.SX.sym("q", sum(sizes))
        self.joint_poses = [Pose(ca.SX.eye(3), ca.SX.zeros(3))]
        self.motions: list[Motion] = []
        self.carriers: list[int] = []
        start = 0
        for i, joint in enumerate(structure.joints, 1):
            base = self._place(
                self.joint_poses[self.parents[i]], structure.turned[i], structure.shifted[i]
            )
            across, motions = joint_motion(joint, self.q[start : start + sizes[i - 1]])
            self.motions += [move(motion, base) for motion in motions]
            self.carriers += [i] * len(motions)
            self.joint_poses.append(compose(base, across))
            start += sizes[i - 1]
        self._frames = {
            name: self._place(self.joint_poses[parent], turned, shifted)
            for name, parent, turned, shifted in structure.frames
        }
        self._frame_parents = {name: parent for name, parent, _, _ in structure.frames}
        heavy = [i for i, is_heavy in enumerate(structure.heavy) if is_heavy]
        self.inertias = [
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
        structure = self.structure
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
        for i, *_ in self.inertias:
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
        return [(i, mass, lever) for i, mass, lever, _ in self.inertias]

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

    def spatial_inertias(self) -> Iterator[tuple[int, ca.SX]]:
        """Joint and inertia (6, 6) of each body with mass about the world's origin, angular first.

        In the world's axes; it gives the momentum (angular, linear) of a motion alike.
        """
        for i, mass, lever, inertia in self.inertias:
            rotation, c = self.joint_poses[i].rotation, ca.skew(self._point(i, lever))
            turned = rotation @ inertia @ rotation.T - mass * c @ c
            yield i, ca.blockcat([[turned, mass * c], [-mass * c, mass * ca.SX.eye(3)]])

    def mass_matrix(self) -> ca.SX:
        """Joint-space mass matrix (nv, nv) by composite rigid bodies about the world's origin."""
        n = len(self.parents)
        mass = [ca.SX(0)] * n
        first = [ca.SX.zeros(3)] * n
        second = [ca.SX.zeros(3, 3)] * n
        for i, m, lever, inertia in self.inertias:
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


class _Spaces(local):
    """Work spaces of one thread: tens of megabytes each, so that many models have to share."""

    def __init__(self) -> None:
        self.by_structure: dict[Structure, pin.Data] = {}
        self.by_model: WeakKeyDictionary[pin.Model, pin.Data] = WeakKeyDictionary()


_spaces = _Spaces()
_weightless: WeakKeyDictionary[pin.Model, pin.Model] = WeakKeyDictionary()


def data_of(model: pin.Model) -> pin.Data:
    """This thread's one work space for models of this structure; the next use overwrites it."""
    if model not in _spaces.by_model:
        structure = read_structure(model)
        if structure not in _spaces.by_structure:
            _spaces.by_structure[structure] = model.createData()
        _spaces.by_model[model] = _spaces.by_structure[structure]
    return _spaces.by_model[model]


def weightless(model: pin.Model) -> pin.Model:
    """A model as it was when first asked for, without gravity."""
    if model not in _weightless:
        _weightless[model] = model.copy()
        _weightless[model].gravity = pin.Motion.Zero()
    return _weightless[model]


def frame_poses(model: pin.Model, q: Array) -> dict[str, pin.SE3]:
    """Pose of every link of a model in the world, by name, at a configuration (nq,)."""
    data = data_of(model)
    pin.framesForwardKinematics(model, data, q)
    return {
        frame.name: data.oMf[i].copy()
        for i, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY
    }
