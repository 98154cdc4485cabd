"""How each stage is to be done: the posture, a motion, the muscles, a reach."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from posture_ik.arrays import Array
from posture_ik.problem.block import Block
from posture_ik.problem.signals import Signal, Table
from posture_ik.problem.tasks import Task, Vector


def _read_stiffness(value: Any) -> Any:
    if value in ("tissue", "uniform"):
        return value
    if isinstance(value, dict):
        for joint, stiffness in value.items():
            number = isinstance(stiffness, (int, float)) and not isinstance(stiffness, bool)
            if not (number and math.isfinite(stiffness) and stiffness > 0.0):
                raise ValueError(f"the stiffness of {joint} must be above zero, not {stiffness!r}")
        return value
    raise ValueError(
        'write "tissue", "uniform" or a table of joints such as { L5_S1_ry = 150.0 } '
        "in N/m or N m/rad"
    )


class PostureBlock(Block):
    """How the posture is found.

    `stiffness`: "tissue" (table 11), "uniform", or a table that replaces the tissue value of the
    joints it names. `ergonomic`: the springs rest in the "reference" shape or in the "middle" of
    the joint ranges (eq 17). `gravity`: count the potential of weight, so that the posture found
    is a static equilibrium.
    """

    stiffness: Annotated[
        Literal["tissue", "uniform"] | dict[str, float], BeforeValidator(_read_stiffness)
    ] = "tissue"
    ergonomic: Literal["reference", "middle"] = "reference"
    gravity: bool = False


class MotionBlock(Block):
    """How long to move (s), how many steps a second, and which numbers of the problem move."""

    duration: float = Field(gt=0.0, le=600.0)
    rate: float = Field(100.0, gt=0.0, le=10_000.0)
    signal: tuple[Signal, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _tables_span_the_motion(self) -> MotionBlock:
        for signal in self.signal:
            if isinstance(signal, Table) and not (
                signal.times[0] <= 0.0 and signal.times[-1] >= self.duration
            ):
                raise ValueError(
                    f"the table of {signal.of} spans {signal.times[0]:g} to "
                    f"{signal.times[-1]:g} s, but the motion 0 to {self.duration:g} s"
                )
        if self.duration * self.rate < 4.0:
            raise ValueError(
                f"{self.duration:g} s at {self.rate:g} steps a second are too few steps for an "
                "acceleration; a motion needs 4 or more"
            )
        return self

    @property
    def times(self) -> Array:
        """Instants of the steps, (T,), s, from 0 up to the duration."""
        return np.arange(int(np.floor(self.duration * self.rate + 1e-9)) + 1) / self.rate


class Reflex(Block):
    """Gains of the stretch reflex (eq 33): activation per optimal length and per top speed."""

    proportional: float = Field(0.0, ge=0.0)
    derivative: float = Field(0.0, ge=0.0)


class ActivationBlock(Block):
    """How the muscles of the arms share the work.

    `law`: of muscle force. `cost`: what is least, the sum of activations squared (eq 32), weighted
    by muscle volume, or the highest activation (fatigue). `co_contraction`: the activation towards
    which all are drawn without changing any torque. `hand_force`: what acts on the right or left
    hand beside a lever that follows it, N, world axes. `short_range`: take the stiffness of
    active muscle from its first few tenths of a per cent of stretch, as vibration finds it.
    """

    law: Literal["pennestri", "de_groote"] = "pennestri"
    cost: Literal["squares", "volume", "fatigue"] = "squares"
    co_contraction: float = Field(0.0, ge=0.0, le=1.0)
    hand_force: dict[Literal["right", "left"], Vector] = Field(default_factory=dict)
    reflex: Reflex = Reflex()
    short_range: bool = False


def _read_per_joint(value: Any) -> Any:
    for joint, number in (value if isinstance(value, dict) else {"": value}).items():
        is_number = isinstance(number, (int, float)) and not isinstance(number, bool)
        if not (is_number and math.isfinite(number) and number > 0.0):
            of = f" for {joint}" if joint else " or a table of joints"
            raise ValueError(f"write a number above zero{of}, not {number!r}")
    return value


PerJoint = Annotated[float | dict[str, float], BeforeValidator(_read_per_joint)]


class TrajectoryBlock(Block):
    """How to reach the tasks from rest, by optimal control.

    The joints that move go from the posture that meets all other tasks to where all tasks are met,
    at rest at both ends.

    `cost`: "effort" for least ∫ Σ (torque / strength)² dt, "time" for the least duration,
    "activation" for least ∫ Σ activation² dt of the arms' muscles, which then drive the joints by
    the law of [activation]. `activation_dynamics`: activations change no faster than muscles can.
    `duration`: s; found where it is not given. `joints`: names of those that move; the arms of the
    hands in the tasks if not given. `speed`, `torque`: limits to either side, one for all joints or
    a table of some, rad/s or m/s and N m or N. `strength`: what torques are measured by, likewise.
    `smoothness`: weight of ∫ Σ a² dt beside the cost. `tolerance`: by how much the motion computed
    may miss its own integration within an interval, rad or m. `along`: tasks held all the way.
    """

    cost: Literal["effort", "time", "activation"] = "effort"
    activation_dynamics: bool = False
    duration: float | None = Field(None, gt=0.0, le=60.0)
    joints: tuple[str, ...] | None = Field(None, min_length=1)
    speed: PerJoint | None = None
    torque: PerJoint | None = None
    strength: PerJoint = 1.0
    smoothness: float | None = Field(None, ge=0.0)
    tolerance: float = Field(1e-4, ge=1e-8, le=0.1)
    along: tuple[Task, ...] = ()

    @model_validator(mode="after")
    def _least_time_is_found_and_bounded(self) -> TrajectoryBlock:
        if self.cost == "time" and self.duration is not None:
            raise ValueError("least time finds the duration; leave duration out, or ask for effort")
        if self.cost == "time" and not (self.speed or self.torque):
            raise ValueError("least time needs a limit on torque or speed, or it takes no time")
        return self

    @model_validator(mode="after")
    def _muscles_lag_where_they_drive(self) -> TrajectoryBlock:
        if self.activation_dynamics and self.cost != "activation":
            raise ValueError("activation_dynamics is of muscles; ask for cost = 'activation' too")
        return self
