"""From a posture or a motion to the muscles that hold it: the cascade of the source's §4.3.

Inverse dynamics asks each arm joint for

    demand = M a + h(q, v) - J_handᵀ F,

the arm's weight and inertia and the load F on the hand: what the problem says, and what a lever
that follows needs for its spring, damper, weight and inertia, taken as the least force at the grip
that does it. The springs that chose the posture are no tissue and help nobody here. An arm whose
hand no task holds rests on the thigh: there nothing is asked of its muscles. Muscles pull along
their paths l(q) with the force of Hill's law, tau = -Lᵀ f, and what their passive part does not
give is recruited (`activation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import xarray as xr

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.kinematics import data_of
from posture_ik.muscle.activation import Recruitment, Shortfall, recruit, volumes
from posture_ik.muscle.hill import LAWS
from posture_ik.muscle.modes import Modes, extremes
from posture_ik.muscle.path import Paths
from posture_ik.muscle.reflex import (
    Endpoint,
    JointDamping,
    JointStiffness,
    endpoint,
    joint_damping,
    joint_stiffness,
    muscle_damping,
    muscle_stiffness,
    trace_slope,
)
from posture_ik.muscle.table import Muscles
from posture_ik.posture import Motion, Posture
from posture_ik.problem import ActivationBlock, Hand, Problem

#: Muscles and joints of each arm within the 50 and the 14.
ARMS = {"right": (slice(0, 25), slice(0, 7)), "left": (slice(25, 50), slice(7, 14))}


@dataclass(frozen=True)
class Hold:
    """What the muscles of one arm make of it at one instant.

    Attributes:
        recruitment: activations, reserve and certificate; capacity is d tau/d a.
        modes: directions in activation that change no torque.
        softest, stiffest: activations (25,) of the same torques with least and most stiffness
            (trace of K).
        stiffness, damping: of the seven joints, by part.
        endpoint: stiffness at the hand, weight and load counted.
    """

    recruitment: Recruitment
    modes: Modes
    softest: Array
    stiffest: Array
    stiffness: JointStiffness
    damping: JointDamping
    endpoint: Endpoint


@dataclass(frozen=True)
class Activity:
    """Activations of the arms' 50 muscles at T instants, one for a posture.

    Attributes:
        shown: the posture or motion they hold.
        asked: law, cost and loads.
        muscles, paths: whose.
        length, rate: of the paths, (T, 50), m and m/s.
        force: along the paths, (T, 50), N.
        demand: torques that inverse dynamics asks of the arm joints, (T, 14), N m.
        passive: what the muscles' passive part gives of it, (T, 14), N m.
        hand_force: load on right and left hand, (T, 2, 3), N, world axes.
        recruitments: of right and left arm at each instant.
        outside: arm joints that leave the range over which the muscles' paths hold.
    """

    shown: Posture | Motion
    asked: ActivationBlock
    muscles: Muscles
    paths: Paths
    length: Array
    rate: Array
    force: Array
    demand: Array
    passive: Array
    hand_force: Array
    recruitments: tuple[tuple[Recruitment, ...], ...]
    outside: tuple[str, ...]

    @property
    def time(self) -> Array:
        """Instants (T,), s; 0 for a posture."""
        return np.zeros(1) if isinstance(self.shown, Posture) else self.shown.time

    @property
    def q(self) -> Array:
        """Configurations (T, n)."""
        return np.atleast_2d(self.shown.q)

    @property
    def problem(self) -> Problem:
        """What was asked."""
        return self.shown.problem

    @cached_property
    def activation(self) -> Array:
        """Activations, (T, 50), 0 to 1."""
        return _both([[r.activation for r in arms] for arms in self.recruitments])

    @cached_property
    def reserve(self) -> Array:
        """Torques that muscles cannot give, (T, 14), N m; exactly 0 where they can."""
        return _both([[r.reserve for r in arms] for arms in self.recruitments])

    @property
    def working(self) -> tuple[str, ...]:
        """Arms that hold something, of `right` and `left`; the others rest on the thighs."""
        return _working(self.problem, self.asked)

    @property
    def delivered(self) -> Array:
        """Torques of the muscles, active and passive, (T, 14), N m."""
        return self.demand - self.reserve

    @cached_property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """Joints whose reserve stands in at some instant, at its largest, worst first."""
        worst: dict[str, Shortfall] = {}
        for arms in self.recruitments:
            for recruitment, (_, joints) in zip(arms, ARMS.values(), strict=True):
                for fall in recruitment.shortfalls(self.paths.dofs[joints]):
                    known = worst.get(fall.joint)
                    if known is None or abs(fall.torque) > abs(known.torque):
                        worst[fall.joint] = fall
        return tuple(sorted(worst.values(), key=lambda fall: -abs(fall.torque)))

    def worst_certificate(self) -> tuple[float, float, float]:
        """Largest primal and dual residual and duality gap of any instant and arm."""
        all_of = np.array([tuple(r.certificate) for arms in self.recruitments for r in arms])
        primal, dual, gap = all_of.max(axis=0)
        return float(primal), float(dual), float(gap)

    def hold(self, side: str, step: int = 0) -> Hold:
        """Modes, stiffness and damping of the `right` or `left` arm at an instant."""
        here, joints = ARMS[side]
        body = self.shown.body
        q, recruitment = self.q[step], self.recruitments[step][list(ARMS).index(side)]
        muscles, law = _part(self.muscles, here), LAWS[self.asked.law]
        jacobian = self.paths.evaluate(q)[1][here, joints]
        length = self.length[step, here]
        full = law(muscles, length, np.zeros_like(length), np.ones_like(length))
        each = np.array([np.trace(self._bend(side, q, unit)) for unit in np.eye(len(length))])
        slope = trace_slope(muscles, full, jacobian, each, short_range=self.asked.short_range)
        softest, stiffest = extremes(recruitment.capacity, recruitment.activation, slope)
        stiffness, damping = self.impedance(side, step)
        data, rows = data_of(body.model), self.paths.rows[joints]
        reach = _jacobian(body, data, q, f"grip_{side[0]}")
        load = self.hand_force[step, list(ARMS).index(side)]
        bearing = _bearing(body, data, q, reach, rows, load)
        return Hold(
            recruitment,
            Modes.of(recruitment.capacity),
            softest,
            stiffest,
            stiffness,
            damping,
            endpoint(stiffness.total + bearing, reach[:3, rows]),
        )

    def impedance(self, side: str, step: int = 0) -> tuple[JointStiffness, JointDamping]:
        """Stiffness and damping of the `right` or `left` arm's seven joints at an instant."""
        here, joints = ARMS[side]
        q, recruitment = self.q[step], self.recruitments[step][list(ARMS).index(side)]
        muscles, reflex = _part(self.muscles, here), self.asked.reflex
        length, rate = self.length[step, here], self.rate[step, here]
        jacobian = self.paths.evaluate(q)[1][here, joints]
        force = LAWS[self.asked.law](muscles, length, rate, recruitment.activation)
        stiff = muscle_stiffness(
            muscles, force, reflex.proportional, short_range=self.asked.short_range
        )
        damped = muscle_damping(muscles, force, reflex.derivative)
        bend = self._bend(side, q, force.force)
        return joint_stiffness(stiff, jacobian, bend), joint_damping(damped, jacobian)

    def _bend(self, side: str, q: Array, weights: Array) -> Array:
        """Second derivatives of an arm's path lengths, weighted and summed, (7, 7), m."""
        here, joints = ARMS[side]
        all_weights = np.zeros(len(self.muscles.names))
        all_weights[here] = weights
        bend: Array = self.paths.curvature(q, all_weights)[joints, joints]
        return bend

    def to_dataset(self) -> xr.Dataset:
        """Everything that a reader of `activation.nc` needs, named and with units."""

        def named(dims: tuple[str, ...], values: Array, unit: str, name: str) -> object:
            return (dims, values, {"units": unit, "long_name": name})

        muscle, dof = ("time", "muscle"), ("time", "dof")
        primal, dual, gap = self.worst_certificate()
        prices = _both([[r.multipliers for r in arms] for arms in self.recruitments])
        bounds = _both([[r.bound_multipliers for r in arms] for arms in self.recruitments])
        return xr.Dataset(
            {
                "activation": named(muscle, self.activation, "1", "activation"),
                "force": named(muscle, self.force, "N", "force along the path"),
                "length": named(muscle, self.length, "m", "length of the path"),
                "rate": named(muscle, self.rate, "m/s", "rate of the path's length"),
                "demand": named(dof, self.demand, "N m", "torque asked by inverse dynamics"),
                "passive": named(dof, self.passive, "N m", "torque of the passive forces"),
                "delivered": named(dof, self.delivered, "N m", "torque of the muscles"),
                "reserve": named(dof, self.reserve, "N m", "torque that no muscle can give"),
                "multiplier": named(dof, prices, "1/(N m)", "price of torque"),
                "bound_multiplier": named(muscle, bounds, "1", "price of the bounds"),
                "hand_force": named(("time", "side", "axis"), self.hand_force, "N", "on the hand"),
            },
            coords={
                "time": ("time", self.time, {"units": "s"}),
                "muscle": list(self.muscles.names),
                "dof": list(self.paths.dofs),
                "side": list(ARMS),
                "axis": ["x", "y", "z"],
                "group": ("muscle", list(self.muscles.group)),
            },
            attrs={
                "title": self.problem.title,
                "law": self.asked.law,
                "cost": self.asked.cost,
                "shortfalls": "; ".join(map(str, self.shortfalls)),
                "outside": ", ".join(self.outside),
                "primal_residual": primal,
                "dual_residual": dual,
                "duality_gap": gap,
            },
        )


