"""Peaks of a magnitude over frequency, found to rounding and not to a step of frequency.

Along s = iω the logarithm L of H(s) s^p has exact derivatives: those of X in

    Z X = b,   Z X' = b' - Z' X,   Z X'' = b'' - Z'' X - 2 Z' X',   Z = s² M + s C + K,

come from one factorisation each. A peak is where d ln|H| / dω = Re(i L') is zero and
d² ln|H| / dω² = -Re(L'') negative; Newton's method finds it from a frequency nearby,
and halves the way where it would step over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from posture_ik.arrays import Array
from posture_ik.vibration.response import frequency_response
from posture_ik.vibration.system import Complex, LinearSystem

#: Newton's steps: at most so many, each of at most this share of the frequency.
_STEPS, _LONGEST = 50, 0.05
#: After a step of at most this share of the frequency, what is left of it is rounding.
_SETTLED = 1e-7


class Magnitude(NamedTuple):
    """|H s^power| of an output over an input, named as the model's ports are.

    With power -2, an output per acceleration of what moves, or an acceleration per acceleration.
    """

    output: str
    input: str
    power: int = 0


class Peak(NamedTuple):
    """Where a magnitude is largest, Hz, and how large; both not a number if there is none."""

    frequency: float
    value: float


def magnitude(system: LinearSystem, of: Magnitude, frequency: float) -> float:
    """A magnitude at a frequency, Hz.

    Raises:
        PostureIKError: the model has no such output or input.
    """
    seen = system.of([of.input], [of.output])
    return float(np.exp(_logarithm(seen, of.power, 2 * np.pi * frequency)[0]))


def follow_peak(system: LinearSystem, of: Magnitude, near: float) -> Peak:
    """The peak of a magnitude that is reached uphill from a frequency, Hz.

    Raises:
        PostureIKError: the model has no such output or input.
    """
    seen, omega = system.of([of.input], [of.output]), 2 * np.pi * near
    rises, falls = 0.0, np.inf
    for _ in range(_STEPS):
        size, slope, curvature = _logarithm(seen, of.power, omega)
        rises, falls = (omega, falls) if slope > 0.0 else (rises, omega)
        longest = _LONGEST * omega
        # Where the curve bends upwards no peak is near: climb until it bends down.
        step = -slope / curvature if curvature < 0.0 else np.copysign(longest, slope)
        to = omega + float(np.clip(step, -longest, longest))
        if not rises <= to <= falls:  # beyond a sharp peak
            to = (rises + falls) / 2.0
        omega, step = to, to - omega
        if abs(step) <= _SETTLED * omega:
            return Peak(omega / (2 * np.pi), float(np.exp(size)))
    return Peak(np.nan, np.nan)


def highest_peaks(
    system: LinearSystem, of: Sequence[Magnitude], frequencies: Sequence[float] | Array
) -> list[Peak]:
    """The highest peak of each magnitude between the ends of some frequencies (F,), Hz.

    Peaks are told apart by these frequencies; what is largest at an end is none.

    Raises:
        BadProblem: the frequencies are not positive and ascending.
        PostureIKError: the model has no such output or input.
    """
    inputs, outputs = {one.input for one in of}, {one.output for one in of}
    response = frequency_response(system.of(sorted(inputs), sorted(outputs)), frequencies)
    found = []
    for one in of:
        seen = response["response"].sel(output=one.output, input=one.input).values
        sizes = np.abs(seen) * np.asarray(frequencies) ** one.power
        tops = 1 + np.flatnonzero((sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] >= sizes[2:]))
        if len(tops):
            highest = tops[np.argmax(sizes[tops])]
            found.append(follow_peak(system, one, float(frequencies[highest])))
        else:
            found.append(Peak(np.nan, np.nan))
    return found


def _logarithm(seen: LinearSystem, power: int, omega: float) -> tuple[float, float, float]:
    """ln|H s^power| of a model of one output and input, and its derivatives by ω."""
    s = 1j * omega
    b, Y, D = (_polynomial(part, s) for part in (seen.B, seen.Y, seen.D))
    Z = _polynomial(np.array([seen.stiffness, seen.damping, seen.mass]), s)
    factors = lu_factor(Z[0])
    X = lu_solve(factors, b[0])
    X1 = lu_solve(factors, b[1] - Z[1] @ X)
    X2 = lu_solve(factors, b[2] - Z[2] @ X - 2 * Z[1] @ X1)
    H = (Y[0] @ X + D[0]).item()
    H1 = (Y[1] @ X + Y[0] @ X1 + D[1]).item()
    H2 = (Y[2] @ X + 2 * Y[1] @ X1 + Y[0] @ X2 + D[2]).item()
    L1 = H1 / H + power / s
    L2 = H2 / H - (H1 / H) ** 2 - power / s**2
    return float(np.log(abs(H * s**power))), float((1j * L1).real), float(-L2.real)


def _polynomial(parts: Array, s: complex) -> tuple[Complex, Complex, Complex]:
    """Sum of s^k parts_k, (3, ...), and its two derivatives by s."""
    zeroth, first, second = parts
    return zeroth + s * first + s**2 * second, first + 2 * s * second, 2.0 * second + 0j
