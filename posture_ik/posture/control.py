"""Optimal control of a reach: from a configuration at rest to tasks met at rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.arms import ARM_JOINTS
from posture_ik.errors import BadProblem, nearest
from posture_ik.kinematics import Kinematics, frame_poses
from posture_ik.posture.actuators import Actuators
from posture_ik.posture.collocation import Mask, Points
from posture_ik.posture.diagnose import nearest_attempt
from posture_ik.posture.mesh import Question
from posture_ik.posture.program import Program
from posture_ik.posture.refine import refine
from posture_ik.posture.solve import solve_posture
from posture_ik.posture.statement import Statement
from posture_ik.posture.tasks import Constraint, constraints_of
from posture_ik.posture.trajectory import Limb, Trajectory
from posture_ik.problem import Hand, Problem

#: Weight of ∫ a² dt beside the effort ((N m)² s⁴), or beside the time or the activations squared
#: (s⁴): little, but it settles what light joints and joints off the critical path do. Beside
#: activations it is not little: two fifths of the cost of `reach_activation`, where a tenth of it
#: lets the light forearm swing to the end of its range.
SMOOTHNESS = {"effort": 1e-4, "time": 1e-8, "activation": 1e-6}
#: Intervals of the first mesh, for the joints of one arm and for more: on one too coarse, stiff
#: joints of the back find motions that are none, from which the next mesh has to find its way.
#: Found by trial (8, 16, 24) on one far target with 12 and with 20 joints.
_FIRST_MESH, _ONE_ARM = (8, 24), 7
#: A task along the path may be missed by this much at the start, m or rad.
_MET = 1e-6


def reach(
    body: Body,
    problem: Problem,
    *,
    start: Array | None = None,
    intervals: int | None = None,
    on_mesh: Callable[[int, int], None] | None = None,
    drive: Callable[[Limb], Actuators] | None = None,
) -> Trajectory:
    """Find the motion of least effort, or of least time, that ends at rest meeting the tasks.

    The body moves under its weight, against the springs and dampers of its joints; the joints
    that do not move stand firm where they start. Solved by direct collocation
    (`posture_ik.posture.collocation`), the mesh refined where needed.

    Of least activation, where actuators drive the joints: those that move then have neither
    springs nor dampers, which stood for the tissue that actuators are models of.

    Args:
        body: who.
        problem: with a [trajectory] block; its tasks are what holds at the end.
        start: configuration (nq,) at rest from which to start; if not given, the posture of least
            energy that meets the tasks that no moving joint can change, and those along the way.
        intervals: of the first mesh; 8 for one arm, 24 for more joints, if not given.
        on_mesh: told before each solve which it is, from 1, and of how many intervals.
        drive: gives the actuators of the joints that move, for the cost "activation".

    Raises:
        InfeasiblePosture: the tasks at the start, or those at the end, cannot be met; tells which,
            and by how much they are missed.
        InfeasibleReach: they can, but not by a motion within the limits and the duration.
        BadProblem: the problem has no [trajectory], a name that the body does not have, or a
            start that is not allowed.
    """
    block = problem.trajectory
    if block is None:
        raise BadProblem("trajectory", "is missing; say under [trajectory] how to reach")
    reference = frame_poses(body.model, body.q_reference)
    asked = constraints_of(reference, problem)
    kept = tuple(
        replace(task, label=f"{task.label} along the way")
        for task in constraints_of(reference, problem.model_copy(update={"task": block.along}))
    )
    moving = _moving(body, problem, block.joints)
    resting = _resting(body, problem, moving, asked)
    if start is None:
        start = solve_posture(body, resting).q
    for dof, value, low, high in zip(body.dofs, start, body.lower, body.upper, strict=True):
        if dof in moving and not low <= value <= high:
            raise BadProblem(
                f"start of {dof}", f"{value:.4g} is not within {low:.4g} to {high:.4g}"
            )
    limb = Limb.of(replace(Statement.of(body, resting), problem=problem), moving, start)
    first = start[list(limb.rows)]
    actuators = None
    if block.cost == "activation":
        if drive is None:
            raise BadProblem(
                "trajectory.cost", "'activation' needs actuators that drive the joints"
            )
        none = np.zeros(len(moving))
        limb = replace(limb, part=replace(limb.part, stiffness=none, damping=none))
        actuators = drive(limb)
    part = limb.part
    twin = Kinematics.of(part.model)
    target = _target(part, problem, (*asked, *kept), first)
    ends, path = (
        [task for task in tasks if any(twin.support(frame) for frame in task.frames)]
        for tasks in (asked, kept)
    )

    most_torque, most_speed = (
        _per_joint(name, getattr(block, name), moving, np.inf) for name in ("torque", "speed")
    )
    limited = tuple(bool(np.isfinite(each).any()) for each in (most_torque, most_speed))
    smoothness = SMOOTHNESS[block.cost] if block.smoothness is None else block.smoothness
    points = Points.of(twin, ends, path, (limited[0], limited[1]), actuators)
    weights = [float(block.cost == "effort"), smoothness, float(block.cost == "time")]
    parameters = points.parameters(
        twin.values(part.model),
        *(part.stiffness, part.q_reference, part.damping),
        _per_joint("strength", block.strength, moving, 1.0),
        np.array(weights),
        actuators.numbers if actuators else np.zeros(0),
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
        duration=block.duration,
        actuators=actuators,
        held=_independent(points, parameters, target),
    )
    if intervals is None:
        intervals = _FIRST_MESH[len(moving) > _ONE_ARM]
    _check_along(path, points, points.path(first, parameters)[0].full().ravel())
    return refine(limb, question, target, block.tolerance, intervals, on_mesh)


def _moving(body: Body, problem: Problem, joints: Sequence[str] | None) -> tuple[str, ...]:
    """Names of the joints that move, in the model's order."""
    if joints is None:
        hands = [task for task in problem.task if isinstance(task, Hand)]
        joints = [f"{name}_{hand.side[0]}" for hand in hands for name in ARM_JOINTS]
    for joint in joints:
        if joint not in body.dofs:
            raise BadProblem(
                "trajectory.joints", f"no joint is called {joint!r}; {nearest(joint, body.dofs)}"
            )
    if not joints:
        raise BadProblem("trajectory.joints", "name the joints that move; no task is a hand's")
    return tuple(dof for dof in body.dofs if dof in joints)


