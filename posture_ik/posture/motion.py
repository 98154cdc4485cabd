"""A motion under tasks: postures along moving targets, their rates, and the torques they take.

Positions are minimum-energy postures, each solved from the one before. Velocities and
accelerations start as numerical derivatives of these and are projected onto the tasks (eqs 21-29,
`projection`). Inverse dynamics then gives what the joints must supply beyond their springs and
dampers,

    tau = M a + h(q, v) + K (q - q_ergo) + C v + Jᵀ lambda,

where the tasks' reactions lambda are those that leave the joints least to do, tauᵀ K^-1 tau: at
rest they are the posture's own multipliers and tau is zero. Levers that follow the hand have
nothing to supply: their tau is zero always.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import xarray as xr
from scipy.linalg import null_space

from posture_ik.arrays import Array, call
from posture_ik.body import Body
from posture_ik.errors import BadProblem, InfeasiblePosture, MotionStopped, PostureNotFound
from posture_ik.kinematics import data_of, weightless
from posture_ik.posture.maximal import bodies_in_motion
from posture_ik.posture.projection import Projection, task_rates
from posture_ik.posture.result import Posture
from posture_ik.posture.solve import solve_statement
from posture_ik.posture.statement import Statement
from posture_ik.problem import BackrestContact, Problem, with_numbers


@dataclass(frozen=True)
class Motion:
    """Postures in time with rates, torques and reactions; T steps, n dofs, m task rows, k places.

    Attributes:
        postures: the minimum-energy posture of every step; their multipliers are the reactions
            in motion, lambda above.
        time: (T,), s.
        q, v, a: (T, n), m or rad, per s, per s².
        tau: (T, n), what the joints supply beyond springs and dampers, N or N m.
        limit_load: (T, n), what joint limits carry, N or N m; zero off the limits.
        residuals: (T, 3, m), miss of each row in position, velocity and acceleration.
        redundant: rows of tasks that other rows imply, by name.
        seat_force, seat_moment: (T, 3), what the seat does to the person at the origin, N, N m.
    """

    problem: Problem
    postures: tuple[Posture, ...]
    time: Array
    q: Array
    v: Array
    a: Array
    tau: Array
    limit_load: Array
    residuals: Array
    redundant: tuple[str, ...]
    seat_force: Array
    seat_moment: Array

    @property
    def body(self) -> Body:
        """Who moves."""
        return self.postures[0].body

    @property
    def multipliers(self) -> Array:
        """Reactions of the tasks, (T, m), N or N m; a task pushes its coordinate with -lambda."""
        return np.array([posture.multipliers for posture in self.postures])

    @property
    def wrench_labels(self) -> tuple[str, ...]:
        """Where forces act: the tasks, then the seat; k of them."""
        return (*[c.label for c in self.postures[0].constraints], "seat")

    @cached_property
    def forces(self) -> Array:
        """Force on the person at each place, world axes, (T, k, 3), N."""
        forces = [[wrench.force for wrench in posture.wrenches] for posture in self.postures]
        return np.concatenate([np.array(forces), self.seat_force[:, None]], axis=1)

    @cached_property
    def moments(self) -> Array:
        """Moment on the person at each place, world axes, (T, k, 3), N m."""
        moments = [[wrench.moment for wrench in posture.wrenches] for posture in self.postures]
        return np.concatenate([np.array(moments), self.seat_moment[:, None]], axis=1)

    @cached_property
    def points(self) -> Array:
        """Where each acts, (T, k, 3), m."""
        points = [[wrench.point for wrench in posture.wrenches] for posture in self.postures]
        return np.concatenate([np.array(points), np.zeros((len(self.time), 1, 3))], axis=1)

    def worst_residuals(self) -> Array:
        """Largest miss in position (m, rad), velocity and acceleration, (3,)."""
        worst: Array = np.abs(self.residuals).max(axis=(0, 2))
        return worst

    def to_dataset(self) -> xr.Dataset:
        """Everything that a reader of `motion.nc` needs, named and with units."""
        first, bodies = self.postures[0], bodies_in_motion(self.body.model, self.q, self.v, self.a)
        rows = [f"{c.label} {row}" for c in first.constraints for row in c.rows]

        def named(dims: tuple[str, ...], values: Array, unit: str, name: str) -> object:
            return (dims, values, {"units": unit, "long_name": name})

        dof, row, place = ("time", "dof"), ("time", "constraint"), ("time", "task", "axis")
        return xr.Dataset(
            {
                "q": named(dof, self.q, "m or rad", "configuration"),
                "v": named(dof, self.v, "m/s or rad/s", "velocity"),
                "a": named(dof, self.a, "m/s2 or rad/s2", "acceleration"),
                "tau": named(dof, self.tau, "N or N m", "supplied beyond springs and dampers"),
                "limit_load": named(dof, self.limit_load, "N or N m", "carried by joint limits"),
                "multiplier": named(row, self.multipliers, "N or N m", "reaction of the task"),
                "residual": named(row, self.residuals[:, 0], "m or rad", "miss of the task"),
                "velocity_residual": named(row, self.residuals[:, 1], "per s", "miss of its rate"),
                "acceleration_residual": named(
                    row, self.residuals[:, 2], "per s2", "miss of its second rate"
                ),
                "force": named(place, self.forces, "N", "on the person"),
                "moment": named(place, self.moments, "N m", "on the person"),
                "point": named(place, self.points, "m", "where the force acts"),
                "position": named(("time", "body", "axis"), bodies.position, "m", "of the link"),
                "orientation": named(
                    ("time", "body", "quaternion"), bodies.orientation, "1", "of the link"
                ),
                "twist": named(
                    ("time", "body", "component"), bodies.velocity, "m/s, rad/s", "of the link"
                ),
                "body_acceleration": named(
                    ("time", "body", "component"), bodies.acceleration, "per s2", "of the link"
                ),
            },
            coords={
                "time": ("time", self.time, {"units": "s"}),
                "dof": list(self.body.dofs),
                "constraint": rows,
                "task": list(self.wrench_labels),
                "axis": ["x", "y", "z"],
                "body": list(bodies.names),
                "quaternion": ["x", "y", "z", "w"],
                "component": ["x", "y", "z", "rx", "ry", "rz"],
            },
            attrs={"title": self.problem.title, "redundant": ", ".join(self.redundant)},
        )


def move(body: Body, problem: Problem, on_step: Callable[[int, int], None] | None = None) -> Motion:
    """Move a body along the signals of a problem.

    Args:
        body: who.
        problem: with a [motion] block.
        on_step: told after each posture how many of how many are solved.

    Raises:
        BadProblem: the problem has no [motion], or holds a one-sided task.
        MotionStopped: no posture is found at some instant; says which and why.
    """
    if problem.motion is None:
        raise BadProblem("motion", "is missing; say under [motion] how long to move, and what")
    if any(isinstance(task, BackrestContact) for task in problem.task):
        raise BadProblem("task", "a backrest_contact cannot move; hold the back by a backrest")
    times = problem.motion.times
    signals = problem.motion.signal
    names = [signal.of for signal in signals]
    values, rates, accelerations = (
        np.column_stack(course) for course in zip(*[s.at(times) for s in signals], strict=True)
    )
    stills = [
        with_numbers(problem, dict(zip(names, map(float, numbers), strict=True)))
        for numbers in values
    ]
    first = Statement.of(body, stills[0])
    courses = first.along(names)(values.T, rates.T, accelerations.T)
    targets, target_rates, target_accelerations = (course.full().T for course in courses)
    postures: list[Posture] = []
    for k, still in enumerate(stills):
        start = _ahead(postures) if postures else (first.q_ergo,)
        try:
            postures.append(solve_statement(first.at(still, targets[k]), *start))
        except (InfeasiblePosture, PostureNotFound) as error:
            raise MotionStopped(float(times[k]), error) from error
        if on_step:
            on_step(k + 1, len(times))

    rates_of, drift_of = task_rates(first.program)
    dynamics = _Dynamics(first.body, problem.posture.gravity)
    q = np.array([posture.q for posture in postures])
    v_guess, a_guess = _differences(q, times, [posture.at_limit for posture in postures])
    steps = []
    for k, posture in enumerate(postures):
        p = posture.statement.parameters
        jacobian, moved = call(rates_of, q[k], p, target_rates[k])
        projection = Projection(dynamics.mass_matrix(q[k]), jacobian, ~posture.at_limit)
        v = projection(v_guess[k], moved)[0]
        (drift,) = call(drift_of, q[k], v, p, target_rates[k], target_accelerations[k])
        a = projection(a_guess[k], drift)[0]
        torque, limit, multipliers = dynamics.share(posture, v, a, jacobian)
        taken = dynamics.taken()
        held = replace(posture, multipliers=multipliers, limit_multipliers=limit)
        misses = [posture.misses, jacobian @ v + moved, jacobian @ a + drift]
        steps.append((held, v, a, torque, limit, misses, taken, projection.dependent))
    held, v, a, torque, limit, misses, taken, dependent = zip(*steps, strict=True)
    acting = np.array([[wrench[1:] for wrench in posture.wrenches] for posture in held])
    force, moment, point = acting.transpose(2, 0, 1, 3)
    seat_force, seat_moment = np.array(taken).transpose(1, 0, 2)
    rows = [f"{c.label} {row}" for c in postures[0].constraints for row in c.rows]
    return Motion(
        problem=problem,
        postures=held,
        time=times,
        q=q,
        v=np.array(v),
        a=np.array(a),
        tau=np.array(torque),
        limit_load=np.array(limit),
        residuals=np.array(misses),
        redundant=tuple(rows[i] for i in sorted(set().union(*map(set, dependent)))),
        seat_force=seat_force - force.sum(axis=1),
        seat_moment=seat_moment - (moment + np.cross(point, force)).sum(axis=1),
    )


#: Weights with which the last steps, the latest last, foretell the next: polynomials through them.
_FORETELL = ((1,), (-1, 2), (1, -3, 3), (-1, 4, -6, 4), (1, -5, 10, -10, 5))


def _ahead(postures: Sequence[Posture]) -> tuple[Array, Array, Array]:
    """Foretell the next configuration (n,) and multipliers (m,); limits press as they last did."""
    last = postures[-len(_FORETELL) :]
    weights = np.array(_FORETELL[len(last) - 1])
    q = weights @ [posture.q for posture in last]
    multipliers = weights @ [posture.multipliers for posture in last]
    return q, multipliers, last[-1].limit_multipliers


def _differences(
    q: Array, times: Array, at_limit: Sequence[npt.NDArray[np.bool_]]
) -> tuple[Array, Array]:
    """First and second numerical derivatives (T, n) of the positions, second order in the step.

    A joint that meets its limit stops at once, and what shares its task takes over: between such
    instants the motion is smooth, and no difference is taken across one.
    """
    step = times[1] - times[0]
    changes = [k for k in range(1, len(q)) if np.any(at_limit[k] != at_limit[k - 1])]
    v, a = np.zeros_like(q), np.zeros_like(q)
    for start, stop in pairwise([0, *changes, len(q)]):
        low, high = (start, stop) if stop - start > 2 else (max(0, start - 2), stop + 2)
        piece = q[low:high]
        second = (piece[2:] - 2 * piece[1:-1] + piece[:-2]) / step**2
        kept = slice(start - low, stop - low)
        v[start:stop] = np.gradient(piece, step, axis=0, edge_order=2)[kept]
        a[start:stop] = np.concatenate([second[:1], second, second[-1:]])[kept]
    return v, a


class _Dynamics:
    """Pinocchio's numbers of a body in motion, with or without weight."""

    def __init__(self, body: Body, gravity: bool) -> None:
        self.body = body
        self.model = body.model if gravity else weightless(body.model)
        self.data = data_of(self.model)
        self.levers = np.array([dof.startswith("lever_") for dof in body.dofs])

    def mass_matrix(self, q: Array) -> Array:
        """M (n, n), its upper triangle."""
        matrix: Array = pin.crba(self.model, self.data, q)
        return matrix

    def share(
        self, posture: Posture, v: Array, a: Array, jacobian: Array
    ) -> tuple[Array, Array, Array]:
        """Share what a motion takes among joints, limits and tasks.

        Returns:
            tau (n,) of the joints; what the limits carry (n,), in the sign of limit multipliers;
            lambda (m,) of the tasks, least-squares in the springs' norm.
        """
        asked = pin.rnea(self.model, self.data, posture.q, v, a)
        asked = asked - posture.prestrain_force + self.body.damping * v
        free, scale = ~posture.at_limit, np.sqrt(posture.stiffness)
        able, idle = free & ~self.levers, free & self.levers
        multipliers, basis = np.zeros(len(jacobian)), np.eye(len(jacobian))
        if idle.any():
            multipliers = np.linalg.lstsq(jacobian[:, idle].T, -asked[idle], rcond=None)[0]
            basis = null_space(jacobian[:, idle].T)
        left = -(asked + jacobian.T @ multipliers)[able] / scale[able]
        columns = jacobian[:, able].T @ basis / scale[able, None]
        multipliers = multipliers + basis @ np.linalg.lstsq(columns, left, rcond=1e-9)[0]
        tau = asked + jacobian.T @ multipliers
        return np.where(free, tau, 0.0), np.where(free, 0.0, -tau), multipliers

    def taken(self) -> tuple[Array, Array]:
        """What the motion last shared takes beyond the weight: force and moment about the origin.

        Of this the seat gives what nothing else that acts on the person does.
        """
        taken = self.data.liMi[1].act(self.data.f[1])
        return taken.linear, taken.angular
