"""Identifies what the source leaves open, and what calibrates its model to measured people.

Nonlinear least squares (SciPy, trust region) from a plain start in each reading of the text, and
from seeded random ones in the best, of

- `source`: the open values of the finite-element spine against the modes of table 6 and the peaks
  of §3.3, for each of `READINGS`;
- `calibrated`: factors on groups of stiffness and damping against measured modes and peaks, with
  a prior that holds each factor near 1 unless the measurements need otherwise.

Modes are printed to 0.01 Hz and taken as good to 2 %, measured ones to 5 %; peaks are told of
curves that are drawn, and taken as good to 5 %, measured ones and all their frequencies to 10 %.
The loss grows linearly for what is far off (soft l1): what cannot be met is not to bend what can.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeAlias

import numpy as np

from posture_ik.arrays import one_thread
from posture_ik.problem import FoamBack
from posture_ik.problem.tasks import expand_bodies
from posture_ik.vibration.factors import SOURCE, Factors
from posture_ik.vibration.finite_element import OpenValues, build_finite_element
from posture_ik.vibration.published import (
    SEATS,
    SOURCE_BACKREST,
    Peak,
    matched,
    peaks,
    sampled,
    table_6,
)
from posture_ik.vibration.search import PRIOR, Search

Parameters: TypeAlias = Literal["source", "calibrated"]
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
#: Readings of the backrest: vertebrae of its mean, and at which it acts.
BACKS, LEVELS = ("T1-T10", "T1-T12", "T5-T10", "T4-T12"), ("T7", "T8", "T9")
MODE, MEASURED_MODE = 0.02, 0.05
SIZE, MEASURED_SIZE, PLACE = 0.05, 0.10, 0.10
#: Random starts in the best reading.
STARTS, SEED, STEP = 2, 1, 0.1


def identify(
    parameters: Parameters,
    tell: Callable[[str], None] = lambda what: None,
    most: int = 30,
) -> dict[str, Any]:
    """Search a parameter set, and tell all that a reader wants to know of the search.

    Args:
        parameters: which, `source` or `calibrated`.
        tell: is told what is done.
        most: steps of one search.

    Returns:
        Plain data: every start of every reading (`searches`, best first), which is `chosen`, its
        `values`, to three digits, the `results` with what was wanted, what 10 % more of each
        value changes (`sensitivity_percent`), and for `source` the peak of figure 12 by each
        reading of its backrest (`backrests`).
    """
    sought = searches(parameters)
    with one_thread():
        plain = _plain(parameters)
        runs: dict[str, list[dict[str, Any]]] = {}
        for i, (reading, search) in enumerate(sought.items(), 1):
            tell(f"reading {i} of {len(sought)}: {reading}")
            runs[reading] = [search.run(plain, most)]
        chosen = min(runs, key=lambda reading: runs[reading][0]["cost"])
        random = np.random.default_rng(SEED)
        for i in range(1, STARTS + 1):
            tell(f"the best again, from random start {i} of {STARTS}: {chosen}")
            runs[chosen].append(sought[chosen].run(sought[chosen].anywhere(random), most))
        runs[chosen].sort(key=lambda run: run["cost"])
        tell("what each value moves")
        search, values = sought[chosen], runs[chosen][0]["values"]
        found = search.results(values)
        changes = {}
        for name, value in values.items():
            # Of a tie that is none, 100 N/m.
            more = search.results(values | {name: 1.1 * value or 100.0})
            changes[name] = {key: _percent(more[key], found[key]) for key in search.wanted}
        if parameters == "source":
            values = values | _given(chosen, values)
        backrests = _backrests(OpenValues(**values)) if parameters == "source" else []
    return {
        "parameters": parameters,
        "seed": SEED,
        "bounds": {reading: dict(of.bounds) for reading, of in sought.items()},
        "prior": PRIOR if search.prior else None,
        "searches": runs,
        "chosen": chosen,
        "values": values,
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
        "backrests": backrests,
    }


def searches(parameters: Parameters) -> dict[str, Search]:
    """What is sought, and by what it is judged, for each reading."""
    return _of_source() if parameters == "source" else _of_calibrated()


def wanted(parameters: Parameters) -> tuple[dict[str, Peak], dict[str, tuple[float, float]]]:
    """The peaks that a set is to meet; and all it is to meet, by name, with how good each is."""
    calibrated = parameters == "calibrated"
    sought = peaks("measured" if calibrated else "section_3_3")
    column, good = ("measured_Hz", MEASURED_MODE) if calibrated else ("frequency_Hz", MODE)
    whole = {f"mode {n} Hz": (hertz, good) for n, (hertz, *_) in table_6(column).items()}
    for name, peak in sought.items():
        whole[f"{name} {peak.unit}"] = (peak.size, MEASURED_SIZE if calibrated else SIZE)
        if peak.frequency:
            whole[f"{name} Hz"] = (peak.frequency, PLACE)
    return sought, whole


def results(
    sought: Mapping[str, Peak], values: OpenValues | None = None, factors: Factors = SOURCE
) -> dict[str, float]:
    """Every mode and peak of the finite-element model, by name and unit."""
    found: dict[str, float] = {}
    for seat, of in SEATS.items():
        inside = {name: peak for name, peak in sought.items() if peak.seat == seat}
        system = build_finite_element(**of, values=values, factors=factors)
        if seat == "bare":
            found |= {f"mode {n} Hz": hertz for n, hertz in matched(system).items()}
        for name, response in sampled(system, inside, STEP).items():
            size, at = sought[name].refined(*response)
            found |= {f"{name} {sought[name].unit}": size, f"{name} Hz": at}
    return found


def _backrests(values: OpenValues) -> list[dict[str, Any]]:
    """The peak of figure 12 for each reading of its backrest, with these open values."""
    peak = peaks("section_3_3")["head x with backrest"]
    rows = []
    for foam in (SOURCE_BACKREST, FoamBack()):
        for bodies in BACKS:
            for at in LEVELS:
                spot = {"bodies": expand_bodies(bodies), "at": at}
                back = foam.model_copy(update=spot)
                system = build_finite_element(backrest=back, values=values)
                (response,) = sampled(system, {"peak": peak}, STEP).values()
                size, hertz = peak.refined(*response)
                rows.append(
                    {
                        "stiffness": back.stiffness,
                        "damping": back.damping,
                        "bodies": bodies,
                        "at": at,
                        "peak": round(size, 3),
                        "frequency_Hz": round(hertz, 3),
                    }
                )
    return rows


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
    return Factors(trunk_flexion=4.0, lateral_bending=4.0, buttocks_shear=0.005)._asdict()


def _percent(value: float, of: float) -> float:
    return round(100 * (float(value) / of - 1), 2)
