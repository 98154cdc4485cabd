"""What resonance and the head's motion hang on: tornado charts on a page, tables in a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs
from rich.console import Group
from rich.table import Table

from posture_ik.arrays import Array
from posture_ik.files import write_whole
from posture_ik.problem import VibrationBlock
from posture_ik.sensitivity import Parameter, Response, Sensitivity
from posture_ik.show.plots import axis, layout
from posture_ik.show.words import number, power, template, who

_LESS, _MORE = "#2f6fb0", "#e07a1f"
#: What moves a response by a smaller share is no bar; what moves none so far, no row in a terminal.
_LEAST, _STILL = 1e-3, 1e-4
_FACTORS = {
    "neck_flexion": "neck flexion stiffness",
    "trunk_flexion": "trunk flexion stiffness",
    "lateral_bending": "lateral bending stiffness",
    "buttocks": "buttocks stiffness",
    "buttocks_shear": "buttocks shear",
}
_SUBJECT = {"thigh_on_seat": "share of thighs on seat", "tension": "trunk tension"}
#: For people: a unit, how many of its parameter's it is, and the word for one of it.
_UNITS = {"years": (1.0, "years", "year"), "deg": (1.0, "°", "°"), "N/m": (1e3, "kN/m", "kN/m")}


def write_sensitivity_report(found: Sensitivity, path: Path | str) -> None:
    """Write the study as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    asked = found.problem.vibration or VibrationBlock()
    lumped = asked.model.startswith("lumped:")
    page = template("sensitivity.html").render(
        title=found.problem.title,
        asked=f"{'' if lumped else who(found.problem.subject) + ' · '}model {asked.model} · "
        f"what moves: {found.moved}",
        stable=found.stable,
        miss=power(100.0 * found.largest_miss),
        cards=[_card(response) for response in found.responses],
        charts=[_tornado(found, j) for j, response in enumerate(found.responses)],
        less=_LESS,
        more=_MORE,
        least=f"{100.0 * _LEAST:g}",
        responses=[
            response.name + ("" if response.unit == "1" else f", {response.unit}")
            for response in found.responses
        ],
        rows=_rows(found),
        plotly=get_plotlyjs(),
    )
    write_whole(path, page)


def sensitivity_summary(found: Sensitivity) -> Group:
    """The responses, and how each parameter moves them, for a terminal."""
    values = Table(box=None)
    for column in ("response", "value", "at"):
        values.add_column(column)
    for response in found.responses:
        values.add_row(response.name, _with_unit(response), f"{response.frequency:.2f} Hz")
    share = Table(title="\n% more for each % more", title_justify="left", box=None)
    unit = Table(title="\nMore for each unit more", title_justify="left", box=None)
    for table, second in ((share, "is"), (unit, "unit")):
        table.add_column("parameter")
        table.add_column(second, no_wrap=True)
    for response in found.responses:
        of = "" if response.unit == "1" else f", {response.unit}"
        share.add_column(response.name, justify="right", min_width=9)
        unit.add_column(response.name + of, justify="right", min_width=10)
    rows, moves = _rows(found), np.any(_reach(found) >= _STILL, axis=1)
    still = [row["name"] for row, does in zip(rows, moves, strict=True) if not does]
    for row in (row for row in rows if row["name"] not in still):
        share.add_row(row["name"], row["value"], *(of["elasticity"] for of in row["of"]))
        unit.add_row(row["name"], row["unit"], *(of["derivative"] for of in row["of"]))
    without = [f"\nWithout effect: {', '.join(still)}."] if still else []
    certificate = (
        f"\nTwo steps of differences agree within {power(100.0 * found.largest_miss)} % of a "
        "response over 10 % of a parameter, 5° of the recline."
    )
    fallen = [] if found.stable else ["The model is unstable: no one will ever see this response."]
    return Group(found.problem.title, values, share, unit, *without, certificate, *fallen)


def _rows(found: Sensitivity) -> list[dict[str, Any]]:
    """A row a parameter, in words and numbers, and with what it does to each response."""
    return [
        {
            "name": _label(parameter),
            "value": _value(parameter, parameter.value),
            "unit": _unit(parameter)[2],
            "of": [
                {
                    "derivative": _signed(found.derivative[i, j] * _unit(parameter)[0]),
                    "elasticity": _percent(found.elasticity[i, j]) if parameter.value else "–",
                }
                for j in range(len(found.responses))
            ],
        }
        for i, parameter in enumerate(found.parameters)
    ]


