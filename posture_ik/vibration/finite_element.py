"""The finite-element spine: every body of tables 8 and 9 with six degrees of freedom (chapter 3).

Bushings of tables 10 and 11 stand between neighbouring vertebrae, along the chord through both.
The buttocks are four corner springs under a plate that the sacrum carries. Viscera follow their
vertebra but along x and z, where they move on springs; a column of springs joins them (table 12),
each along the line through its two nodes. The arms are two point masses that T2 carries.

A reclined person is the erect one turned rigidly about the seat, with all springs but those of the
buttocks, which keep the seat's axes. What the source leaves open is in `OpenValues`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg

from posture_ik.arrays import Array
from posture_ik.body.laws import scale_of
from posture_ik.body.scaling import REFERENCE, Scale, region_of, region_of_joint
from posture_ik.body.spine import VISCERA, inertias, nodes
from posture_ik.body.tables import numbers, read_table, table
from posture_ik.problem import COMPONENTS, SPINE, Cushion, FoamBack, RigidBack, Subject
from posture_ik.vibration.backrest import BEHIND
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
from posture_ik.vibration.seat import DATA
from posture_ik.vibration.system import LinearSystem

#: Damping over stiffness of the ties between viscera and vertebrae, s (assumed, as table 12's).
TIE_DAMPING_TIME = 0.1
#: Viscera that move on their vertebra; those of T10 and S1 are fixed to theirs.
LOOSE = VISCERA[1:-1][::-1]
_COLUMNS = ("11", "m"), ("22", "m"), ("33", "m"), ("44", "m_rad"), ("55", "m_rad"), ("66", "m_rad")
#: What a rigid backrest holds of the back's motion: all but the slide along it.
_FIXED = [0, 1, 3, 4, 5]
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
    """A person's points (3,), m, turned back, and motions (6, n); `turn` is the turn, (3, 3)."""

    scale: Scale
    turn: Array
    points: Mapping[str, Array]
    motions: Mapping[str, Array]

    def at(self, body: str, point: Array) -> Array:
        """The motion (6, n) of a point that a body carries."""
        return carry(point - self.points[body]) @ self.motions[body]


