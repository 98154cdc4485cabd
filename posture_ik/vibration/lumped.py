"""Lumped models of a seated person: masses that move in z, on springs and dampers.

The six of the source's table 7 ship as TOML files; a user writes others in the same form:

    title = "Two masses"
    head = "head"                       # the mass whose motion counts as the head's
    [masses]                            # kg
    trunk = 50.0
    head = 5.0
    [[link]]                            # as many as wanted; what carries the person is "seat"
    between = ["trunk", "seat"]
    stiffness = 50e3                    # N/m
    damping = 1500.0                    # N s/m
    [[link]]
    between = ["head", "trunk"]
    stiffness = 200e3
    damping = 300.0
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, ValidationError, model_validator

from posture_ik.arrays import Array
from posture_ik.errors import BadProblem, nearest
from posture_ik.files import read_toml
from posture_ik.problem import Cushion
from posture_ik.problem.block import Block
from posture_ik.vibration.network import (
    Mass,
    Spring,
    acceleration,
    assemble,
    drive,
    exerted,
    force,
    motion_ports,
)
from posture_ik.vibration.seat import DATA
from posture_ik.vibration.system import LinearSystem

#: What carries the person, as links name it.
SEAT = "seat"
_UNDER = "floor", "cushion"


class Link(Block):
    """A spring (N/m) and a damper (N s/m) between two masses, or a mass and the seat."""

    between: tuple[str, str]
    stiffness: float = Field(ge=0.0)
    damping: float = Field(0.0, ge=0.0)


class LumpedModel(Block):
    """Masses (kg) by name, the links between them, and which of them is the head."""

    title: str
    source: str = ""
    head: str
    masses: dict[str, Annotated[float, Field(gt=0.0)]] = Field(min_length=1)
    link: tuple[Link, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _names_exist(self) -> LumpedModel:
        for name in (SEAT, *_UNDER):
            if name in self.masses:
                raise ValueError(
                    f"masses.{name}: {name!r} is the name of what carries the person; "
                    "give the mass another"
                )
        if self.head not in self.masses:
            raise ValueError(
                f"head = {self.head!r} is none of the masses; {nearest(self.head, self.masses)}"
            )
        for i, link in enumerate(self.link, 1):
            for end in link.between:
                if end != SEAT and end not in self.masses:
                    raise ValueError(
                        f"link {i}.between: {end!r} is neither a mass nor {SEAT!r}; "
                        f"{nearest(end, (*self.masses, SEAT))}"
                    )
            if link.between[0] == link.between[1]:
                raise ValueError(
                    f"link {i}.between joins {link.between[0]!r} to itself; name two ends"
                )
        return self

    @model_validator(mode="after")
    def _all_stand_on_the_seat(self) -> LumpedModel:
        standing, grown = {SEAT}, True
        while grown:
            more = {
                end
                for link in self.link
                if link.stiffness > 0.0 and standing & set(link.between)
                for end in link.between
            }
            grown = not more <= standing
            standing |= more
        for name in self.masses:
            if name not in standing:
                raise ValueError(
                    f"masses.{name} does not stand on the seat; link it to {SEAT!r}, or to a mass "
                    "that stands on it, by a stiffness greater than 0"
                )
        return self


def lumped_models() -> dict[str, Path]:
    """The lumped models that ship with the package, by name (table 7)."""
    return {path.stem: path for path in sorted((DATA / "lumped").glob("*.toml"))}


def load_lumped(name: str | Path) -> LumpedModel:
    """Read a lumped model.

    Args:
        name: path of a TOML file, or a shipped model such as `boileau_rakheja`.

    Raises:
        BadProblem: one sentence with the place, the value, and what would be valid.
    """
    known, path = lumped_models(), Path(name)
    if path.suffix != ".toml":
        if str(name) not in known:
            raise BadProblem(
                str(name), f"no lumped model has this name; {nearest(str(name), known)}"
            )
        path = known[str(name)]
    try:
        return LumpedModel.model_validate(read_toml(path))
    except ValidationError as error:
        raise BadProblem(path.name, _one_sentence(error)) from None


def _one_sentence(error: ValidationError) -> str:
    """Turn pydantic's first complaint into a sentence with place, value and what is valid."""
    first = error.errors()[0]
    steps: list[str] = []
    for step in first["loc"]:
        if not isinstance(step, int):
            steps.append(step)
        elif steps == ["link"]:
            steps = [f"link {step + 1}"]
        else:
            steps.append(f"item {step + 1}")
    place = ".".join(steps)
    message = first["msg"].removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    if first["type"] == "missing":
        whole = "a link has between, two names, and stiffness"
        if not steps[0].startswith("link "):
            whole = "a lumped model has title, head, [masses] and [[link]]"
        return f"{place} is missing; {whole}"
    if first["type"] == "extra_forbidden":
        fields = Link.model_fields if steps[0].startswith("link") else LumpedModel.model_fields
        return f"{place} is not a known key; {nearest(steps[-1], fields)}"
    if not place:
        return message
    return f"{place} = {first['input']!r}: {message}"


def build_lumped(model: LumpedModel, cushion: Cushion | None = None) -> LinearSystem:
    """The linear system of a lumped model.

    Args:
        model: masses and links.
        cushion: the seat and cushion of table 5 under it, if wanted.

    Returns:
        Coordinates are the masses' heights over the input's, `m1 z`, and with a cushion `seat z`
        and `cushion z`. The input is `seat z`, or `floor z` with a cushion. Outputs are
        accelerations of the head (`Head acceleration z`) and of every coordinate, and what acts on
        the person from below (`seat force z`) and on the seat from the floor (`floor force z`).
    """
    layers = ("seat", "cushion") if cushion else ()
    names = (*model.masses, *layers)
    own = np.eye(len(names) + 1)[:, None]
    row = {name: own[i] + own[-1] for i, name in enumerate(names)}
    below = [own[-1], *(row[layer] for layer in layers)]
    masses = [Mass(row[name], np.array([[mass]])) for name, mass in model.masses.items()]
    springs = []
    parts = (cushion.seat, cushion.cushion) if cushion else ()
    for on, layer, values in zip(below, layers, parts, strict=False):
        masses.append(Mass(row[layer], np.array([[values.mass]])))
        springs.append(_spring(row[layer] - on, values.stiffness, values.damping))
    held = np.zeros((3, 1, len(names) + 1))
    for link in model.link:
        upper, lower = sorted(link.between, key=SEAT.__eq__)
        on = below[-1] if lower == SEAT else row[lower]
        spring = _spring(row[upper] - on, link.stiffness, link.damping)
        springs.append(spring)
        if lower == SEAT:
            held += exerted(spring, np.ones((1, 1)))
    matrices = assemble(masses, springs)
    readouts = [
        acceleration("Head", "z", row[model.head]),
        *(acceleration(name, "z", row[name]) for name in names),
        force("seat", "z", held),
    ]
    if cushion:
        readouts.append(force("floor", "z", matrices[:, -1:]))
    ground = "floor" if cushion else "seat"
    return drive([f"{name} z" for name in names], motion_ports(ground, "z"), matrices, readouts)


def _spring(stretch: Array, stiffness: float, damping: float) -> Spring:
    return Spring(stretch, np.array([stiffness]), np.array([damping]))
