"""One page that puts our apparent masses beside the source's model and the measurements."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs
from rich.table import Table

from posture_ik.files import write_whole
from posture_ik.show.plots import Figure, axis, layout
from posture_ik.show.words import template
from posture_ik.validation import Numbers, Result, mean_errors

#: One colour a row, in the order of the tables.
_COLOURS = ("#2f6fb0", "#2a9d8f", "#e07a1f", "#8a5aa8")
#: Who is drawn in the charts: in table 25, the same people as in 24 but tabled, nobody.
_DRAWN = {15: "tabled", 16: "tabled", 17: "tabled", 18: "tabled", 24: "typical"}
_TITLES = {
    "no_backrest": "No backrest",
    "rigid_upright": "Rigid backrest, upright",
    "rigid_reclined": "Rigid backrest, 15° back",
    "foam_reclined": "Foam backrest, 15° back",
    "BMI": "Body mass index",
    "age": "Age",
    "weight": "Weight",
    "stature": "Stature",
    "gender": "Gender",
}
_UNITS = {"BMI": " kg/m²", "age": " years", "weight": " kg", "stature": " cm"}


def write_validation_report(results: list[Result], path: Path | str) -> None:
    """Write the comparison as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    drawn = [r for r in results if _DRAWN.get(r.case.table) == r.case.kind]
    charts = []
    for condition in dict.fromkeys(r.case.condition for r in drawn):
        here = [r for r in drawn if r.case.condition == condition]
        charts.append({"title": _TITLES[condition], "rows": _key(here), "figure": _chart(here)})
    page = template("validation.html").render(
        charts=charts,
        means=[_mean_row(row) for row in mean_errors(results)],
        rows=[_row(result) for result in _told(results)],
        plotly=get_plotlyjs(),
    )
    write_whole(path, page)


def validation_summary(results: list[Result]) -> list[Table]:
    """Resonance (Hz), peak and static mass (kg) of every person, and mean errors (%)."""
    tables: list[Table] = []
    for result in _told(results):
        row = _row(result)
        del row["error to thesis"]  # a terminal is narrow
        title = f"\nTable {row.pop('table')}: {row.pop('condition')}"
        if not tables or tables[-1].title != title:
            tables.append(_table(title, row))
        tables[-1].add_row(*row.values())
    means = [_mean_row(mean) for mean in mean_errors(results) if mean["measured"] is not None]
    for mean in means:
        del mean["ours to thesis"]
    tables.append(_table("\nMean errors of resonance, peak and static, %", means[0]))
    for mean in means:
        tables[-1].add_row(*mean.values())
    return tables


def _table(title: str, columns: Iterable[str]) -> Table:
    table = Table(title=title, title_justify="left", box=None, expand=False)
    for column in columns:
        table.add_column(column.replace(" to ", "\nto "), no_wrap=True)
    return table


def _told(results: list[Result]) -> list[Result]:
    """One result for each person: table 25 has those of table 24 over again, but for one."""
    persons = {(r.case.condition, r.case.row, r.case.kind): r for r in results[::-1]}
    return [r for r in results if persons[r.case.condition, r.case.row, r.case.kind] is r]


def _row(result: Result) -> dict[str, str]:
    """A result in words, by column."""
    case, ours = result.case, result.numbers
    return {
        "table": str(case.table),
        "condition": _TITLES[case.condition],
        "row": _label(result),
        "subject": case.kind,
        "ours": _three(ours),
        "thesis": _three(case.thesis),
        "error to thesis": _percents(ours.errors(case.thesis)) if case.thesis else "",
        "measured": _three(case.measured),
        "error to measured": _percents(ours.errors(case.measured)) if case.measured else "",
    }


def _mean_row(mean: dict[str, Any]) -> dict[str, str]:
    return {
        "table": str(mean["table"]),
        "condition": _TITLES[mean["condition"]],
        "subject": mean["subject"],
        "ours to measured": _percents(mean["measured"]),
        "thesis to measured": _percents(mean["thesis_measured"]),
        "ours to thesis": _percents(mean["thesis"]),
    }


def _label(result: Result) -> str:
    return f"{result.case.row}{_UNITS.get(result.case.condition, '')}"


def _three(numbers: Numbers | None) -> str:
    if numbers is None:
        return ""
    return f"{numbers.resonance:.2f}, {numbers.peak:.0f}, {numbers.static:.0f}"


def _percents(errors: Any) -> str:
    return "" if errors is None else ", ".join(f"{error:.1f}" for error in errors)


def _key(results: list[Result]) -> list[tuple[str, str]]:
    """Name and colour of each row."""
    return [(_label(result), colour) for result, colour in zip(results, _COLOURS, strict=False)]


def _chart(results: list[Result]) -> Figure:
    """Apparent mass over frequency; marks where resonance and static value are published."""
    data: list[Figure] = []
    for result, colour in zip(results, _COLOURS, strict=False):
        case = result.case
        data.append(
            {
                "x": [round(float(f), 3) for f in result.frequencies],
                "y": [round(float(m), 3) for m in result.magnitude],
                "mode": "lines",
                "line": {"color": colour, "width": 2},
                "hovertemplate": f"{_label(result)}: %{{y:.1f}} kg at %{{x:.2f}} Hz<extra></extra>",
            }
        )
        for source, published, symbol in (
            ("thesis", case.thesis, "diamond-open"),
            ("measured", case.measured, "circle"),
        ):
            if published is None:
                continue
            data.append(
                {
                    "x": [float(result.frequencies[0]), published.resonance],
                    "y": [published.static, published.peak],
                    "mode": "markers",
                    "marker": {"color": colour, "size": 9, "symbol": symbol},
                    "cliponaxis": False,
                    "hovertemplate": f"{_label(result)}, {source}: %{{y:.1f}} kg at %{{x:.2f}} Hz"
                    "<extra></extra>",
                }
            )
    look = layout(axis("Frequency, Hz") | {"range": [0, 20]})
    look["yaxis"] = axis("Apparent mass, kg") | {"rangemode": "tozero"}
    return {"data": data, "layout": look}
