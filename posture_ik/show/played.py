"""What moves, as pages show it: a motion as it is, a trajectory at even steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.posture import Motion, Posture, Trajectory
from posture_ik.problem import Problem

#: Steps a second of a trajectory, and the least and most in all.
_A_SECOND, _LEAST, _MOST = 240.0, 120, 600


class Moving(Protocol):
    """What pages ask of whatever moves: T even steps, n degrees of freedom, k places of forces.

    The names are those of `posture_ik.Motion`, which is one.
    """

    @property
    def problem(self) -> Problem:
        """What was asked."""

    @property
    def body(self) -> Body:
        """Who moves."""

    @property
    def postures(self) -> tuple[Posture, ...]:
        """The posture of every step."""

    @property
    def time(self) -> Array:
        """(T,), s."""

    @property
    def q(self) -> Array:
        """(T, n), m or rad."""

    @property
    def v(self) -> Array:
        """(T, n), m/s or rad/s."""

    @property
    def tau(self) -> Array:
        """(T, n), beyond springs and dampers, N or N m."""

    @property
    def wrench_labels(self) -> tuple[str, ...]:
        """Where forces act on the person."""

    @property
    def forces(self) -> Array:
        """(T, k, 3), N."""

    @property
    def moments(self) -> Array:
        """(T, k, 3), N m."""

    @property
    def points(self) -> Array:
        """(T, k, 3), m."""


@dataclass(frozen=True)
class Sampled:
    """A trajectory of some joints as that of the whole body; what holds the rest is not known."""

    problem: Problem
    body: Body
    postures: tuple[Posture, ...]
    time: Array
    q: Array
    v: Array
    tau: Array
    wrench_labels: tuple[str, ...]
    forces: Array
    moments: Array
    points: Array

    @classmethod
    def of(cls, trajectory: Trajectory) -> Sampled:
        """Look at a trajectory at even steps."""
        count = int(np.clip(_A_SECOND * trajectory.duration, _LEAST, _MOST))
        time = np.linspace(0.0, trajectory.duration, count + 1)
        sample = trajectory.at(time)
        v, tau = np.zeros((2, len(time), len(trajectory.body.dofs)))
        v[:, trajectory.limb.rows], tau[:, trajectory.limb.rows] = sample.v, sample.tau
        nothing = np.zeros((len(time), 0, 3))
        return cls(
            problem=trajectory.problem,
            body=trajectory.body,
            postures=trajectory.postures(time),
            time=time,
            q=trajectory.configurations(time),
            v=v,
            tau=tau,
            wrench_labels=(),
            forces=nothing,
            moments=nothing,
            points=nothing,
        )


def played(shown: Motion | Trajectory) -> Moving:
    """What a page plays."""
    return shown if isinstance(shown, Motion) else Sampled.of(shown)