def solve_activation(body: Body, posture: Posture | Motion, problem: Problem) -> Activity:
    """Find the activations of least cost that hold a posture or drive a motion.

    Args:
        body: who; both arms must be those of this package.
        posture: a posture, or a motion.
        problem: its [activation] block, or the defaults if there is none.

    Raises:
        PostureIKError: the body lacks an arm.
    """
    asked = problem.activation or ActivationBlock()
    muscles, paths = Muscles.of(body), Paths.of(body)
    shown = posture
    q = np.atleast_2d(shown.q)
    v, a = (np.zeros_like(q),) * 2 if isinstance(shown, Posture) else (shown.v, shown.a)
    model = shown.body.model
    data = data_of(model)
    weights = {
        "squares": None,
        "fatigue": None,
        "volume": volumes(muscles.peak_force, muscles.optimal_length),
    }[asked.cost]
    rows = paths.rows
    found = [paths.evaluate(each) for each in q]
    length, jacobian = (np.array(part) for part in zip(*found, strict=True))
    rate = (jacobian @ v[:, rows, None])[..., 0]
    # All are affine in the activation: at rest they tell what is passive and what one would add.
    rest = LAWS[asked.law](muscles, length, rate, np.zeros_like(length))
    passive = -(rest.passive[:, None] @ jacobian)[:, 0]
    capacity = -jacobian.swapaxes(1, 2) * rest.d_activation[:, None]

    demand, loads = np.empty((len(q), len(rows))), np.empty((len(q), len(ARMS), 3))
    for k in range(len(q)):
        torque = pin.rnea(model, data, q[k], v[k], a[k])
        loads[k] = _hand_loads(shown.body, data, q[k], v[k], torque, problem, asked)
        demand[k] = torque[rows]
        for side, force in zip(ARMS, loads[k], strict=True):
            if force.any():
                reach = _jacobian(shown.body, data, q[k], f"grip_{side[0]}")[:3, rows]
                demand[k] -= reach.T @ force
    resting = set(ARMS) - set(_working(problem, asked))
    for side in resting:
        demand[:, ARMS[side][1]] = passive[:, ARMS[side][1]]

    by_arm: list[list[Recruitment]] = []
    for side, (here, joints) in ARMS.items():
        own = np.ascontiguousarray(capacity[:, joints, here])
        asked_of = (demand - passive)[:, joints]
        arm: list[Recruitment] = []
        for k in range(len(q)):
            arm.append(
                recruit(
                    own[k],
                    asked_of[k],
                    None if weights is None else weights[here],
                    level=0.0 if side in resting else asked.co_contraction,
                    evenly=asked.cost == "fatigue",
                    start=arm[-1] if arm else None,
                )
            )
        by_arm.append(arm)
    recruitments = tuple(zip(*by_arm, strict=True))
    activation = _both([[r.activation for r in arms] for arms in recruitments])
    return Activity(
        shown=shown,
        asked=asked,
        muscles=muscles,
        paths=paths,
        length=length,
        rate=rate,
        force=rest.passive + activation * rest.d_activation,
        demand=demand,
        passive=passive,
        hand_force=loads,
        recruitments=recruitments,
        outside=tuple(dict.fromkeys(dof for each in q for dof in paths.outside(each))),
    )


