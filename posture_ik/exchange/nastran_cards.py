"""The elements of the finite-element spine as Nastran's bulk cards, in groups by body.

What each becomes stands in `posture_ik.exchange.nastran`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.tables import table
from posture_ik.problem import SPINE
from posture_ik.vibration.network import average
from posture_ik.vibration.spine_elements import Elements, Link, Lump, Mean, Node

#: First numbers of grids that table 8 does not number, of rigid elements of nodes, and of links.
_OTHERS, _TIES, _LINKS = 101, 500, 1000


class _Deck(NamedTuple):
    """What the bulk cards are written of.

    Attributes:
        elements: of the person.
        dialect: whose cards.
        stiffest: springs beyond are rigid, N/m.
        grids: numbers of the nodes.
        frames: axes in use, each once; the first are the basic ones.
    """

    elements: Elements
    dialect: str
    stiffest: float
    grids: dict[str, int]
    frames: list[Array]

    def frame(self, axes: Array) -> int:
        """The number of some axes."""
        return next(i for i, known in enumerate(self.frames) if np.allclose(axes, known))


def bulk(elements: Elements, dialect: str, stiffest: float = np.inf) -> Iterator[str]:
    """Axes, nodes with their masses, the mean back, and links."""
    deck = _Deck(elements, dialect, stiffest, grids(elements), _frames(elements))
    yield "$ ==== axes of bushings, springs and a reclined person"
    for number, axes in enumerate(deck.frames[1:], 1):
        yield card("CORD2R", number, 0, 0.0, 0.0, 0.0, *axes[:, 2], *axes[:, 0])
    yield "$ ==== bodies"
    lumps = {lump.node: lump for lump in elements.lumps}
    for node in elements.nodes:
        yield from _node(deck, node, lumps.get(node.name))
    if elements.back and elements.backrest:
        yield from _mean(deck, elements.back, bool(elements.backrest.rigid))
    yield "$ ==== springs and dampers"
    for number, link in enumerate(elements.every_link, 1):
        yield from _link(deck, link, _LINKS + 100 * number)


def _node(deck: _Deck, node: Node, lump: Lump | None) -> Iterator[str]:
    """A node, what ties it to the node it moves with, and its mass."""
    grid = deck.grids[node.name]
    tied = [c for c in range(6) if c not in node.free] if node.on else []
    yield f"$ ---- {node.name}" + (f", on {node.on}" if tied else "")
    yield _grid(deck, grid, node.point, node.axes)
    if node.on and tied:
        yield _rigid(deck, _TIES + grid, deck.grids[node.on], tied, grid)
    if lump:
        # CONM2 takes products of inertia, which are the tensor's other entries but for their sign.
        tensor = (lump.tensor * (2 * np.eye(3) - 1))[np.tril_indices(3)]
        yield card("CONM2", grid, grid, 0, lump.mass, *lump.centre, None, *tensor)


def _mean(deck: _Deck, back: Mean, rigid: bool) -> Iterator[str]:
    """The mean of the back: it hangs on its vertebrae, or the first on it and on the others."""
    grid, of = deck.grids[back.name], [deck.grids[body] for body in back.of]
    yield f"$ ---- mean of {back.of[0]} to {back.of[-1]}"
    yield _grid(deck, grid, back.point, back.axes)
    if deck.dialect == "nastran":
        fields = ["RBE3", _TIES + grid, None, grid, 123456, 1.0, 123456, *of]
        if rigid:
            fields += [*[None] * (-(len(fields) - 1) % 8), "UM", of[0], 123456]
        yield card(*fields)
        return
    points = {node.name: node.point for node in deck.elements.nodes}
    each = np.eye(6 * len(of)).reshape(len(of), 6, -1)
    mean = average(list(each), [points[body] for body in back.of], back.point)
    seen = scipy.linalg.block_diag(back.axes.T, back.axes.T) @ mean
    moving = {grid: -np.eye(6), **dict(zip(of, np.hsplit(seen, len(of)), strict=True))}
    hanging = of[0] if rigid else grid
    solved = np.linalg.inv(moving.pop(hanging))
    for row in range(6):
        terms = [(hanging, row + 1, 1.0)]
        for other, motion in moving.items():
            factors = (solved @ motion)[row]
            terms += [(other, c + 1, x) for c, x in enumerate(factors) if abs(x) > 1e-12]
        pairs = [
            [*first, *second]
            for first, second in zip_longest(terms[::2], terms[1::2], fillvalue=())
        ]
        yield card("MPC", 1, *[field for pair in pairs for field in (*pair, None, None)])


def _link(deck: _Deck, link: Link, number: int) -> Iterator[str]:
    """The ends of a link, and the springs and dampers between them.

    Where some springs are rigid, one end follows the other node in them, and its own node follows
    that end: the upper one, but below the first vertebra that a rigid backrest holds the lower.
    """
    stiff = [c for c in link.sprung if link.stiffness[c] > deck.stiffest]
    springs = [c for c in link.sprung if c not in stiff]
    if not springs and not link.rigid:
        return
    yield f"$ ---- {link.name}"
    back, backrest = deck.elements.back, deck.elements.backrest
    held = SPINE.index(back.of[0]) if back and backrest and backrest.rigid else 0
    follower = int(not stiff or SPINE.index(link.upper) > held)
    places = {part.name: (part.point, part.axes) for part in deck.elements.nodes}
    if back:
        places[back.name] = back.point, back.axes
    nodes = [deck.grids[name] for name in (link.lower, link.upper)]
    ends = list(nodes)
    for side, name in enumerate((link.lower, link.upper)):
        point, axes = places[name]
        if springs and not (np.allclose(point, link.point) and np.allclose(axes, link.axes)):
            end = ends[side] = number + side + 1
            yield _grid(deck, end, link.point, link.axes)
            pair = (end, nodes[side]) if stiff and side == follower else (nodes[side], end)
            yield _rigid(deck, end, pair[0], range(6), pair[1])
    if stiff or link.rigid:
        lead = nodes[1 - follower]
        yield _rigid(deck, number, lead, link.rigid or stiff, ends[follower])
    for c in springs:
        spring, damper = number + 11 + c, number + 21 + c
        yield card("PELAS", spring, float(link.stiffness[c]))
        yield card("CELAS1", spring, spring, ends[0], c + 1, ends[1], c + 1)
        yield card("PDAMP", damper, float(link.damping[c]))
        yield card("CDAMP1", damper, damper, ends[0], c + 1, ends[1], c + 1)


def grids(elements: Elements) -> dict[str, int]:
    """Numbers of the nodes: those of table 8, and others behind."""
    numbers = {name: int(row["id"]) for name, row in table("table_8_nodes").items()}
    names = [node.name for node in elements.nodes] + ([elements.back.name] if elements.back else [])
    others = [name for name in names if name not in numbers]
    return {**numbers, **{name: _OTHERS + i for i, name in enumerate(others)}}


def _frames(elements: Elements) -> list[Array]:
    """Axes in use, each once; the first are the basic ones."""
    frames = [np.eye(3)]
    every = [node.axes for node in elements.nodes] + [link.axes for link in elements.every_link]
    for axes in every:
        if not any(np.allclose(axes, known) for known in frames):
            frames.append(axes)
    return frames


def _grid(deck: _Deck, number: int, point: Array, axes: Array) -> str:
    return card("GRID", number, 0, *point, deck.frame(axes))


def _rigid(deck: _Deck, number: int, lead: int, components: Iterable[int], follower: int) -> str:
    name = {"nastran": "RBE2", "nastran95": "CRBE2"}[deck.dialect]
    return card(name, number, lead, int("".join(str(c + 1) for c in components)), follower)


def card(*fields: Any) -> str:
    """A card in fields of 8 columns, or of 16 where its numbers need them."""
    from pyNastran.bdf.field_writer_8 import print_card_8
    from pyNastran.bdf.field_writer_16 import print_card_16

    short = all(_fits(field) for field in fields if isinstance(field, float))
    text: str = (print_card_8 if short else print_card_16)(list(fields))
    return text.rstrip("\n")


def _fits(number: float) -> bool:
    """Whether 8 columns hold a number to the 10th digit."""
    return len(f"{number:.10g}") < 8 or bool(np.isclose(number, float(f"{number:.3e}"), 1e-10, 0.0))


def continued(lines: Iterable[str]) -> Iterator[str]:
    """Name what continues a card, in its own first field and the last one before it."""
    ahead = ""
    for number, line in enumerate("\n".join(lines).split("\n")):
        if line[:1] in ("*", " "):
            mark = ("*" if line[0] == "*" else "+") + f"{number:07d}"
            yield f"{ahead:<72}{mark}"
            ahead = mark + line[8:]
            continue
        if ahead:
            yield ahead
        ahead = line
    yield ahead
