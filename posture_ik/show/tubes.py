"""The muscles as numbers for the 3D page, which draws each as a tube and carries it along."""

from __future__ import annotations

from typing import Any

import numpy as np

from posture_ik.arrays import Array
from posture_ik.muscle import Activity, Paths
from posture_ik.muscle.activity import ARMS
from posture_ik.show.effort import RAMP, muscle_name
from posture_ik.show.moving import packed, shown_steps

#: Points of each muscle, evenly spaced along its path; they are packed in steps of this, m.
POINTS, GRAIN = 20, 1e-4
#: Shown instants a second, and the most in all; between two the page moves points straight.
_A_SECOND, _MOST = 20.0, 300
#: Force that a cross-section bears, Pa, and the share of the radius it takes that is drawn: bones
#: stay in sight, and stronger muscles are still thicker.
_STRESS, _DRAWN = 0.5e6, 0.36
#: Thinnest and thickest that a muscle is drawn, m.
_THIN, _THICK = 0.003, 0.0095


def tubes(activity: Activity) -> dict[str, Any]:
    """Where the muscles are at each shown instant, and how active.

    `points` (f, 50, 20, 3) in tenths of a millimetre, world axes; `activation` and `force` (f, 50),
    N; `radii` (50,), m, at the muscles' bellies.
    """
    steps = _steps(activity)
    paths = Paths.of(activity.shown.body)
    points = [[along(line) for line in paths.polylines(activity.q[i])] for i in steps]
    radii = _DRAWN * np.sqrt(activity.muscles.peak_force / _STRESS / np.pi)
    return {
        "names": [
            f"{side} {muscle_name(name)}"
            for side, (here, _) in ARMS.items()
            for name in activity.muscles.names[here]
        ],
        "time": packed(activity.time[steps]),
        "count": POINTS,
        "grain": GRAIN,
        "points": packed(np.round(np.array(points) / GRAIN), "<i2"),
        "activation": packed(activity.activation[steps]),
        "force": packed(activity.force[steps]),
        "radii": packed(np.clip(radii, _THIN, _THICK)),
        "ramp": RAMP,
    }


def riders(activity: Activity) -> dict[str, Any]:
    """How the muscles' points ride on links as those move a little: between corners of the paths.

    `corners` (c, 3), m, of all paths, each carried by one of `links`; `before` (50, 20), the number
    of the corner before each point, and `share` (50, 20), how far it lies towards the next.

    Args:
        activity: whose first instant counts.
    """
    paths, q = Paths.of(activity.shown.body), activity.q[0]
    lines, carriers = paths.polylines(q), paths.carriers(q)
    links = sorted({link for those in carriers for link in those})
    places = np.array([_even(line, POINTS) for line in lines])
    lengths = np.array([len(line) for line in lines])
    before = np.minimum(places.astype(int), lengths[:, None] - 2)
    starts = np.cumsum(lengths) - lengths
    return {
        "links": links,
        "corners": packed(np.concatenate(lines)),
        "carriers": packed([links.index(link) for those in carriers for link in those], "u1"),
        "before": packed(before + starts[:, None], "<i2"),
        "share": packed(places - before),
    }


def along(line: Array, count: int = POINTS) -> Array:
    """Points (count, 3) evenly along a broken line (k, 3)."""
    places, corners = _even(line, count), np.arange(len(line))
    return np.column_stack([np.interp(places, corners, of) for of in line.T])


def _even(line: Array, count: int) -> Array:
    """Where `count` even points of a broken line (k, 3) lie, from 0, its first point, to k - 1."""
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places: Array = np.interp(np.linspace(0.0, run[-1], count), run, np.arange(len(line)))
    return places


def _steps(activity: Activity) -> list[int]:
    """Steps to show: of those that the page plays at most 20 a second, first and last too."""
    shown = shown_steps(activity.time) if len(activity.time) > 1 else np.array([0])
    span = float(activity.time[-1] - activity.time[0])
    count = min(max(int(span * _A_SECOND) + 1, 11), _MOST, len(shown))
    return sorted(set(shown[np.linspace(0, len(shown) - 1, count).round().astype(int)].tolist()))