def build_finite_element(
    subject: Subject = REFERENCE,
    recline: float = 0.0,
    backrest: RigidBack | FoamBack | None = None,
    cushion: Cushion | None = None,
    values: OpenValues | None = None,
    scale: Scale | None = None,
) -> LinearSystem:
    """The finite-element model of a seated person.

    Args:
        subject: who, scaled from the reference subject as the multibody model is.
        recline: of the person and the backrest, rad, positive backwards.
        backrest: what holds the back, if anything; it moves with the seat.
        cushion: the seat and cushion between the floor and the person, if any.
        values: in place of the identified ones.
        scale: in place of what the subject's law gives.

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
    values = values or OpenValues.identified()
    layers = ("seat", "cushion") if cushion else ()
    ground = "floor" if cushion else "seat"
    coordinates = (
        *(f"{body} {component}" for body in SPINE[::-1] for component in COMPONENTS),
        *(f"{viscus} {component}" for viscus in LOOSE for component in "xz"),
        *(f"{layer} z" for layer in layers),
    )
    row = dict(zip((*coordinates, *COMPONENTS), np.eye(len(coordinates) + 6), strict=True))
    below = {"floor": np.stack([row[component] for component in COMPONENTS])}
    for layer in layers:
        below[layer] = below["floor"].copy()
        below[layer][2] += row[f"{layer} z"]
    under = below[layers[-1] if layers else "floor"]
    person = _person(scale or scale_of(subject), recline, row, below["floor"])

    masses = _masses(person)
    springs = [*_bushings(person, values.bushing_fraction), *_viscera(person, values, row)]
    parts = (cushion.seat, cushion.cushion) if cushion else ()
    for on, name, part in zip(("floor", "seat"), layers, parts, strict=False):
        masses.append(Mass(below[name][:3], part.mass * np.eye(3)))
        rise = (below[name] - below[on])[2:3]
        springs.append(Spring(rise, np.array([part.stiffness]), np.array([part.damping])))
    buttocks, corners = _buttocks(person, values, under)
    readouts = [
        acceleration("Head", COMPONENTS, person.motions["Head"]),
        acceleration("S1", COMPONENTS, person.motions["S1"]),
        *(acceleration(layer, "z", below[layer][2:3]) for layer in layers),
        force("seat", COMPONENTS, exerted(buttocks, corners)),
    ]
    springs.append(buttocks)
    if backrest:
        relative, ends = _back(person, backrest.bodies, below[layers[0] if layers else "floor"])
        pads = [(2, backrest.tangential_stiffness, backrest.tangential_damping)]
        if isinstance(backrest, FoamBack):
            pads.append((0, backrest.stiffness, backrest.damping))
        at, stiffness, damping = (np.array(column) for column in zip(*pads, strict=True))
        pad = Spring(relative[at], stiffness, damping)
        springs.append(pad)
    matrices = assemble(masses, springs)
    if backrest:
        push = exerted(pad, ends[at])
        if isinstance(backrest, RigidBack):
            held = hold(relative[_FIXED], matrices, len(coordinates))
            push += ends[_FIXED].T @ held.forces
        readouts.append(force("backrest", COMPONENTS, push))
    if isinstance(backrest, RigidBack):
        coordinates = tuple(coordinates[i] for i in held.kept[:-6])
        matrices = held.every.T @ matrices @ held.every
        readouts = [Readout(readout.ports, readout.rows @ held.every) for readout in readouts]
    if cushion:
        readouts.append(force("floor", COMPONENTS, matrices[:, -6:]))
    return drive(coordinates, motion_ports(ground, COMPONENTS), matrices, readouts)


def _person(scale: Scale, recline: float, row: Mapping[str, Array], floor: Array) -> _Person:
    """The person's points, turned, and the motions of all that has a node.

    Each coordinate is a motion relative to the floor's. So springs stretch by coordinates alone,
    and the small difference of two large forces, by which a slow motion is accelerated, is not lost
    in the rounding of stiff springs.
    """
    c, s = np.cos(recline), np.sin(recline)
    turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    points = {name: turn @ point for name, point in nodes(scale).items()}
    motions = {
        body: np.stack([row[f"{body} {c}"] for c in COMPONENTS]) + carry(points[body]) @ floor
        for body in SPINE
    }
    person = _Person(scale, turn, points, motions)
    for viscus in VISCERA:
        motions[viscus] = person.at(viscus.removesuffix("V"), points[viscus])
        if viscus in LOOSE:
            motions[viscus][:3] += np.outer(turn[:, 0], row[f"{viscus} x"])
            motions[viscus][:3] += np.outer(turn[:, 2], row[f"{viscus} z"])
    for arm in ("L_arm", "R_arm"):
        motions[arm] = person.at("T2", points[arm])
    return person


def _masses(person: _Person) -> list[Mass]:
    """The masses of table 9, each at its offset from its node; the arms' are points."""
    masses = []
    for name, inertia in inertias(person.scale).items():
        centre = person.points[name] + person.turn @ inertia.centre
        tensor = person.turn @ inertia.tensor @ person.turn.T
        matrix = scipy.linalg.block_diag(inertia.mass * np.eye(3), tensor)
        masses.append(Mass(person.at(name, centre), matrix))
    for arm in ("L_arm", "R_arm"):
        mass = person.scale.mass["arm"] * float(table("table_9_masses")[arm]["mass_kg"])
        masses.append(Mass(person.motions[arm][:3], mass * np.eye(3)))
    return masses


