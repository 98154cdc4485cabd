"""The elements of the finite-element spine: what its matrices and its Nastran decks are made of.

Every body of tables 8 and 9 is a node with six degrees of freedom. Bushings of tables 10 and 11
stand between neighbouring vertebrae, along the chord through both. The buttocks are four corner
springs under a plate that the sacrum carries. Viscera follow their vertebra but along x and z,
where they move on springs; a column of springs joins them (table 12), each along the line through
its two nodes. The arms are two point masses that T2 carries.

A reclined person is the erect one turned rigidly about the seat, or the one of a solved posture;
all springs turn with it but those of the buttocks, which keep the seat's axes. A bushing turns with
its lower vertebra. What the source leaves open is in `OpenValues`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Literal, NamedTuple, Self

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body.scaling import Scale
from posture_ik.body.spine import VISCERA, inertias, nodes
from posture_ik.body.tables import numbers, read_table, table
from posture_ik.errors import PostureIKError
from posture_ik.posture import Posture
from posture_ik.problem import SPINE, Cushion, FoamBack, LawBack, RigidBack, Subject
from posture_ik.vibration.backrest import at_preload, backrest_axes, rest_on
from posture_ik.vibration.factors import SOURCE, Factors
from posture_ik.vibration.network import Link, Mean
from posture_ik.vibration.seat import DATA

__all__ = [
    "LOOSE",
    "TIE_DAMPING_TIME",
    "Elements",
    "Link",
    "Lump",
    "Mean",
    "Node",
    "OpenValues",
    "spine_elements",
]

#: Damping over stiffness of the ties between viscera and vertebrae, s (assumed, as table 12's).
TIE_DAMPING_TIME = 0.1
#: Viscera that move on their vertebra; those of T10 and S1 are fixed to theirs.
LOOSE = VISCERA[1:-1][::-1]
_COLUMNS = ("11", "m"), ("22", "m"), ("33", "m"), ("44", "m_rad"), ("55", "m_rad"), ("66", "m_rad")
_SCALED_AS = ("axial", "axial", "axial", "rx", "ry", "rz")
_ALL, _NONE = (0, 1, 2, 3, 4, 5), ()


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
    def identified(cls, model: Literal["finite_element", "multibody"] = "finite_element") -> Self:
        """The values with which a model meets the source's own results best.

        Those of the multibody model stand beside its body's tables (`identified.csv`), as the
        bushings shape postures, those of the finite elements in `finite_element.csv`.
        """
        of_bodies = model == "multibody"
        rows = table("identified") if of_bodies else read_table(DATA / "finite_element.csv")
        return cls(*(float(rows[name]["value"]) for name in cls._fields))


class Node(NamedTuple):
    """A point that moves with another as one rigid body, but for what is free.

    Attributes:
        name: of the body.
        point: where, (3,), m.
        on: the node it moves with; none for what is driven.
        free: components, 0 to 5, that move by themselves, in `axes`.
        axes: columns, (3, 3).
    """

    name: str
    point: Array
    on: str | None
    free: tuple[int, ...] = _NONE
    axes: Array = np.eye(3)


class Lump(NamedTuple):
    """A rigid mass (kg) on a node: its centre from there (3,), m, and tensor (3, 3), kg m²."""

    node: str
    mass: float
    centre: Array
    tensor: Array


class Elements(NamedTuple):
    """A seated person: nodes (each behind the one it moves with), masses, links, the mean back.

    The first node is what is driven: `seat`, or `floor` under a cushion. `below` are the links
    that carry the person from below, `backrest` the one that holds the back.
    """

    nodes: tuple[Node, ...]
    lumps: tuple[Lump, ...]
    links: tuple[Link, ...]
    below: tuple[Link, ...]
    back: Mean | None
    backrest: Link | None

    @property
    def every_link(self) -> tuple[Link, ...]:
        """All links, those of the backrest last."""
        return (*self.links, *self.below, *([self.backrest] if self.backrest else []))


class _Person(NamedTuple):
    """A person's size; points (3,), m, and turns (3, 3) from the reference shape, `erect`."""

    scale: Scale
    erect: Mapping[str, Array]
    points: Mapping[str, Array]
    turns: Mapping[str, Array]


