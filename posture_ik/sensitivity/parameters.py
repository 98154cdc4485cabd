"""The numbers of a problem that are changed, each alone, and the model with one of them changed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from posture_ik.body import Body, build_body
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import Posture, solve_posture
from posture_ik.problem import Problem, VibrationBlock
from posture_ik.problem.block import Block
from posture_ik.problem.paths import with_numbers
from posture_ik.vibration import Factors, LinearSystem, build_lumped, load_lumped
from posture_ik.vibration.vibrate import model_of

#: Steps: a tenth of a parameter, 5° of an angle, whose zero is nothing special.
_SHARE, _ANGLE = 0.1, 5.0
_UNITS = {
    "age": "years",
    "weight": "kg",
    "recline_deg": "deg",
    "stiffness": "N/m",
    "tangential_stiffness": "N/m",
    "damping": "N s/m",
    "tangential_damping": "N s/m",
    "preload": "N",
    "thigh_on_seat": "1",
    "tension": "1",
}
#: Who sits how, and the muscles that hold it; None of a lumped model, which has none of it.
Seated: TypeAlias = tuple[Body, Posture, Activity | None] | None


class Parameter(NamedTuple):
    """A number that is changed alone.

    Attributes:
        path: as `--set` names it; `factors.` and a name of `Factors`; or `lumped.` and a path in
            the lumped model, such as `lumped.link.1.stiffness`.
        unit: of it.
        value: as it is.
        step: how far a bar of the tornado goes to either side.
    """

    path: str
    unit: str
    value: float
    step: float


def parameters_of(problem: Problem) -> Iterator[Parameter]:
    """What may be changed: every number of who sits and of the seat that counts, and is not 0."""
    asked, seat = problem.vibration or VibrationBlock(), problem.seat
    if asked.model.startswith("lumped:"):
        model = load_lumped(asked.model.removeprefix("lumped:"))
        for mass, value in model.masses.items():
            yield Parameter(f"lumped.masses.{mass}", "kg", value, _SHARE * value)
        for i, link in enumerate(model.link, 1):
            yield from _numbers(f"lumped.link.{i}", link)
    else:
        yield from _numbers("subject", problem.subject)
        yield from _numbers("subject.measured", problem.subject.measured)
        yield Parameter("seat.recline_deg", "deg", seat.recline_deg, _ANGLE)
        if seat.backrest:
            yield from _numbers("seat.backrest", seat.backrest)
    if seat.cushion:
        yield from _numbers("seat.cushion.seat", seat.cushion.seat)
        yield from _numbers("seat.cushion.cushion", seat.cushion.cushion)
    if not asked.model.startswith("lumped:"):
        for name, value in Factors.of(asked.parameters)._asdict().items():
            yield Parameter(f"factors.{name}", "1", value, _SHARE * value)


def _numbers(path: str, block: Block) -> Iterator[Parameter]:
    """The numbers of a block that are not zero, of which a tenth is something."""
    for name in type(block).model_fields:
        value = getattr(block, name)
        if isinstance(value, float) and value:
            unit = _UNITS.get(name, "kg" if name.endswith("mass") else "m")
            yield Parameter(f"{path}.{name}", unit, value, _SHARE * abs(value))


def seated_of(problem: Problem) -> Seated:
    """Who sits how; only the multibody model knows of muscles.

    Raises:
        PostureIKError: there is no such posture.
    """
    asked = problem.vibration or VibrationBlock()
    if asked.model.startswith("lumped:"):
        return None
    body = build_body(problem.subject)
    posture = solve_posture(body, problem)
    activity = None
    if problem.activation and asked.model == "multibody":
        activity = solve_activation(body, posture, problem)
    return body, posture, activity


def changed_model(
    problem: Problem, seated: Seated, path: str = "", value: float = 0.0
) -> LinearSystem:
    """The model with what stands at a parameter's path replaced; as it is if there is no path.

    The posture is found anew where who sits changes, or the seat's angle. Nothing is checked again.

    Raises:
        PostureIKError: there is no such posture or model.
    """
    asked = problem.vibration or VibrationBlock()
    kind, _, name = path.partition(".")
    if path and kind not in ("factors", "lumped"):
        problem = with_numbers(problem, {path: value})
    if seated is None:
        lumped = load_lumped(asked.model.removeprefix("lumped:"))
        part, _, mass = name.partition(".")
        if part == "masses":  # of any name, dots and all
            lumped = lumped.model_copy(update={part: lumped.masses | {mass: value}})
        elif kind == "lumped":
            lumped = with_numbers(lumped, {name: value})
        return build_lumped(lumped, problem.seat.cushion)
    if kind == "subject" or path == "seat.recline_deg":
        seated = seated_of(problem) or seated
    body, posture, activity = seated
    factors = Factors.of(asked.parameters)
    if kind == "factors":
        factors = factors._replace(**{name: value})
    return model_of(asked.model, body, posture, problem, ("Head",), activity, factors)