def _reach(found: Sensitivity) -> Array:
    """How far the longer half of each bar goes, as a share of the response, (P, R)."""
    values = np.array([response.value for response in found.responses])
    reach: Array = np.fmax(np.abs(found.low - values), np.abs(found.high - values)) / values
    return np.nan_to_num(reach, nan=1.0)  # what loses a peak both ways does much


def _tornado(found: Sensitivity, j: int) -> dict[str, Any]:
    """Bars from a response as it is to what it is a step below and above, the longest on top."""
    response = found.responses[j]
    ends, reach = np.array([found.low[:, j], found.high[:, j]]), _reach(found)[:, j]
    order = [int(i) for i in np.argsort(-reach, kind="stable")]
    shown = [i for i in order if reach[i] >= _LEAST][::-1]
    labels = [f"{_label(p)}, {_value(p, p.value)}" for p in (found.parameters[i] for i in shown)]
    # Where both bars go to the same side, the one behind stands out beside the other.
    alike = np.prod(ends - response.value, axis=0) > 0.0
    widths = {-1: [0.75 for _ in shown], 1: [0.4 if alike[i] else 0.75 for i in shown]}
    bars = []
    for side, end, colour in ((-1, ends[0], _LESS), (1, ends[1], _MORE)):
        told = [_value(p, p.value + side * p.step) for p in (found.parameters[i] for i in shown)]
        bars.append(
            {
                "type": "bar",
                "orientation": "h",
                "y": labels,
                "x": [_plain(end[i] - response.value) for i in shown],
                "base": response.value,
                "width": widths[side],
                "customdata": [
                    f"{what}: {_short(end[i], response)}"
                    for what, i in zip(told, shown, strict=True)
                ],
                "marker": {"color": colour},
                "hovertemplate": "%{customdata}<extra>%{y}</extra>",
            }
        )
    unit = "" if response.unit == "1" else f", {response.unit}"
    look = layout(axis(response.name.capitalize() + unit))
    look["barmode"] = "overlay"
    look["shapes"] = [
        {
            "type": "line",
            "x0": response.value,
            "x1": response.value,
            "y0": 0,
            "y1": 1,
            "yref": "paper",
            "line": {"color": "#1c2733", "width": 1},
        }
    ]
    return {
        "title": f"{response.name.capitalize()}: {_with_unit(response)}",
        "figure": {"data": bars, "layout": look},
        "height": 70 + 26 * len(shown),
        "still": [_label(found.parameters[i]) for i in order if reach[i] < _LEAST],
    }


def _card(response: Response) -> dict[str, str]:
    unit = "" if response.unit == "1" else response.unit
    more = "" if response.unit == "Hz" else f"at {response.frequency:.2f} Hz"
    return {
        "name": response.name.capitalize(),
        "value": number(response.value),
        "unit": unit,
        "more": more,
    }


def _label(parameter: Parameter) -> str:
    """A parameter in words."""
    kind, *names = parameter.path.split(".")
    last = names[-1].removesuffix("_deg").replace("_", " ")
    if kind == "factors":
        return _FACTORS.get(names[0], last)
    if kind == "subject":
        return _SUBJECT.get(names[-1], last)
    if names[0] == "masses":
        return f"mass {'.'.join(names[1:])}"
    if names[0] == "link":
        return f"link {names[1]} {last}"
    return last if len(names) == 1 else f"{names[-2]} {last}"


def _unit(parameter: Parameter) -> tuple[float, str, str]:
    """A unit for people: how many of the parameter's it is, and its words for many and one."""
    return _UNITS.get(parameter.unit, (1.0, parameter.unit, parameter.unit))


def _value(parameter: Parameter, value: float) -> str:
    size, unit, _ = _unit(parameter)
    told = f"{value / size:.4g}".replace("-", "−")
    if parameter.path.startswith("factors.") or parameter.path == "subject.tension":
        return f"× {told}"
    return told if unit == "1" else f"{told}{unit}" if unit == "°" else f"{told} {unit}"


def _with_unit(response: Response) -> str:
    return number(response.value) + ("" if response.unit == "1" else f" {response.unit}")


def _short(value: float, response: Response) -> str:
    if not np.isfinite(value):
        return "the peak is lost"
    return f"{value:.4g}" + ("" if response.unit == "1" else f" {response.unit}")


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _percent(value: float) -> str:
    if not np.isfinite(value):
        return "lost"
    return "0" if abs(value) < 5e-4 else f"{value:+.3f}".replace("-", "−")


def _signed(value: float) -> str:
    """Three significant figures with a sign; 0 for what is nearly nothing."""
    if not np.isfinite(value):
        return "lost"
    return ("+" if value >= 1e-6 else "") + number(value)
