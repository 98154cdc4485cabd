"""What the resonance and the head's motion hang on: derivatives by who sits and what one sits on.

Each parameter p is changed alone and all is done anew: body, posture, linear model. On the model
the same peak is then followed to rounding (`posture_ik.vibration.peak`), so that differences of
peaks are as smooth as the model itself. With D(h) the central difference by p ± h,

    d/dp = (4 D(h/2) - D(h)) / 3,

whose error is of fourth order. How far D(h) and D(h/2) are apart tells whether the response is
smooth there at all, and is kept beside every derivative. The ends of a tornado's bars are no
derivatives: they are what comes out at p ± one whole step, a tenth of the parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from posture_ik.arrays import Array, one_thread
from posture_ik.errors import BadProblem
from posture_ik.problem import Problem, VibrationBlock
from posture_ik.sensitivity.parameters import Parameter, changed_model, parameters_of, seated_of
from posture_ik.sensitivity.result import Response, Sensitivity
from posture_ik.vibration import LinearSystem
from posture_ik.vibration.peak import Magnitude, Peak, follow_peak, highest_peaks, magnitude
from posture_ik.vibration.vibrate import base_of

#: The steps h of derivatives over those of a tornado's bars.
_FINE = 0.1


def sensitivity(
    problem: Problem,
    at: float | None = None,
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> Sensitivity:
    """Find what the resonance, the apparent mass and the head's motion hang on.

    The responses are the frequency and height of the highest peak of the apparent mass in the
    problem's range of frequencies, and those of the head's motion over what moves, along z and
    along x. What moves goes along z, a backrest that moves alone goes square to itself. A
    response without a peak in the range is left out.

    Args:
        problem: who sits where, and of which model; `vibration` may be left out.
        at: frequency at which the head's motion is asked, Hz, in place of its peak.
        tell: called with how many parameters are done, of how many.

    Raises:
        BadProblem: the frequency is not positive, or no response has a peak in the range.
        PostureIKError: the posture or the model cannot be found.
    """
    if at is not None and not 0.0 < at < np.inf:
        raise BadProblem("at", f"{at:g} Hz; give a frequency above zero")
    with one_thread():
        seated = seated_of(problem)
        system = changed_model(problem, seated)
        curves = _curves(problem, system, at)

        def read(parameter: Parameter, change: float) -> Array:
            value = parameter.value + change
            return _read(changed_model(problem, seated, parameter.path, value), curves)

        def slope(parameter: Parameter, h: float) -> Array:
            return (read(parameter, h) - read(parameter, -h)) / (2.0 * h)

        parameters = tuple(parameters_of(problem))
        rows = []
        for done, parameter in enumerate(parameters):
            tell(done, len(parameters))
            h, step = _FINE * parameter.step, parameter.step
            coarse, fine = slope(parameter, h), slope(parameter, h / 2.0)
            derivative = (4.0 * fine - coarse) / 3.0
            rows.append(
                (derivative, np.abs(coarse - fine), *(read(parameter, d) for d in (-step, step)))
            )
    values, resonance = _read(system, curves), curves[0].frequency
    responses = (
        Response("resonance", "Hz", resonance, resonance),
        *(
            Response(curve.name, curve.unit, value, curve.frequency)
            for curve, value in zip(curves, values[1:].tolist(), strict=True)
        ),
    )
    moved = curves[0].of.input
    return Sensitivity(
        problem, system.stable, moved, parameters, responses, *np.array(rows).swapaxes(0, 1)
    )


class _Curve(NamedTuple):
    """A magnitude that is read at its peak near a frequency, Hz, or at just that one."""

    name: str
    unit: str
    of: Magnitude
    frequency: float
    peaks: bool = True


def _curves(problem: Problem, system: LinearSystem, at: float | None) -> list[_Curve]:
    """The curves that responses are read off: the apparent mass first, then the head's motions."""
    asked, base = problem.vibration or VibrationBlock(), base_of(problem)
    frequencies = asked.frequencies.values
    axis = "x" if base == "backrest" else "z"
    moved = f"{base} {axis}"
    if moved not in [port.name for port in system.inputs]:
        raise BadProblem(
            "vibration.input", f"the model {asked.model!r} has no {base} that could move"
        )
    sought = {"apparent mass": Magnitude(f"{base} force {axis}", moved, -2)}
    outputs = [port.name for port in system.outputs]
    for to in "zx":
        for motion, power in ((f"Head {to}", 0), (f"Head acceleration {to}", -2)):
            if motion in outputs:
                sought.setdefault(f"head {to}", Magnitude(motion, moved, power))
    curves: list[_Curve] = []
    for (name, of), peak in zip(
        sought.items(), highest_peaks(system, [*sought.values()], frequencies), strict=True
    ):
        if at is not None and curves:
            curves.append(_Curve(name, "1", of, at, peaks=False))
        elif np.isfinite(peak.frequency):
            unit = "1" if curves else "kg"
            curves.append(_Curve(f"peak {name}", unit, of, peak.frequency))
        elif not curves:
            raise BadProblem(
                "vibration.frequencies",
                f"the apparent mass has no peak between {frequencies[0]:g} and "
                f"{frequencies[-1]:g} Hz; widen the range, or narrow its step",
            )
    return curves


def _read(system: LinearSystem, curves: list[_Curve]) -> Array:
    """The resonance, and then what is read off every curve; (R,)."""
    peaks = [
        follow_peak(system, curve.of, curve.frequency)
        if curve.peaks
        else Peak(curve.frequency, magnitude(system, curve.of, curve.frequency))
        for curve in curves
    ]
    return np.array([peaks[0].frequency, *(peak.value for peak in peaks)])
