"""What is asked, block by block, checked and completed with defaults.

A problem names a subject, a seat, the tasks to hold and how the posture is to be solved. Everything
here is plain data in the units people write (degrees in keys that end in `_deg`, SI elsewhere);
`posture_ik.posture` turns it into equations.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    field_validator,
    model_validator,
)

from posture_ik.arrays import Array
from posture_ik.errors import nearest
from posture_ik.problem.block import Block
from posture_ik.problem.paths import number_at
from posture_ik.problem.signals import Signal, Table
from posture_ik.problem.vibration import VibrationBlock

#: Spine bodies from the seat to the head.
SPINE = (
    "S1",
    *(f"L{i}" for i in range(5, 0, -1)),
    *(f"T{i}" for i in range(12, 0, -1)),
    *(f"C{i}" for i in range(7, 0, -1)),
    "Head",
)
Component = Literal["x", "y", "z", "rx", "ry", "rz"]
COMPONENTS: tuple[Component, ...] = ("x", "y", "z", "rx", "ry", "rz")
Vector = tuple[float, float, float]


def _within_the_cabin(position: Vector) -> Vector:
    if max(abs(value) for value in position) > 3.0:
        raise ValueError(
            "lies more than 3 m from the seat; positions are in metres (were these millimetres?)"
        )
    return position


def _expand_bodies(value: Any) -> Any:
    """Write `"T1-T10"` out as the vertebrae it names, lower end first as the spine is built."""
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names:
        raise ValueError('write a range such as "T1-T10" or a list such as ["T1", "T5"]')
    bodies: list[str] = []
    for name in names:
        ends = [end.strip() for end in str(name).split("-")]
        for end in ends:
            if end not in SPINE:
                raise ValueError(f"no vertebra is called {end!r}; {nearest(end, SPINE)}")
        first, last = sorted((SPINE.index(ends[0]), SPINE.index(ends[-1])))
        bodies += [body for body in SPINE[first : last + 1] if body not in bodies]
    return tuple(bodies)


Position = Annotated[Vector, AfterValidator(_within_the_cabin)]
Bodies = Annotated[tuple[str, ...], BeforeValidator(_expand_bodies)]
Angle = Annotated[float, Field(ge=-180.0, le=180.0)]
Components = Annotated[tuple[Component, ...], Field(min_length=1)]


class Subject(Block):
    """Who sits: gender, age (years), weight (kg), stature (m).

    The defaults are the reference subject of the source's §3.2. `urdf` names a file of one's own
    in place of the scaled reference body.
    """

    gender: Literal["male", "female"] = "male"
    age: float = Field(30.0, ge=18.0, le=99.0)
    weight: float = Field(80.0, gt=0.0)
    stature: float = 1.80
    urdf: Path | None = None

    @field_validator("stature")
    @classmethod
    def _stature_in_metres(cls, stature: float) -> float:
        if not 1.40 <= stature <= 2.10:
            hint = f" (did you mean {stature / 100:g} m?)" if 140 <= stature <= 210 else ""
            raise ValueError(f"the stature must lie between 1.40 and 2.10 m{hint}")
        return stature

    @model_validator(mode="after")
    def _weight_of_a_person(self) -> Subject:
        if not 14.0 <= self.body_mass_index <= 55.0:
            low, high = (bmi * self.stature**2 for bmi in (14.0, 55.0))
            raise ValueError(
                f"weight {self.weight:g} kg at {self.stature:g} m is a body mass index of "
                f"{self.body_mass_index:.1f}; it must lie between 14 and 55, that is "
                f"{low:.0f} to {high:.0f} kg"
            )
        return self

    @property
    def body_mass_index(self) -> float:
        """Weight over stature squared, kg/m²."""
        return self.weight / self.stature**2


class RigidBack(Block):
    """A backrest that the back touches and slides along: nothing else of its mean motion is left.

    The mean motion of `bodies` (an RBE3 average) is taken at a point 0.1 m behind T7. Along the
    back it is free, or held by a spring (N/m) and a damper (N s/m).
    """

    kind: Literal["rigid"] = "rigid"
    bodies: Bodies = _expand_bodies("T1-T10")
    tangential_stiffness: float = Field(0.0, ge=0.0)
    tangential_damping: float = Field(0.0, ge=0.0)


class FoamBack(Block):
    """A backrest of foam: a spring (N/m) and a damper (N s/m) behind the mean of `bodies`.

    They act square to the back at a point 0.1 m behind T7, and others along it where asked. The
    values are those of Toward & Griffin's foam.
    """

    kind: Literal["foam"] = "foam"
    bodies: Bodies = _expand_bodies("T1-T10")
    stiffness: float = Field(21e3, gt=0.0)
    damping: float = Field(109.0, ge=0.0)
    tangential_stiffness: float = Field(0.0, ge=0.0)
    tangential_damping: float = Field(0.0, ge=0.0)


class Seat(Block):
    """Where one sits.

    `recline_deg`: the backrest's angle from the vertical, positive backwards, turned about the
    seat. `backrest`: what the back meets when it vibrates; nothing if not given.
    """

    recline_deg: float = Field(0.0, ge=-45.0, le=90.0)
    backrest: Annotated[RigidBack | FoamBack, Field(discriminator="kind")] | None = None


class Gaze(Block):
    """Where the head looks, from straight ahead and level, in degrees.

    First turned (about z, positive to the left), then nodded (about y, positive down), then
    tilted (about x, positive to the right shoulder).
    """

    turn_deg: Angle = 0.0
    nod_deg: Angle = 0.0
    tilt_deg: Angle = 0.0


def _read_gaze(value: Any) -> Any:
    if value == "ahead":
        return Gaze()
    if isinstance(value, (dict, Gaze)):
        return value
    raise ValueError('write "ahead" or { turn_deg = 40, nod_deg = 0, tilt_deg = 10 }')


def _read_head_position(value: Any) -> Any:
    if value in ("free", "over C1") or isinstance(value, (list, tuple)):
        return value
    raise ValueError('write "free", "over C1" or a position such as [0.02, 0.0, 0.75] in metres')


class Head(Block):
    """The head's orientation held; its position free, over C1 of the reclined spine, or given."""

    kind: Literal["head"] = "head"
    looking: Annotated[Gaze, BeforeValidator(_read_gaze)] = Gaze()
    position: Annotated[
        Literal["free", "over C1"] | Position, BeforeValidator(_read_head_position)
    ] = "free"


