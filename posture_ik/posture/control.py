"""Optimal control of a reach: from a configuration at rest to tasks met at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.arms import ARM_JOINTS
from posture_ik.errors import BadProblem, nearest
from posture_ik.kinematics import Kinematics, frame_poses
from posture_ik.posture.collocation import Mask, Points
from posture_ik.posture.diagnose import nearest_attempt
from posture_ik.posture.mesh import Question
from posture_ik.posture.program import Program
from posture_ik.posture.refine import refine
from posture_ik.posture.statement import Statement
from posture_ik.posture.tasks import Constraint, constraints_of
from posture_ik.posture.trajectory import Limb, Trajectory
from posture_ik.problem import Hand, Problem, Task

PerJoint = float | Mapping[str, float]

#: Weight of ∫ a² dt beside the effort ((N m)² s⁴) or beside the time (s⁴): little, but it settles
#: what light joints and joints off the critical path do.
SMOOTHNESS = {"effort": 1e-4, "time": 1e-8}
#: A task along the path may be missed by this much at the start, m or rad.
_MET = 1e-6


def reach(
    body: Body,
    problem: Problem,
    *,
    joints: Sequence[str] | None = None,
    start: Array | None = None,
    duration: float | None = None,
    cost: Literal["effort", "time"] = "effort",
    along: Sequence[Task] = (),
    speed: PerJoint | None = None,
    torque: PerJoint | None = None,
    strength: PerJoint = 1.0,
    smoothness: float | None = None,
    tolerance: float = 1e-4,
    intervals: int = 8,
) -> Trajectory:
    """Find the motion of least effort, or of least time, that ends at rest meeting the tasks.

    The body moves under its weight, against the springs and dampers of its joints; the joints
    that do not move stand firm. Solved by direct collocation (`posture_ik.posture.collocation`),
    the mesh refined where needed.

    Args:
        body: who.
        problem: its tasks are what holds at the end. Those that no moving joint can change must
            be met from the start.
        joints: names of the joints that move; if not given, the arms of the hands in the tasks.
        start: configuration (nq,) at rest from which to start; the reference shape if not given.
        duration: s; free if not given.
        cost: "effort" for ∫ Σ (tau / strength)² dt, "time" for the duration.
        along: tasks to be met all along the way, from the start on.
        speed: limit to either side, for all joints or by name, rad/s or m/s.
        torque: likewise, N m or N.
        strength: what torques are measured by in the effort, for all joints or by name.
        smoothness: weight of ∫ Σ a² dt beside the cost; `SMOOTHNESS` if not given.
        tolerance: largest defect of an interval, m or rad; see `Trajectory.defect`.
        intervals: of the first mesh.

    Raises:
        InfeasiblePosture: the tasks at the end cannot be met; tells by how much they are missed.
        InfeasibleReach: they can, but not by a motion within the limits and the duration.
        BadProblem: a name that the body does not have, or a start that is not allowed.
    """
    if start is None:
        start = body.q_reference
    if duration is not None and not duration > 0.0:
        raise BadProblem("duration", f"{duration:g} s is not above zero")
    moving = _moving(body, problem, joints, start)
    limb = Limb.of(body, moving, start)
    part, first = limb.part, start[list(limb.rows)]
    reference = frame_poses(body.model, body.q_reference)
    asked = constraints_of(reference, problem)
    kept = constraints_of(reference, problem.model_copy(update={"task": tuple(along)}))
    twin = Kinematics.of(part.model)
    target = _target(part, problem, asked, first)
    ends, path = (
        [task for task in tasks if any(twin.support(frame) for frame in task.frames)]
        for tasks in (asked, kept)
    )

    most_torque, most_speed = (_per_joint(each, moving, np.inf) for each in (torque, speed))
    limited = tuple(bool(np.isfinite(each).any()) for each in (most_torque, most_speed))
    if cost == "time" and not any(limited):
        raise BadProblem("cost = 'time'", "give a limit on torque or speed, or it takes no time")
    if smoothness is None:
        smoothness = SMOOTHNESS[cost]
    points = Points.of(twin, ends, path, (limited[0], limited[1]))
    weights = {"effort": [1.0, smoothness, 0.0], "time": [0.0, smoothness, 1.0]}[cost]
    parameters = points.parameters(
        twin.values(part.model),
        *(part.stiffness, part.q_reference, part.damping),
        _per_joint(strength, moving, 1.0),
        np.array(weights),
        *(task.target for task in (*ends, *path)),
    )
    question = Question(
        points=points,
        parameters=parameters,
        start=first,
        lower=part.lower,
        upper=part.upper,
        torque=most_torque if limited[0] else None,
        speed=most_speed if limited[1] else None,
        duration=duration,
        held=_independent(points, parameters, target),
    )
    missed = points.path(first, parameters)[0].full().ravel()
    one_sided = points.one_sided[1]
    if np.any(np.where(one_sided, -missed, np.abs(missed)) > _MET):
        raise BadProblem("along", "the tasks along the way are not met at the start")
    return refine(limb, question, target, tolerance, intervals)


def _moving(
    body: Body, problem: Problem, joints: Sequence[str] | None, start: Array
) -> tuple[str, ...]:
    """Names of the joints that move, in the model's order."""
    if joints is None:
        hands = [task for task in problem.task if isinstance(task, Hand)]
        joints = [f"{name}_{hand.side[0]}" for hand in hands for name in ARM_JOINTS]
    for joint in joints:
        if joint not in body.dofs:
            raise BadProblem("joints", f"no joint is called {joint!r}; {nearest(joint, body.dofs)}")
    if not joints:
        raise BadProblem("joints", "name the joints that move; no task is a hand's")
    for dof, value, low, high in zip(body.dofs, start, body.lower, body.upper, strict=True):
        if dof in joints and not low <= value <= high:
            raise BadProblem(
                f"start of {dof}", f"{value:.4g} is not within {low:.4g} to {high:.4g}"
            )
    return tuple(dof for dof in body.dofs if dof in joints)


