"""A problem posed on a body: the program to minimise and all its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.levers import with_levers
from posture_ik.errors import BadProblem, nearest
from posture_ik.kinematics import Kinematics, frame_poses
from posture_ik.posture.program import Program
from posture_ik.posture.tasks import Constraint, constraints_of
from posture_ik.problem import PostureBlock, Problem, with_numbers

#: The dummy springs of `stiffness = "uniform"`: one for every turn, one for every stretch.
UNIFORM_TURN, UNIFORM_STRETCH = 500.0, 1.0e6  # N m/rad, N/m


class _Reference(NamedTuple):
    """What every problem on a body begins with: its twin, the twin's numbers, and its shape."""

    kinematics: Kinematics
    numbers: Array
    frames: Mapping[str, pin.SE3]

    @classmethod
    def of(cls, body: Body) -> _Reference:
        twin = Kinematics.of(body.model)
        frames = frame_poses(body.model, body.q_reference)
        return cls(twin, twin.values(body.model), frames)


# Worth keeping: reading a model through Python takes longer than a solve.
_references: WeakKeyDictionary[Body, _Reference] = WeakKeyDictionary()


@dataclass(frozen=True)
class Statement:
    """What a solver is given.

    Attributes:
        constraints: the tasks as equations, in the order asked; `rows` of them in all.
        program: the symbolic program they share with every body of the same structure.
        stiffness, q_ergo: ergonomic springs K and where they rest, (n,), N/m or N m/rad; m or rad.
        parameters: the program's numbers p.
    """

    body: Body
    problem: Problem
    constraints: tuple[Constraint, ...]
    program: Program
    stiffness: Array
    q_ergo: Array
    parameters: Array

    @classmethod
    def of(cls, body: Body, problem: Problem) -> Statement:
        """Pose a problem on a body, and on the levers of the problem that follow its hands.

        Raises:
            BadProblem: the problem names a link or joint that the body does not have.
        """
        body = with_levers(body, problem.lever)
        if body not in _references:
            _references[body] = _Reference.of(body)
        reference = _references[body]
        constraints = constraints_of(reference.frames, problem)
        stiffness = _stiffness(body, problem.posture)
        q_ergo = _rest(body, problem.posture)
        targets = [constraint.target for constraint in constraints]
        return cls(
            body,
            problem,
            constraints,
            Program.of(reference.kinematics, constraints, problem.posture.gravity),
            stiffness,
            q_ergo,
            np.concatenate([reference.numbers, stiffness, q_ergo, *targets]),
        )

    def along(self, signals: Sequence[str]) -> ca.Function:
        """How the targets follow numbers s of the problem, (k,), named as `--set` names them.

        Returns:
            (s, s', s'') -> targets alpha (t,) of all constraints in order, alpha' and alpha''.
        """
        s, rate, acceleration = (ca.SX.sym(name, len(signals)) for name in ("s", "ds", "dds"))
        numbers = dict(zip(signals, ca.vertsplit(s), strict=True))
        frames = _references[self.body].frames
        moving = constraints_of(frames, with_numbers(self.problem, numbers))
        alpha = ca.SX(ca.vertcat(*[ca.vertcat(*c.target) for c in moving]))
        moved = ca.jtimes(alpha, s, rate)
        bent = ca.jtimes(moved, s, rate) + ca.jtimes(alpha, s, acceleration)
        return ca.Function("along", [s, rate, acceleration], [alpha, moved, bent])

    def at(self, problem: Problem, targets: Array) -> Statement:
        """The same statement with other numbers in the problem, and the targets these make."""
        ends = np.cumsum([constraint.target.size for constraint in self.constraints])
        parts = np.split(targets, ends[:-1])
        stiffness = _stiffness(self.body, problem.posture)
        numbers = self.parameters[: -len(stiffness) - len(self.q_ergo) - len(targets)]
        return replace(
            self,
            problem=problem,
            constraints=tuple(
                replace(c, target=part) for c, part in zip(self.constraints, parts, strict=True)
            ),
            stiffness=stiffness,
            parameters=np.concatenate([numbers, stiffness, self.q_ergo, targets]),
        )

    @property
    def rows(self) -> int:
        """Number m of equations and one-sided conditions."""
        return sum(len(constraint.rows) for constraint in self.constraints)

    @property
    def scale(self) -> Array:
        """K^½ (n,): the program's x is this times the displacement from rest."""
        return np.sqrt(self.stiffness)

    def x_of(self, q: Array) -> Array:
        """The program's coordinates of a configuration, (n,), √J."""
        return self.scale * (q - self.q_ergo)


def _stiffness(body: Body, block: PostureBlock) -> Array:
    if block.stiffness == "tissue":
        return body.stiffness
    if block.stiffness == "uniform":
        slides = [name.endswith("_axial") for name in body.dofs]
        levers = [name.startswith("lever_") for name in body.dofs]
        dummies = np.where(slides, UNIFORM_STRETCH, UNIFORM_TURN)
        return np.where(levers, body.stiffness, dummies)
    stiffness = body.stiffness.copy()
    for joint, value in block.stiffness.items():
        if joint not in body.dofs:
            raise BadProblem(
                f"posture.stiffness.{joint}", f"no such joint; {nearest(joint, body.dofs)}"
            )
        stiffness[body.dofs.index(joint)] = value
    return stiffness


def _rest(body: Body, block: PostureBlock) -> Array:
    """Where the springs rest: the reference shape, or the middle of the range (eq 17)."""
    if block.ergonomic == "reference":
        return body.q_reference
    middle: Array = (body.lower + body.upper) / 2
    return middle