class Backrest(Block):
    """The mean pose of some vertebrae carried rigidly to the reclined plane (an RBE3 average).

    `slide` leaves the direction along the back free.
    """

    kind: Literal["backrest"] = "backrest"
    bodies: Bodies = _expand_bodies("T1-T10")
    slide: bool = False


class BackrestContact(Block):
    """A backrest that can only push: vertebrae may lift off it but not enter. Needs gravity."""

    kind: Literal["backrest_contact"] = "backrest_contact"
    bodies: Bodies = _expand_bodies("T1-T12")


class Pelvis(Block):
    """The pelvis rolled back (positive) and tilted to the right (positive), in degrees."""

    kind: Literal["pelvis"] = "pelvis"
    roll_back_deg: Angle = 0.0
    oblique_deg: Angle = 0.0


class Lever(Block):
    """A control lever on a hinge: where it turns, how long it is, how far it is swung.

    Upright at zero, it swings about its pivot forward (`fore_aft_deg`, about y) and then to the
    right (`lateral_deg`, about x). The hand holds it `length` metres from the pivot, on a handle
    bent forward from the lever by `handle_deg`.

    The angles drive the hand, unless they are named in `follows`: those the hand moves, against a
    spring (`stiffness`, N m/rad) that rests at the angle given and a damper (N m s/rad), by up to
    `throw_deg` to either side; the lever's `mass` (kg) is spread evenly along it. No cockpit's
    values are published where we looked: the defaults are assumed.
    """

    pivot: Position
    length: float = Field(gt=0.0, le=2.0)
    fore_aft_deg: Angle = 0.0
    lateral_deg: Angle = 0.0
    handle_deg: Angle = 0.0
    follows: tuple[Literal["fore_aft", "lateral"], ...] = ()
    stiffness: float = Field(2.0, gt=0.0)
    damping: float = Field(0.2, ge=0.0)
    mass: float = Field(1.0, gt=0.0)
    throw_deg: float = Field(25.0, gt=0.0, le=180.0)


