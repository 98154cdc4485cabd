"""Modes of a linear model: undamped and damped, what moves in them, and whether it comes to rest.

Undamped, K phi = ω² M phi. Damped, (lambda² M + lambda C + K) phi = 0, solved in first order with
the undamped modes as coordinates, in which all numbers are frequencies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import eig, eigh

from posture_ik.arrays import Array, one_thread
from posture_ik.errors import PostureIKError
from posture_ik.vibration.system import Complex, LinearSystem, rounding
from posture_ik.vibration.words import is_odd, told

#: A mode's share that must be even (or odd) to call it symmetric (anti-symmetric).
_PURE = 0.75
#: About which the poles are sought, 1/s: 5 Hz, where people answer most.
_SHIFT = 10.0 * np.pi


@dataclass(frozen=True)
class Mode:
    """One mode.

    Attributes:
        eigenvalue: lambda, 1/s; iω of an undamped mode that oscillates.
        shape: phi (n,), phiᴴ M phi = 1; complex where damped.
        symmetry: `symmetric`: left and right move as each other's mirror image; `anti-symmetric`:
            as its opposite; `mixed`: neither.
        effective_mass: how much of the mass each input moves through this mode, (p,), kg or kg m²:
            |phiᵀ B_2|².
        words: what moves.
    """

    eigenvalue: complex
    shape: Complex
    symmetry: str
    effective_mass: Array
    words: str

    @property
    def frequency(self) -> float:
        """|lambda| / 2π, Hz."""
        return abs(self.eigenvalue) / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re(lambda) / |lambda|; 1 where it does not oscillate, negative where it grows."""
        return -self.eigenvalue.real / max(abs(self.eigenvalue), np.finfo(float).tiny)

    def __str__(self) -> str:
        return f"{self.frequency:.2f} Hz, {self.symmetry}: {self.words}"


class Stability(NamedTuple):
    """Whether every motion dies away, and the mode that does so least or grows fastest."""

    stable: bool
    worst: Mode

    @classmethod
    def of(cls, modes: Sequence[Mode]) -> Stability:
        """What a model's damped modes tell."""
        worst = max(modes, key=lambda mode: mode.eigenvalue.real)
        value = np.array(worst.eigenvalue)
        return cls(bool(value.real <= rounding(value)), worst)

    def __str__(self) -> str:
        if self.stable:
            return f"stable; what lasts longest: {self.worst}"
        growth = self.worst.eigenvalue.real
        return f"unstable, doubling every {np.log(2) / growth:.2g} s: {self.worst}"


class Poles(NamedTuple):
    """A model in first order, z' = values z, and in the coordinates of its undamped modes.

    Attributes:
        values: lambda, (2 n,).
        places: from z to the coordinates, (n, 2 n).
        vectors: from z to places and speeds of the undamped modes, the places each in a unit of
            its own, (2 n, 2 n).
        shapes: undamped modes, (n, n), of mass 1; `stiffness`, `damping`: K and C in them.
    """

    values: Complex
    places: Complex
    vectors: Complex
    shapes: Array
    stiffness: Array
    damping: Array