def spine_elements(
    subject: Subject,
    recline: float = 0.0,
    backrest: RigidBack | FoamBack | LawBack | None = None,
    cushion: Cushion | None = None,
    values: OpenValues | None = None,
    factors: Factors = SOURCE,
    posture: Posture | None = None,
) -> Elements:
    """The elements of a seated person; arguments as of `build_finite_element`.

    Raises:
        PostureIKError: the posture's body lacks a vertebra, or the backrest does not bear its
            preload (`at_preload`).
    """
    values = values or OpenValues.identified()
    person = _person(Scale.of(subject), recline, posture)

    origin = np.zeros(3)
    layers = {"seat": cushion.seat, "cushion": cushion.cushion} if cushion else {}
    stack = ("floor" if cushion else "seat", *layers)
    every = [Node(stack[0], origin, None), *_nodes(person, stack[0])]
    lumps = list(_lumps(person))
    links = [*_bushings(person, values, factors), *_viscera(person, values)]
    for on, (layer, part) in zip(stack, layers.items(), strict=False):
        every.append(Node(layer, origin, stack[0], (2,)))
        lumps.append(Lump(layer, part.mass, origin, np.zeros((3, 3))))
        upright = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        spring = part.stiffness * upright, part.damping * upright
        links.append(Link(f"{layer}_{on}", on, layer, origin, np.eye(3), *spring))
    below = tuple(_buttocks(person, values, factors, stack[-1]))
    back = held = None
    if backrest:
        behind = person.points[backrest.at]
        back, held = rest_on(at_preload(backrest, posture), recline, behind)
    return Elements(tuple(every), tuple(lumps), tuple(links), below, back, held)


def _person(scale: Scale, recline: float, posture: Posture | None) -> _Person:
    """A person erect and turned rigidly, or where the vertebrae of a posture are."""
    erect, turn = nodes(scale), backrest_axes(recline)
    points, turns = {body: turn @ erect[body] for body in SPINE}, dict.fromkeys(SPINE, turn)
    if posture:
        lacking = [body for body in SPINE if body not in posture.frames]
        if lacking:
            raise PostureIKError(
                f"vibration: the posture's body has no {', '.join(lacking)}, and so no shape for "
                'the finite-element model; take shape = "rigid".'
            )
        points = {body: posture.frames[body].translation for body in SPINE}
        turns = {body: posture.frames[body].rotation for body in SPINE}
    carriers = {viscus: viscus.removesuffix("V") for viscus in VISCERA}
    carriers |= {"L_arm": "T2", "R_arm": "T2", "butt_up": "S1"}
    for name, body in carriers.items():
        turns[name] = turns[body]
        points[name] = points[body] + turns[body] @ (erect[name] - erect[body])
    return _Person(scale, erect, points, turns)


def _nodes(person: _Person, ground: str) -> Iterator[Node]:
    """Vertebrae, relative to the ground; viscera, in the axes of their vertebra; arms."""
    for body in SPINE[::-1]:
        yield Node(body, person.points[body], ground, _ALL)
    for viscus in VISCERA[::-1]:
        free = (0, 2) if viscus in LOOSE else _NONE
        yield Node(
            viscus, person.points[viscus], viscus.removesuffix("V"), free, person.turns[viscus]
        )
    for arm in ("L_arm", "R_arm"):
        yield Node(arm, person.points[arm], "T2")


