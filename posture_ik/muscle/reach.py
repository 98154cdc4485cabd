"""A reach driven by the muscles of the arms: their activations as its cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.errors import BadProblem
from posture_ik.muscle.activation import recruit
from posture_ik.muscle.hill import LAWS
from posture_ik.muscle.path import Paths, arm_lengths
from posture_ik.muscle.table import Muscles
from posture_ik.posture import control
from posture_ik.posture.actuators import Lag
from posture_ik.posture.trajectory import Limb, Trajectory
from posture_ik.problem import ActivationBlock, Problem

#: Of rise and fall: the defaults of OpenSim's Millard2012EquilibriumMuscle.
_LAG = Lag(rise=0.010, fall=0.040)
#: What a law asks of muscles (`hill.Fibres`).
_FIBRES = ("peak_force", "optimal_length", "slack_length", "pennation", "fastest")


def reach(
    body: Body,
    problem: Problem,
    *,
    start: Array | None = None,
    intervals: int | None = None,
    on_mesh: Callable[[int, int], None] | None = None,
) -> Trajectory:
    """Find the motion of least effort, time or muscle activation that ends at rest on the tasks.

    As `posture_ik.posture.reach`, with the muscles of the arms to drive the joints where the cost
    is "activation": each of 25 a side pulls by Hill's law along its path, and

        minimise  ∫ Σ a² + price Σ reserve² + smoothness Σ q''² dt
        subject to  M q'' + h(q, q') = -Lᵀ f(l, l', a) + reserve,  0 <= a <= 1.

    The springs and dampers of the joints that move help nobody, as in
    `posture_ik.muscle.solve_activation`: they chose the start, and are no tissue. With activation
    dynamics the activations start from those that hold the arm at the start, and change no faster
    than excitations between 0 and 1 make them. Without dampers the motion integrated open loop
    goes astray more easily: for an end to be trusted ask for a tolerance of 1e-6 or less.

    Args:
        body: who.
        problem: with a [trajectory] block; its tasks are what holds at the end. The muscles' law
            is that of its [activation], if there is one.
        start: configuration (nq,) at rest from which to start, found if not given.
        intervals: of the first mesh, chosen if not given.
        on_mesh: told before each solve which it is, from 1, and of how many intervals.

    Raises:
        InfeasiblePosture: the tasks at the start, or those at the end, cannot be met; tells which,
            and by how much they are missed.
        InfeasibleReach: they can, but not by a motion within the limits and the duration.
        BadProblem: the problem has no [trajectory], a name that the body does not have, a start
            that is not allowed, or asks muscles to move a joint that is not an arm's.
        PostureIKError: the cost is "activation", and the body lacks an arm.
    """
    asked = problem.activation or ActivationBlock()
    lag = _LAG if problem.trajectory and problem.trajectory.activation_dynamics else None
    drive = partial(ArmMuscles.of, law=asked.law, lag=lag)
    return control.reach(
        body, problem, start=start, intervals=intervals, on_mesh=on_mesh, drive=drive
    )


@dataclass(frozen=True, eq=False)
class ArmMuscles:
    """The muscles that cross moving joints of the arms, as `posture_ik.posture.actuators` asks.

    Attributes:
        limb: who moves, and which joints.
        paths, muscles: of both arms.
        law: of `posture_ik.muscle.hill`.
        lag: of activation; None where it follows excitation at once.
        columns: place of each moving joint among the 14 of the arms, (n,).
        crossing: which of the 50 muscles cross a moving joint, (m,).
    """

    limb: Limb
    paths: Paths
    muscles: Muscles
    law: str
    lag: Lag | None
    columns: tuple[int, ...]
    crossing: npt.NDArray[np.intp]

    @classmethod
    def of(cls, limb: Limb, *, law: str, lag: Lag | None) -> ArmMuscles:
        """The muscles of a limb.

        Raises:
            BadProblem: a joint that moves is no arm's.
            PostureIKError: the body lacks an arm, or its arms are not those of this package.
        """
        body = limb.statement.body
        paths = Paths.of(body)
        for joint in limb.joints:
            if joint not in paths.dofs:
                raise BadProblem(
                    "trajectory.joints",
                    f"{joint!r} has no muscles to move it; with cost = 'activation' name joints "
                    "of the arms alone",
                )
        columns = tuple(paths.dofs.index(joint) for joint in limb.joints)
        crossed = ca.DM(arm_lengths().sparsity_out(1), 1.0).full()[:, list(columns)]
        crossing = np.flatnonzero(crossed.any(axis=1))
        return cls(limb, paths, Muscles.of(body), law, lag, columns, crossing)

    @property
    def names(self) -> tuple[str, ...]:
        """Such as `DELT1_r`, (m,)."""
        return tuple(self.muscles.names[i] for i in self.crossing)

    @property
    def numbers(self) -> Array:
        """The angles of both arms at the start, their size, and what the law asks."""
        each = [getattr(self.muscles, name) for name in _FIBRES]
        return np.concatenate([self.limb.start[self.paths.rows], [self.paths.scale], *each])

    @cached_property
    def start(self) -> Array:
        """Activations that hold the limb at the start, or come nearest to it, (m,): `recruit`."""
        model, q = self.limb.part.model, self.limb.start[list(self.limb.rows)]
        weight = pin.computeGeneralizedGravity(model, model.createData(), q)
        at_rest = self.torque_at(q, 0 * q, np.zeros(len(self.crossing)))
        each = [self.torque_at(q, 0 * q, unit) - at_rest for unit in np.eye(len(self.crossing))]
        return recruit(np.ascontiguousarray(np.transpose(each)), weight - at_rest).activation

    def structure(self) -> object:
        """What decides the graph of `torque`, and what lags."""
        return ArmMuscles, self.law, self.lag, self.columns

    def torque(self, q: ca.SX, v: ca.SX, activation: ca.SX, numbers: ca.SX) -> ca.SX:
        """Torques (n,), N m: -Lᵀ f by the law's formulas on symbols."""
        count = len(self.muscles.names)
        sizes = [len(self.paths.dofs), 1, *[count] * len(_FIBRES)]
        angles, scale, *fibres = ca.vertsplit(numbers, np.cumsum([0, *sizes]).tolist())
        angles[list(self.columns)] = q
        lengths, slopes = arm_lengths()(angles, scale)
        across, whole = slopes[:, list(self.columns)], ca.SX(count, 1)
        whole[self.crossing.tolist()] = activation
        law: Any = LAWS[self.law]
        of = SimpleNamespace(**dict(zip(_FIBRES, fibres, strict=True)))
        force: ca.SX = law(of, lengths, across @ v, whole, ca).force
        return -across.T @ force

    def torque_at(self, q: Array, v: Array, activation: Array) -> Array:
        """The same of numbers, by `Paths` and the law on arrays."""
        posture, whole = self.limb.start.copy(), np.zeros(len(self.muscles.names))
        posture[list(self.limb.rows)], whole[self.crossing] = q, activation
        lengths, jacobian = self.paths.evaluate(posture)
        across = jacobian[:, list(self.columns)]
        force = LAWS[self.law](self.muscles, lengths, across @ v, whole).force
        torque: Array = -across.T @ force
        return torque