def _working(problem: Problem, asked: ActivationBlock) -> tuple[str, ...]:
    holding = {task.side for task in problem.task if isinstance(task, Hand)} | set(asked.hand_force)
    return tuple(side for side in ARMS if side in holding)


def _both(arms: Sequence[Sequence[Array]]) -> Array:
    """Right and left arm's arrays at each instant, side by side, (T, right + left)."""
    return np.array([np.concatenate(pair) for pair in arms])


def _part(muscles: Muscles, here: slice) -> Muscles:
    """The muscles of one arm."""
    parts = {field.name: getattr(muscles, field.name)[here] for field in fields(muscles)}
    return Muscles(**parts)


def _hand_loads(
    body: Body,
    data: pin.Data,
    q: Array,
    v: Array,
    torque: Array,
    problem: Problem,
    asked: ActivationBlock,
) -> Array:
    """Force on the right and the left hand, (2, 3), N: as given, and of levers that follow."""
    loads = np.zeros((len(ARMS), 3))
    for side, force in asked.hand_force.items():
        loads[list(ARMS).index(side)] = force
    for task in problem.task:
        if not isinstance(task, Hand) or task.lever is None:
            continue
        if not problem.lever[task.lever].follows:
            continue
        name = f"lever_{task.lever}"
        rows = [i for i, dof in enumerate(body.dofs) if dof.startswith(f"{name}_")]
        springs = body.stiffness[rows] * (q - body.q_reference)[rows]
        needed = torque[rows] + springs + body.damping[rows] * v[rows]
        jacobian = _jacobian(body, data, q, f"{name}_grip")[:3, rows]
        loads[list(ARMS).index(task.side)] -= np.linalg.pinv(jacobian.T) @ needed
    return loads


def _jacobian(body: Body, data: pin.Data, q: Array, frame: str) -> Array:
    """Jacobian (6, n) of a frame, linear above angular, in the world's axes at the frame."""
    model = body.model
    jacobian: Array = pin.computeFrameJacobian(
        model, data, q, model.getFrameId(frame), pin.LOCAL_WORLD_ALIGNED
    )
    return jacobian


def _bearing(
    body: Body, data: pin.Data, q: Array, jacobian: Array, rows: npt.NDArray[np.intp], load: Array
) -> Array:
    """What weight and the hand's load add to the stiffness of an arm, (7, 7), N m/rad.

    d(h - Jᵀ F)/dq, with d²p/dq_i dq_j = w_i x dp/dq_j for i inside j.
    """
    weight = pin.computeGeneralizedGravityDerivatives(body.model, data, q)[np.ix_(rows, rows)]
    linear, angular = jacobian[:3, rows], jacobian[3:, rows]
    bends = np.triu(np.cross(angular.T[:, None], linear.T[None]) @ load)
    stiffness: Array = weight - bends - np.triu(bends, 1).T
    return stiffness
