"""What drives the joints of a reach in place of torques at will: muscles, by their activations."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import casadi as ca

from posture_ik.arrays import Array

#: What a reserve torque costs beside the activations squared, 1/(N m)²: where muscles suffice, one
#: more N m costs 0.2 at most, for which the reserve gives 0.01 mN m.
RESERVE_PRICE = 1e4


class Lag(NamedTuple):
    """Time constants by which an activation rises and falls, s.

    An excitation e between 0 and 1 changes it by a' = (e - a)/rise or (e - a)/fall, and so
    -a/fall <= a' <= (1 - a)/rise: all that need be asked for e to exist (De Groote et al. 2009,
    Comput. Methods Biomech. Biomed. Eng. 12:563).
    """

    rise: float
    fall: float


class Actuators(Protocol):
    """Actuators m that give n joints their torques, each by its activation from 0 to 1."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the actuators, (m,)."""

    @property
    def numbers(self) -> Array:
        """What `torque` takes for `numbers`."""

    @property
    def lag(self) -> Lag | None:
        """How fast activations change; None where they do at once."""

    @property
    def start(self) -> Array:
        """Activations before the start, (m,): where they lag, those to begin from."""

    def structure(self) -> object:
        """What decides the graph of `torque`: equal where that is the same."""

    def torque(self, q: ca.SX, v: ca.SX, activation: ca.SX, numbers: ca.SX) -> ca.SX:
        """Torques (n,), N m, of the joints at q and v (n,) under activations (m,)."""

    def torque_at(self, q: Array, v: Array, activation: Array) -> Array:
        """The same of numbers, not by the graph."""