def _bushings(person: _Person, fraction: float) -> list[Spring]:
    """The bushings of tables 10 and 11, z along the chord from the lower node to the upper one."""
    springs = []
    for lower, upper in pairwise(SPINE):
        chord = person.points[upper] - person.points[lower]
        sin, cos = chord[[0, 2]] / np.linalg.norm(chord)
        axes = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
        stands = person.points[lower] + fraction * chord
        apart = person.at(upper, stands) - person.at(lower, stands)
        joint = f"{upper}_{lower}"
        stiffness, damping = _bushing(joint)
        region, scale = region_of_joint(joint), person.scale
        stiffness = stiffness * [scale.stiffness(region, component) for component in _SCALED_AS]
        damping = damping * [scale.damping(region, component) for component in _SCALED_AS]
        turned = scipy.linalg.block_diag(axes, axes) @ apart
        springs.append(Spring(turned, stiffness, damping))
    return springs


def _bushing(name: str) -> tuple[Array, Array]:
    """Stiffness and damping of a row of tables 11 and 10, (6,), x to rz."""
    stiffness = numbers(table("table_11_stiffness")[name], *(f"k{i}_N_{u}" for i, u in _COLUMNS))
    units = {"m": "s_m", "m_rad": "m_s_rad"}
    damping = numbers(table("table_10_damping")[name], *(f"c{i}_N_{units[u]}" for i, u in _COLUMNS))
    return np.array(stiffness), np.array(damping)


def _viscera(person: _Person, values: OpenValues, row: Mapping[str, Array]) -> list[Spring]:
    """The ties of the viscera to their vertebrae, and the column of table 12."""
    region = region_of(VISCERA[0])
    stiffer = person.scale.stiffness(region, "axial")
    damper = person.scale.damping(region, "axial")
    ties = [(v, c, k) for v in LOOSE for c, k in zip("xz", values[3:5], strict=True)]
    stiffness = np.array([k for _, _, k in ties])
    moved = np.stack([row[f"{viscus} {component}"] for viscus, component, _ in ties])
    springs = [Spring(moved, stiffer * stiffness, damper * TIE_DAMPING_TIME * stiffness)]
    for joint, of in table("table_12_viscera").items():
        upper, lower = joint.split("_")
        share = values.column_top if upper == VISCERA[-1] else 1.0
        chord = person.points[upper] - person.points[lower]
        along = chord / np.linalg.norm(chord)
        stretch = along @ (person.motions[upper] - person.motions[lower])[:3]
        stiff, damped = share * np.array(numbers(of, "k33_N_m", "c33_N_s_m"))
        springs.append(
            Spring(stretch[None], np.array([stiffer * stiff]), np.array([damper * damped]))
        )
    return springs


def _buttocks(person: _Person, values: OpenValues, under: Array) -> tuple[Spring, Array]:
    """The four corners' springs, x to z each, and the motions of their lower ends, (12, 6).

    The corners stand level about the sacrum's `butt_up`, whatever the recline, and what lies under
    them is rigid.
    """
    across = np.array([values.buttock_x, values.buttock_y, 0.0]) * person.scale.length["pelvis"]
    stretch, ends, stiffness, damping = [], [], [], []
    for name, front in (("butt_front", 1.0), ("butt_rear", -1.0)):
        for side in (1.0, -1.0):
            corner = person.points["butt_up"] + across * (front, side, 0.0)
            ends.append(carry(corner)[:3])
            stretch.append(person.at("S1", corner)[:3] - ends[-1] @ under)
            k, c = _bushing(name)
            stiffness.append(person.scale.stiffness("pelvis", "axial") * k[:3])
            damping.append(person.scale.damping("pelvis", "axial") * c[:3])
    spring = Spring(np.vstack(stretch), np.concatenate(stiffness), np.concatenate(damping))
    return spring, np.vstack(ends)


def _back(person: _Person, bodies: Sequence[str], seat: Array) -> tuple[Array, Array]:
    """The back's mean motion over the backrest's, (6, n), in the backrest's axes.

    With it the backrest's own motion by the seat's, (6, 6).
    """
    at = person.points["T7"] - BEHIND * person.turn[:, 0]
    axes = scipy.linalg.block_diag(person.turn.T, person.turn.T)
    mean = average([person.motions[b] for b in bodies], [person.points[b] for b in bodies], at)
    end = axes @ carry(at)
    return axes @ mean - end @ seat, end
