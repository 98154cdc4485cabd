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
from posture_ik.problem import load_problem
from posture_ik.vibration import (
    Factors,
    LinearSystem,
    build_finite_element,
    build_lumped,
    linearise,
    load_lumped,
)
from posture_ik.vibration.published import (
    SEATS,
    Mode,
    Peak,
    matched,
    modes,
    peaks,
    sampled,
    table_6,
)

#: Tables of peaks by what they are called: the file, whose they are, and the parameter set.
TABLES = {
    "§3.3": ("section_3_3", "source"),
    "table 7": ("table_7", "source"),
    "§6.1": ("section_6_1", "source"),
    "§3.3, measured": ("measured", "calibrated"),
}
#: How many modes the source counts (§3.3.1), up to how much, Hz.
COUNTED = (55, 50.0)
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
        plain = build_finite_element()
        count, most = COUNTED
        below = int(np.sum(modes(plain, 2 * count)[0] < most))
        rows = _modes("table 6", table_6(), plain)
        note = "our next two lie within 2 Hz above"
        rows.append(_row("§3.3.1", f"modes below {most:g} Hz", "1", count, below, note))
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
    rows = []
    for model, seat in dict.fromkeys((peak.model, peak.seat) for peak in published.values()):
        inside = {n: p for n, p in published.items() if (p.model, p.seat) == (model, seat)}
        responses = sampled(_system(model, seat, parameters), inside)
        for name, peak in inside.items():
            read = peak.refined if model.startswith("lumped:") else peak.found
            size, frequency = read(*responses[name])
            rows.append(_row(source, name, peak.unit, peak.size, size, peak.note))
            if peak.frequency and peak.lies_in(responses[name][1]):
                where = f"{name}, where"
                rows.append(_row(source, where, "Hz", peak.frequency, frequency, peak.note))
    return rows


def _system(model: str, seat: str, parameters: str) -> LinearSystem:
    """A model of the reference subject, erect, in one of `SEATS`."""
    if model == "finite_element":
        return build_finite_element(**SEATS[seat], factors=Factors.of(parameters))
    if model == "multibody":
        upright = load_problem("upright")
        sat = upright.model_copy(update={"seat": upright.seat.model_copy(update=SEATS[seat])})
        body = build_body(sat.subject)
        return linearise(body, solve_posture(body, upright), sat)
    return build_lumped(load_lumped(model.removeprefix("lumped:")), SEATS[seat].get("cushion"))


def _row(source: str, quantity: str, unit: str, thesis: float, ours: float, note: str = "") -> Row:
    ours = float(f"{ours:.5g}")
    difference = round(100 * (ours / thesis - 1), 2)
    near = f"within {NEAR:g} %" if abs(difference) <= NEAR else note
    return Row(
        source=source,
        quantity=quantity,
        unit=unit,
        thesis=thesis,
        ours=ours,
        difference_percent=difference,
        note=near,
    )
