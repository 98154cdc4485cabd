"""Every error a user can meet: one sentence that says where, what, and what would be valid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple


class PostureIKError(Exception):
    """Root of all errors of this package; its text is one sentence fit for a user."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Say which valid name lies nearest to `name`, or list what is valid."""
    valid = list(valid)
    close = get_close_matches(name, valid, n=1, cutoff=0.5)
    if close:
        return f"did you mean {close[0]!r}?"
    shown = ", ".join(valid[:12]) + (", ..." if len(valid) > 12 else "")
    return f"valid are {shown}."


class BadProblem(PostureIKError):
    """A problem file, or a value set on the command line, that cannot be read as a problem."""

    def __init__(self, where: str, why: str) -> None:
        super().__init__(f"{where}: {why}")


class BadURDF(PostureIKError):
    """A URDF that is not a seated person of this package's naming."""

    def __init__(self, path: Path | str, why: str) -> None:
        super().__init__(f"{path}: {why}")


class UnsupportedJoint(PostureIKError):
    """A joint type that the kinematics twin does not know."""

    def __init__(self, joint: str, kind: str, supported: Sequence[str]) -> None:
        super().__init__(
            f"joint {joint!r} is a {kind}, which the kinematics twin does not know; "
            f"it knows {', '.join(supported)}."
        )


class BadResult(PostureIKError):
    """A result folder or file that cannot be read back."""

    def __init__(self, path: Path | str, why: str) -> None:
        super().__init__(f"{path}: {why}")


class UnwritableOutput(PostureIKError):
    """A place where results cannot be written."""

    def __init__(self, path: Path | str, why: str) -> None:
        super().__init__(f"{path}: cannot write here ({why}); give a folder you may write to.")


class Miss(NamedTuple):
    """By how much the nearest attempt misses a task, in its worst row: `unit` is "m" or "deg"."""

    task: str
    row: str
    size: float
    unit: str

    def __str__(self) -> str:
        size = f"{self.size * 1000:.1f} mm" if self.unit == "m" else f"{self.size:.2f} deg"
        return f"{self.task} {self.row} misses its target by {size}"


class InfeasiblePosture(PostureIKError):
    """No posture within the joint ranges meets every task.

    Attributes:
        misses: the tasks that the nearest attempt misses, the worst first.
        limits: the joint limits in the way, hardest pressed first.
    """

    def __init__(self, misses: Sequence[Miss], limits: Sequence[str]) -> None:
        self.misses, self.limits = tuple(misses), tuple(limits)
        names = " and ".join(f"{miss.task!r}" for miss in misses)
        which = (
            f"the task {names} cannot be met"
            if len(misses) == 1
            else f"the tasks {names} cannot be met together"
        )
        missed = ", ".join(str(miss) for miss in misses)
        shown = ", ".join(limits[:6]) + (f" and {len(limits) - 6} more" if len(limits) > 6 else "")
        way = f"; in the way: {shown}" if limits else ""
        super().__init__(
            f"{which}: at best {missed}{way}; "
            "move a target, free one of its components, or widen those limits."
        )


class PostureNotFound(PostureIKError):
    """The solver stopped without a posture that can be trusted."""

    def __init__(self, why: str) -> None:
        super().__init__(f"no trustworthy posture was found: {why}.")


class MotionStopped(PostureIKError):
    """A motion whose posture cannot be found at some instant."""

    def __init__(self, time: float, cause: PostureIKError) -> None:
        super().__init__(f"at {time:.4g} s {cause}")
