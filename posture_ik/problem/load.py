"""Read a problem file, with overrides, and say in one sentence what is wrong with it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from posture_ik.errors import BadProblem, nearest
from posture_ik.files import read_toml
from posture_ik.problem.block import Block
from posture_ik.problem.blocks import (
    FoamBack,
    LawBack,
    Lever,
    Problem,
    RigidBack,
    Seat,
)
from posture_ik.problem.stages import (
    ActivationBlock,
    MotionBlock,
    PostureBlock,
    Reflex,
    TrajectoryBlock,
)
from posture_ik.problem.subject import Measured, Subject
from posture_ik.problem.tasks import (
    Backrest,
    BackrestContact,
    Frame,
    Gaze,
    Hand,
    Head,
    Pelvis,
)
from posture_ik.problem.vibration import FrequencyBlock, VibrationBlock
from posture_ik.resources import resource


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
    data = read_toml(path)
    if not data:
        raise BadProblem(str(path), "is empty; a problem needs at least one [[task]]")
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
        if isinstance(table, list):
            table = table[_numbered(table, name, override)]
        else:
            table = table.setdefault(name, {})
        if not isinstance(table, (dict, list)):
            raise BadProblem(f"--set {override}", f"{name} holds a value, not a table")
    if isinstance(table, list):
        table[_numbered(table, last, override)] = value
    else:
        table[last] = value


def _numbered(blocks: list[Any], name: str, override: str) -> int:
    """Find one of several blocks by its kind or by its number from 1."""
    for i, block in enumerate(blocks):
        if isinstance(block, dict) and name in (str(i + 1), block.get("kind")):
            return i
    kinds = [str(block.get("kind")) for block in blocks if isinstance(block, dict)]
    raise BadProblem(f"--set {override}", f"no block is called {name!r}; {nearest(name, kinds)}")


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
        case "union_tag_not_found" | "union_tag_invalid":
            what, kinds = ("backrest", _BACKS) if place == "seat.backrest" else ("task", _TASKS)
            if first["type"] == "union_tag_not_found":
                return f"{place} needs a kind, one of {', '.join(kinds)}"
            tag = first["ctx"]["tag"]
            return f"{place}: no {what} is of kind {tag!r}; {nearest(tag, kinds)}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{place} is {value!r}, but must be a block of keys"
    if isinstance(value, (dict, BaseModel)):
        return f"{place + ': ' if place else ''}{message}"
    return f"{place} = {value!r}: {message[0].lower() + message[1:]}"


_TASKS: dict[str, type[Block]] = {
    cls.model_fields["kind"].default: cls
    for cls in (Head, Backrest, BackrestContact, Pelvis, Hand, Frame)
}
_BACKS: dict[str, type[Block]] = {"rigid": RigidBack, "foam": FoamBack, "law": LawBack}
_BLOCKS: dict[str, type[Block]] = {
    "subject": Subject,
    "measured": Measured,
    "seat": Seat,
    "posture": PostureBlock,
    "looking": Gaze,
    "motion": MotionBlock,
    "activation": ActivationBlock,
    "reflex": Reflex,
    "trajectory": TrajectoryBlock,
    "vibration": VibrationBlock,
    "frequencies": FrequencyBlock,
}


def _place(loc: tuple[int | str, ...], data: dict[str, Any]) -> tuple[str, type[Block]]:
    """Write pydantic's location as a person would, and find the block it lies in."""
    words: list[str] = []
    model: type[Block] = Problem
    for step in loc:
        if isinstance(step, int):
            if words[-1] in ("task", "along"):
                words[-1] += f" {step + 1}"
            else:
                words.append(f"item {step + 1}")
        elif step in _TASKS and words and words[-1].startswith(("task ", "along ")):
            model = _TASKS[step]
            words[-1] += f" ({step})"
        elif step in _BACKS and words[-1:] == ["backrest"]:
            model = _BACKS[step]
        elif step.startswith(("literal[", "tuple[", "function-", "dict[", "float", "int")):
            continue
        elif words == ["lever"]:
            words.append(step)
            model = Lever
        else:
            words.append(step)
            model = _BLOCKS.get(step, model) if step != loc[-1] else model
    return ".".join(words), model
