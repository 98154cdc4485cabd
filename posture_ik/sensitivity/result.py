"""What a study of sensitivity comes to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from posture_ik.arrays import Array
from posture_ik.problem import Problem
from posture_ik.sensitivity.parameters import Parameter


class Response(NamedTuple):
    """A number read off the model: `resonance`, `peak apparent mass`, `head z`, `head x`.

    Attributes:
        name, unit: of it.
        value: as it is.
        frequency: where, Hz.
    """

    name: str
    unit: str
    value: float
    frequency: float


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """How P parameters move R responses.

    Attributes:
        problem: what was asked.
        stable: whether the model is.
        moved: what moves, such as `seat z`.
        parameters: P of them; `responses`: R.
        derivative: (P, R), unit of the response over that of the parameter.
        disagreement: |D(h) - D(h/2)|, (P, R), as the derivative.
        low, high: the responses (P, R) at a step below and above; not a number where the peak is
            lost on the way.
    """

    problem: Problem
    stable: bool
    moved: str
    parameters: tuple[Parameter, ...]
    responses: tuple[Response, ...]
    derivative: Array
    disagreement: Array
    low: Array
    high: Array

    @property
    def elasticity(self) -> Array:
        """% of the response per % of the parameter, (P, R); 0 of a parameter that is zero."""
        sizes = np.array([parameter.value for parameter in self.parameters])
        values = np.array([response.value for response in self.responses])
        scaled: Array = self.derivative * sizes[:, None] / values
        return scaled

    @property
    def miss(self) -> Array:
        """Certificate: `disagreement`, over a whole step, as a share of the response, (P, R)."""
        steps = np.array([parameter.step for parameter in self.parameters])
        values = np.array([response.value for response in self.responses])
        share: Array = self.disagreement * steps[:, None] / values
        return share

    @property
    def largest_miss(self) -> float:
        """The largest `miss`, of all that is a number."""
        return float(np.nanmax(self.miss, initial=0.0))

    def records(self) -> list[dict[str, Any]]:
        """A row for each response and parameter, for machines; None where a peak is lost."""
        rows: list[dict[str, Any]] = []
        for j, response in enumerate(self.responses):
            for i, parameter in enumerate(self.parameters):
                numbers = {
                    "derivative": self.derivative[i, j],
                    "elasticity": self.elasticity[i, j],
                    "low": self.low[i, j],
                    "high": self.high[i, j],
                    "miss": self.miss[i, j],
                }
                rows.append(
                    {
                        "response": response.name,
                        "response_unit": response.unit,
                        "response_value": response.value,
                        "frequency_hz": response.frequency,
                        "parameter": parameter.path,
                        "parameter_unit": parameter.unit,
                        "parameter_value": parameter.value,
                        "step": parameter.step,
                        **{k: float(x) if np.isfinite(x) else None for k, x in numbers.items()},
                    }
                )
        return rows
