"""The finite-element spine: every body of tables 8 and 9 with six degrees of freedom (chapter 3).

Bushings of tables 10 and 11 stand between neighbouring vertebrae, along the chord through both.
The buttocks are four corner springs under a plate that the sacrum carries. Viscera follow their
vertebra but along x and z, where they move on springs; a column of springs joins them (table 12),
each along the line through its two nodes. The arms are two point masses that T2 carries.

A reclined person is the erect one turned rigidly about the seat, or the one of a solved posture;
all springs turn with it but those of the buttocks, which keep the seat's axes. A bushing turns with
its lower vertebra. What the source leaves open is in `OpenValues`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.scaling import REFERENCE, Scale
from posture_ik.body.spine import VISCERA, inertias, nodes
from posture_ik.body.tables import numbers, read_table, table
from posture_ik.errors import PostureIKError, nearest
from posture_ik.posture import Posture
from posture_ik.problem import COMPONENTS, SPINE, Cushion, FoamBack, LawBack, RigidBack, Subject
from posture_ik.vibration.backrest import at_preload, backrest_axes, lean
from posture_ik.vibration.network import (
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
from posture_ik.vibration.seat import DATA
from posture_ik.vibration.system import LinearSystem

#: Damping over stiffness of the ties between viscera and vertebrae, s (assumed, as table 12's).
TIE_DAMPING_TIME = 0.1
#: Viscera that move on their vertebra; those of T10 and S1 are fixed to theirs.
LOOSE = VISCERA[1:-1][::-1]
_COLUMNS = ("11", "m"), ("22", "m"), ("33", "m"), ("44", "m_rad"), ("55", "m_rad"), ("66", "m_rad")
#: Components of a bushing, as the posture's coordinates are named.
BUSHING = ("x", "y", "axial", "rx", "ry", "rz")
_SCALED_AS = ("axial", "axial", "axial", "rx", "ry", "rz")


class OpenValues(NamedTuple):
    """What the source leaves open, of the reference subject; `identified()` gives the values.

    Attributes:
        bushing_fraction: where a bushing stands, from the lower node (0) to the upper one (1).
        buttock_x, buttock_y: half-spacings of the buttocks' corners, m.
        visceral_x, visceral_z: stiffness of the tie of each viscus to its vertebra, N/m.
        column_top: share of the spring T10V_T11V that acts: 1 tied to T10, 0 with a free end.
    """

    bushing_fraction: float
    buttock_x: float
    buttock_y: float
    visceral_x: float
    visceral_z: float
    column_top: float

    @classmethod
    def identified(cls) -> OpenValues:
        """The values that meet the source's own results best (`finite_element.csv`)."""
        rows = read_table(DATA / "finite_element.csv")
        return cls(*(float(rows[name]["value"]) for name in cls._fields))


class _Person(NamedTuple):
    """A person's points (3,), m, turns from the reference shape, (3, 3), and motions (6, n)."""

    scale: Scale
    points: Mapping[str, Array]
    turns: Mapping[str, Array]
    motions: Mapping[str, Array]

    def at(self, body: str, point: Array) -> Array:
        """The motion (6, n) of a point that a body carries."""
        return carry(point - self.points[body]) @ self.motions[body]