def _resting(
    body: Body, problem: Problem, moving: tuple[str, ...], asked: Sequence[Constraint]
) -> Problem:
    """The problem of the start: tasks that no moving joint can change, and those along the way."""
    twin, rows = Kinematics.of(body.model), {body.dofs.index(joint) for joint in moving}
    kept = [
        task
        for task, constraint in zip(problem.task, asked, strict=True)
        if not any(rows & set(twin.support(frame)) for frame in constraint.frames)
    ]
    along = problem.trajectory.along if problem.trajectory else ()
    kept += [task for task in along if task not in kept]
    return problem.model_copy(update={"task": tuple(kept)})


def _check_along(path: Sequence[Constraint], points: Points, missed: Array) -> None:
    """Refuse a start that misses a task along the way: it would have to jump."""
    missed = np.where(points.one_sided[1], np.maximum(-missed, 0.0), np.abs(missed))
    stop = 0
    for task in path:
        rows, stop = slice(stop, stop + len(task.rows)), stop + len(task.rows)
        if np.any(missed[rows] > _MET):
            raise BadProblem(
                "start",
                f"misses the {task.label} by {np.max(missed[rows]):.2g} m or rad; "
                "what holds along the way must hold from the start",
            )


def _per_joint(
    key: str, values: float | Mapping[str, float] | None, joints: tuple[str, ...], default: float
) -> Array:
    """One value for all joints, or values by name; (n,)."""
    if not isinstance(values, Mapping):
        return np.full(len(joints), default if values is None else values)
    for name in values:
        if name not in joints:
            raise BadProblem(
                f"trajectory.{key}.{name}", f"no such joint moves; {nearest(name, joints)}"
            )
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
