"""What is asked: a problem file read, checked and completed with defaults.

A problem names a subject, a seat, the tasks to hold and how the posture is to be solved. Everything
here is plain data in the units people write (degrees in keys that end in `_deg`, SI elsewhere);
`posture_ik.posture` turns it into equations.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from posture_ik.errors import BadProblem, nearest
from posture_ik.resources import resource

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


class Block(BaseModel):
    """A block of a problem file: unknown keys are refused, nothing changes after it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


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


class Seat(Block):
    """Where: the backrest's angle from the vertical, positive backwards, turned about the seat."""

    recline_deg: float = Field(0.0, ge=-45.0, le=90.0)


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


class Hand(Block):
    """A hand's grip held at a pose, say that of a lever.

    The grip's z is the axis of the stick (up through the thumb's side), x points away from the
    forearm. `rotation_deg` turns it from the world's axes: about z, then y, then x, given as
    [about x, about y, about z].
    """

    kind: Literal["hand"] = "hand"
    side: Literal["right", "left"]
    position: Position
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    components: Components = COMPONENTS


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


class Problem(Block):
    """A whole problem: who, where, what is held, how it is solved."""

    title: str = "Untitled"
    subject: Subject = Subject()
    seat: Seat = Seat()
    task: tuple[Task, ...] = Field(min_length=1)
    posture: PostureBlock = PostureBlock()

    @model_validator(mode="after")
    def _tasks_agree(self) -> Problem:
        seen: set[str] = set()
        for number, task in enumerate(self.task, 1):
            held = task_label(task)
            if held in seen:
                raise ValueError(f"task {number} holds {held} a second time; keep one of the two")
            seen.add(held)
        if "backrest contact" in seen and not self.posture.gravity:
            raise ValueError(
                "a backrest_contact needs the weight that presses on it: "
                "set gravity = true under [posture], or use a backrest task"
            )
        return self


def task_label(task: Head | Backrest | BackrestContact | Pelvis | Hand | Frame) -> str:
    """Name what a task holds, as the report does: `head`, `right hand`, `frame T5`."""
    if isinstance(task, Hand):
        return f"{task.side} hand"
    if isinstance(task, Frame):
        return f"frame {task.frame}"
    return task.kind.replace("_", " ")


def example_problems() -> dict[str, Path]:
    """Find the example problems that ship with the package, by name."""
    return {path.stem: path for path in sorted(resource("problems").glob("*.toml"))}


def load_problem(name: str | Path, overrides: tuple[str, ...] = ()) -> Problem:
    """Read a problem file, or an example by its name, with `key=value` overrides.

    Args:
        name: path of a TOML file, or the name of an example such as `reclined_15`.
        overrides: such as `seat.recline_deg=20` or `task.backrest.slide=true`; a task is named by
            its kind or by its number from 1.

    Raises:
        BadProblem: one sentence with the place, the value, and what would be valid.
    """
    examples = example_problems()
    path = Path(name)
    if path.suffix != ".toml" and str(name) in examples:
        path = examples[str(name)]
    elif path.suffix != ".toml" and not path.exists():
        raise BadProblem(
            str(name), f"no example problem has this name; {nearest(str(name), examples)}"
        )
    data = _read_toml(path)
    _anchor_urdf(data, path.parent)
    for override in overrides:
        _set(data, override)
    _anchor_urdf(data, Path.cwd())
    try:
        return Problem.model_validate(data)
    except ValidationError as error:
        raise BadProblem(path.name, _one_sentence(error, data)) from None


