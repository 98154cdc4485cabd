"""The source's published numbers beside ours, with a word on why they differ.

Cocco 2019, and the measurements that it quotes; its misprints are corrected. The numbers, and the
words where ours are not as near as they could be read, come from the tables in `vibration/data/`.
Responses are sampled as the source's are, by 0.05 Hz from 0.1 Hz on, but those of the lumped
models, whose peaks are known finer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypedDict

import numpy as np

from posture_ik.arrays import one_thread
from posture_ik.body import build_body
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, load_problem
from posture_ik.vibration import (
    Factors,
    LinearSystem,
    build_finite_element,
    build_lumped,
    linearise,
    load_lumped,
)
from posture_ik.vibration.published import SEATS, Mode, Peak, matched, modes, peaks, table_6

#: Tables of peaks by what they are called: the file, whose they are, and the parameter set.
TABLES = {
    "§3.3": ("section_3_3", "source"),
    "table 7": ("table_7", "source"),
    "§6.1": ("section_6_1", "source"),
    "§3.3, measured": ("measured", "calibrated"),
}
#: Modes up to which the source counts its own, Hz.
COUNTED = 50.0
#: Differences up to which a number is as near as it is told, %.
NEAR = 2.0


class Row(TypedDict):
    """A published number beside ours; `difference_percent` is of the published one."""

    source: str
    quantity: str
    unit: str
    thesis: float
    ours: float
    difference_percent: float
    note: str


def compare(tell: Callable[[str], None] = lambda what: None) -> list[Row]:
    """Compute what the source publishes, and lay both side by side.

    Args:
        tell: is told what is computed.

    Returns:
        Rows: the modes of table 6 and its count, the peaks of `TABLES`, the measured modes.
    """
    with one_thread():
        tell("modes")
        rows = _modes("table 6", table_6(), build_finite_element())
        for source, (table, parameters) in TABLES.items():
            tell(f"responses of {source}")
            rows += _peaks(source, peaks(table), parameters)
        tell("measured modes")
        calibrated = build_finite_element(factors=Factors.of("calibrated"))
        rows += _modes("table 6, measured", table_6("measured_Hz"), calibrated)
    return rows


def _modes(source: str, published: Mapping[str, Mode], system: LinearSystem) -> list[Row]:
    found = matched(system)
    rows = []
    for number, mode in published.items():
        kind = "symmetric" if mode.symmetric else "anti-symmetric"
        quantity = f"mode {number}, {kind}"
        rows.append(_row(source, quantity, "Hz", mode.frequency, found[number], mode.note))
    return rows


def _peaks(source: str, published: Mapping[str, Peak], parameters: str) -> list[Row]:
    known: dict[tuple[str, str], LinearSystem] = {}
    rows = []
    for name, peak in published.items():
        at = (peak.model, peak.seat)
        if at not in known:
            known[at] = _system(*at, parameters)
        lumped = peak.model.startswith("lumped:")
        size, frequency = (peak.refined if lumped else peak.found)(known[at])
        rows.append(_row(source, name, peak.unit, peak.size, size, peak.note))
        if peak.frequency:
            told = f"{name}, where"
            rows.append(_row(source, told, "Hz", peak.frequency, frequency, peak.note))
    return rows


def _system(model: str, seat: str, parameters: str) -> LinearSystem:
    """A model of the reference subject, erect, in one of `SEATS`."""
    if model == "finite_element":
        return build_finite_element(**SEATS[seat], factors=Factors.of(parameters))
    if model == "multibody":
        problem = load_problem("upright")
        body = build_body(problem.subject)
        sat = problem.seat.model_copy(update=SEATS[seat])
        return linearise(
            body, solve_posture(body, problem), problem.model_copy(update={"seat": sat})
        )
    return build_lumped(load_lumped(model.removeprefix("lumped:")), SEATS[seat].get("cushion"))


def _row(source: str, quantity: str, unit: str, thesis: float, ours: float, note: str = "") -> Row:
    difference = 100 * (ours / thesis - 1)
    near = f"within {NEAR:g} %" if abs(difference) <= NEAR else note
    return Row(
        source=source,
        quantity=quantity,
        unit=unit,
        thesis=thesis,
        ours=round(ours, 4),
        difference_percent=round(difference, 2),
        note=near,
    )
