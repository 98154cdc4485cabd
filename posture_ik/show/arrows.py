"""Forces and moments as arrows: where they stand, how long they are, what is written at them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from posture_ik.arrays import Array
from posture_ik.posture import Posture, Wrench

#: Length of the largest force's arrow, and of the least, m.
_LONGEST, _SHORTEST = 0.30, 0.06
#: Less than this share of the largest is not drawn, nor less than so many N or N m.
_NEGLIGIBLE, _LEAST = 0.01, 0.05


class Arrow(NamedTuple):
    """A force to draw: it pushes at `tip`, coming from `tail` (3,), m."""

    name: str
    tail: Array
    tip: Array


class Turn(NamedTuple):
    """A moment to draw: it turns about `axis` (3,), a unit vector, through `centre` (3,), m."""

    name: str
    centre: Array
    axis: Array
    radius: float


class Label(NamedTuple):
    """What is written beside a force and a moment: at `at`, seen from `start` outwards (3,), m."""

    name: str
    force: str
    moment: str
    at: Array
    start: Array


def acting(posture: Posture) -> list[Wrench]:
    """What acts on the person; the backrest's push at each vertebra where contact is one-sided."""
    if not posture.contacts:
        return [*posture.wrenches, posture.seat]
    one_sided = {c.label for c in posture.constraints if c.one_sided}
    held = [wrench for wrench in posture.wrenches if wrench.label not in one_sided]
    return [*held, *posture.contacts, posture.seat]


def arrows(wrenches: Sequence[Wrench], largest: float | None = None) -> list[Arrow]:
    """The forces as arrows whose lengths are in proportion, the largest 0.30 m.

    Args:
        wrenches: what acts.
        largest: the force drawn 0.30 m long, N; the largest of these if not given.
    """
    sizes = [float(np.linalg.norm(wrench.force)) for wrench in wrenches]
    largest = max(sizes, default=0.0) if largest is None else largest
    return [
        Arrow(
            w.label,
            w.point - w.force / size * max(_LONGEST * size / largest, _SHORTEST),
            w.point,
        )
        for w, size in zip(wrenches, sizes, strict=True)
        if size > max(_LEAST, _NEGLIGIBLE * largest)
    ]


def turns(wrenches: Sequence[Wrench], largest: float | None = None) -> list[Turn]:
    """The moments as arcs whose radii grow with the root of the moment.

    Args:
        wrenches: what acts.
        largest: the moment drawn largest, N m; the largest of these if not given.
    """
    sizes = [float(np.linalg.norm(wrench.moment)) for wrench in wrenches]
    largest = max(sizes, default=0.0) if largest is None else largest
    return [
        Turn(
            w.label,
            w.point,
            w.moment / size,
            0.045 + 0.055 * float(np.sqrt(size / largest)),
        )
        for w, size in zip(wrenches, sizes, strict=True)
        if size > max(_LEAST, _NEGLIGIBLE * largest)
    ]


def size(vector: Array) -> str:
    """How large a force or a moment is, in its own unit, for a table."""
    value = float(np.linalg.norm(vector))
    return f"{value:.3g}" if value >= _LEAST else "0"


def labels(wrenches: Sequence[Wrench]) -> list[Label]:
    """One label for each wrench that is drawn: at its arrow's tail, else below its arc."""
    arrow_of = {arrow.name: arrow for arrow in arrows(wrenches)}
    turn_of = {turn.name: turn for turn in turns(wrenches)}
    found = []
    for wrench in wrenches:
        arrow, turn = arrow_of.get(wrench.label), turn_of.get(wrench.label)
        force = f"{np.linalg.norm(wrench.force):.3g} N" if arrow else ""
        moment = f"{np.linalg.norm(wrench.moment):.3g} N m" if turn else ""
        if arrow:
            found.append(Label(wrench.label, force, moment, arrow.tail, arrow.tip))
        elif turn:
            below = turn.centre - np.array([0.0, 0.0, turn.radius])
            found.append(Label(wrench.label, force, moment, below, turn.centre))
    return found
