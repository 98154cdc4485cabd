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

**NASTRAN-95** differs. RBE2 is CRBE2 there, EIGRL is EIGR, and an MPC takes the place of RBE3,
whose rotations do not scale with length by themselves. No motion is given: `response.inp` (direct
frequency response, rigid format 8) holds the seat and pushes every mass by what a frame that
accelerates does, so that its accelerations are relative to the seat's. Its loads are in single
precision and so is the substitution of every solution; by springs of 1e10 N/m that leaves no digit.
Those are rigid there, in that deck alone, and their dampers with them.

Cards: MSC Nastran Quick Reference Guide; NASTRAN User's Manual, NASA SP-222(08), section 2.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from posture_ik.arrays import Array
from posture_ik.exchange.nastran_cards import bulk, card, continued, grids
from posture_ik.posture import Posture
from posture_ik.problem import Problem, VibrationBlock
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.spine_elements import Elements, spine_elements

#: Names of the two decks, modes and response.
DECKS = {"nastran": ("modes.bdf", "response.bdf"), "nastran95": ("modes.inp", "response.inp")}
#: Above it NASTRAN-95's response takes a spring for rigid, N/m.
STIFFEST = 1e9
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


def write_nastran(
    problem: Problem, folder: Path, dialect: str = "nastran", posture: Posture | None = None
) -> None:
    """Write a problem's finite-element spine as two decks into an existing folder.

    Args:
        problem: its `subject`, its `seat`, and of its `vibration` the frequencies and parameters
            count.
        folder: where.
        dialect: whose, of `DECKS`.
        posture: gives the person its shape, in place of the erect one reclined.
    """
    seat = problem.seat
    recline = float(np.radians(seat.recline_deg))
    asked = problem.vibration or VibrationBlock()
    elements = spine_elements(
        problem.subject,
        recline,
        seat.backrest,
        seat.cushion,
        factors=Factors.of(asked.parameters),
        posture=posture,
    )
    frequencies = asked.frequencies.values
    stiffest = np.inf if dialect == "nastran" else STIFFEST
    shaken = "FREQUENCY = 1\n" + "".join(
        f"SUBCASE {number}\nLABEL = 1 M/S2 {direction}\nDLOAD = {number}\n"
        for number, direction in enumerate(_DIRECTIONS, 1)
    )
    modes = [*bulk(elements, dialect), *_modes(elements, dialect)]
    response = [
        *bulk(elements, dialect, stiffest),
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
        lines = cards if dialect == "nastran" else continued(cards)
        mean = "MPC = 1\n" if dialect == "nastran95" and elements.back else ""
        (folder / name).write_text(
            head.format(title=title, solution=solution)
            + mean
            + results
            + cases
            + "\n".join(["BEGIN BULK", *lines, "ENDDATA", ""]),
            encoding="ascii",
        )


def _modes(elements: Elements, dialect: str) -> Iterator[str]:
    """The modes of a person whose seat stands: those up to 50 Hz, or the lowest 40."""
    ground = elements.nodes[0].name
    yield f"$ ==== {ground} held, and the modes asked for"
    yield card("SPC1", 1, _ALL, grids(elements)[ground])
    if dialect == "nastran":
        yield card("EIGRL", 1, None, 50.0)
    else:
        yield card("EIGR", 1, "FEER", 0.0, None, None, 40, None, None, "MASS")


def _response(elements: Elements, frequencies: Array, dialect: str) -> Iterator[str]:
    """The response to 1 m/s² along x, y and z."""
    ground = elements.nodes[0].name
    numbers = grids(elements)
    yield f"$ ==== {ground} accelerated by 1 m/s2"
    yield card("SPC1", 1, _ALL, numbers[ground])
    if dialect == "nastran":
        # Dampers tie modes: with those below 50 Hz alone the head is 20 % off or more, 200 Hz 5 %.
        yield "$ ---- modes far beyond the frequencies asked for"
        yield card("EIGRL", 1, None, max(1000.0, 50.0 * float(frequencies[-1])))
    axes = {node.name: node.axes for node in elements.nodes}
    for number, direction in enumerate(np.eye(3), 1):
        load = ("RLOAD1", 20 + number, 10 + number, None, None, 1)
        if dialect == "nastran":
            yield card("SPCD", 10 + number, numbers[ground], number, 1.0)
            yield card(*load, None, "ACCE")
        else:
            yield f"$ ---- mass times acceleration of {ground}, component {number}"
            for lump in elements.lumps:
                force = -lump.mass * direction
                wrench = np.r_[force, np.cross(lump.centre, force)].reshape(2, 3) @ axes[lump.node]
                for component, size in enumerate(wrench.ravel(), 1):
                    if size:
                        yield card("DAREA", 10 + number, numbers[lump.node], component, size)
            yield card(*load)
        yield card("DLOAD", number, 1.0, 1.0, 20 + number)
    yield card("TABLED1", 1, *[None] * 7, 0.0, 1.0, 1000.0, 1.0, "ENDT")
    yield f"$ ---- {len(frequencies)} frequencies, Hz"
    first = float(frequencies[0])
    if len(frequencies) == 1:
        yield card("FREQ", 1, first)
    else:
        yield card("FREQ1", 1, first, float(frequencies[1]) - first, len(frequencies) - 1)


def _plain(text: str) -> str:
    """Text that a card can hold."""
    return text.encode("ascii", "replace").decode()[:50]
