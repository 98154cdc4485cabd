"""Numbers of a problem that move: each a function of time with its first two derivatives.

All are twice continuously differentiable, so that accelerations exist at every instant.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator
from scipy.interpolate import CubicSpline

from posture_ik.arrays import Array
from posture_ik.problem.block import Block

#: Value, rate and acceleration at the times asked, (T,) each, in the number's unit, /s and /s².
Course = tuple[Array, Array, Array]


class Constant(Block):
    """A number that stays where it is set."""

    of: str
    kind: Literal["constant"]
    value: float

    def at(self, t: Array) -> Course:
        """The same value at all times."""
        return np.full_like(t, self.value), np.zeros_like(t), np.zeros_like(t)


class Sine(Block):
    """offset + amplitude sin(2 pi frequency t + phase), frequency in Hz."""

    of: str
    kind: Literal["sine"]
    amplitude: float
    frequency: float = Field(gt=0.0)
    offset: float = 0.0
    phase_deg: float = 0.0

    def at(self, t: Array) -> Course:
        """The sine and its derivatives."""
        rate = 2 * np.pi * self.frequency
        angle = rate * t + np.radians(self.phase_deg)
        wave = self.amplitude * np.sin(angle)
        return self.offset + wave, self.amplitude * rate * np.cos(angle), -(rate**2) * wave


class _Change(Block):
    """From one value to another between two times, at rest before and after."""

    of: str
    initial: float
    final: float
    start: float = Field(0.0, ge=0.0)
    stop: float

    @model_validator(mode="after")
    def _takes_time(self) -> _Change:
        if self.stop <= self.start:
            raise ValueError(
                f"a change from {self.initial:g} to {self.final:g} must take time: "
                f"stop = {self.stop:g} s is not after start = {self.start:g} s"
            )
        return self

    def _course(self, t: Array, blend: float) -> Course:
        """A rate that rises over `blend` seconds as (1 - cos)/2, stays, and falls likewise."""
        length = self.stop - self.start
        top = (self.final - self.initial) / (length - blend)
        since = np.clip(t - self.start, 0.0, length)
        left = length - since
        near = np.minimum(since, left)  # the course is odd about its middle
        rising = near < blend
        angle = np.pi * near / blend
        way = np.where(rising, near / 2 - blend / (2 * np.pi) * np.sin(angle), near - blend / 2)
        rate = np.where(rising, (1 - np.cos(angle)) / 2, 1.0)
        turn = np.where(rising, np.pi / (2 * blend) * np.sin(angle), 0.0)
        first = since <= left
        value = np.where(first, self.initial + top * way, self.final - top * way)
        return value, top * rate, np.where(first, top * turn, -top * turn)


class CosineStep(_Change):
    """A step whose rate is a full cosine wave, 1 - cos."""

    kind: Literal["cosine_step"]

    def at(self, t: Array) -> Course:
        """The step and its derivatives."""
        return self._course(t, (self.stop - self.start) / 2)


class Ramp(_Change):
    """A steady rate, taken up and given back within a tenth of the time at either end."""

    kind: Literal["ramp"]

    def at(self, t: Array) -> Course:
        """The ramp and its derivatives."""
        return self._course(t, (self.stop - self.start) / 10)


class Table(Block):
    """Values at times (s), joined by a natural cubic spline; it must span the motion."""

    of: str
    kind: Literal["table"]
    times: tuple[float, ...] = Field(min_length=2)
    values: tuple[float, ...]

    @model_validator(mode="after")
    def _one_value_a_time(self) -> Table:
        if len(self.times) != len(self.values):
            raise ValueError(f"there are {len(self.times)} times for {len(self.values)} values")
        if any(
            later <= earlier for earlier, later in zip(self.times, self.times[1:], strict=False)
        ):
            raise ValueError("the times must grow; a target that jumps has no velocity")
        return self

    def at(self, t: Array) -> Course:
        """The spline and its derivatives; the acceleration is zero at both ends."""
        spline = CubicSpline(self.times, self.values, bc_type="natural")
        return spline(t), spline(t, 1), spline(t, 2)


Signal = Annotated[Constant | Sine | CosineStep | Ramp | Table, Field(discriminator="kind")]