class Hand(Block):
    """A hand's grip held at a pose, given outright or as that of a lever of the problem.

    The grip's z is the axis of the stick (up through the thumb's side), x points away from the
    forearm. `rotation_deg` turns it from the world's axes: about z, then y, then x, given as
    [about x, about y, about z].
    """

    kind: Literal["hand"] = "hand"
    side: Literal["right", "left"]
    lever: str | None = None
    position: Position | None = None
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    components: Components = COMPONENTS

    @model_validator(mode="after")
    def _held_by_one_of_two(self) -> Hand:
        if (self.lever is None) == (self.position is None):
            raise ValueError(
                f"the {self.side} hand needs either a lever or a position, and not both"
            )
        return self


class Frame(Block):
    """Any link of the body held in any of its six components, along the target's own axes."""

    kind: Literal["frame"] = "frame"
    frame: str
    components: Components
    position: Position = (0.0, 0.0, 0.0)
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)


Task = Annotated[
    Head | Backrest | BackrestContact | Pelvis | Hand | Frame, Field(discriminator="kind")
]


def _read_stiffness(value: Any) -> Any:
    if value in ("tissue", "uniform"):
        return value
    if isinstance(value, dict):
        for joint, stiffness in value.items():
            number = isinstance(stiffness, (int, float)) and not isinstance(stiffness, bool)
            if not (number and math.isfinite(stiffness) and stiffness > 0.0):
                raise ValueError(f"the stiffness of {joint} must be above zero, not {stiffness!r}")
        return value
    raise ValueError(
        'write "tissue", "uniform" or a table of joints such as { L5_S1_ry = 150.0 } '
        "in N/m or N m/rad"
    )


class PostureBlock(Block):
    """How the posture is found.

    `stiffness`: "tissue" (table 11), "uniform", or a table that replaces the tissue value of the
    joints it names. `ergonomic`: the springs rest in the "reference" shape or in the "middle" of
    the joint ranges (eq 17). `gravity`: count the potential of weight, so that the posture found
    is a static equilibrium.
    """

    stiffness: Annotated[
        Literal["tissue", "uniform"] | dict[str, float], BeforeValidator(_read_stiffness)
    ] = "tissue"
    ergonomic: Literal["reference", "middle"] = "reference"
    gravity: bool = False


