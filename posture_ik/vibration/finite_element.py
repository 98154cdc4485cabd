"""The matrices of the finite-element spine, and what drives and is read off it (chapter 3).

What it is made of stands in `posture_ik.vibration.spine_elements`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.scaling import REFERENCE
from posture_ik.problem import COMPONENTS, Cushion, FoamBack, RigidBack, Subject
from posture_ik.vibration.network import (
    Mass,
    Readout,
    Spring,
    acceleration,
    assemble,
    average,
    carry,
    drive,
    exerted,
    force,
    hold,
    motion_ports,
)
from posture_ik.vibration.spine_elements import LOOSE, Elements, Link, OpenValues, spine_elements
from posture_ik.vibration.system import LinearSystem

__all__ = ["LOOSE", "OpenValues", "build_finite_element"]


def build_finite_element(
    subject: Subject = REFERENCE,
    recline: float = 0.0,
    backrest: RigidBack | FoamBack | None = None,
    cushion: Cushion | None = None,
    values: OpenValues | None = None,
) -> LinearSystem:
    """The finite-element model of a seated person.

    Args:
        subject: who, scaled from the reference subject as the multibody model is.
        recline: of the person and the backrest, rad, positive backwards.
        backrest: what holds the back, if anything; it moves with the seat.
        cushion: the seat and cushion between the floor and the person, if any.
        values: in place of the identified ones.

    Returns:
        A system whose coordinates are `Head x` to `S1 rz` (each body's motion at its node, in the
        seat's axes), `T11V x`, `T11V z` to `L5V z` (on their vertebra, in the person's axes), and
        `seat z` and `cushion z` with a cushion; all but the viscera's are relative to what moves
        with the input as one rigid body. A rigid backrest eliminates five of them.

        Inputs are six motions about the seat's origin, `seat x` to `seat rz`; with a cushion
        `floor x` to `floor rz`, which it follows in all but z. Outputs are accelerations of
        `Head`, `S1` and, with a cushion, `seat z` and `cushion z`; and the forces, with moments
        about the seat's origin, that act on the person from below (`seat force x` to `rz`) and
        from the backrest (`backrest force x` to `rz`), and on the seat from the floor.
    """
    elements = spine_elements(subject, recline, backrest, cushion, values)
    coordinates = tuple(
        f"{node.name} {COMPONENTS[component]}" for node in elements.nodes for component in node.free
    )
    motions = _motions(elements, coordinates)
    points = {node.name: node.point for node in elements.nodes}
    if elements.back:
        at, of = elements.back.point, elements.back.of
        motions["back"] = average([motions[body] for body in of], [points[b] for b in of], at)
        points["back"] = at

    def apart(link: Link) -> Array:
        """How far a link's ends are apart, (6, n), in its axes."""
        upper = carry(link.point - points[link.upper]) @ motions[link.upper]
        lower = carry(link.point - points[link.lower]) @ motions[link.lower]
        return _in_axes(link, upper - lower)

    springs = {
        link.name: Spring(
            apart(link)[link.sprung], link.stiffness[link.sprung], link.damping[link.sprung]
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

    def pushed(link: Link) -> Array:
        """What a link's springs exert on the person, about the origin, (3, 6, n)."""
        return exerted(springs[link.name], _in_axes(link, carry(link.point))[link.sprung])

    readouts = [
        acceleration("Head", COMPONENTS, motions["Head"]),
        acceleration("S1", COMPONENTS, motions["S1"]),
        *(
            acceleration(layer, "z", motions[layer][2:3])
            for layer in (("seat", "cushion") if cushion else ())
        ),
        force("seat", COMPONENTS, np.sum([pushed(link) for link in elements.below], axis=0)),
    ]
    if elements.backrest:
        link, push = elements.backrest, pushed(elements.backrest)
        if link.rigid:
            fixed = list(link.rigid)
            held = hold(apart(link)[fixed], matrices, len(coordinates))
            push += _in_axes(link, carry(link.point))[fixed].T @ held.forces
        readouts.append(force("backrest", COMPONENTS, push))
        if link.rigid:
            coordinates = tuple(coordinates[i] for i in held.kept[:-6])
            matrices = held.every.T @ matrices @ held.every
            readouts = [Readout(readout.ports, readout.rows @ held.every) for readout in readouts]
    if cushion:
        readouts.append(force("floor", COMPONENTS, matrices[:, -6:]))
    ground = elements.nodes[0].name
    return drive(coordinates, motion_ports(ground, COMPONENTS), matrices, readouts)


def _motions(elements: Elements, coordinates: tuple[str, ...]) -> dict[str, Array]:
    """The motion (6, n) of every node by its own coordinates and, behind them, the ground's six.

    Each coordinate is a motion relative to the node below. So springs stretch by coordinates alone,
    and the small difference of two large forces, by which a slow motion is accelerated, is not lost
    in the rounding of stiff springs.
    """
    row: Mapping[str, Array] = dict(
        zip((*coordinates, *COMPONENTS), np.eye(len(coordinates) + 6), strict=True)
    )
    motions: dict[str, Array] = {}
    points: dict[str, Array] = {}
    for node in elements.nodes:
        points[node.name] = node.point
        if node.on is None:
            motions[node.name] = np.stack([row[component] for component in COMPONENTS])
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