def _lumps(person: _Person) -> Iterator[Lump]:
    """The masses of table 9, each at its offset from its node; the arms' are points."""
    for name, inertia in inertias(person.scale).items():
        turn = person.turns[name]
        yield Lump(name, inertia.mass, turn @ inertia.centre, turn @ inertia.tensor @ turn.T)
    for arm in ("L_arm", "R_arm"):
        mass = person.scale.mass * float(table("table_9_masses")[arm]["mass_kg"])
        yield Lump(arm, mass, np.zeros(3), np.zeros((3, 3)))


def _bushings(person: _Person, values: OpenValues, factors: Factors) -> Iterator[Link]:
    """The bushings of tables 10 and 11, z along the chord from the lower node to the upper one.

    Each turns with the lower vertebra and stands where the upper one holds it: in a bent spine as
    the joints of the multibody model.
    """
    scales = np.array([person.scale.stiffness(component) for component in _SCALED_AS])
    for lower, upper in pairwise(SPINE):
        chord = person.erect[upper] - person.erect[lower]
        down = (1.0 - values.bushing_fraction) * person.turns[upper] @ chord
        stands, axes = person.points[upper] - down, person.turns[lower] @ _along(chord)
        name = f"{upper}_{lower}"
        stiffness, damping = (scales * column for column in _bushing(name, factors))
        yield Link(name, lower, upper, stands, axes, stiffness, damping)


def _along(chord: Array) -> Array:
    """Axes whose z runs along a chord (3,), and whose x is square to y; columns, (3, 3)."""
    z = chord / np.linalg.norm(chord)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _bushing(name: str, factors: Factors) -> tuple[Array, Array]:
    """Stiffness and damping of a row of tables 11 and 10, (6,), x to rz."""
    stiffness = numbers(table("table_11_stiffness")[name], *(f"k{i}_N_{u}" for i, u in _COLUMNS))
    units = {"m": "s_m", "m_rad": "m_s_rad"}
    damping = numbers(table("table_10_damping")[name], *(f"c{i}_N_{units[u]}" for i, u in _COLUMNS))
    softer, damped = factors.of_joint(name)
    return softer * np.array(stiffness), damped * np.array(damping)


def _viscera(person: _Person, values: OpenValues) -> Iterator[Link]:
    """The ties of the viscera to their vertebrae, and the column of table 12."""
    factor = person.scale.stiffness("axial")
    tie = factor * np.array([values.visceral_x, 0.0, values.visceral_z, 0.0, 0.0, 0.0])
    for viscus in LOOSE:
        lower, at = viscus.removesuffix("V"), person.points[viscus]
        damping = TIE_DAMPING_TIME * tie
        yield Link(f"{viscus}_{lower}", lower, viscus, at, person.turns[viscus], tie, damping)
    for joint, of in table("table_12_viscera").items():
        upper, lower = joint.split("_")
        share = factor * (values.column_top if upper == VISCERA[-1] else 1.0)
        stiffness, damping = np.zeros(6), np.zeros(6)
        stiffness[2], damping[2] = share * np.array(numbers(of, "k33_N_m", "c33_N_s_m"))
        axes = _along(person.points[upper] - person.points[lower])
        at = person.points[lower]  # or anywhere else on the line through both
        yield Link(joint, lower, upper, at, axes, stiffness, damping)


def _buttocks(person: _Person, values: OpenValues, factors: Factors, under: str) -> Iterator[Link]:
    """The four corners' springs, x to z each.

    The corners stand level about the sacrum's `butt_up`, whatever the recline, and what lies under
    them is rigid.
    """
    across = person.scale.point(np.array([values.buttock_x, values.buttock_y, 0.0]))
    pushes = person.scale.stiffness("axial") * np.repeat([1.0, 0.0], 3)
    for name, front in (("butt_front", 1.0), ("butt_rear", -1.0)):
        stiffness, damping = (pushes * column for column in _bushing(name, factors))
        for side, left in (("left", 1.0), ("right", -1.0)):
            corner = person.points["butt_up"] + across * (front, left, 0.0)
            yield Link(f"{name}_{side}", under, "S1", corner, np.eye(3), stiffness, damping)
