"""A search by nonlinear least squares: bounded, seeded, from several starts.

Minimises, over the logarithms of values x between their bounds,

    sum_i rho((ln(found_i(x) / wanted_i) / good_i)²)  [ + sum_j (ln x_j / ln PRIOR)² ],

with rho(z) = 2 (√(1 + z) - 1), soft l1, by SciPy's trust region.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import least_squares

from posture_ik.arrays import Array

#: A value by name, and how good it is taken to be, relative.
Wanted: TypeAlias = Mapping[str, tuple[float, float]]

#: A factor's prior, as good as a factor of so much.
PRIOR = 3.0
#: Steps for the slopes, in the coordinates of the search.
STEP = 1e-3


class Search(NamedTuple):
    """What is sought in one reading.

    Attributes:
        bounds: of each unknown by name.
        wanted: what is to be met.
        results: the same of the model, for the unknowns' values.
        prior: whether each unknown is held near 1.
    """

    bounds: Mapping[str, tuple[float, float]]
    wanted: Wanted
    results: Callable[[Mapping[str, float]], Mapping[str, float]]
    prior: bool

    def residuals(self, values: Mapping[str, float]) -> Array:
        """Differences over what each is good for, logarithmic, then the prior's."""
        found = self.results(values)
        off = [np.log(found[name] / size) / good for name, (size, good) in self.wanted.items()]
        held = [np.log(value) / np.log(PRIOR) for value in values.values()] if self.prior else []
        return np.array([*off, *held])

    def run(self, start: Mapping[str, float], most: int) -> dict[str, Any]:
        """One search from one start, with at most so many steps."""
        low, high = (
            np.array([_coordinate(n, ends[i]) for n, ends in self.bounds.items()]) for i in (0, 1)
        )
        begun = np.clip([_coordinate(name, start[name]) for name in self.bounds], low, high)

        def residuals(x: Array) -> Array:
            return self.residuals(self._values(x))

        def slopes(x: Array) -> Array:
            # Steps of one size: where x is 0 SciPy's own would be too small.
            steps = np.where(x + STEP < high, STEP, -STEP) * np.eye(len(x))
            here = residuals(x)
            moved = [residuals(x + step) - here for step in steps]
            gap: Array = np.transpose(moved) / np.sum(steps, axis=1)
            return gap

        best = least_squares(
            residuals,
            begun,
            slopes,
            bounds=(low, high),
            loss="soft_l1",
            xtol=1e-3,
            ftol=1e-3,
            max_nfev=most,
        )
        return {
            "start": _rounded(self._values(begun)),
            "values": _rounded(self._values(best.x)),
            "cost": round(float(best.cost), 4),
            "evaluations": int(best.nfev),
            "stopped": best.message,
        }

    def anywhere(self, random: np.random.Generator) -> dict[str, float]:
        """A random start between the bounds."""
        ends = [[_coordinate(n, end) for end in ends] for n, ends in self.bounds.items()]
        return self._values(random.uniform(*np.transpose(ends)))

    def _values(self, x: Array) -> dict[str, float]:
        return {n: _value(n, float(v)) for n, v in zip(self.bounds, x, strict=True)}


def _coordinate(name: str, value: float) -> float:
    """A value as the coordinate it is sought by; a tie along z may be none."""
    if name == "visceral_z":
        return float(np.arcsinh(value / 1e3))
    return value if name == "bushing_fraction" else float(np.log(value))


def _value(name: str, coordinate: float) -> float:
    if name == "visceral_z":
        return float(1e3 * np.sinh(coordinate))
    return coordinate if name == "bushing_fraction" else float(np.exp(coordinate))


def _rounded(values: Mapping[str, float]) -> dict[str, float]:
    """To three digits; a tie along z below 1 mN/m as none."""
    none = {"visceral_z"} if values.get("visceral_z", 1.0) < 1e-3 else set()
    return {name: 0.0 if name in none else float(f"{v:.3g}") for name, v in values.items()}
