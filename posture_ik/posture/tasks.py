"""Tasks as equations: the prescribed parts psi(theta) = alpha of the posture (eqs 11, 20).

Every task becomes a constraint whose residual is **linear in the pose** of each frame it names,
that is in its position p_b and rotation matrix R_b (its target may enter in any way). That
one property gives, by a single sweep over the tree, the forces of each constraint in the world
and the exact second derivatives of the Lagrangian (see `posture_ik.posture.program`).

Rotations are compared without angles: for a target R* the residual is the axial part of
R*ᵀ R, that is sin(phi) n for a rotation by phi about n. It also vanishes half a turn away, where
the `overturn` 1 - cos(phi), linear as well, is 2 and tells the two apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik import problem as ask
from posture_ik.arrays import Array
from posture_ik.errors import BadProblem, nearest
from posture_ik.kinematics import Pose


@dataclass(frozen=True)
class Constraint:
    """One task as equations.

    Attributes:
        label: what the report calls it.
        frames: the frames it holds.
        rows: name of each equation, in order; those that start with `r` are angles (rad), the
            rest lengths (m).
        target: the numbers alpha and whatever else the residual needs, (t,).
    """

    label: str
    frames: tuple[str, ...]
    rows: tuple[str, ...]
    target: Array

    one_sided: ClassVar[bool] = False

    @property
    def person_frames(self) -> int:
        """How many of the frames, from the first, are the person's own."""
        return len(self.frames)

    def residual(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """Residual psi - alpha, (len(rows),), linear in each pose; m and rad."""
        raise NotImplementedError

    def overturn(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """1 - cos(phi) of the angle to the target, () or empty where not all angles are held."""
        return ca.SX(0, 1)

    def structure(self) -> tuple[object, ...]:
        """What two constraints must share to share a graph."""
        return (type(self), self.frames, self.rows, self.target.size)


class Held(Constraint):
    """A frame held at a target pose (R*, p*), in some of the components along the target's axes.

    Lengths are R*ᵀ (p - p*); angles the axial part of R*ᵀ R. The target is p* then R* by columns.
    """

    def residual(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """R*ᵀ (p - p*) and axial(R*ᵀ R), in the rows held."""
        rotation, position = poses[self.frames[0]]
        goal = ca.reshape(target[3:12], 3, 3)
        errors = ca.vertcat(goal.T @ (position - target[:3]), _axial(goal.T @ rotation))
        return errors[[ask.COMPONENTS.index(row) for row in self.rows]]

    def overturn(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """1 - cos(phi) = (3 - tr(R*ᵀ R)) / 2 where all three angles are held, else empty."""
        goal = ca.reshape(target[3:12], 3, 3)
        return _away(goal, poses[self.frames[0]].rotation, self.rows)


class Gripped(Constraint):
    """A hand closed around a lever's handle: the loop from the seat through arm and lever to it.

    Lengths are p - p_L of hand and handle in the world's axes, angles the axial part of
    (R_L R*)ᵀ R, with R* how the hand lies on the handle, which is the target.
    """

    @property
    def person_frames(self) -> int:
        """The hand alone."""
        return 1

    def residual(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """Lengths p - p_L, angles axial((R_L R*)ᵀ R), in the rows held."""
        (rotation, position), (handle, middle) = (poses[frame] for frame in self.frames)
        goal = handle @ ca.reshape(target, 3, 3)
        errors = ca.vertcat(position - middle, _axial(goal.T @ rotation))
        return errors[[ask.COMPONENTS.index(row) for row in self.rows]]

    def overturn(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """As of a frame held."""
        (rotation, _), (handle, _) = (poses[frame] for frame in self.frames)
        return _away(handle @ ca.reshape(target, 3, 3), rotation, self.rows)


class Averaged(Constraint):
    """The weighted mean motion of frames held: Nastran's RBE3, exact at finite rotations.

    With s_i the target positions from their mean, R*_i the target rotations and L the mean of
    |s_i|, the best-fitting rotation is the target's where

        sum_i [ s_i x p_i + L² axial(R_i R*_iᵀ) ] = 0,

    the stationarity of the weighted Procrustes fit; its linearisation is the RBE3 average of
    translations and rotations. Divided by sum(|s_i|² + L²) it is an angle. The target is the mean
    position, the axes of the components, L, then every s_i and R*_i.
    """

    def residual(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """Mean position and mean rotation from the target's, along the target's axes."""
        count = len(self.frames)
        axes, square = ca.reshape(target[3:12], 3, 3), target[12] ** 2
        mean, moment, weight = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX(0)
        for i, frame in enumerate(self.frames):
            rotation, position = poses[frame]
            numbers = target[13 + 12 * i : 25 + 12 * i]
            arm, goal = numbers[:3], ca.reshape(numbers[3:], 3, 3)
            mean += position / count
            moment += ca.cross(arm, position) + square * _axial(rotation @ goal.T)
            weight += ca.sumsqr(arm) + square
        errors = ca.vertcat(axes.T @ (mean - target[:3]), axes.T @ moment / weight)
        return errors[[ask.COMPONENTS.index(row) for row in self.rows]]


class Supported(Constraint):
    """Frames kept in front of a plane, n·p - d >= 0 each; the target is n then d."""

    one_sided: ClassVar[bool] = True

    def residual(self, poses: Mapping[str, Pose], target: ca.SX) -> ca.SX:
        """Distance of every frame in front of the plane."""
        return ca.vertcat(
            *[ca.dot(target[:3], poses[frame].position) - target[3] for frame in self.frames]
        )


def _axial(matrix: ca.SX) -> ca.SX:
    """The axial vector of the antisymmetric part: sin(phi) n for a rotation."""
    return ca.inv_skew(matrix - matrix.T) / 2


def _away(goal: ca.SX, rotation: ca.SX, rows: tuple[str, ...]) -> ca.SX:
    """1 - cos(phi) = (3 - tr(R*ᵀ R)) / 2 where the rows hold all three angles, else empty."""
    if not {"rx", "ry", "rz"} <= set(rows):
        return ca.SX(0, 1)
    return (3 - ca.trace(goal.T @ rotation)) / 2


def constraints_of(
    reference: Mapping[str, pin.SE3], problem: ask.Problem
) -> tuple[Constraint, ...]:
    """Write the tasks of a problem as constraints, in the order they are asked.

    Numbers of the problem may be CasADi symbols (`problem.with_numbers`); targets are then arrays
    of expressions in them.

    Args:
        reference: pose of every link of the body in its reference shape, by name.
        problem: whose tasks and seat.

    Raises:
        BadProblem: a task names a link that the body does not have.
    """
    recline = _rotation(0.0, -problem.seat.recline_deg, 0.0)
    return tuple(_constraint(task, problem, reference, recline) for task in problem.task)


def _constraint(
    task: ask.Head | ask.Backrest | ask.BackrestContact | ask.Pelvis | ask.Hand | ask.Frame,
    problem: ask.Problem,
    reference: Mapping[str, pin.SE3],
    recline: Array,
) -> Constraint:
    label = ask.task_label(task)
    match task:
        case ask.Head():
            return _head(label, task, reference, recline)
        case ask.Backrest():
            return _backrest(label, task, reference, recline)
        case ask.BackrestContact():
            deepest = min(reference[body].translation[0] for body in task.bodies)
            normal = recline[:, 0]
            return Supported(label, task.bodies, task.bodies, np.append(normal, deepest))
        case ask.Pelvis():
            rolled = _rotation(task.oblique_deg, -task.roll_back_deg, 0.0)
            goal = rolled @ reference["S1"].rotation
            return _held(label, "S1", ("rx", "ry"), goal, (0.0, 0.0, 0.0))
        case ask.Hand():
            goal, grip = _rotation(*task.rotation_deg), f"grip_{task.side[0]}"
            if task.lever is None:
                return _held(label, grip, task.components, goal, np.array(task.position))
            lever = problem.lever[task.lever]
            if lever.follows:
                frames = (grip, f"lever_{task.lever}_grip")
                return Gripped(label, frames, task.components, goal.T.ravel())
            handle, position = handle_of(lever)
            return _held(label, grip, task.components, handle @ goal, position)
        case ask.Frame():
            if task.frame not in reference:
                raise BadProblem(
                    label, f"the body has no such link; {nearest(task.frame, reference)}"
                )
            goal = _rotation(*task.rotation_deg)
            return _held(label, task.frame, task.components, goal, task.position)


def _rotation(about_x_deg: float, about_y_deg: float, about_z_deg: float) -> Array:
    """Turn about x, then y, then z of the fixed axes, (3, 3), of numbers or of CasADi symbols."""
    angles = [angle * (np.pi / 180.0) for angle in (about_x_deg, about_y_deg, about_z_deg)]
    (cx, sx), (cy, sy), (cz, sz) = [(ca.cos(angle), ca.sin(angle)) for angle in angles]
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    rotation: Array = about_z @ about_y @ about_x
    return rotation


def handle_of(lever: ask.Lever) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,), m, of a lever's handle at the angles given."""
    swung = _rotation(0.0, lever.fore_aft_deg, 0.0) @ _rotation(lever.lateral_deg, 0.0, 0.0)
    position = np.array(lever.pivot) + swung @ np.array([0.0, 0.0, lever.length])
    return swung @ _rotation(0.0, lever.handle_deg, 0.0), position


def _held(
    label: str,
    frame: str,
    rows: tuple[str, ...],
    rotation: Array,
    position: Array | tuple[float, ...],
) -> Held:
    return Held(label, (frame,), rows, np.concatenate([np.array(position), rotation.T.ravel()]))


def _head(label: str, task: ask.Head, reference: Mapping[str, pin.SE3], recline: Array) -> Held:
    gaze = task.looking
    turned = _rotation(gaze.tilt_deg, gaze.nod_deg, gaze.turn_deg)
    goal = turned @ reference["Head"].rotation
    if task.position == "free":
        return _held(label, "Head", ("rx", "ry", "rz"), goal, (0.0, 0.0, 0.0))
    if task.position == "over C1":
        # The head stands on the atlas as in the reference shape, turned the way it looks.
        atlas = reference["C1"].translation
        position = recline @ atlas + turned @ (reference["Head"].translation - atlas)
        return _held(label, "Head", ask.COMPONENTS, goal, position)
    return _held(label, "Head", ask.COMPONENTS, goal, task.position)


def _backrest(
    label: str, task: ask.Backrest, reference: Mapping[str, pin.SE3], recline: Array
) -> Averaged:
    poses = [reference[body] for body in task.bodies]
    mean = np.mean([pose.translation for pose in poses], axis=0)
    arms = [pose.translation - mean for pose in poses]
    length = np.mean([np.linalg.norm(arm) for arm in arms])
    rows = tuple(row for row in ask.COMPONENTS if not (task.slide and row == "z"))
    numbers = [recline @ mean, recline.T.ravel(), [length]]
    for arm, pose in zip(arms, poses, strict=True):
        numbers += [recline @ arm, (recline @ pose.rotation).T.ravel()]
    return Averaged(label, task.bodies, rows, np.concatenate(numbers))
