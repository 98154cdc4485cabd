"""The matrices of the finite-element spine, and what drives and is read off it (chapter 3).

What it is made of stands in `posture_ik.vibration.spine_elements`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.scaling import REFERENCE
from posture_ik.errors import PostureIKError, nearest
from posture_ik.posture import Posture
from posture_ik.problem import COMPONENTS, SPINE, Cushion, FoamBack, LawBack, RigidBack, Subject
from posture_ik.vibration.backrest import lean
from posture_ik.vibration.factors import SOURCE, Factors
from posture_ik.vibration.network import (
    Link,
    Mass,
    Readout,
    Spring,
    assemble,
    carry,
    drive,
    exerted,
    force,
    hold,
    motion_ports,
    strain,
    travel,
)
from posture_ik.vibration.spine_elements import LOOSE, Elements, OpenValues, spine_elements
from posture_ik.vibration.system import LinearSystem

__all__ = ["LOOSE", "OpenValues", "build_finite_element"]

#: Components of a bushing, as the posture's coordinates are named.
_BUSHING = ("x", "y", "axial", "rx", "ry", "rz")


def build_finite_element(
    subject: Subject = REFERENCE,
    recline: float = 0.0,
    backrest: RigidBack | FoamBack | LawBack | None = None,
    cushion: Cushion | None = None,
    values: OpenValues | None = None,
    factors: Factors = SOURCE,
    posture: Posture | None = None,
    frames: Sequence[str] = ("Head", "S1"),
    discs: Sequence[str] = (),
) -> LinearSystem:
    """The finite-element model of a seated person.

    Args:
        subject: who, scaled from the reference subject as the multibody model is.
        recline: of the person and the backrest, rad, positive backwards.
        backrest: what holds the back, if anything; it moves with the seat.
        cushion: the seat and cushion between the floor and the person, if any.
        values: in place of the identified ones.
        factors: on the tables' stiffness and damping.
        posture: gives the person its shape, in place of the erect one reclined.
        frames: vertebrae, viscera and `Head`, whose position, velocity and acceleration are
            outputs, along the world's axes (`Head z`, `Head acceleration z`).
        discs: joints, such as `L4_L5`, whose strains and forces are outputs.

    Returns:
        A system whose coordinates are `Head x` to `S1 rz` (each body's motion at its node, in the
        seat's axes), `T11V x`, `T11V z` to `L5V z` (on their vertebra, in its axes), and `seat z`
        and `cushion z` with a cushion; all but the viscera's are relative to what moves with the
        input as one rigid body. A rigid backrest eliminates five of them.

        Inputs are six motions about the seat's origin, `seat x` to `seat rz`; with a cushion
        `floor x` to `floor rz`, which it follows in all but z; and with a backrest `backrest x`
        to `rz`, its motion beside the seat's, along its own axes at a point 0.1 m behind T7.
        Outputs are motions of the frames and, with a cushion, of `seat z` and `cushion z`; of each
        disc its strains and the forces of spring and damper against them (`L4_L5_axial`,
        `L4_L5_axial force`, and likewise `x`, `y`, `rx`, `ry`, `rz`); the forces, with moments
        about the seat's origin, that act on the person from below (`seat force x` to `rz`), on
        the seat from the floor, and in `total`; and from the backrest, along its axes at its point
        (`backrest force x` to `rz`).

    Raises:
        PostureIKError: there is no such frame or disc, the posture's body lacks a vertebra, or the
            backrest does not bear its preload (`at_preload`).
    """
    elements = spine_elements(subject, recline, backrest, cushion, values, factors, posture)
    coordinates = tuple(
        f"{node.name} {COMPONENTS[component]}" for node in elements.nodes for component in node.free
    )
    n, ground = len(coordinates), elements.nodes[0].name
    moved = (ground, "backrest") if backrest else (ground,)
    every = np.eye(n + 6 * len(moved))
    motions = _motions(elements, dict(zip(coordinates, every, strict=False)), every[n : n + 6])
    points = {node.name: node.point for node in elements.nodes}

    def apart(link: Link) -> Array:
        """How far a link's ends are apart, (6, n), in its axes."""
        upper = carry(link.point - points[link.upper]) @ motions[link.upper]
        lower = carry(link.point - points[link.lower]) @ motions[link.lower]
        return _in_axes(link, upper - lower)

    stretches = {link.name: apart(link) for link in (*elements.links, *elements.below)}
    if elements.back:
        own = every[n + 6 :]
        stretches["backrest"], _ = lean(elements.back, points, motions, motions["seat"], own)
    springs = {
        link.name: Spring(
            stretches[link.name][link.sprung],
            link.stiffness[link.sprung],
            link.damping[link.sprung],
        )
        for link in elements.every_link
    }
    masses = [
        Mass(
            carry(lump.centre) @ motions[lump.node],
            scipy.linalg.block_diag(lump.mass * np.eye(3), lump.tensor),
        )
        for lump in elements.lumps
    ]
    matrices = assemble(masses, list(springs.values()))

    below = [
        exerted(springs[link.name], _in_axes(link, carry(link.point))[link.sprung])
        for link in elements.below
    ]
    readouts = [
        *(travel(frame, COMPONENTS, _motion(motions, frame)) for frame in frames),
        *(
            travel(layer, "z", motions[layer][2:3])
            for layer in (("seat", "cushion") if cushion else ())
        ),
        *(_strain(springs, disc) for disc in discs),
        force("seat", COMPONENTS, np.sum(below, axis=0)),
    ]
    if elements.backrest:
        link, ends = elements.backrest, np.eye(6)
        fixed = list(link.rigid)
        held = hold(stretches["backrest"][fixed], matrices, n)
        push = exerted(springs["backrest"], ends[link.sprung]) + ends[fixed].T @ held.forces
        readouts.append(force("backrest", COMPONENTS, push))
        matrices = held.every.T @ matrices @ held.every
        readouts = [Readout(readout.ports, readout.rows @ held.every) for readout in readouts]
        coordinates = tuple(coordinates[i] for i in held.kept[: -6 * len(moved)])
        n = len(coordinates)
    for name in dict.fromkeys((ground, "total")):
        if name != "seat":
            readouts.append(force(name, COMPONENTS, matrices[:, n : n + 6]))
    inputs = [port for name in moved for port in motion_ports(name, COMPONENTS)]
    return drive(coordinates, inputs, matrices, readouts)


def _motions(elements: Elements, row: Mapping[str, Array], ground: Array) -> dict[str, Array]:
    """The motion (6, n) of every node by its own coordinates and the ground's six.

    Each coordinate is a motion relative to the node below. So springs stretch by coordinates alone,
    and the small difference of two large forces, by which a slow motion is accelerated, is not lost
    in the rounding of stiff springs.
    """
    motions: dict[str, Array] = {}
    points: dict[str, Array] = {}
    for node in elements.nodes:
        points[node.name] = node.point
        if node.on is None:
            motions[node.name] = ground
            continue
        motion = carry(node.point - points[node.on]) @ motions[node.on]
        axes = scipy.linalg.block_diag(node.axes, node.axes)
        for component in node.free:
            motion += np.outer(axes[:, component], row[f"{node.name} {COMPONENTS[component]}"])
        motions[node.name] = motion
    return motions


def _in_axes(link: Link, motion: Array) -> Array:
    """A motion (6, n) seen in a link's axes."""
    seen: Array = scipy.linalg.block_diag(link.axes.T, link.axes.T) @ motion
    return seen


def _motion(motions: Mapping[str, Array], frame: str) -> Array:
    if frame not in motions:
        known = nearest(frame, motions)
        raise PostureIKError(
            f"vibration: the finite-element model has no link called {frame!r}; {known}"
        )
    return motions[frame]


def _strain(springs: Mapping[str, Spring], disc: str) -> Readout:
    discs = [name for name in springs if name.partition("_")[0] in SPINE]
    if disc not in discs:
        known = nearest(disc, discs)
        raise PostureIKError(f"vibration: the body has no disc called {disc!r}; {known}")
    return strain([f"{disc}_{component}" for component in _BUSHING], springs[disc])
