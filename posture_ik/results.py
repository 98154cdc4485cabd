"""What a problem asks for, stage by stage: found, written and shown together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import RenderableType

from posture_ik.body import Body
from posture_ik.exchange import (
    write_activation,
    write_motion,
    write_posture,
    write_trajectory,
    write_vibration,
)
from posture_ik.muscle import Activity, reach, solve_activation
from posture_ik.posture import Motion, Posture, Trajectory, move
from posture_ik.problem import Problem
from posture_ik.show import (
    write_activation_report,
    write_motion_report,
    write_report,
    write_vibration_report,
    write_view,
)
from posture_ik.show.muscle_summary import activation_summary
from posture_ik.show.summary import motion_summary, summary, trajectory_summary
from posture_ik.show.vibration_summary import vibration_summary
from posture_ik.vibration import Vibration, vibrate

#: Told what is going on.
Tell = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Results:
    """A posture, and of the other stages those that its problem asks for."""

    posture: Posture
    moving: Motion | Trajectory | None = None
    activity: Activity | None = None
    vibration: Vibration | None = None

    @classmethod
    def of(cls, posture: Posture, tell: Tell) -> Results:
        """Find all that the posture's problem asks for beside it.

        Raises:
            PostureIKError: a stage cannot be done.
        """
        problem, body = posture.problem, posture.body
        moving: Motion | Trajectory | None = None
        if problem.motion is not None:
            moving = moved(body, problem, tell)
        elif problem.trajectory is not None:
            moving = reached(body, problem, tell)
        activity = vibration = None
        if problem.activation is not None and problem.trajectory is None:  # a reach tells its own
            tell("activating the muscles")
            shown = moving if isinstance(moving, Motion) else posture
            activity = solve_activation(body, shown, problem)
        if problem.vibration is not None:
            tell("vibrating")
            vibration = vibrate(body, posture, problem, None if moving else activity)
        return cls(posture, moving, activity, vibration)

    def write(self, folder: Path) -> None:
        """Write the numbers of all stages into an existing folder."""
        write_posture(self.posture, folder)
        match self.moving:
            case Motion():
                write_motion(self.moving, folder)
            case Trajectory():
                write_trajectory(self.moving, folder)
        if self.activity is not None:
            write_activation(self.activity, folder)
        if self.vibration is not None:
            write_vibration(self.vibration, folder)

    def draw(self, folder: Path) -> None:
        """Write the pages: each stage has a report of its own, all share the 3D page."""
        write_report(self.posture, folder / "report.html")
        if self.moving is not None:
            write_motion_report(self.moving, folder / self._report_of_motion)
        if self.activity is not None:
            write_activation_report(self.activity, folder / "activation.html")
        if self.vibration is not None:
            write_vibration_report(self.vibration, folder / "vibration.html")
        write_view(self.shown, folder / "view.html", self.activity, self.modes)

    @property
    def shown(self) -> Posture | Motion | Trajectory:
        """What the 3D page plays."""
        return self.moving or self.posture

    @property
    def modes(self) -> Vibration | None:
        """Whose modes the 3D page plays: of a posture, where nothing else moves."""
        return None if self.moving else self.vibration

    @property
    def pages(self) -> list[str]:
        """Names of the files that `draw` writes."""
        names = ["report.html", *([self._report_of_motion] if self.moving else [])]
        names += ["activation.html"] if self.activity else []
        return [*names, *(["vibration.html"] if self.vibration else []), "view.html"]

    @property
    def _report_of_motion(self) -> str:
        return "motion.html" if isinstance(self.moving, Motion) else "trajectory.html"

    def summaries(self) -> Iterator[RenderableType]:
        """What each stage comes to, for the terminal."""
        yield summary(self.posture)
        match self.moving:
            case Motion():
                yield motion_summary(self.moving)
            case Trajectory():
                yield trajectory_summary(self.moving)
        if self.activity is not None:
            yield activation_summary(self.activity)
        if self.vibration is not None:
            yield vibration_summary(self.vibration)


def moved(body: Body, problem: Problem, tell: Tell) -> Motion:
    """Follow a problem's signals, telling how far it is."""
    tell("moving")
    return move(body, problem, lambda done, of: tell(f"moving: {done} of {of} steps"))


def reached(body: Body, problem: Problem, tell: Tell) -> Trajectory:
    """Reach a problem's tasks, telling how far it is."""
    tell("reaching")

    def on_mesh(mesh: int, intervals: int) -> None:
        tell(f"reaching: mesh {mesh}, {intervals} intervals")

    return reach(body, problem, on_mesh=on_mesh)
