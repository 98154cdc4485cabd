"""Published numbers beside ours, and what a search found, in tables and on a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs
from rich.console import Group
from rich.table import Table
from rich.text import Text

from posture_ik.files import write_whole
from posture_ik.show.plots import Figure, axis, layout
from posture_ik.show.words import template

#: Differences up to which a number is called near, and far beyond, %.
_NEAR, _FAR = 5.0, 12.0
_COLOURS = {"near": "#1f7a4d", "off": "#e07a1f", "far": "#b3261e"}
_STYLES = {"near": "green", "off": "yellow", "far": "red"}


def comparison(rows: Sequence[Mapping[str, Any]]) -> Group:
    """The rows of `compare` as tables for the terminal, one a source."""
    tables: dict[str, Table] = {}
    for row in rows:
        table = tables.setdefault(row["source"], _table(row["source"]))
        difference = row["difference_percent"]
        table.add_row(
            row["quantity"],
            f"{row['thesis']:.4g}",
            f"{row['ours']:.4g}",
            "" if row["unit"] == "1" else row["unit"],
            Text(f"{difference:+.1f} %", style=_STYLES[_word(difference)]),
            row["note"],
        )
    counted = Text(f"\n{_counted(rows)}")
    return Group(*tables.values(), counted)


def identification(found: Mapping[str, Any]) -> Group:
    """What `identify` found as tables for the terminal."""
    values = Table(title=f"Found: {found['chosen']}", title_justify="left", box=None)
    values.add_column("value")
    values.add_column("found", justify="right")
    values.add_column("10 % more of it moves most")
    for name, changes in found["sensitivity_percent"].items():
        most = max(changes, key=lambda key: abs(changes[key]))
        values.add_row(name, f"{found['values'][name]:g}", f"{most} {changes[most]:+.1f} %")
    results = Table(title="What was wanted", title_justify="left", box=None)
    results.add_column("result")
    for name in ("wanted", "found", "difference"):
        results.add_column(name, justify="right")
    for name, result in found["results"].items():
        difference = result["difference_percent"]
        told = Text(f"{difference:+.1f} %", style=_STYLES[_word(difference)])
        results.add_row(name, f"{result['wanted']:g}", f"{result['found']:.4g}", told)
    return Group(values, "", results)


def write_comparison(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write the rows of `compare` as one page that opens offline.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    sources = list(dict.fromkeys(row["source"] for row in rows))
    page = template("compare.html").render(
        title="Published numbers beside ours",
        counted=_counted(rows),
        tables={
            source: [row | {"word": _word(row["difference_percent"])} for row in of]
            for source in sources
            for of in [[dict(row) for row in rows if row["source"] == source]]
        },
        chart=_chart(rows),
        height=90 + 19 * len(rows),
        plotly=get_plotlyjs(),
    )
    write_whole(path, page)


def _table(source: str) -> Table:
    table = Table(title=f"\n{source}", title_justify="left", box=None)
    table.add_column("quantity")
    table.add_column("published", justify="right")
    table.add_column("ours", justify="right")
    table.add_column("unit")
    table.add_column("difference", justify="right")
    table.add_column("why")
    return table


def _word(difference: float) -> str:
    size = abs(difference)
    return "near" if size <= _NEAR else "off" if size <= _FAR else "far"


def _counted(rows: Sequence[Mapping[str, Any]]) -> str:
    words = [_word(row["difference_percent"]) for row in rows]
    return (
        f"Of {len(rows)} published numbers {words.count('near')} are met within {_NEAR:g} %, "
        f"{words.count('off')} more within {_FAR:g} %; {words.count('far')} are farther off."
    )


def _chart(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """A dot a number, by how far ours is from it, the first on top."""
    labels = [f"{row['source']}: {row['quantity']} [{row['unit']}]" for row in rows][::-1]
    off = [row["difference_percent"] for row in rows][::-1]
    told = [f"published {row['thesis']:g}, ours {row['ours']:.4g} {row['unit']}" for row in rows][
        ::-1
    ]
    dots = {
        "type": "scatter",
        "mode": "markers",
        "x": off,
        "y": labels,
        "text": told,
        "marker": {"size": 9, "color": [_COLOURS[_word(value)] for value in off]},
        "hovertemplate": "%{y}<br>%{text}<br>%{x:+.1f} %<extra></extra>",
    }
    band = {
        "type": "rect",
        "x0": -_NEAR,
        "x1": _NEAR,
        "y0": 0,
        "y1": 1,
        "yref": "paper",
        "fillcolor": "#eef5f0",
        "line": {"width": 0},
        "layer": "below",
    }
    return {"data": [dots], "layout": layout(axis("ours over published, %")) | {"shapes": [band]}}
