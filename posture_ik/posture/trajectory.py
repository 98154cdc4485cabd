"""A motion found by optimal control, with the torques that drive it and its own certificate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import xarray as xr
from scipy.integrate import solve_ivp

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.errors import PostureIKError
from posture_ik.posture.actuators import Actuators
from posture_ik.posture.collocation import DEGREE, radau
from posture_ik.posture.result import Posture
from posture_ik.posture.statement import Statement
from posture_ik.problem import Problem

#: Relative and absolute tolerance of the integration that checks a trajectory.
_INTEGRATION = 1e-10


#: What a file tells of a trajectory beside its courses.
_TOLD = ("cost", "status", "iterations", "primal", "dual", "defect", "overshoot", "end_error")


class InfeasibleReach(PostureIKError):
    """The tasks at the end can be met, but no motion to them was found."""

    def __init__(self, why: str) -> None:
        super().__init__(f"no motion to the tasks was found: {why}.")


@dataclass(frozen=True, eq=False)
class Limb:
    """The joints of a body that move, in the model's order, while all others stay as they are.

    Attributes:
        statement: the whole body, the problem, and the tasks met from the start.
        joints: names of the n that move; `rows` tells which they are.
        start: configuration of the whole at the start, (nq,).
        part: the body with all other joints fixed, n degrees of freedom, and its springs; without
            these where actuators drive it.
    """

    statement: Statement
    joints: tuple[str, ...]
    rows: tuple[int, ...]
    start: Array
    part: Body

    @classmethod
    def of(cls, statement: Statement, joints: tuple[str, ...], start: Array) -> Limb:
        """Fix all joints of a body but some."""
        body = statement.body
        rows = [body.dofs.index(joint) for joint in joints]
        fixed = [i for i in range(1, body.model.njoints) if i - 1 not in rows]
        part = replace(
            body,
            model=pin.buildReducedModel(body.model, fixed, start),
            stiffness=statement.stiffness[rows],
            damping=body.damping[rows],
            q_reference=statement.q_ergo[rows],
        )
        return cls(statement, joints, tuple(rows), start, part)


class Sample(NamedTuple):
    """A trajectory at some times: positions, velocities, accelerations and torques, (k, n).

    And the actuators' controls as `Trajectory` has them, (k, ...).
    """

    q: Array
    v: Array
    a: Array
    tau: Array
    controls: Array


class Round(NamedTuple):
    """One solve on the way to a fine enough mesh; see `Trajectory` for the numbers."""

    intervals: int
    iterations: int
    cost: float
    duration: float
    defect: float
    overshoot: float


@dataclass(frozen=True)
class Trajectory:
    """A motion from rest to rest. Arrays run over the n joints that move, in the model's order.

    On each interval q and v are the polynomials through its start and its Radau points, tau and a
    those through the points alone.

    Attributes:
        limb: who moves, and which joints.
        mesh: lengths of the intervals as shares of the duration, (k,).
        time: 0, then every collocation point, (p,), s.
        q, v, a: (p, n), m or rad, and per s, per s².
        tau: (p, n), N or N m, net of springs and dampers: what muscles supply.
        actuators: what drives the joints; None where they move at will.
        controls: activations of the actuators, reserve torques beside them, N m, and where
            activations lag their rates, 1/s; (p, m + n) or (p, m + n + m), none without actuators.
        cost: what was minimised.
        status, iterations: of IPOPT, on the last mesh.
        primal: largest overrun of an equation or limit at the points; `dual`: largest component
            of the Lagrangian's gradient; both as IPOPT left them, recomputed.
        defect: largest distance, in position or in speed times the interval's length (m, rad),
            between the end of an interval and where Pinocchio's forward dynamics under tau,
            integrated by LSODA from its beginning, arrives.
        overshoot: largest overrun of a limit between the points, as a share of the limit (of the
            range, for positions).
        end_error: largest miss of a task at the end (m, rad) when tau is integrated open loop
            from the start.
        rounds: the meshes tried, the last being this one's.
    """

    limb: Limb
    mesh: Array
    time: Array
    q: Array
    v: Array
    a: Array
    tau: Array
    actuators: Actuators | None
    controls: Array
    cost: float
    status: str
    iterations: int
    primal: float
    dual: float
    defect: float
    overshoot: float
    end_error: float
    rounds: tuple[Round, ...]

    @property
    def problem(self) -> Problem:
        """What was asked."""
        return self.limb.statement.problem

    @property
    def body(self) -> Body:
        """Who moves."""
        return self.limb.statement.body

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.time[-1])

    @property
    def effort(self) -> float:
        """∫ Σ tau² dt, (N m)² s, by the points' own quadrature."""
        weights = self.duration * np.kron(self.mesh, radau()[1][-1])
        return float(weights @ np.sum(self.tau[1:] ** 2, axis=1))

    @property
    def activation(self) -> Array:
        """Of the actuators, (p, m), 0 to 1; what is read back to the start is kept within."""
        return np.clip(self.controls[:, : self._count], 0.0, 1.0)

    @property
    def reserve(self) -> Array:
        """Torques beside the actuators', (p, n), N m: next to nothing where these suffice."""
        return self.controls[:, self._count : self._count + len(self.limb.joints)]

    @property
    def excitation(self) -> Array:
        """What drives the activations, (p, m), 0 to 1: these themselves where they do not lag."""
        lag = self.actuators.lag if self.actuators else None
        if lag is None:
            return self.activation
        rate = self.controls[:, -self._count :]
        return np.clip(self.activation + np.where(rate > 0, *lag) * rate, 0.0, 1.0)

    @property
    def imbalance(self) -> float:
        """Largest torque, N m, between Pinocchio's inverse dynamics and actuators with reserve.

        Zero without actuators; else at the points, the actuators' torque not by the graph.
        """
        if self.actuators is None:
            return 0.0
        model, data = self.limb.part.model, self.limb.part.model.createData()
        left = [
            pin.rnea(model, data, q, v, a) - self.actuators.torque_at(q, v, activation) - reserve
            for q, v, a, activation, reserve in zip(
                self.q[1:], self.v[1:], self.a[1:], self.activation[1:], self.reserve[1:],
                strict=True,
            )
        ]  # fmt: skip
        return float(np.max(np.abs(left)))

    @property
    def _count(self) -> int:
        return len(self.actuators.names) if self.actuators else 0

    def at(self, times: Array) -> Sample:
        """Interpolate at times (k,), s, from 0 to the duration."""
        edges = self.duration * np.append(0.0, np.cumsum(self.mesh))
        which = np.clip(np.searchsorted(edges, times, side="left") - 1, 0, len(self.mesh) - 1)
        share = (times - edges[which]) / (self.duration * self.mesh[which])
        rows = DEGREE * which[:, None] + np.arange(DEGREE + 1)
        points = radau()[0]
        with_start = _lagrange(np.append(0.0, points), share)
        without = _lagrange(points, share)
        q, v = ((with_start[:, None] @ each[rows])[:, 0] for each in (self.q, self.v))
        a, tau, controls = (
            (without[:, None] @ each[rows[:, 1:]])[:, 0]
            for each in (self.a, self.tau, self.controls)
        )
        return Sample(q, v, a, tau, controls)

    def configurations(self, times: Array) -> Array:
        """Configurations of the whole body, (k, nq), the joints at rest included."""
        whole = np.tile(self.limb.start, (len(times), 1))
        whole[:, self.limb.rows] = self.at(times).q
        return whole

    def postures(self, times: Array) -> tuple[Posture, ...]:
        """The whole body at times, with its springs' strain; what holds it firm is not computed."""
        statement = self.limb.statement
        free = np.zeros(statement.rows), np.zeros(len(statement.stiffness))
        return tuple(
            Posture(statement, q, *free, iterations=0, status="on the way", seconds=0.0)
            for q in self.configurations(times)
        )

    def arrive(self, interval: int, state: Array) -> Array:
        """Integrate tau over one interval with Pinocchio's `aba` and LSODA.

        Args:
            interval: which, from 0.
            state: q and v at its beginning, (2 n,).

        Returns:
            q and v at its end, (2 n,).
        """
        length = self.duration * self.mesh[interval]
        part = self.limb.part
        model, data = part.model, part.model.createData()
        rows = slice(DEGREE * interval + 1, DEGREE * (interval + 1) + 1)
        powers = np.linalg.solve(np.vander(radau()[0]), self.tau[rows])
        n, exponents = len(self.limb.joints), np.arange(DEGREE)[::-1]

        def drive(time: float, q: Array, v: Array) -> Array:
            passive = part.stiffness * (q - part.q_reference) + part.damping * v
            net: Array = (time / length) ** exponents @ powers - passive
            return net

        def rate(time: float, state: Array) -> Array:
            q, v = state[:n], state[n:]
            return np.concatenate([v, pin.aba(model, data, q, v, drive(time, q, v))])

        def slope(time: float, state: Array) -> Array:
            q, v = state[:n], state[n:]
            pin.computeABADerivatives(model, data, q, v, drive(time, q, v))
            upper = np.triu(data.Minv)
            inverse = upper + np.triu(upper, 1).T
            by_q, by_v = (
                data.ddq_dq - inverse * part.stiffness,
                data.ddq_dv - inverse * part.damping,
            )
            return np.block([[np.zeros((n, n)), np.eye(n)], [by_q, by_v]])

        # Dampers of light joints make it stiff.
        accuracy = {"rtol": _INTEGRATION, "atol": _INTEGRATION}
        found = solve_ivp(rate, (0.0, length), state, "LSODA", jac=slope, **accuracy)
        end: Array = found.y[:, -1]
        return end

    def defects(self) -> Array:
        """The defect of every interval, (k,), m or rad."""
        states = np.hstack([self.q, self.v])[::DEGREE]
        missed = [np.abs(self.arrive(k, states[k]) - states[k + 1]) for k in range(len(self.mesh))]
        position, speed = np.split(np.array(missed), 2, axis=1)
        lengths = self.duration * self.mesh
        worst: Array = np.maximum(position.max(axis=1), speed.max(axis=1) * lengths)
        return worst

    def shoot(self) -> Array:
        """Integrate tau open loop: q and v at every edge of the mesh, (k + 1, 2 n)."""
        states = [np.append(self.q[0], self.v[0])]
        for k in range(len(self.mesh)):
            states.append(self.arrive(k, states[-1]))
        return np.array(states)

    def to_dataset(self) -> xr.Dataset:
        """Everything that a reader of `trajectory.nc` needs, named and with units."""

        def named(values: Array, unit: str, name: str) -> object:
            return (("time", "dof"), values, {"units": unit, "long_name": name})

        return xr.Dataset(
            {
                "q": named(self.q, "m or rad", "configuration"),
                "v": named(self.v, "m/s or rad/s", "velocity"),
                "a": named(self.a, "m/s2 or rad/s2", "acceleration"),
                "tau": named(self.tau, "N or N m", "supplied beyond springs and dampers"),
                **self._driven(),
                "start": ("joint", self.limb.start, {"units": "m or rad", "long_name": "start"}),
                "mesh": ("interval", self.mesh, {"long_name": "shares of the duration"}),
                **{
                    f"round_{name}": ("round", np.array(values))
                    for name, values in zip(
                        Round._fields, zip(*self.rounds, strict=True), strict=True
                    )
                },
            },
            coords={
                "time": ("time", self.time, {"units": "s"}),
                "dof": list(self.limb.joints),
                **({"muscle": list(self.actuators.names)} if self.actuators else {}),
                "joint": list(self.body.dofs),
            },
            attrs={
                "title": self.problem.title,
                "duration": self.duration,
                "effort": self.effort,
                **{name: getattr(self, name) for name in _TOLD},
                **({"imbalance": self.imbalance} if self.actuators else {}),
            },
        )

    def _driven(self) -> dict[str, object]:
        """What actuators do, for the file."""
        if self.actuators is None:
            return {}
        muscle = ("time", "muscle")
        told: dict[str, object] = {
            "activation": (muscle, self.activation, {"units": "1", "long_name": "activation"}),
            "reserve": (
                ("time", "dof"),
                self.reserve,
                {"units": "N m", "long_name": "torque beside the muscles'"},
            ),
        }
        if self.actuators.lag:
            named = {"units": "1", "long_name": "excitation"}
            told["excitation"] = (muscle, self.excitation, named)
        return told


def _lagrange(nodes: Array, at: Array) -> Array:
    """Values (k, m) of the m Lagrange polynomials of some nodes at k places."""
    basis = np.ones((len(at), len(nodes)))
    for i, node in enumerate(nodes):
        for other in np.delete(nodes, i):
            basis[:, i] *= (at - other) / (node - other)
    return basis
