"""Masses and springs on small motions: what the finite-element and lumped models are built of.

A point's small motion is a matrix that takes the model's coordinates x to its displacement and
rotation, v = A x. A rigid link carries that motion to another point (an RBE2), an average of many
points gives a new one (an RBE3), a spring stretches by a difference of two, and a mass moves by
one. So a node that hangs on others is its own equation, and needs no coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.vibration.system import LinearSystem, Port


class Mass(NamedTuple):
    """A mass matrix (k, k) on a motion (k, n)."""

    motion: Array
    matrix: Array


class Spring(NamedTuple):
    """k springs with dampers beside them: stretch (k, n), stiffness and damping (k,)."""

    stretch: Array
    stiffness: Array
    damping: Array


class Mean(NamedTuple):
    """A node that takes the mean motion of others (`average`)."""

    name: str
    point: Array
    axes: Array
    of: tuple[str, ...]


class Link(NamedTuple):
    """Springs and dampers between what two nodes carry at one point.

    Attributes:
        name: of the joint, such as `L4_L5`.
        lower, upper: nodes.
        point: where, (3,), m.
        axes: columns, (3, 3).
        stiffness, damping: along and about the axes, (6,).
        rigid: components that let nothing move, in place of springs.
    """

    name: str
    lower: str
    upper: str
    point: Array
    axes: Array
    stiffness: Array
    damping: Array
    rigid: tuple[int, ...] = ()

    @property
    def sprung(self) -> list[int]:
        """Components with a spring or a damper."""
        return [int(i) for i in np.flatnonzero(np.abs(self.stiffness) + np.abs(self.damping))]


class Readout(NamedTuple):
    """What is read off a model: r ports, and their rows (3, r, n) by order of derivative."""

    ports: tuple[Port, ...]
    rows: Array


def carry(offset: Array) -> Array:
    """What takes a body's motion at a point to its motion at `offset` (3,) from it, (6, 6), RBE2.

    u' = u + θ × offset, θ' = θ.
    """
    x, y, z = offset
    carried = np.eye(6)
    carried[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return carried


def average(motions: Sequence[Array], points: Sequence[Array], at: Array) -> Array:
    """The mean motion (6, n) of several points, carried to the point `at` (3,), m: an RBE3.

    The rigid motion v about `at` nearest to the points' own,

        min Σ |u_i − u_i(v)|² + L² |θ_i − θ|²,

    with L the mean distance of the points from `at`, which makes a rotation comparable with a
    displacement (the scaling usual for RBE3 elements).
    """
    length = np.mean([np.linalg.norm(point - at) for point in points])
    weight = np.r_[np.ones(3), np.full(3, length**2)][:, None]
    rigid = [carry(point - at) for point in points]
    normal = np.sum([r.T @ (weight * r) for r in rigid], axis=0)
    pulled = [r.T @ (weight * motion) for r, motion in zip(rigid, motions, strict=True)]
    mean: Array = np.linalg.solve(normal, np.sum(pulled, axis=0))
    return mean


def assemble(masses: Sequence[Mass], springs: Sequence[Spring]) -> Array:
    """Stiffness, damping and mass of the n coordinates, (3, n, n), by order of derivative."""
    n = masses[0].motion.shape[1]
    matrices = np.zeros((3, n, n))
    for mass in masses:
        matrices[2] += mass.motion.T @ mass.matrix @ mass.motion
    for spring in springs:
        matrices[0] += spring.stretch.T @ (spring.stiffness[:, None] * spring.stretch)
        matrices[1] += spring.stretch.T @ (spring.damping[:, None] * spring.stretch)
    return matrices


def exerted(spring: Spring, ends: Array) -> Array:
    """What springs exert on what they carry, about the point where their lower ends are told.

    Args:
        spring: k springs.
        ends: the motion of their lower ends by the m motions of a rigid support, (k, m).

    Returns:
        Force and moment by these motions, rows (3, m, n) by order of derivative.
    """
    rows = np.zeros((3, ends.shape[1], spring.stretch.shape[1]))
    rows[0] = -ends.T @ (spring.stiffness[:, None] * spring.stretch)
    rows[1] = -ends.T @ (spring.damping[:, None] * spring.stretch)
    return rows


class Held(NamedTuple):
    """Coordinates that meet A x = 0, c rows.

    Attributes:
        kept: indices of the n − c coordinates that are left, ascending.
        every: T, (n, n − c), with x = T x_kept.
        forces: what holds A x at zero, rows (3, c, n) by order of derivative.
    """

    kept: npt.NDArray[np.intp]
    every: Array
    forces: Array


def hold(constraint: Array, matrices: Array, free: int) -> Held:
    """Hold A x = 0 by eliminating as many coordinates as A has rows.

    Those that a pivoted QR of A finds best to solve for are eliminated. Their equations then give
    the forces f that hold: M x'' + C x' + K x = Aᵀ f.

    Args:
        constraint: A, (c, n), of full rank in the first `free` coordinates.
        matrices: (3, n, n) as `assemble` gives them.
        free: how many coordinates may be eliminated; the given motions behind them may not.
    """
    c, n = constraint.shape
    if not c:
        return Held(np.arange(n), np.eye(n), np.zeros((3, 0, n)))
    out = scipy.linalg.qr(constraint[:, :free], mode="r", pivoting=True)[1][:c]
    kept = np.setdiff1d(np.arange(n), out)
    every = np.zeros((n, n - c))
    every[kept, np.arange(n - c)] = 1.0
    every[out] = -np.linalg.solve(constraint[:, out], constraint[:, kept])
    forces = np.asarray(np.linalg.solve(constraint[:, out].T, matrices[:, out]), dtype=np.float64)
    return Held(kept, every, forces)


def drive(
    coordinates: Sequence[str],
    inputs: Sequence[Port],
    matrices: Array,
    readouts: Sequence[Readout],
) -> LinearSystem:
    """A linear system whose last p coordinates are given motions.

    Args:
        coordinates: names of the others, n − p of them.
        inputs: the p given motions.
        matrices: (3, n, n) as `assemble` gives them.
        readouts: over all n coordinates.
    """
    free = len(coordinates)
    rows = np.concatenate([readout.rows for readout in readouts], axis=1)
    return LinearSystem(
        tuple(coordinates),
        mass=matrices[2, :free, :free],
        damping=matrices[1, :free, :free],
        stiffness=matrices[0, :free, :free],
        inputs=tuple(inputs),
        outputs=tuple(port for readout in readouts for port in readout.ports),
        B=-matrices[:, :free, free:],
        Y=rows[:, :, :free],
        D=rows[:, :, free:],
    )


def acceleration(name: str, components: Sequence[str], motion: Array) -> Readout:
    """Read out the acceleration of a motion (k, n), such as `Head acceleration z`."""
    ports = tuple(
        Port(f"{name} acceleration {c}", "rad/s²" if c.startswith("r") else "m/s²")
        for c in components
    )
    return Readout(ports, np.stack([np.zeros_like(motion), np.zeros_like(motion), motion]))


def travel(name: str, components: Sequence[str], motion: Array) -> Readout:
    """Read out a motion (k, n), its rate and acceleration, such as `Head velocity z`."""
    none = np.zeros_like(motion)
    orders = "", "velocity ", "acceleration "
    rates = "", "/s", "/s²"
    ports = tuple(
        Port(f"{name} {order}{c}", ("rad" if c.startswith("r") else "m") + rate)
        for order, rate in zip(orders, rates, strict=True)
        for c in components
    )
    rows = [np.concatenate([motion if i == k else none for i in range(3)]) for k in range(3)]
    return Readout(ports, np.stack(rows))


def strain(names: Sequence[str], spring: Spring) -> Readout:
    """Read out the stretch of k springs and the force of spring and damper against it.

    Args:
        names: of the springs, such as `L4_L5_axial` and, of a hinge, `L4_L5_ry`.
        spring: k of them.
    """
    turns = [name.rpartition("_")[2].startswith("r") for name in names]
    ports = (
        *(Port(name, "rad" if turn else "m") for name, turn in zip(names, turns, strict=True)),
        *(
            Port(f"{name} force", "N m" if turn else "N")
            for name, turn in zip(names, turns, strict=True)
        ),
    )
    none = np.zeros_like(spring.stretch)
    stiff, damped = spring.stiffness[:, None], spring.damping[:, None]
    rows = [
        np.vstack([spring.stretch, stiff * spring.stretch]),
        np.vstack([none, damped * spring.stretch]),
        np.vstack([none, none]),
    ]
    return Readout(ports, np.stack(rows))


def force(name: str, components: Sequence[str], rows: Array) -> Readout:
    """Read out a force from its rows (3, k, n), such as `seat force z`."""
    return Readout(force_ports(name, components), rows)


def force_ports(name: str, components: Sequence[str]) -> tuple[Port, ...]:
    """The force and moment of a thing, such as `seat force z`."""
    return tuple(Port(f"{name} force {c}", "N m" if c.startswith("r") else "N") for c in components)


def motion_ports(name: str, components: Sequence[str]) -> tuple[Port, ...]:
    """The motions of a thing as inputs, such as `seat z`."""
    return tuple(Port(f"{name} {c}", "rad" if c.startswith("r") else "m") for c in components)
