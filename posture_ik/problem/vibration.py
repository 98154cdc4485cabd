"""How a person vibrates about the posture: the `[vibration]` block."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from posture_ik.arrays import Array
from posture_ik.problem.block import Block


def _read_model(value: Any) -> Any:
    if value in ("multibody", "finite_element") or str(value).startswith("lumped:"):
        return value
    raise ValueError('write "multibody", "finite_element" or "lumped:" and the name of a model')


Model = Annotated[str, BeforeValidator(_read_model)]


class FrequencyBlock(Block):
    """Frequencies from `start` to `stop` in equal steps, Hz."""

    start: float = Field(0.1, gt=0.0)
    stop: float = Field(20.0, gt=0.0, le=1000.0)
    step: float = Field(0.05, gt=0.0)

    @model_validator(mode="after")
    def _ascend(self) -> FrequencyBlock:
        if self.stop < self.start:
            raise ValueError(f"stop {self.stop:g} Hz lies below start {self.start:g} Hz")
        if (self.stop - self.start) / self.step > 1e5:
            raise ValueError(f"a step of {self.step:g} Hz makes more than 100,000 frequencies")
        return self

    @property
    def values(self) -> Array:
        """The frequencies, (F,), Hz."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-9)) + 1
        values: Array = self.start + self.step * np.arange(float(count))
        return values


class VibrationBlock(Block):
    """How the person vibrates about the posture.

    `beside`: other models, for their responses in the same charts. `input`: what moves: the seat
    with all that stands on it, or the backrest alone. `frames`: links whose motions are told beside
    the head's; the pelvis's and all grips' if not given. `discs`: joints of the spine, such as
    `L4_L5`, whose strains and forces are told. `shape`, of the finite-element model: the erect
    person turned rigidly with the backrest, or the solved posture. `gravity`: count the stiffness,
    negative for what stands, of the weight; `prestress`: that of the forces with which the tasks
    hold the posture. The source counts neither. `parameters`: stiffness and damping of the
    source, or as calibrated to measurements. `grip`: whether a hand keeps hold of the lever it is
    on; what the other tasks hold is let go.
    """

    model: Model = "multibody"
    beside: tuple[Model, ...] = ()
    input: Literal["seat", "backrest"] = "seat"
    frequencies: FrequencyBlock = FrequencyBlock()
    frames: tuple[str, ...] | None = None
    discs: tuple[str, ...] = ()
    shape: Literal["rigid", "solved"] = "rigid"
    parameters: Literal["source", "calibrated"] = "source"
    gravity: bool = False
    prestress: bool = False
    grip: bool = True
