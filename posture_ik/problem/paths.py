"""Numbers of a problem by their dotted paths, as `--set` and signals name them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from posture_ik.errors import nearest
from posture_ik.problem.block import Block

AnyBlock = TypeVar("AnyBlock", bound=Block)


def number_at(problem: Block, path: str) -> Any:
    """What stands at a dotted path of a problem.

    A task is named by its kind or its number from 1, a part of a position by x, y or z.

    Raises:
        ValueError: there is nothing of this name; says what there is.
    """
    place: Any = problem
    for name in path.split("."):
        place = _parts(place, path)[_key(place, name, path)]
    return place


def with_numbers(problem: AnyBlock, numbers: Mapping[str, Any]) -> AnyBlock:
    """A copy of a problem with what stands at dotted paths replaced, and nothing checked again.

    Unchecked, so that CasADi symbols can take the place of numbers.
    """

    def replaced(place: Any, names: list[str], path: str, value: Any) -> Any:
        if not names:
            return value
        parts = _parts(place, path)
        key = _key(place, names[0], path)
        part = replaced(parts[key], names[1:], path, value)
        if isinstance(place, Block):
            return place.model_copy(update={str(key): part})
        if isinstance(place, dict):
            return {**place, key: part}
        return tuple(part if other == key else parts[other] for other in parts)

    for path, value in numbers.items():
        problem = replaced(problem, path.split("."), path, value)
    return problem


def _parts(place: Any, path: str) -> dict[str | int, Any]:
    """What a block or a list is made of."""
    if isinstance(place, Block):
        return {name: getattr(place, name) for name in type(place).model_fields}
    if isinstance(place, tuple):
        return dict(enumerate(place))
    if isinstance(place, dict):
        return dict(place)
    raise ValueError(f"{path} goes on below {place!r}, which has no parts")


def _key(place: Any, name: str, path: str) -> str | int:
    """Find a part by the name a person gives it."""
    if isinstance(place, Block):
        names: dict[str, str | int] = {field: field for field in type(place).model_fields}
    elif isinstance(place, dict):
        names = {key: key for key in place}
    elif place and isinstance(place[0], Block):
        names = {str(i): i - 1 for i in range(1, len(place) + 1)}
        for i, block in reversed(list(enumerate(place))):
            names[getattr(block, "kind", str(i + 1))] = i
    else:
        names = {axis: i for i, axis in enumerate("xyz"[: len(place)])}
    if name not in names:
        raise ValueError(f"{path}: there is no {name!r}; {nearest(name, names)}")
    return names[name]
