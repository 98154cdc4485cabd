"""The posture found, with everything that holds it and its own certificate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import xarray as xr
from scipy.linalg import eigh, eigvalsh, qr

from posture_ik.arrays import Array, call
from posture_ik.body import Body
from posture_ik.kinematics import data_of, frame_poses, weightless
from posture_ik.posture.pieces import ActiveLimit, Certificate, Prestrain, Wrench
from posture_ik.posture.projection import implied
from posture_ik.posture.statement import Statement
from posture_ik.posture.tasks import Constraint, handle_of
from posture_ik.problem import Problem

#: A limit or a contact counts as active where it carries more than this share of the largest
#: scaled spring force: well above the solver's 1e-11, well below anything that matters.
_ACTIVE = 1e-6


@dataclass(frozen=True)
class Posture:
    """A posture of least energy under tasks.

    Attributes:
        statement: what was solved: body, problem, constraints and their numbers.
        q: configuration, (n,), rad and m.
        multipliers: lambda of each row of the constraints, (m,), N or N m: a constraint pushes
            its coordinate with -lambda. For one-sided rows lambda <= 0.
        limit_multipliers: mu of each joint limit, (n,), N or N m; positive at an upper limit,
            negative at a lower one; the limit pushes with -mu.
        iterations, status, seconds: of the solve, once its equations are built.
    """

    statement: Statement
    q: Array
    multipliers: Array
    limit_multipliers: Array
    iterations: int
    status: str
    seconds: float

    @property
    def body(self) -> Body:
        """Who sits."""
        return self.statement.body

    @property
    def problem(self) -> Problem:
        """What was asked."""
        return self.statement.problem

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The tasks as equations, in the order asked."""
        return self.statement.constraints

    # Springs

    @property
    def q_ergo(self) -> Array:
        """Where the springs rest, (n,), m or rad."""
        return self.statement.q_ergo

    @property
    def stiffness(self) -> Array:
        """Ergonomic springs K, (n,), N/m or N m/rad."""
        return self.statement.stiffness

    @property
    def displacement(self) -> Array:
        """Relative displacement of each joint from rest, local frame, (n,), m or rad."""
        return self.q - self.q_ergo

    @property
    def prestrain_force(self) -> Array:
        """Force each spring exerts along its own coordinate, -K (q - q_ergo), (n,), N or N m."""
        return -self.stiffness * self.displacement

    @property
    def prestrain(self) -> Prestrain:
        """What every spring is displaced by and exerts, in its joint's own frame."""
        return Prestrain(self.displacement, self.prestrain_force)

    @property
    def energies(self) -> Array:
        """Strain energy of each spring, (n,), J."""
        return self.stiffness * self.displacement**2 / 2

    @property
    def elastic_energy(self) -> float:
        """Strain energy of all springs, J (eq 16, corrected)."""
        return float(self.energies.sum())

    @property
    def gravity_energy(self) -> float:
        """Potential of the weight above the seat, J; 0 where gravity is not counted."""
        return float(self._evaluated[4].item())

    @property
    def energy(self) -> float:
        """What is minimal: strain energy, and the weight's potential where gravity is counted."""
        return self.elastic_energy + self.gravity_energy

    # Frames and forces

    @cached_property
    def frames(self) -> dict[str, pin.SE3]:
        """Pose of every link in the world, by name."""
        return frame_poses(self.body.model, self.q)

    @property
    def levers(self) -> dict[str, pin.SE3]:
        """Pose of the handle of each of the problem's levers in the world, by the lever's name."""
        return {
            name: self.frames[f"lever_{name}_grip"] if lever.follows else pin.SE3(*handle_of(lever))
            for name, lever in self.problem.lever.items()
        }

    @cached_property
    def wrenches(self) -> tuple[Wrench, ...]:
        """Resultant of each task on the person, at the frame held or the mean of those held."""
        parts = self.frame_wrenches
        wrenches = []
        start = 0
        for constraint in self.constraints:
            stop = start + constraint.person_frames
            forces, moments, points = parts[start:stop].transpose(1, 0, 2)
            point = points.mean(axis=0)
            moment = moments.sum(axis=0) + np.cross(points - point, forces).sum(axis=0)
            wrenches.append(Wrench(constraint.label, forces.sum(axis=0), moment, point))
            start += len(constraint.frames)
        return tuple(wrenches)

    @cached_property
    def contacts(self) -> tuple[Wrench, ...]:
        """Force of the backrest on each vertebra that touches it, where contact is one-sided."""
        contacts = []
        row = start = 0
        for constraint in self.constraints:
            for k, frame in enumerate(constraint.frames):
                if constraint.one_sided and -self.multipliers[row + k] > _ACTIVE:
                    contacts.append(Wrench(frame, *self.frame_wrenches[start + k]))
            row += len(constraint.rows)
            start += len(constraint.frames)
        return tuple(contacts)

    @cached_property
    def seat(self) -> Wrench:
        """What the seat does to the person at the origin: springs, and what they leave rigid.

        Pinocchio's static inverse dynamics under the tasks' forces, and weight if counted.
        """
        weighs = self.problem.posture.gravity
        model = self.body.model if weighs else weightless(self.body.model)
        data = data_of(model)
        pin.framesForwardKinematics(model, data, self.q)
        outer = [pin.Force.Zero() for _ in range(model.njoints)]
        names = [frame for constraint in self.constraints for frame in constraint.frames]
        for name, (force, moment, point) in zip(names, self.frame_wrenches, strict=True):
            joint = model.frames[model.getFrameId(name)].parentJoint
            wrench = pin.SE3(np.eye(3), point).act(pin.Force(force, moment))
            outer[joint] += data.oMi[joint].actInv(wrench)
        rest = np.zeros(model.nv)
        pin.rnea(model, data, self.q, rest, rest, outer)
        root = data.oMi[1].act(data.f[1])
        return Wrench("seat", root.linear, root.angular, np.zeros(3))

    @property
    def active_limits(self) -> tuple[ActiveLimit, ...]:
        """Joints held by their limits, hardest pressed first in the springs' norm."""
        press = np.abs(self.limit_multipliers) / self.statement.scale
        order = [i for i in np.argsort(-press) if self.at_limit[i]]
        return tuple(
            ActiveLimit(
                self.body.dofs[i],
                "upper" if self.limit_multipliers[i] > 0 else "lower",
                float(self.q[i]),
                float(abs(self.limit_multipliers[i])),
            )
            for i in order
        )

    # Certificate

    def residuals(self) -> dict[str, Array]:
        """Miss of every equation by task, m or rad; for one-sided rows the overrun."""
        ends = np.cumsum([len(constraint.rows) for constraint in self.constraints])
        rows = np.split(self.misses, ends[:-1])
        return {c.label: row for c, row in zip(self.constraints, rows, strict=True)}

    def primal_residual(self) -> float:
        """Largest miss of a task or overrun of a joint limit, m or rad."""
        over = np.maximum(self.body.lower - self.q, self.q - self.body.upper)
        return float(max(np.max(np.abs(self.misses)), np.max(over), 0.0))

    def dual_residual(self) -> float:
        """Largest component of the projected gradient, relative, in the springs' norm.

        The gradient of the Lagrangian with the limits' multipliers, scaled by K^-½, over the
        largest scaled spring force or 1 √J, whichever is more.
        """
        gradient = self._evaluated[2] + self.limit_multipliers / self.statement.scale
        return float(np.max(np.abs(gradient)) / self._spring_force)

    def reduced_curvature(self) -> float:
        """Least eigenvalue of the Hessian on the directions left free, in the springs' norm.

        Second-order condition: above zero, the posture is a strict local minimum.
        """
        reduced, _ = self._reduced_hessian()
        if len(reduced) == 0:
            return np.inf
        return float(eigvalsh(reduced, subset_by_index=[0, 0])[0])

    def _reduced_hessian(self) -> tuple[Array, Array]:
        """Hessian in x on the free directions, (k, k), and their basis (free dofs, k)."""
        free = ~self.at_limit
        hessian = self._evaluated[3][np.ix_(free, free)]
        rows = self._held_rows[:, free]
        orthogonal, triangle, _ = qr(rows.T, pivoting=True)
        pivots = np.abs(np.diag(triangle))
        rank = int(np.sum(pivots > 1e-10 * pivots.max(initial=0.0)))
        basis = orthogonal[:, rank:]
        return basis.T @ hessian @ basis, basis

    def downhill(self) -> Array | None:
        """A step in x (n,) that lowers the energy to second order, where the posture is a saddle.

        None at a minimum: a Cholesky factor of the reduced Hessian exists.
        """
        reduced, basis = self._reduced_hessian()
        try:
            np.linalg.cholesky(reduced)
        except np.linalg.LinAlgError:
            step = np.zeros(len(self.q))
            step[~self.at_limit] = basis @ eigh(reduced, subset_by_index=[0, 0])[1][:, 0]
            return step
        return None

    @cached_property
    def certificate(self) -> Certificate:
        """All of the above in one, with the rank of the equations that hold."""
        rows = self._held_rows[:, ~self.at_limit]
        return Certificate(
            self.primal_residual(),
            self.dual_residual(),
            self.reduced_curvature(),
            int(np.linalg.matrix_rank(rows)) if rows.size else 0,
            len(rows),
        )

    @property
    def redundant(self) -> tuple[str, ...]:
        """Equations that others imply, by name: what holds there may be shared in any way."""
        names = [f"{c.label} {row}" for c in self.constraints for row in c.rows]
        held = [name for name, holds in zip(names, self._holding, strict=True) if holds]
        return tuple(held[i] for i in implied(self._held_rows[:, ~self.at_limit]))

    def overturned(self) -> bool:
        """Whether a frame held in all angles is more than a quarter turn from its target."""
        statement = self.statement
        (away,) = call(statement.program.overturn, self.q, statement.parameters)
        return bool(np.any(away > 1.0))

    # To a file

    def to_dataset(self) -> xr.Dataset:
        """Everything that a reader of `posture.nc` needs, named and with units."""
        labels = [f"{c.label} {row}" for c in self.constraints for row in c.rows]
        angular = [row.startswith("r") for c in self.constraints for row in c.rows]
        wrenches = (*self.wrenches, self.seat)
        per_dof = "m or rad, as in `unit`"
        per_dof_force = "N or N m, as in `unit`"

        def named(dims: str | tuple[str, ...], values: object, unit: str, name: str) -> object:
            return (dims, values, {"units": unit, "long_name": name})

        certificate = self.certificate
        return xr.Dataset(
            {
                "q": named("dof", self.q, per_dof, "configuration"),
                "q_ergo": named("dof", self.q_ergo, per_dof, "configuration at rest"),
                "lower": named("dof", self.body.lower, per_dof, "lower joint limit"),
                "upper": named("dof", self.body.upper, per_dof, "upper joint limit"),
                "stiffness": named("dof", self.stiffness, "N/m or N m/rad", "ergonomic spring"),
                "displacement": named("dof", self.displacement, per_dof, "relative displacement"),
                "prestrain_force": named(
                    "dof", self.prestrain_force, per_dof_force, "spring force"
                ),
                "energy_by_dof": named("dof", self.energies, "J", "strain energy"),
                "limit_multiplier": named(
                    "dof", self.limit_multipliers, per_dof_force, "limit load"
                ),
                "unit": ("dof", ["m" if d.endswith("_axial") else "rad" for d in self.body.dofs]),
                "residual": named("constraint", self.misses, "m or rad", "miss of the task"),
                "multiplier": named("constraint", self.multipliers, "N or N m", "multiplier"),
                "constraint_unit": ("constraint", ["rad" if turn else "m" for turn in angular]),
                "force": named(("task", "axis"), [w.force for w in wrenches], "N", "on the person"),
                "moment": named(
                    ("task", "axis"), [w.moment for w in wrenches], "N m", "on the person"
                ),
                "point": named(
                    ("task", "axis"), [w.point for w in wrenches], "m", "where the force acts"
                ),
            },
            coords={
                "dof": list(self.body.dofs),
                "constraint": labels,
                "task": [wrench.label for wrench in wrenches],
                "axis": ["x", "y", "z"],
            },
            attrs={
                "title": self.problem.title,
                "energy": self.energy,
                "elastic_energy": self.elastic_energy,
                "gravity_energy": self.gravity_energy,
                "kkt_residual": max(certificate.primal, certificate.dual),
                "primal_residual": certificate.primal,
                "dual_residual": certificate.dual,
                "reduced_curvature": certificate.curvature,
                "redundant": ", ".join(self.redundant),
                "status": self.status,
                "iterations": self.iterations,
                "seconds": self.seconds,
            },
        )

    # What the certificate and the forces are made of

    @cached_property
    def _evaluated(self) -> tuple[Array, ...]:
        """Residual (m,), its Jacobian (m, n), gradient (n,), Hessian (n, n) in x; potential."""
        statement = self.statement
        return tuple(
            call(statement.program.evaluate, self.q, statement.parameters, self.multipliers)
        )

    @cached_property
    def misses(self) -> Array:
        """Miss of every row, (m,), m or rad; of one-sided rows the overrun."""
        statement = self.statement
        (residual,) = call(statement.program.residual, self.q, statement.parameters)
        over = np.minimum(residual, 0.0)
        missed: Array = np.where(statement.program.one_sided, over, residual)
        return missed

    @cached_property
    def frame_wrenches(self) -> Array:
        """Force, moment and point of each constraint on each frame it holds, (frames, 3, 3)."""
        weights = np.append(self.multipliers, 1.0)
        (parts,) = call(self.statement.program.wrenches, self.q, self.statement.parameters, weights)
        wrenches: Array = parts.T.reshape(-1, 3, 3)
        return wrenches

    @property
    def _spring_force(self) -> float:
        return max(1.0, float(np.max(np.abs(self.prestrain_force) / self.statement.scale)))

    @cached_property
    def at_limit(self) -> npt.NDArray[np.bool_]:
        """Which degrees of freedom press against a limit, (n,)."""
        press = np.abs(self.limit_multipliers) / self.statement.scale
        return press > _ACTIVE * self._spring_force

    @property
    def _holding(self) -> npt.NDArray[np.bool_]:
        """Which rows hold: the equations and the contacts that carry load, (m,)."""
        holding: npt.NDArray[np.bool_] = ~self.statement.program.one_sided | (
            np.abs(self.multipliers) > _ACTIVE
        )
        return holding

    @property
    def _held_rows(self) -> Array:
        """Jacobian in x of the rows that hold, (held, n)."""
        return self._evaluated[1][self._holding]