def _per_joint(values: PerJoint | None, joints: tuple[str, ...], default: float) -> Array:
    """One value for all joints, or values by name; (n,)."""
    if not isinstance(values, Mapping):
        return np.full(len(joints), default if values is None else values)
    for name in values:
        if name not in joints:
            raise BadProblem(name, f"no such joint moves; {nearest(name, joints)}")
    return np.array([values.get(joint, default) for joint in joints])


def _target(part: Body, problem: Problem, constraints: Sequence[Constraint], start: Array) -> Array:
    """The configuration (n,) nearest to the start that meets the tasks.

    Raises:
        InfeasiblePosture: there is none within the joint ranges.
    """
    twin, ones = Kinematics.of(part.model), np.ones(len(start))
    statement = Statement(
        part,
        problem,
        tuple(constraints),
        Program.of(twin, constraints, gravity=False),
        stiffness=ones,
        q_ergo=start,
        parameters=np.concatenate(
            [twin.values(part.model), ones, start, *(task.target for task in constraints)]
        ),
    )
    attempt = nearest_attempt(statement)
    if not attempt.reaches:
        raise attempt.error()
    return attempt.q


def _independent(points: Points, parameters: Array, target: Array) -> tuple[Mask, Mask]:
    """Which rows of the tasks at the end, and of those along the path, to ask for at the end.

    Those that no row before them implies, to first order, or that are one-sided.
    """
    jacobians = (f(target, parameters)[1].full() for f in (points.end, points.path))
    rows, masks = np.zeros((0, points.size)), []
    for jacobian, one_sided in zip(jacobians, points.one_sided, strict=True):
        mask = one_sided.copy()
        for i, row in enumerate(jacobian):
            if not one_sided[i]:
                longer = np.vstack([rows, row])
                if np.linalg.matrix_rank(longer, 1e-6) > len(rows):
                    rows, mask[i] = longer, True
        masks.append(mask)
    return masks[0], masks[1]
