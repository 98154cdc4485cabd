"""Forces and moments on the person as arrows and arcs, each with its label."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from posture_ik.posture import Wrench
from posture_ik.show.paper import Array, Paper, arc, arrow, text

#: Length of the longest arrow on paper (mm).
_LONGEST = 200.0
#: Width of a letter, and from line to line, on paper (mm).
_LETTER, _LINE = 18.0, 38.0


class _Label(NamedTuple):
    words: str
    at: Array
    to_the_left: bool
    style: str


def draw_forces(paper: Paper, wrenches: Sequence[Wrench], low: Array, high: Array) -> str:
    """Draw forces as arrows in proportion, and moments about the reader's line of sight as arcs.

    Labels say what is drawn, that is what acts in the plane of the paper, and stay inside the
    window from `low` to `high` on paper (mm). What is too small beside the largest is left out.
    """
    longest = max((float(np.linalg.norm(w.force)) for w in wrenches), default=0.0)
    turning = max((float(np.linalg.norm(w.moment)) for w in wrenches), default=0.0)
    drawn, labels = [], []
    for label, force, moment, point in wrenches:
        tip = paper.project(point)[0]
        along = paper.project(force)[0] / 1000.0
        clockwise = float(moment[1] if paper.view == "side" else -moment[0])
        has_arrow = np.linalg.norm(along) > max(0.2 * longest, 0.05)
        has_arc = abs(clockwise) > max(0.05 * turning, 0.01)
        tail = tip - _LONGEST * along / longest if has_arrow else tip + np.array([66.0, -20.0])
        words = []
        if has_arrow:
            drawn.append(arrow(tail, tip, "force"))
            words.append(f"{np.linalg.norm(along):.3g} N")
        if has_arc:
            drawn.append(arc(tip, clockwise > 0.0, "moment"))
            words.append(f"{abs(clockwise):.3g} N m")
        if words:
            style = "force" if has_arrow else "moment"
            to_the_left = bool(has_arrow and along[0] > 0.0)
            beside = tail + np.array([0.0, 34.0 if tail[1] > tip[1] + 40.0 else -20.0])
            labels.append(_Label(f"{label} {', '.join(words)}", beside, to_the_left, style))
    return "".join(drawn) + _write(labels, low, high)


def _write(labels: Sequence[_Label], low: Array, high: Array) -> str:
    """Write labels inside the window, each moved down until it covers none before it."""
    taken: list[tuple[float, float, float]] = []
    written = []
    for words, at, to_the_left, style in labels:
        width = _LETTER * len(words) + 20.0
        x = float(np.clip(at[0] - width * to_the_left, low[0], high[0] - width))
        y = float(min(at[1], high[1] - 20.0))
        while any(abs(y - v) < _LINE and a < x + width and x < b for a, b, v in taken):
            y += _LINE / 4.0
        taken.append((x, x + width, y))
        written.append(text(np.array([x, y]), words, style))
    return "".join(written)
