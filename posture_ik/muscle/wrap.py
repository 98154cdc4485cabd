"""How long a muscle is between two points past a sphere or a cylinder, in closed form.

Seen along the surface's axis (for a sphere: from across the plane of both points and the centre),
the points lie at r0 and r1 from the centre and the path turns by the angle G from one to the other.
A string that bends at the radius R meets it at the incidence ψ and passes the centre at the
distance p = R sin ψ, and its length is

    W = √(r0² − p²) + √(r1² − p²) − 2 R cos ψ + p f
    f = G + asin(p/r0) + asin(p/r1) − 2 ψ

Over an `outside` surface it leaves along the tangent: ψ = 90 deg, and R f is the arc. Through an
`inside` one, a ring that it must pass, it is reflected in one point: f = 0, which gives ψ. Either
way W is stationary in ψ where f = 0 or the string is tangent, so its slopes are those at fixed ψ.

θ, the value of f at 90 deg, says who touches: a string over a surface does where θ > 0, one through
a ring where θ < 0. At θ = 0 W equals the straight distance D and so does its slope; in between

    length = D + h(θ) (W − D),  h = ½ (1 ± tanh(θ/ε))

is smooth, and off by about a thousandth of a millimetre at most (0.06 ε² over the sum of the
inverse tangents).
Along a cylinder's axis the string climbs evenly: the root of the squares of length and climb.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import casadi as ca
import numpy as np

from posture_ik.arrays import Array

#: Symbols, or numbers to follow a path with.
Expression = TypeVar("Expression", ca.SX, ca.DM)
#: Half the angle over which a surface takes hold of a path, ε, rad.
_SWITCH = 0.03
#: Keeps roots off zero, m² (beside the squares of millimetres).
_TINY = 1e-14
#: Newton steps from the chord to the incidence on a ring, each doubling the digits: 1e-8 after 3.
_NEWTON_STEPS = 3


class Surface(NamedTuple):
    """A sphere or cylinder that a path wraps on, in a link's frame.

    Attributes:
        kind: `outside` (a sphere the path runs over), `inside` (one it runs through) or `cylinder`
            (run over, endless, the path turning positively about its axis).
        centre: (3,), m.
        radius: m.
        axis: Of a cylinder, (3,), of length one.
        turn: About how far a path turns round a cylinder, rad: within half a turn of it.
    """

    kind: str
    centre: Array
    radius: float
    axis: Array | None = None
    turn: float = 0.0

    def reversed(self) -> Surface:
        """The same body for a path that runs the other way."""
        return self if self.axis is None else self._replace(axis=-self.axis)


class Ring(NamedTuple):
    """The unknown of a path through an inside sphere.

    Attributes:
        incidence: ψ as a symbol.
        value: ψ as an expression in the points, rad.
        condition: f, which vanishes at ψ and falls with it.
    """

    incidence: ca.SX
    value: ca.SX
    condition: ca.SX


class Piece(NamedTuple):
    """What lies between two points of a path.

    Attributes:
        length: As an expression in the points, and in ψ through a ring, m.
        pull: Its slope as the end moves, (3,), at fixed ψ.
        ring: The ring it may run through.
    """

    length: ca.SX
    pull: ca.SX
    ring: Ring | None = None


def straight(start: ca.SX, end: ca.SX) -> Piece:
    """A straight piece from one point (3,) to another."""
    length = ca.sqrt(ca.sumsqr(end - start))
    return Piece(length, (end - start) / length)


def bend(start: ca.SX, end: ca.SX, surface: Surface) -> Piece:
    """A piece from one point (3,) to another past a surface, all in one frame."""
    p, s = start - surface.centre, end - surface.centre
    if surface.axis is not None:
        across, axis = ca.DM(plane(surface.axis)), ca.DM(surface.axis)
        flat = _bend(across @ p, across @ s, surface)
        climb = ca.dot(axis, s - p)
        length = ca.sqrt(flat.length**2 + climb**2)
        return Piece(length, (flat.length * (across.T @ flat.pull) + climb * axis) / length)
    return _bend(p, s, surface)


def _bend(p: ca.SX, s: ca.SX, surface: Surface) -> Piece:
    """The same from the centre: in space about a sphere, in the plane about a cylinder."""
    R = surface.radius
    squares = ca.sumsqr(p), ca.sumsqr(s)
    angle, sweep = turned(p, s, surface)
    distance = ca.sqrt(ca.sumsqr(s - p) + _TINY)
    legs = [leg(square, R) for square in squares]
    theta = angle + lean(legs, R) - ca.pi
    tanh = ca.tanh(theta / _SWITCH)
    ring = None
    passing: ca.SX | float
    if surface.kind == "inside":
        incidence = ca.SX.sym("incidence")
        passing = R * ca.sin(incidence)
        condition = _condition(angle, squares, passing, incidence)
        ring = Ring(incidence, reflect(angle, squares, R), condition)
        held, rise = (1 - tanh) / 2, (tanh**2 - 1) / (2 * _SWITCH)
        touching = [leg(square, passing) for square in squares]
        longer = sum(touching) - 2 * R * ca.cos(incidence) - distance  # f = 0
    else:
        held, rise = (1 + tanh) / 2, (1 - tanh**2) / (2 * _SWITCH)
        passing, touching = R, legs
        longer = sum(legs) + R * theta - distance
    # With W' = p G' + √(r1² - p²)/r1 r1' and θ' = G' - R/(r1 √(r1² - R²)) r1'
    release = rise * longer
    clear = squares[1] > R**2 + _TINY  # a leg kept real does not change
    outward = held * touching[1] - clear * release * R / legs[1]
    pull = (held * passing + release) * sweep
    pull += outward / squares[1] * s + (1 - held) / distance * (s - p)
    return Piece(distance + held * longer, pull, ring)


def turned(p: Expression, s: Expression, surface: Surface) -> tuple[Expression, Expression]:
    """By how much a path turns from one point to another, rad, and its slope as the other moves.

    The points are as seen from the centre: (3,) of a sphere, (2,) across a cylinder.
    """
    along = ca.dot(p, s)
    if surface.axis is None:
        turn = ca.sqrt(ca.sumsqr(ca.cross(p, s)) + _TINY**2)
        return ca.atan2(turn, along), (along / ca.sumsqr(s) * s - p) / turn
    turn = p[0] * s[1] - p[1] * s[0]
    cos, sin = np.cos(surface.turn), np.sin(surface.turn)
    angle = surface.turn + ca.atan2(turn * cos - along * sin, along * cos + turn * sin)
    return angle, ca.vertcat(-s[1], s[0]) / ca.sumsqr(s)


def plane(axis: Array) -> Array:
    """Two directions (2, 3) across an axis, with it a right-handed set."""
    aside = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    aside /= np.linalg.norm(aside)
    return np.array([aside, np.cross(axis, aside)])


def leg(square: Expression, passing: Expression | float) -> Expression:
    """√(r² - p²), kept real for a point inside."""
    return ca.sqrt(ca.fmax(square - passing**2, _TINY))


def lean(legs: Sequence[Expression], passing: Expression | float) -> Expression:
    """The sum of asin(p/r), from the legs √(r² - p²)."""
    total = ca.atan2(passing, legs[0])
    for other in legs[1:]:
        total = total + ca.atan2(passing, other)
    return total


def _condition(
    angle: Expression, squares: Sequence[Expression], passing: Expression, incidence: Expression
) -> Expression:
    return angle + lean([leg(square, passing) for square in squares], passing) - 2 * incidence


def reflect(angle: Expression, squares: Sequence[Expression], radius: float) -> Expression:
    """Incidence on a ring, from the angle turned and r²; by Newton's method.

    f is concave and falls, so that its chord from 0 to 90 deg starts close by.
    """
    incidence = ca.pi / 2 * angle / (ca.pi - lean([leg(x, radius) for x in squares], radius))
    for _ in range(_NEWTON_STEPS):
        passing = radius * ca.sin(incidence)
        falling = 1 / leg(squares[0], passing) + 1 / leg(squares[1], passing)
        slope = radius * ca.cos(incidence) * falling - 2
        incidence -= _condition(angle, squares, passing, incidence) / slope
    return incidence
