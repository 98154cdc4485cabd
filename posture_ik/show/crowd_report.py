"""What became of many random people: a summary, a page of charts and a table for others to read."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs
from rich.table import Table

from posture_ik.arrays import Array
from posture_ik.crowd import STAGES, Outcome
from posture_ik.files import whole_file, write_whole
from posture_ik.show.plots import Figure, axis, layout
from posture_ik.show.words import template, who

#: A chart draws at most so many people; the numbers beside it are of all.
_DRAWN = 2000


def write_crowd(outcomes: Sequence[Outcome], wall: float, folder: Path) -> None:
    """Write `people.csv`, a row a person, and `people.html`, a page that opens offline.

    Args:
        outcomes: of everybody, one at least.
        wall: what it took in all, s.
        folder: where to.

    Raises:
        UnwritableOutput: a file cannot be written.
    """
    records = [outcome.record() for outcome in outcomes]
    with (
        whole_file(folder / "people.csv") as scratch,
        scratch.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.DictWriter(file, list(records[0]))
        writer.writeheader()
        writer.writerows(records)
    page = template("people.html").render(
        count=len(outcomes),
        drawn=min(len(outcomes), _DRAWN),
        rows=_rows(outcomes, wall),
        troubled=[(who(o.subject), o.trouble) for o in outcomes if o.trouble],
        charts=_charts(outcomes),
        plotly=get_plotlyjs(),
    )
    write_whole(folder / "people.html", page)


def crowd_summary(outcomes: Sequence[Outcome], wall: float) -> Table:
    """How many sit and answer, who does not and why, in which range, in what time."""
    table = Table(title=f"{len(outcomes)} random people", title_justify="left", show_header=False)
    for what, said in _rows(outcomes, wall):
        table.add_row(what, said)
    return table


def _rows(outcomes: Sequence[Outcome], wall: float) -> list[tuple[str, str]]:
    """Each line of the summary: what, and what is said of it."""
    sound = [outcome for outcome in outcomes if not outcome.trouble]
    rows = [("seated and shaken, all sound", f"{len(sound)} of {len(outcomes)}")]
    troubles = Counter(outcome.trouble for outcome in outcomes if outcome.trouble)
    rows += [(f"{count} of them not", trouble) for trouble, count in troubles.most_common()]
    if sound:
        rows += [
            ("posture solved by", _counted(outcome.solver for outcome in sound)),
            ("response found by", _counted(outcome.method for outcome in sound)),
            ("resonance, Hz", _range([o.resonance for o in sound])),
            ("peak over body weight", _range([o.peak / o.subject.weight for o in sound])),
            ("static over body weight", _range([o.static / o.subject.weight for o in sound])),
            ("head over seat, at most", _range([o.head for o in sound])),
        ]
        parts = 1e3 * np.array([outcome.seconds for outcome in sound])
        timed = np.column_stack([parts.sum(axis=1), parts]).T
        for stage, part in zip(("a person in all", *STAGES), timed, strict=True):
            median, late, worst = np.quantile(part, [0.5, 0.99, 1.0])
            said = f"{median:.1f} ms, 1 % over {late:.1f} ms, {worst:.0f} ms at worst"
            rows.append((f"time: {stage}", said))
    rows.append(("time: everybody", f"{wall:.1f} s"))
    return rows


def _counted(words: Iterable[str]) -> str:
    return ", ".join(f"{word} {count}" for word, count in Counter(words).most_common())


def _range(values: Sequence[float]) -> str:
    low, middle, high = np.quantile(values, [0.0, 0.5, 1.0])
    return f"{low:.3g} to {high:.3g}, median {middle:.3g}"


def _charts(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """Scatters of what comes out over what goes in."""
    some = outcomes[:_DRAWN]
    age = np.array([outcome.subject.age for outcome in some])
    weight = np.array([outcome.subject.weight for outcome in some])
    bmi = np.array([outcome.subject.body_mass_index for outcome in some])
    resonance, peak, head = np.array([(o.resonance, o.peak, o.head) for o in some]).T
    told = [who(outcome.subject) for outcome in some]
    years, mass_index = "Age, years", "Body mass index, kg/m²"
    charts = [
        ("Resonance over age", age, years, resonance, "Resonance, Hz", bmi, "BMI"),
        ("Resonance over body mass index", bmi, mass_index, resonance, "Resonance, Hz", age, "age"),
        ("Largest apparent mass", weight, "Weight, kg", peak, "Peak, kg", age, "age"),
        ("Largest motion of the head", bmi, mass_index, head, "Head over seat", age, "age"),
    ]
    return [
        {"title": title, "figure": _scatter(x, of, y, what, colour, by, told)}
        for title, x, of, y, what, colour, by in charts
    ]


def _scatter(
    x: Array, of: str, y: Array, what: str, colour: Array, by: str, told: Sequence[str]
) -> Figure:
    """A dot a person in the colour of a third number; who gave no answer is left out."""
    there = np.isfinite(y)
    dots = {
        "type": "scatter",
        "mode": "markers",
        "x": [round(float(value), 3) for value in x[there]],
        "y": [round(float(value), 3) for value in y[there]],
        "text": [words for words, is_there in zip(told, there, strict=True) if is_there],
        "marker": {
            "size": 5,
            "opacity": 0.75,
            "color": [round(float(value), 1) for value in colour[there]],
            "colorscale": "Viridis",
            "colorbar": {"title": {"text": by}, "thickness": 10, "outlinewidth": 0},
        },
        "hovertemplate": "%{text}<br>%{x:.1f}, %{y:.2f}<extra></extra>",
    }
    look = layout(axis(of))
    look["yaxis"] = axis(what) | {"rangemode": "tozero"}
    return {"data": [dots], "layout": look}