def poles(system: LinearSystem) -> Poles:
    """Solve the damped eigenvalue problem of a model.

    A spine with its shear springs has poles from 1 to 1e9 1/s, and rounding the fastest would blot
    out the slow. So it is the inverse about a shift σ that is solved, (A - σ)⁻¹ with eigenvalues
    1 / (lambda - σ), in which the slow are the largest. With D = σ² + σ C + K, in the coordinates
    of the undamped modes,

        (A - σ)⁻¹ = [ -D⁻¹ (C + σ)   -D⁻¹ ]
                    [  D⁻¹ K        -σ D⁻¹ ]

    Raises:
        LinAlgError: M is not positive definite, or a motion grows at the very pace of the shift.
    """
    _, shapes = eigh(system.stiffness, system.mass)
    # Projected: K's own eigenvalues are the less exact.
    stiffness, damping = (shapes.T @ part @ shapes for part in (system.stiffness, system.damping))
    n = len(shapes)
    dynamic = _SHIFT**2 * np.eye(n) + _SHIFT * damping + stiffness
    speed = np.sqrt(np.maximum(np.abs(np.diag(dynamic)), _SHIFT**2))
    # As many times the speed, so that no number is far from 1 / σ.
    scaled = dynamic / np.outer(speed, speed)
    given = np.hstack([damping + _SHIFT * np.eye(n), np.eye(n), stiffness]) / speed[:, None]
    by_place, by_speed, by_spring = np.split(np.linalg.solve(scaled, given), 3, axis=1)
    inverse = np.zeros((2 * n, 2 * n))
    inverse[:n, :n], inverse[:n, n:] = -by_place / speed, -by_speed
    inverse[n:, :n] = by_spring / np.outer(speed, speed)
    inverse[n:, n:] = -_SHIFT * by_speed / speed[:, None]
    values, vectors = eig(inverse)
    places = shapes @ (vectors[:n] / speed[:, None])
    return Poles(_SHIFT + 1.0 / values, places, vectors, shapes, stiffness, damping)


def undamped_modes(system: LinearSystem) -> tuple[Mode, ...]:
    """Modes of M and K alone, lowest first; ω² below zero gives a real, positive eigenvalue.

    Raises:
        PostureIKError: M is not positive definite.
    """
    with one_thread():
        try:
            squares, shapes = eigh(system.stiffness, system.mass)
        except np.linalg.LinAlgError:
            raise _no_mass() from None
    roots = np.sqrt(squares.astype(complex))
    return _modes(system, np.where(squares < 0.0, roots.imag, 1j * roots.real), shapes + 0j)


def damped_modes(system: LinearSystem) -> tuple[Mode, ...]:
    """Modes with damping: those that oscillate, lowest |lambda| first, then those that do not.

    Of a conjugate pair the one that turns forward.

    Raises:
        PostureIKError: M is not positive definite.
    """
    with one_thread():
        try:
            found = poles(system)
        except np.linalg.LinAlgError:
            raise _no_mass() from None
    forward = np.flatnonzero(found.values.imag >= 0.0)
    kept = found.values[forward]
    order = forward[np.lexsort((np.abs(kept), kept.imag == 0.0))]
    return _modes(system, found.values[order], found.places[:, order])


def stability(system: LinearSystem) -> Stability:
    """Whether every motion of a model dies away, or at least does not grow.

    Raises:
        PostureIKError: M is not positive definite.
    """
    return Stability.of(damped_modes(system))


def mirror(coordinates: Sequence[str]) -> tuple[npt.NDArray[np.intp], Array]:
    """Mirror image of coordinates, left for right: take those at `places`, times `signs`; (n,)."""
    place = {name: i for i, name in enumerate(coordinates)}
    other = {"_r": "_l", "_l": "_r"}
    twins = [name[:-2] + other[name[-2:]] if name[-2:] in other else name for name in coordinates]
    places = np.array([place.get(twin, i) for i, twin in enumerate(twins)])
    return places, np.where([is_odd(name) for name in coordinates], -1.0, 1.0)


def _modes(
    system: LinearSystem,
    values: Complex,
    shapes: Complex,
) -> tuple[Mode, ...]:
    places, signs = mirror(system.coordinates)
    weighed = system.mass @ shapes
    shapes = shapes / np.sqrt(np.sum(shapes.conj() * weighed, axis=0).real)
    weighed = system.mass @ shapes
    even = np.sum((signs[:, None] * shapes[places]).conj() * weighed, axis=0).real
    moved = np.abs(shapes.T @ system.B[2]) ** 2
    words = told(system, shapes)
    modes = []
    for i, value in enumerate(values):
        share = (1.0 + even[i]) / 2.0
        kind = "symmetric" if share > _PURE else "anti-symmetric" if share < 1 - _PURE else "mixed"
        modes.append(Mode(complex(value), shapes[:, i], kind, moved[i], words[i]))
    return tuple(modes)


def _no_mass() -> PostureIKError:
    return PostureIKError(
        "modes: every coordinate needs a mass of its own; leave out those without, or write them "
        "in the others."
    )
