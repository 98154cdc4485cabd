"""The finite-element spine as Nastran decks: its modes, and its response to a moving seat.

Both decks hold the elements of `posture_ik.vibration.spine_elements`, card by card:

    a node                  GRID, on another by RBE2 in all components but its free ones
    a mass                  CONM2
    a bushing, any spring   two GRIDs at its point, in its axes (CORD2R), each on its node by RBE2,
                            with CELAS1 (PELAS) and CDAMP1 (PDAMP) between them
    the mean of the back    RBE3
    a rigid backrest        RBE2 from the seat to the mean, which then no longer hangs on the
                            vertebrae: the lowest of them hangs on it and on the others (UM)

`modes.bdf` is SOL 103 with the seat (or the floor under a cushion) held; `response.bdf` is SOL 111,
in which it accelerates by 1 m/s² (SPCD) along x, y and z in subcases 1 to 3. Grids bear the numbers
of table 8 where it has them.

**NASTRAN-95** has no RBE2 and RBE3 but CRBE2 and CRBE3, whose weights of rotations do not scale
with length by themselves; no EIGRL but EIGR; and no motions that are given. There `response.inp`
is the direct frequency response (rigid format 8), in which a mass a million times the person's
carries the seat and is pushed by as many newtons.

Cards: MSC Nastran Quick Reference Guide; NASTRAN User's Manual, NASA SP-222(08), section 2.4.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.tables import table
from posture_ik.problem import SPINE, Problem, VibrationBlock
from posture_ik.vibration.network import average
from posture_ik.vibration.spine_elements import Elements, Link, Lump, Mean, Node, spine_elements

Dialect = Literal["nastran", "nastran95"]
#: Names of the two decks, modes and response.
DECKS = {"nastran": ("modes.bdf", "response.bdf"), "nastran95": ("modes.inp", "response.inp")}
#: Above it NASTRAN-95's response takes a spring for rigid, N/m.
STIFFEST = 1e9
#: First numbers of grids that table 8 does not number, and of links.
_OTHERS, _LINKS = 101, 1000
_DIRECTIONS = ("forward", "left", "up")
_ALL = 123456

_OPENING = """\
$ {title}
$ Written by posture_ik. Units: m, kg, s, N, rad.
$ x forward, y left, z up; the origin lies on the seat under the buttocks.
"""
_CONTROL = """\
CEND
TITLE = {title}
ECHO = NONE
$ all bodies, without the ends of springs
SET 1 = 1 THRU 999
SPC = 1
"""
_EXECUTIVE = {
    "nastran": "SOL {solution}\n",
    "nastran95": "ID POSTURE,IK\nAPP DISPLACEMENT\nSOL {solution},0\nTIME 10\n",
}
_MODES = {
    "nastran": (103, "METHOD = 1\nDISPLACEMENT = 1\n"),
    "nastran95": (3, "METHOD = 1\nDISPLACEMENT = 1\n"),
}
_RESPONSE = {
    "nastran": (111, "METHOD = 1\nACCELERATION(SORT2) = 1\nSPCFORCES(SORT2) = ALL\n"),
    "nastran95": (8, "MAXLINES = 999999999\nACCELERATION(SORT2) = 1\n"),
}


def write_nastran(problem: Problem, folder: Path, dialect: Dialect = "nastran") -> None:
    """Write a problem's finite-element spine as two decks into an existing folder.

    Args:
        problem: its `subject`, `seat` and the frequencies of its `vibration` count.
        folder: where.
        dialect: whose, of `DECKS`.
    """
    seat = problem.seat
    recline = float(np.radians(seat.recline_deg))
    elements = spine_elements(problem.subject, recline, seat.backrest, seat.cushion)
    frequencies = (problem.vibration or VibrationBlock()).frequencies.values
    stiffest = np.inf if dialect == "nastran" else STIFFEST
    shaken = "FREQUENCY = 1\n" + "".join(
        f"SUBCASE {number}\nLABEL = 1 M/S2 {direction}\nDLOAD = {number}\n"
        for number, direction in enumerate(_DIRECTIONS, 1)
    )
    modes = [*_bulk(elements, dialect), *_modes(elements, dialect)]
    response = [
        *_bulk(elements, dialect, stiffest),
        *_response(elements, frequencies, dialect),
    ]
    analyses = (
        ("modes", _MODES[dialect], "", modes),
        ("response", _RESPONSE[dialect], shaken, response),
    )
    for name, (what, (solution, results), cases, cards) in zip(
        DECKS[dialect], analyses, strict=True
    ):
        title = f"{_plain(problem.title)}: {what}"
        head = _OPENING + _EXECUTIVE[dialect] + _CONTROL
        lines = cards if dialect == "nastran" else _continued(cards)
        mean = "MPC = 1\n" if dialect == "nastran95" and elements.back else ""
        (folder / name).write_text(
            head.format(title=title, solution=solution)
            + mean
            + results
            + cases
            + "\n".join(["BEGIN BULK", *lines, "ENDDATA", ""]),
            encoding="ascii",
        )


def _modes(elements: Elements, dialect: Dialect) -> Iterator[str]:
    """The modes of a person whose seat stands: those up to 50 Hz, or the lowest 40."""
    ground = elements.nodes[0].name
    yield f"$ ==== {ground} held, and the modes asked for"
    yield _card("SPC1", 1, _ALL, _grids(elements)[ground])
    if dialect == "nastran":
        yield _card("EIGRL", 1, None, 50.0)
    else:
        yield _card("EIGR", 1, "FEER", 0.0, None, None, 40, None, None, "MASS")


def _response(elements: Elements, frequencies: Array, dialect: Dialect) -> Iterator[str]:
    """The response to 1 m/s² along x, y and z."""
    ground = elements.nodes[0].name
    grids = _grids(elements)
    yield f"$ ==== {ground} accelerated by 1 m/s2"
    yield _card("SPC1", 1, _ALL, grids[ground])
    if dialect == "nastran":
        yield "$ modes far beyond the frequencies asked for"
        yield _card("EIGRL", 1, None, 50.0 * float(frequencies[-1]))
    axes = {node.name: node.axes for node in elements.nodes}
    for number, direction in enumerate(np.eye(3), 1):
        load = ("RLOAD1", 20 + number, 10 + number, None, None, 1)
        if dialect == "nastran":
            yield _card("SPCD", 10 + number, grids[ground], number, 1.0)
            yield _card(*load, None, "ACCE")
        else:
            yield f"$ ---- mass times acceleration of {ground}, component {number}"
            for lump in elements.lumps:
                force = -lump.mass * direction
                wrench = np.r_[force, np.cross(lump.centre, force)].reshape(2, 3) @ axes[lump.node]
                for component, size in enumerate(wrench.ravel(), 1):
                    if size:
                        yield _card("DAREA", 10 + number, grids[lump.node], component, size)
            yield _card(*load)
        yield _card("DLOAD", number, 1.0, 1.0, 20 + number)
    yield _card("TABLED1", 1, *[None] * 7, 0.0, 1.0, 1000.0, 1.0, "ENDT")
    yield f"$ ---- {len(frequencies)} frequencies, Hz"
    step = float(frequencies[1] - frequencies[0]) if len(frequencies) > 1 else 1.0
    yield _card("FREQ1", 1, float(frequencies[0]), step, max(len(frequencies) - 1, 1))


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
    dialect: Dialect
    stiffest: float
    grids: dict[str, int]
    frames: list[Array]

    def frame(self, axes: Array) -> int:
        """The number of some axes."""
        return next(i for i, known in enumerate(self.frames) if np.allclose(axes, known))


def _bulk(elements: Elements, dialect: Dialect, stiffest: float = np.inf) -> Iterator[str]:
    """Axes, nodes with their masses, the mean back, and links."""
    deck = _Deck(elements, dialect, stiffest, _grids(elements), _frames(elements))
    yield "$ ==== axes of bushings, springs and a reclined person"
    for number, axes in enumerate(deck.frames[1:], 1):
        yield _card("CORD2R", number, 0, 0.0, 0.0, 0.0, *axes[:, 2], *axes[:, 0])
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
        yield _rigid(deck, grid, deck.grids[node.on], tied, grid)
    if lump:
        # CONM2 takes products of inertia, which are the tensor's other entries but for their sign.
        tensor = (lump.tensor * (2 * np.eye(3) - 1))[np.tril_indices(3)]
        yield _card("CONM2", grid, grid, 0, lump.mass, *lump.centre, None, *tensor)


def _mean(deck: _Deck, back: Mean, rigid: bool) -> Iterator[str]:
    """The mean of the back, which hangs on its vertebrae, or else the first on it and the others."""
    grid, of = deck.grids[back.name], [deck.grids[body] for body in back.of]
    yield f"$ ---- mean of {back.of[0]} to {back.of[-1]}"
    yield _grid(deck, grid, back.point, back.axes)
    if deck.dialect == "nastran":
        fields = ["RBE3", grid, None, grid, 123456, 1.0, 123456, *of]
        if rigid:
            fields += [*[None] * (-(len(fields) - 1) % 8), "UM", of[0], 123456]
        yield _card(*fields)
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
        yield _card("MPC", 1, *[field for pair in pairs for field in (*pair, None, None)])


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
        yield _card("PELAS", spring, float(link.stiffness[c]))
        yield _card("CELAS1", spring, spring, ends[0], c + 1, ends[1], c + 1)
        yield _card("PDAMP", damper, float(link.damping[c]))
        yield _card("CDAMP1", damper, damper, ends[0], c + 1, ends[1], c + 1)


def _grids(elements: Elements) -> dict[str, int]:
    """Numbers of the nodes: those of table 8, and others behind."""
    numbers = {name: int(row["id"]) for name, row in table("table_8_nodes").items()}
    names = [node.name for node in elements.nodes] + ([elements.back.name] if elements.back else [])
    others = [name for name in names if name not in numbers]
    return {**numbers, **{name: _OTHERS + i for i, name in enumerate(others)}}


def _frames(elements: Elements) -> list[Array]:
    """Axes in use, each once; the first are the basic ones."""
    frames = [np.eye(3)]
    for part in (*elements.nodes, *elements.every_link):
        if not any(np.allclose(part.axes, known) for known in frames):
            frames.append(part.axes)
    return frames


def _grid(deck: _Deck, number: int, point: Array, axes: Array) -> str:
    return _card("GRID", number, 0, *point, deck.frame(axes))


def _rigid(deck: _Deck, number: int, lead: int, components: Iterable[int], follower: int) -> str:
    name = {"nastran": "RBE2", "nastran95": "CRBE2"}[deck.dialect]
    return _card(name, number, lead, int("".join(str(c + 1) for c in components)), follower)


def _card(*fields: Any) -> str:
    """A card in fields of 8 columns, or of 16 where its numbers need them."""
    from pyNastran.bdf.field_writer_8 import print_card_8
    from pyNastran.bdf.field_writer_16 import print_card_16

    short = all(_fits(field) for field in fields if isinstance(field, float))
    card: str = (print_card_8 if short else print_card_16)(list(fields))
    return card.rstrip("\n")


def _fits(number: float) -> bool:
    """Whether 8 columns hold a number to the 10th digit."""
    return len(f"{number:.10g}") < 8 or bool(np.isclose(number, float(f"{number:.3e}"), 1e-10, 0.0))


def _continued(lines: Iterable[str]) -> Iterator[str]:
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


def _plain(text: str) -> str:
    """Text that a card can hold."""
    return text.encode("ascii", "replace").decode()[:50]
