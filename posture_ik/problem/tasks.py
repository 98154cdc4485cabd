"""What is held: tasks, block by block, in the units people write."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from posture_ik.errors import nearest
from posture_ik.problem.block import Block

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


def expand_bodies(value: Any) -> Any:
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


def _a_vertebra(name: str) -> str:
    if name not in SPINE:
        raise ValueError(f"no vertebra is called {name!r}; {nearest(name, SPINE)}")
    return name


Position = Annotated[Vector, AfterValidator(_within_the_cabin)]
Bodies = Annotated[tuple[str, ...], BeforeValidator(expand_bodies)]
Vertebra = Annotated[str, AfterValidator(_a_vertebra)]
Angle = Annotated[float, Field(ge=-180.0, le=180.0)]
Components = Annotated[tuple[Component, ...], Field(min_length=1)]


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
    bodies: Bodies = expand_bodies("T1-T10")
    slide: bool = False


class BackrestContact(Block):
    """A backrest that can only push: vertebrae may lift off it but not enter. Needs gravity."""

    kind: Literal["backrest_contact"] = "backrest_contact"
    bodies: Bodies = expand_bodies("T1-T12")


class Pelvis(Block):
    """The pelvis rolled back (positive) and tilted to the right (positive), in degrees."""

    kind: Literal["pelvis"] = "pelvis"
    roll_back_deg: Angle = 0.0
    oblique_deg: Angle = 0.0


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


def task_label(task: Head | Backrest | BackrestContact | Pelvis | Hand | Frame) -> str:
    """Name what a task holds, as the report does: `head`, `right hand`, `frame T5`."""
    if isinstance(task, Hand):
        return f"{task.side} hand"
    if isinstance(task, Frame):
        return f"frame {task.frame}"
    return task.kind.replace("_", " ")
