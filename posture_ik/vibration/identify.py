"""Identifies what the source leaves open, and what calibrates its model to measured people.

Nonlinear least squares (SciPy, trust region) from a plain start and seeded random ones, of

- `source`: the open values of the finite-element spine against the modes of table 6 and the peaks
  of §3.3, for each reading of the text in `READINGS`;
- `calibrated`: factors on groups of stiffness and damping against measured modes and peaks, with
  a prior that holds each factor near 1 unless the measurements need otherwise.

Modes are printed to 0.01 Hz and taken as good to 1 %, measured ones to 5 %; peaks are told of
curves that are drawn, and taken as good to 10 %, their frequencies too. The loss grows linearly
for what is far off (soft l1): what the model cannot meet is not to bend what it can.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import least_squares

from posture_ik.arrays import Array, one_thread
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.finite_element import OpenValues, build_finite_element
from posture_ik.vibration.published import SEATS, Peak, matched, peaks, table_6

Parameters: TypeAlias = Literal["source", "calibrated"]
#: A value by name, and how good it is taken to be, relative.
Wanted: TypeAlias = Mapping[str, tuple[float, float]]

#: The readings: whether the column of viscera is tied to T10, ties along z are stiff or soft, and
#: the buttocks' corners, of "two squares", have one spacing.
READINGS = {
    f"column {'tied to' if top else 'free at'} T10, {ties} ties along z, corners {corners}": (
        float(top),
        ties,
        corners,
    )
    for top in (True, False)
    for ties in ("stiff", "soft")
    for corners in ("apart", "square")
}
#: Bounds of the open values, and where every search starts once.
BOUNDS = {
    "bushing_fraction": (0.0, 1.0),
    "buttock_x": (0.01, 0.4),
    "buttock_y": (0.01, 0.4),
    "visceral_x": (1e3, 1e6),
}
TIES = {"stiff": (1e3, 1e7), "soft": (0.0, 1e3)}
PLAIN = OpenValues(0.5, 0.2, 0.2, 9e3, 100.0, 0.0)
#: Bounds of the factors. Buttocks are soft in shear as flesh is, where the source's are not.
FACTORS = dict.fromkeys(Factors._fields, (0.1, 10.0)) | {"buttocks_shear": (1e-4, 10.0)}
#: A factor's prior, as good as a factor of so much.
PRIOR = 5.0
MODE, MEASURED_MODE, PEAK = 0.01, 0.05, 0.10
STARTS, SEED, STEP = 1, 1, 0.1


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
            # Steps of a thousandth, whatever x is: where it is 0 SciPy's own would be too small.
            steps = np.where(x + 1e-3 < high, 1e-3, -1e-3) * np.eye(len(x))
            here = residuals(x)
            moved = [residuals(x + step) - here for step in steps]
            return np.transpose(moved) / np.sum(steps, axis=1)

        best = least_squares(
            residuals,
            begun,
            slopes,
            bounds=(low, high),
            loss="soft_l1",
            xtol=1e-4,
            ftol=1e-4,
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


def identify(
    parameters: Parameters,
    tell: Callable[[str], None] = lambda what: None,
    starts: int = STARTS,
    most: int = 40,
) -> dict[str, Any]:
    """Search a parameter set, and tell all that a reader wants to know of the search.

    Args:
        parameters: which, `source` or `calibrated`.
        tell: is told what is done.
        starts: random ones, beside the plain one, in each reading.
        most: steps of one search.

    Returns:
        Plain data: every start of every reading (`searches`, best first), which is `chosen`, its
        `values`, to three digits, the `results` with what was wanted, and what 10 % more of each
        value changes (`sensitivity_percent`).
    """
    random = np.random.default_rng(SEED)
    searches = _of_source() if parameters == "source" else _of_calibrated()
    with one_thread():
        runs: dict[str, list[dict[str, Any]]] = {}
        for i, (reading, search) in enumerate(searches.items(), 1):
            runs[reading] = []
            for start in (_plain(parameters), *(search.anywhere(random) for _ in range(starts))):
                tell(f"reading {i} of {len(searches)}, {reading}: start {len(runs[reading]) + 1}")
                runs[reading].append(search.run(start, most))
            runs[reading].sort(key=lambda run: run["cost"])
        chosen = min(runs, key=lambda reading: runs[reading][0]["cost"])
        tell("what each value moves")
        search, values = searches[chosen], runs[chosen][0]["values"]
        found = search.results(values)
        changes = {}
        for name, value in values.items():
            # Of a tie that is none, 100 N/m.
            more = search.results(values | {name: 1.1 * value or 100.0})
            changes[name] = {key: _percent(more[key], found[key]) for key in search.wanted}
    return {
        "parameters": parameters,
        "seed": SEED,
        "bounds": {reading: dict(of.bounds) for reading, of in searches.items()},
        "prior": PRIOR if search.prior else None,
        "searches": runs,
        "chosen": chosen,
        "values": values | _given(chosen, values) if parameters == "source" else values,
        "results": {
            name: {
                "wanted": size,
                "tolerance_percent": 100 * good,
                "found": round(float(found[name]), 4),
                "difference_percent": _percent(found[name], size),
            }
            for name, (size, good) in search.wanted.items()
        },
        "sensitivity_percent": changes,
    }


def wanted(parameters: Parameters) -> tuple[dict[str, Peak], dict[str, tuple[float, float]]]:
    """The peaks that a set is to meet; and all it is to meet, by name, with how good each is."""
    calibrated = parameters == "calibrated"
    sought = peaks("measured" if calibrated else "section_3_3")
    column, good = ("measured_Hz", MEASURED_MODE) if calibrated else ("frequency_Hz", MODE)
    whole = {f"mode {n} Hz": (hertz, good) for n, (hertz, *_) in table_6(column).items()}
    for name, peak in sought.items():
        whole[f"{name} {peak.unit}"] = (peak.size, PEAK)
        if peak.frequency:
            whole[f"{name} Hz"] = (peak.frequency, PEAK)
    return sought, whole


def results(
    sought: Mapping[str, Peak], values: OpenValues | None = None, factors: Factors = Factors()
) -> dict[str, float]:
    """Every mode and peak of the finite-element model, by name and unit."""
    seats = {"bare", *(peak.seat for peak in sought.values())}
    systems = {
        seat: build_finite_element(**SEATS[seat], values=values, factors=factors) for seat in seats
    }
    found = {f"mode {n} Hz": hertz for n, hertz in matched(systems["bare"]).items()}
    for name, peak in sought.items():
        size, at = peak.refined(systems[peak.seat], STEP)
        found |= {f"{name} {peak.unit}": size, f"{name} Hz": at}
    return found


def _of_source() -> dict[str, Search]:
    sought, whole = wanted("source")
    searches = {}
    for reading, (_, ties, corners) in READINGS.items():
        bounds = BOUNDS | {"visceral_z": TIES[ties]}
        if corners == "square":
            del bounds["buttock_y"]

        def found(values: Mapping[str, float], reading: str = reading) -> dict[str, float]:
            return results(sought, OpenValues(**{**values, **_given(reading, values)}))

        searches[reading] = Search(bounds, whole, found, prior=False)
    return searches


def _of_calibrated() -> dict[str, Search]:
    sought, whole = wanted("calibrated")

    def found(values: Mapping[str, float]) -> dict[str, float]:
        return results(sought, factors=Factors(**values))

    return {"the source's open values": Search(FACTORS, whole, found, prior=True)}


def _given(reading: str, values: Mapping[str, float]) -> dict[str, float]:
    """What a reading says of the open values, beside those sought."""
    top, _, corners = READINGS[reading]
    square = {"buttock_y": values["buttock_x"]} if corners == "square" else {}
    return {**square, "column_top": top}


def _plain(parameters: Parameters) -> dict[str, float]:
    if parameters == "source":
        return PLAIN._asdict()
    return Factors(trunk_flexion=4.0, trunk_lateral=4.0, buttocks_shear=0.005)._asdict()


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


def _percent(value: float, of: float) -> float:
    return round(100 * (float(value) / of - 1), 2)