def _anchor_urdf(data: dict[str, Any], folder: Path) -> None:
    """Read a relative path of a URDF from the folder of the file or command that names it."""
    subject = data.get("subject")
    if isinstance(subject, dict) and isinstance(subject.get("urdf"), str):
        subject["urdf"] = str((folder / subject["urdf"]).resolve())


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        text = path.read_bytes().decode("utf-8")
        data = tomllib.loads(text)
    except FileNotFoundError:
        raise BadProblem(str(path), "there is no such file") from None
    except OSError as error:
        raise BadProblem(str(path), f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadProblem(str(path), "is not a text file in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise BadProblem(str(path), f"is not valid TOML: {error}") from None
    if not data:
        raise BadProblem(str(path), "is empty; a problem needs at least one [[task]]")
    return data


def _set(data: dict[str, Any], override: str) -> None:
    """Write `a.b.c=value` into nested tables; the value is TOML, or else a plain string."""
    key, separator, text = override.partition("=")
    if not separator or not key.strip():
        raise BadProblem(f"--set {override}", "write key=value, such as seat.recline_deg=20")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    *parents, last = key.strip().split(".")
    table: Any = data
    for name in parents:
        table = _task_named(table, name) if isinstance(table, list) else table.setdefault(name, {})
        if not isinstance(table, (dict, list)):
            raise BadProblem(f"--set {override}", f"{name} holds a value, not a table")
    if isinstance(table, list):
        raise BadProblem(f"--set {override}", "name the task and its key: task.backrest.slide=true")
    table[last] = value


def _task_named(tasks: list[Any], name: str) -> Any:
    for number, task in enumerate(tasks, 1):
        if isinstance(task, dict) and name in (str(number), task.get("kind")):
            return task
    kinds = [str(task.get("kind")) for task in tasks if isinstance(task, dict)]
    raise BadProblem(f"--set task.{name}", f"there is no such task; {nearest(name, kinds)}")


def _one_sentence(error: ValidationError, data: dict[str, Any]) -> str:
    """Turn pydantic's first complaint into a sentence with place, value and what is valid."""
    # A value that may be a word or something else is refused by both; the something else says more.
    errors = error.errors()
    first = next((e for e in errors if "literal[" not in str(e["loc"][-1:])), errors[0])
    place, model = _place(first["loc"], data)
    value = first["input"]
    message = first["msg"].removeprefix("Value error, ")
    match first["type"]:
        case "extra_forbidden":
            key = str(first["loc"][-1])
            return f"{place} is not a known key; {nearest(key, model.model_fields)}"
        case "missing":
            return f"{place} is missing"
        case "union_tag_not_found":
            return f"{place} needs a kind, one of {first['ctx'].get('expected_tags', _KINDS)}"
        case "union_tag_invalid":
            tag = first["ctx"]["tag"]
            return f"{place}: no task is of kind {tag!r}; {nearest(tag, _TASKS)}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{place} is {value!r}, but must be a block of keys"
    if isinstance(value, (dict, BaseModel)):
        return f"{place + ': ' if place else ''}{message}"
    return f"{place} = {value!r}: {message[0].lower() + message[1:]}"


_TASKS: dict[str, type[Block]] = {
    cls.model_fields["kind"].default: cls
    for cls in (Head, Backrest, BackrestContact, Pelvis, Hand, Frame)
}
_KINDS = ", ".join(_TASKS)
_BLOCKS: dict[str, type[Block]] = {
    "subject": Subject,
    "seat": Seat,
    "posture": PostureBlock,
    "looking": Gaze,
}


def _place(loc: tuple[int | str, ...], data: dict[str, Any]) -> tuple[str, type[Block]]:
    """Write pydantic's location as a person would, and find the block it lies in."""
    words: list[str] = []
    model: type[Block] = Problem
    for step in loc:
        if isinstance(step, int):
            words.append(f"task {step + 1}" if words == ["task"] else f"item {step + 1}")
            if words[0] == "task" and len(words) == 2:
                words = words[1:]
        elif step in _TASKS and words and words[-1].startswith("task "):
            model = _TASKS[step]
            words[-1] += f" ({step})"
        elif step.startswith(("literal[", "tuple[", "function-", "dict[", "float", "int")):
            continue
        else:
            words.append(step)
            model = _BLOCKS.get(step, model) if step != loc[-1] else model
    return ".".join(words), model
