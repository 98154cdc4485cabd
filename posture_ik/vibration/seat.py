"""Seats: the seat and cushion of table 5, and backrests on the mean motion of the back.

A backrest acts at a point 0.1 m behind T7 that moves as the mean of T1 to T10 (an RBE3). A rigid
one holds every component of that motion but the slide along the back; a foam one is a spring and a
damper across the back. Both may hold the slide by a spring and a damper too, as friction does.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from posture_ik.body.tables import numbers, read_table
from posture_ik.errors import PostureIKError

DATA = Path(__file__).resolve().parent / "data"

#: What a backrest touches, and how far behind the middle of it, m (§5.2.1).
BACK = tuple(f"T{i}" for i in range(1, 11))
BEHIND = ("T7", 0.1)


class Layer(NamedTuple):
    """A mass (kg) on a spring (N/m) and a damper (N s/m), vertical."""

    mass: float
    stiffness: float
    damping: float


class Cushion(NamedTuple):
    """A seat on the floor and a cushion on the seat, under the person (figure 8)."""

    seat: Layer
    cushion: Layer

    @classmethod
    def of_table_5(cls) -> Cushion:
        """The values of table 5."""
        rows = read_table(DATA / "table_5_seat.csv").values()
        columns = "mass_kg", "stiffness_N_m", "damping_N_s_m"
        return cls(*(Layer(*numbers(row, *columns)) for row in rows))


class Backrest(NamedTuple):
    """A backrest: springs (N/m) and dampers (N s/m) across the back and along it.

    Attributes:
        stiffness: across the back; None for a rigid backrest.
        damping: across the back.
        tangential_stiffness: along the back, as friction holds it there: 0 slides freely.
        tangential_damping: along the back.
    """

    stiffness: float | None = None
    damping: float = 0.0
    tangential_stiffness: float = 0.0
    tangential_damping: float = 0.0


#: Rigid, and free to slide along (§5.2.1).
RIGID = Backrest()
#: The foam of Toward and Griffin (2010), as §5.2.1 gives it.
FOAM = Backrest(stiffness=21e3, damping=109.0)


def law(strain: float, bilateral: bool = False) -> tuple[float, float]:
    """Force (N) of a backrest's rod, and its derivative, by its strain (eqs 44 and 45).

    F(ε) = 250/3 (ε³ − ε³ tanh 15ε)    which resists only a back pressed into it, ε < 0
    F(ε) = 500/3 ε³                    which also holds it back, as a belt does (bilateral)
    """
    cubic, slope = 250.0 / 3.0 * strain**3, 250.0 * strain**2
    if bilateral:
        return 2.0 * cubic, 2.0 * slope
    bend = np.tanh(15.0 * strain)
    return float(cubic * (1 - bend)), float(slope * (1 - bend) - 15.0 * cubic * (1 - bend**2))


def law_stiffness(preload: float, bilateral: bool = False, length: float = 0.1) -> float:
    """Stiffness across the back of the laws of eqs 44 and 45, linearised at their preload.

    A back that touches without pressing meets none, by either law.

    Args:
        preload: force with which the back presses, N; negative where a bilateral law pulls.
        bilateral: which law.
        length: of the undeformed rod, m.

    Returns:
        The tangent dF/dl, N/m.

    Raises:
        PostureIKError: the preload squeezes the rod to nothing, or pulls on a unilateral one.
    """
    most = -law(-1.0, bilateral)[0]
    least = -most if bilateral else 0.0
    if not least <= preload < most:
        raise PostureIKError(
            f"backrest preload = {preload:g} N: must be at least {least:.0f} N and less than "
            f"{most:.1f} N, what the law bears until its rod is squeezed to nothing."
        )
    if bilateral:
        strain = -np.cbrt(3.0 / 500.0 * preload)
    else:
        strain = brentq(lambda strain: law(strain)[0] + preload, -1.0, 0.0)
    return law(strain, bilateral)[1] / length
