"""The backrest's laws of eqs 44 and 45, and their stiffness at a preload."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from posture_ik.errors import PostureIKError

DATA = Path(__file__).resolve().parent / "data"


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