def build_finite_element(
    subject: Subject = REFERENCE,
    recline: float = 0.0,
    backrest: RigidBack | FoamBack | LawBack | None = None,
    cushion: Cushion | None = None,
    values: OpenValues | None = None,
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
        posture: gives the person its shape, in place of the erect one reclined.
        frames: vertebrae, viscera and `Head`, whose position, velocity and acceleration are
            outputs, along the world's axes (`Head z`, `Head acceleration z`).
        discs: joints, such as `L4_L5`, whose strains and forces are outputs.

    Returns:
        A system whose coordinates are `Head x` to `S1 rz` (each body's motion at its node, in the
        seat's axes), `T11V x`, `T11V z` to `L5V z` (on their vertebra, in the person's axes), and
        `seat z` and `cushion z` with a cushion; all but the viscera's are relative to what moves
        with the input as one rigid body. A rigid backrest eliminates five of them.

        Inputs are six motions about the seat's origin, `seat x` to `seat rz`; with a cushion
        `floor x` to `floor rz`, which it follows in all but z; and with a backrest `backrest x`
        to `rz`, its motion beside the seat's, at a point 0.1 m behind T7 along its own axes.
        Outputs are motions of the frames and, with a cushion, of `seat z` and `cushion z`; of each
        disc its strains and the forces of spring and damper against them (`L4_L5_axial`,
        `L4_L5_axial force`, and likewise `x`, `y`, `rx`, `ry`, `rz`); the forces, with moments
        about the seat's origin, that act on the person from below (`seat force x` to `rz`), on
        all (`total force x` to `rz`) and on the seat from the floor; and from the backrest, along
        its axes at its point (`backrest force x` to `rz`).

    Raises:
        PostureIKError: there is no such frame or disc, the posture's body lacks a vertebra, or the
            backrest does not bear its preload (`at_preload`).
    """
    values = values or OpenValues.identified()
    layers = ("seat", "cushion") if cushion else ()
    ground = "floor" if cushion else "seat"
    moved = (ground, "backrest") if backrest else (ground,)
    coordinates = (
        *(f"{body} {component}" for body in SPINE[::-1] for component in COMPONENTS),
        *(f"{viscus} {component}" for viscus in LOOSE for component in "xz"),
        *(f"{layer} z" for layer in layers),
    )
    n = len(coordinates)
    every = np.eye(n + 6 * len(moved))
    row = dict(zip(coordinates, every, strict=False))
    floor, own = every[n : n + 6], every[n + 6 :]
    below = {layer: floor.copy() for layer in layers}
    for layer in layers:
        below[layer][2] += row[f"{layer} z"]
    person = _person(Scale.of(subject), recline, row, floor, posture)

    masses = _masses(person)
    bushings = _bushings(person, values.bushing_fraction)
    springs = [*bushings.values(), *_viscera(person, values, row)]
    on = floor
    for layer, part in zip(layers, (cushion.seat, cushion.cushion) if cushion else (), strict=True):
        masses.append(Mass(below[layer][:3], part.mass * np.eye(3)))
        rise = (below[layer] - on)[2:3]
        springs.append(Spring(rise, np.array([part.stiffness]), np.array([part.damping])))
        on = below[layer]
    buttocks, corners = _buttocks(person, values, on)
    springs.append(buttocks)
    readouts = [
        *(travel(frame, COMPONENTS, _motion(person, frame)) for frame in frames),
        *(travel(layer, "z", below[layer][2:3]) for layer in layers),
        *(_strained(bushings, disc) for disc in discs),
        force("seat", COMPONENTS, exerted(buttocks, corners)),
    ]
    leaning = None
    if backrest:
        back, seat = at_preload(backrest, posture), below.get("seat", floor)
        leaning = lean(back, recline, person.points, person.motions, seat, own)
        springs.append(leaning.pad)
    matrices = assemble(masses, springs)
    if leaning:
        held = hold(leaning.held, matrices, n)
        push = exerted(leaning.pad, np.eye(6)[leaning.at]) + leaning.holds.T @ held.forces
        readouts.append(force("backrest", COMPONENTS, push))
        matrices = held.every.T @ matrices @ held.every
        readouts = [Readout(readout.ports, readout.rows @ held.every) for readout in readouts]
        coordinates = tuple(coordinates[i] for i in held.kept[: -6 * len(moved)])
        n = len(coordinates)
    for name in ("floor", "total") if cushion else ("total",):
        readouts.append(force(name, COMPONENTS, matrices[:, n : n + 6]))
    inputs = [port for name in moved for port in motion_ports(name, COMPONENTS)]
    return drive(coordinates, inputs, matrices, readouts)


def _person(
    scale: Scale, recline: float, row: Mapping[str, Array], floor: Array, posture: Posture | None
) -> _Person:
    """The person's points, turned, and the motions of all that has a node.

    Each coordinate is a motion relative to the floor's. So springs stretch by coordinates alone,
    and the small difference of two large forces, by which a slow motion is accelerated, is not lost
    in the rounding of stiff springs.
    """
    place, turn = nodes(scale), backrest_axes(recline)
    points = {body: turn @ place[body] for body in SPINE}
    turns = dict.fromkeys(SPINE, turn)
    if posture:
        lacking = [body for body in SPINE if body not in posture.frames]
        if lacking:
            raise PostureIKError(
                f"vibration: the posture's body has no {', '.join(lacking)}, and so no shape for "
                'the finite-element model; take shape = "rigid".'
            )
        points = {body: posture.frames[body].translation for body in SPINE}
        turns = {body: posture.frames[body].rotation for body in SPINE}
    motions = {
        body: np.stack([row[f"{body} {c}"] for c in COMPONENTS]) + carry(points[body]) @ floor
        for body in SPINE
    }
    person = _Person(scale, points, turns, motions)
    carriers = {viscus: viscus.removesuffix("V") for viscus in VISCERA}
    carriers |= {"L_arm": "T2", "R_arm": "T2", "butt_up": "S1"}
    for name, body in carriers.items():
        turns[name] = turns[body]
        points[name] = points[body] + turns[body] @ (place[name] - place[body])
        motions[name] = person.at(body, points[name])
    for viscus in LOOSE:
        for axis, component in zip(turns[viscus].T[[0, 2]], "xz", strict=True):
            motions[viscus][:3] += np.outer(axis, row[f"{viscus} {component}"])
    return person


def _motion(person: _Person, frame: str) -> Array:
    if frame not in person.motions:
        known = nearest(frame, person.motions)
        raise PostureIKError(
            f"vibration: the finite-element model has no link called {frame!r}; {known}"
        )
    return person.motions[frame]


def _strained(bushings: Mapping[str, Spring], disc: str) -> Readout:
    if disc not in bushings:
        known = nearest(disc, bushings)
        raise PostureIKError(f"vibration: the body has no disc called {disc!r}; {known}")
    return strain([f"{disc}_{component}" for component in BUSHING], bushings[disc])


def _masses(person: _Person) -> list[Mass]:
    """The masses of table 9, each at its offset from its node; the arms' are points."""
    masses = []
    for name, inertia in inertias(person.scale).items():
        turn = person.turns[name]
        centre = person.points[name] + turn @ inertia.centre
        matrix = scipy.linalg.block_diag(inertia.mass * np.eye(3), turn @ inertia.tensor @ turn.T)
        masses.append(Mass(person.at(name, centre), matrix))
    for arm in ("L_arm", "R_arm"):
        mass = person.scale.mass * float(table("table_9_masses")[arm]["mass_kg"])
        masses.append(Mass(person.motions[arm][:3], mass * np.eye(3)))
    return masses


def _bushings(person: _Person, fraction: float) -> dict[str, Spring]:
    """The bushings of tables 10 and 11, z along the chord from the lower node to the upper one.

    Each stands on the lower vertebra, where the upper one holds it: in a bent spine as the joints
    of the multibody model do.
    """
    springs, place = {}, nodes(person.scale)
    factors = np.array([person.scale.stiffness(component) for component in _SCALED_AS])
    for lower, upper in pairwise(SPINE):
        chord = place[upper] - place[lower]
        sin, cos = chord[[0, 2]] / np.linalg.norm(chord)
        chord_axes = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
        axes = (person.turns[lower] @ chord_axes).T
        stands = person.points[upper] - (1 - fraction) * person.turns[upper] @ chord
        apart = person.at(upper, stands) - person.at(lower, stands)
        stiffness, damping = _bushing(f"{upper}_{lower}")
        turned = scipy.linalg.block_diag(axes, axes) @ apart
        springs[f"{upper}_{lower}"] = Spring(turned, factors * stiffness, factors * damping)
    return springs


def _bushing(name: str) -> tuple[Array, Array]:
    """Stiffness and damping of a row of tables 11 and 10, (6,), x to rz."""
    stiffness = numbers(table("table_11_stiffness")[name], *(f"k{i}_N_{u}" for i, u in _COLUMNS))
    units = {"m": "s_m", "m_rad": "m_s_rad"}
    damping = numbers(table("table_10_damping")[name], *(f"c{i}_N_{units[u]}" for i, u in _COLUMNS))
    return np.array(stiffness), np.array(damping)


def _viscera(person: _Person, values: OpenValues, row: Mapping[str, Array]) -> list[Spring]:
    """The ties of the viscera to their vertebrae, and the column of table 12."""
    factor = person.scale.stiffness("axial")
    ties = [(v, c, k) for v in LOOSE for c, k in zip("xz", values[3:5], strict=True)]
    stiffness = factor * np.array([k for _, _, k in ties])
    moved = np.stack([row[f"{viscus} {component}"] for viscus, component, _ in ties])
    springs = [Spring(moved, stiffness, TIE_DAMPING_TIME * stiffness)]
    for joint, of in table("table_12_viscera").items():
        upper, lower = joint.split("_")
        share = factor * (values.column_top if upper == VISCERA[-1] else 1.0)
        chord = person.points[upper] - person.points[lower]
        along = chord / np.linalg.norm(chord)
        stretch = along @ (person.motions[upper] - person.motions[lower])[:3]
        stiff, damped = share * np.array(numbers(of, "k33_N_m", "c33_N_s_m"))
        springs.append(Spring(stretch[None], np.array([stiff]), np.array([damped])))
    return springs


def _buttocks(person: _Person, values: OpenValues, under: Array) -> tuple[Spring, Array]:
    """The four corners' springs, x to z each, and the motions of their lower ends, (12, 6).

    The corners stand level about the sacrum's `butt_up`, whatever the recline, and what lies under
    them is rigid.
    """
    across = person.scale.point(np.array([values.buttock_x, values.buttock_y, 0.0]))
    stretch, ends, stiffness, damping = [], [], [], []
    for name, front in (("butt_front", 1.0), ("butt_rear", -1.0)):
        for side in (1.0, -1.0):
            corner = person.points["butt_up"] + across * (front, side, 0.0)
            ends.append(carry(corner)[:3])
            stretch.append(person.at("S1", corner)[:3] - ends[-1] @ under)
            k, c = _bushing(name)
            stiffness.append(person.scale.stiffness("axial") * k[:3])
            damping.append(person.scale.stiffness("axial") * c[:3])
    spring = Spring(np.vstack(stretch), np.concatenate(stiffness), np.concatenate(damping))
    return spring, np.vstack(ends)