class MotionBlock(Block):
    """How long to move (s), how many steps a second, and which numbers of the problem move."""

    duration: float = Field(gt=0.0, le=600.0)
    rate: float = Field(100.0, gt=0.0, le=10_000.0)
    signal: tuple[Signal, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _tables_span_the_motion(self) -> MotionBlock:
        for signal in self.signal:
            if isinstance(signal, Table) and not (
                signal.times[0] <= 0.0 and signal.times[-1] >= self.duration
            ):
                raise ValueError(
                    f"the table of {signal.of} spans {signal.times[0]:g} to "
                    f"{signal.times[-1]:g} s, but the motion 0 to {self.duration:g} s"
                )
        if self.duration * self.rate < 4.0:
            raise ValueError(
                f"{self.duration:g} s at {self.rate:g} steps a second are too few steps for an "
                "acceleration; a motion needs 4 or more"
            )
        return self

    @property
    def times(self) -> Array:
        """Instants of the steps, (T,), s, from 0 up to the duration."""
        return np.arange(int(np.floor(self.duration * self.rate + 1e-9)) + 1) / self.rate


class Reflex(Block):
    """Gains of the stretch reflex (eq 33): activation per optimal length and per top speed."""

    proportional: float = Field(0.0, ge=0.0)
    derivative: float = Field(0.0, ge=0.0)


class ActivationBlock(Block):
    """How the muscles of the arms share the work.

    `law`: of muscle force. `cost`: what is least, the sum of activations squared (eq 32), weighted
    by muscle volume, or the highest activation (fatigue). `co_contraction`: the activation towards
    which all are drawn without changing any torque. `hand_force`: what acts on the right or left
    hand beside a lever that follows it, N, world axes. `short_range`: take the stiffness of
    active muscle from its first few tenths of a per cent of stretch, as vibration finds it.
    """

    law: Literal["pennestri", "de_groote"] = "pennestri"
    cost: Literal["squares", "volume", "fatigue"] = "squares"
    co_contraction: float = Field(0.0, ge=0.0, le=1.0)
    hand_force: dict[Literal["right", "left"], Vector] = Field(default_factory=dict)
    reflex: Reflex = Reflex()
    short_range: bool = False


def _read_per_joint(value: Any) -> Any:
    for joint, number in (value if isinstance(value, dict) else {"": value}).items():
        is_number = isinstance(number, (int, float)) and not isinstance(number, bool)
        if not (is_number and math.isfinite(number) and number > 0.0):
            of = f" for {joint}" if joint else " or a table of joints"
            raise ValueError(f"write a number above zero{of}, not {number!r}")
    return value


PerJoint = Annotated[float | dict[str, float], BeforeValidator(_read_per_joint)]


class TrajectoryBlock(Block):
    """How to reach the tasks from rest, by optimal control.

    The joints that move go from the posture that meets all other tasks to where all tasks are met,
    at rest at both ends.

    `cost`: "effort" for least ∫ Σ (torque / strength)² dt, "time" for the least duration,
    "activation" for least ∫ Σ activation² dt of the arms' muscles, which then drive the joints by
    the law of [activation]. `activation_dynamics`: activations change no faster than muscles can.
    `duration`: s; found where it is not given. `joints`: names of those that move; the arms of the
    hands in the tasks if not given. `speed`, `torque`: limits to either side, one for all joints or
    a table of some, rad/s or m/s and N m or N. `strength`: what torques are measured by, likewise.
    `smoothness`: weight of ∫ Σ a² dt beside the cost. `tolerance`: by how much the motion computed
    may miss its own integration within an interval, rad or m. `along`: tasks held all the way.
    """

    cost: Literal["effort", "time", "activation"] = "effort"
    activation_dynamics: bool = False
    duration: float | None = Field(None, gt=0.0, le=60.0)
    joints: tuple[str, ...] | None = Field(None, min_length=1)
    speed: PerJoint | None = None
    torque: PerJoint | None = None
    strength: PerJoint = 1.0
    smoothness: float | None = Field(None, ge=0.0)
    tolerance: float = Field(1e-4, ge=1e-8, le=0.1)
    along: tuple[Task, ...] = ()

    @model_validator(mode="after")
    def _least_time_is_found_and_bounded(self) -> TrajectoryBlock:
        if self.cost == "time" and self.duration is not None:
            raise ValueError("least time finds the duration; leave duration out, or ask for effort")
        if self.cost == "time" and not (self.speed or self.torque):
            raise ValueError("least time needs a limit on torque or speed, or it takes no time")
        return self

    @model_validator(mode="after")
    def _muscles_lag_where_they_drive(self) -> TrajectoryBlock:
        if self.activation_dynamics and self.cost != "activation":
            raise ValueError("activation_dynamics is of muscles; ask for cost = 'activation' too")
        return self


class Problem(Block):
    """A whole problem: who, where, what is held, how it is solved, and how it moves if it does."""

    title: str = "Untitled"
    subject: Subject = Subject()
    seat: Seat = Seat()
    task: tuple[Task, ...] = Field(min_length=1)
    posture: PostureBlock = PostureBlock()
    lever: dict[str, Lever] = Field(default_factory=dict)
    motion: MotionBlock | None = None
    trajectory: TrajectoryBlock | None = None
    activation: ActivationBlock | None = None
    vibration: VibrationBlock | None = None

    @model_validator(mode="after")
    def _moves_one_way(self) -> Problem:
        if self.motion and self.trajectory:
            raise ValueError(
                "a problem has [motion], that follows signals, or [trajectory], that finds its "
                "own way, not both"
            )
        if self.activation and self.trajectory and self.trajectory.cost != "activation":
            raise ValueError(
                "[activation] says how muscles share the work, and no muscle drives a [trajectory] "
                f'of cost = "{self.trajectory.cost}"; leave it out, or take cost = "activation"'
            )
        return self

    @model_validator(mode="after")
    def _reaches_for_levers_that_stand(self) -> Problem:
        for name, lever in self.lever.items():
            if self.trajectory and lever.follows:
                raise ValueError(
                    f"a [trajectory] ends on a lever that stands, and lever.{name} follows the "
                    "hand; leave follows out"
                )
        return self

    @model_validator(mode="after")
    def _levers_exist(self) -> Problem:
        along = self.trajectory.along if self.trajectory else ()
        for task in (*self.task, *along):
            if isinstance(task, Hand) and task.lever not in (None, *self.lever):
                known = nearest(str(task.lever), self.lever) if self.lever else "there is none yet"
                raise ValueError(
                    f"the {task.side} hand holds no lever called {task.lever!r}; {known}"
                )
        return self

    @model_validator(mode="after")
    def _levers_follow_a_hand(self) -> Problem:
        hands = [task for task in self.task if isinstance(task, Hand)]
        for name, lever in self.lever.items():
            holding = [hand for hand in hands if hand.lever == name]
            if lever.follows and not holding:
                raise ValueError(f"lever.{name} follows no hand; let a hand task hold it")
            for hand in holding if lever.follows else ():
                if not {"x", "y", "z"} <= set(hand.components):
                    raise ValueError(
                        f"the {hand.side} hand must hold x, y and z of lever.{name}, which follows "
                        f"it, and holds only {', '.join(hand.components)}"
                    )
        return self

    @model_validator(mode="after")
    def _tasks_agree(self) -> Problem:
        seen: set[str] = set()
        for number, task in enumerate(self.task, 1):
            held = task_label(task)
            if held in seen:
                raise ValueError(f"task {number} holds {held} a second time; keep one of the two")
            seen.add(held)
        along: set[str] = set()
        for number, task in enumerate(self.trajectory.along if self.trajectory else (), 1):
            held = task_label(task)
            if held in along:
                raise ValueError(f"along {number} holds {held} a second time; keep one of the two")
            along.add(held)
        if "backrest contact" in seen | along and not self.posture.gravity:
            raise ValueError(
                "a backrest_contact needs the weight that presses on it: "
                "set gravity = true under [posture], or use a backrest task"
            )
        return self

    @model_validator(mode="after")
    def _signals_move_numbers(self) -> Problem:
        moved: set[str] = set()
        for signal in self.motion.signal if self.motion else ():
            if signal.of in moved:
                raise ValueError(f"two signals move {signal.of}; keep one of the two")
            moved.add(signal.of)
            block, _, name = signal.of.rpartition(".")[0].partition(".")
            if block == "activation":
                raise ValueError(f"{signal.of} cannot move: [activation] holds all the time")
            if block == "lever" and name in self.lever and self.lever[name].follows:
                raise ValueError(f"{signal.of} cannot move: lever.{name} follows the hand")
            value = number_at(self, signal.of)
            if not isinstance(value, (int, float)) or isinstance(value, bool):
                raise ValueError(f"a signal can only move a number, and {signal.of} is {value!r}")
        return self


def task_label(task: Head | Backrest | BackrestContact | Pelvis | Hand | Frame) -> str:
    """Name what a task holds, as the report does: `head`, `right hand`, `frame T5`."""
    if isinstance(task, Hand):
        return f"{task.side} hand"
    if isinstance(task, Frame):
        return f"frame {task.frame}"
    return task.kind.replace("_", " ")
