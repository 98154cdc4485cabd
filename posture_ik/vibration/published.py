"""What is published of the responses, and how the same is read off a model of ours.

The figures are in the CSV files of `data/`. A mode is met by the mode of its own symmetry and of
the same number within it: the finite-element model has anti-symmetric modes that table 6 leaves
out. A peak is the highest value, or where that is told the lowest, in a band around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.tables import read_table
from posture_ik.problem import Cushion, FoamBack
from posture_ik.problem.tasks import expand_bodies
from posture_ik.vibration.seat import DATA
from posture_ik.vibration.system import LinearSystem

#: The backrest of §3.1.2 and figure 12: a spring and a damper as the cushion's, behind the mean of
#: vertebrae that the source does not name. With the thoracic ones, at T8, its peak is met best.
SOURCE_BACKREST = FoamBack(
    stiffness=Cushion().cushion.stiffness,
    damping=Cushion().cushion.damping,
    bodies=expand_bodies("T1-T12"),
    at="T8",
)
#: What the person sits in, by the tables' name for it.
SEATS: dict[str, dict[str, Any]] = {
    "bare": {},
    "backrest": {"backrest": SOURCE_BACKREST},
    "cushion": {"cushion": Cushion()},
}
#: Steps of the source's responses, Hz (FREQ1, §3.3.2).
STEP = 0.05


class Mode(NamedTuple):
    """A published mode: its frequency, Hz, whether it is symmetric, and why ours may differ."""

    frequency: float
    symmetric: bool
    note: str


class Peak(NamedTuple):
    """A published peak or valley of a response.

    Attributes:
        model: by name; `seat` is one of `SEATS`.
        given, read: input and output. Their ratio is one of accelerations, unless the unit says it
            is a force's over an acceleration (kg) or a velocity (N s/m).
        size, unit: what is published.
        frequency: where, Hz, if that is.
        band: in which it is sought, Hz.
        valley: whether it is the lowest value.
        note: why ours may differ.
    """

    model: str
    seat: str
    given: str
    read: str
    size: float
    unit: str
    frequency: float | None
    band: tuple[float, float]
    valley: bool
    note: str

    def lies_in(self, sizes: Array) -> bool:
        """Whether a sampled response has such a peak or valley, not only an end of the band."""
        i = int(np.argmin(sizes) if self.valley else np.argmax(sizes))
        return 0 < i < len(sizes) - 1

    def found(self, frequencies: Array, sizes: Array) -> tuple[float, float]:
        """Size and frequency of the same in a sampled response: the highest, or lowest, sample.

        Where the band has none inside it, of the sample nearest to the published frequency.
        """
        i = int(np.argmin(sizes) if self.valley else np.argmax(sizes))
        if self.frequency and not self.lies_in(sizes):
            i = int(np.argmin(np.abs(frequencies - self.frequency)))
        return float(sizes[i]), float(frequencies[i])

    def refined(self, frequencies: Array, sizes: Array) -> tuple[float, float]:
        """As `found`, by a parabola through that sample and its neighbours."""
        sign, step = -1.0 if self.valley else 1.0, frequencies[1] - frequencies[0]
        i = int(np.clip(np.argmax(sign * sizes), 1, len(sizes) - 2))
        a, b, c = np.polyfit(frequencies[i - 1 : i + 2] - frequencies[i], sizes[i - 1 : i + 2], 2)
        at = float(np.clip(-b / (2 * a), -step, step)) if sign * a < 0 else 0.0
        return float(a * at**2 + b * at + c), float(frequencies[i] + at)


def peaks(table: str) -> dict[str, Peak]:
    """The peaks of a table of `data/`, by name."""
    return {
        name: Peak(
            row.get("model", "finite_element"),
            row["set"],
            row["input"],
            row["output"],
            float(row["peak"]),
            row["unit"],
            float(row["frequency_Hz"]) if row["frequency_Hz"] else None,
            (float(row["from_Hz"]), float(row["to_Hz"])),
            "valley" in name,
            row.get("note", ""),
        )
        for name, row in read_table(DATA / f"{table}.csv").items()
    }


def table_6(column: str = "frequency_Hz") -> dict[str, Mode]:
    """Modes of table 6 by number, those that the column has."""
    return {
        number: Mode(float(row[column]), row["symmetric"] == "1", row["note"])
        for number, row in read_table(DATA / "table_6_modes.csv").items()
        if row[column]
    }


def matched(system: LinearSystem) -> dict[str, float]:
    """The frequencies that stand for table 6's, Hz, by number."""
    frequencies, symmetric = modes(system, 40)
    pools = {True: list(frequencies[symmetric]), False: list(frequencies[~symmetric])}
    return {number: pools[mode.symmetric].pop(0) for number, mode in table_6().items()}


def modes(system: LinearSystem, most: int) -> tuple[Array, npt.NDArray[np.bool_]]:
    """The lowest undamped frequencies, Hz, and whether each is symmetric, (most,).

    What `undamped_modes` tells at length, in a tenth of the time.
    """
    squares, shapes = scipy.linalg.eigh(
        system.stiffness, system.mass, subset_by_index=[0, most - 1]
    )
    odd = np.array([name.split()[-1] in ("y", "rx", "rz") for name in system.coordinates])
    mirror = np.einsum("in,ij,jn->n", shapes, system.mass, np.where(odd, -1, 1)[:, None] * shapes)
    return np.sqrt(squares) / (2 * np.pi), mirror > 0


def sampled(
    system: LinearSystem, sought: Mapping[str, Peak], step: float = STEP
) -> dict[str, tuple[Array, Array]]:
    """The responses of a model around peaks, solved directly.

    Args:
        system: in the seat of all these peaks.
        sought: by name.
        step: Hz, counted from 0.1 Hz on, as the source's is.

    Returns:
        For each name the frequencies of its band, Hz, and the response there, in its unit; (f,).
    """
    matrices = np.stack([system.stiffness, system.damping, system.mass])
    solved: dict[tuple[str, tuple[float, float]], Array] = {}
    responses = {}
    for name, peak in sought.items():
        first, last = (round((end - 0.1) / step) for end in peak.band)
        frequencies = 0.1 + step * np.arange(first, last + 1.0)
        powers = (2j * np.pi * frequencies)[:, None] ** np.arange(3)
        one = system.of([peak.given], [peak.read])
        if (peak.given, peak.band) not in solved:
            found = [
                np.linalg.solve(np.tensordot(s, matrices, 1), s @ one.B[:, :, 0]) for s in powers
            ]
            solved[peak.given, peak.band] = np.array(found)
        x = solved[peak.given, peak.band]
        read = np.sum((powers @ one.Y[:, 0]) * x, axis=1) + powers @ one.D[:, 0, 0]
        over = np.abs(powers[:, 1 if peak.unit == "N s/m" else 2])
        responses[name] = frequencies, np.abs(read) / over
    return responses
