"""What is asked, block by block, checked and completed with defaults.

A problem names a subject, a seat, the tasks to hold and how the posture is to be solved. Everything
here is plain data in the units people write (degrees in keys that end in `_deg`, SI elsewhere);
`posture_ik.posture` turns it into equations.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from posture_ik.errors import nearest
from posture_ik.problem.block import Block
from posture_ik.problem.paths import number_at
from posture_ik.problem.stages import ActivationBlock, MotionBlock, PostureBlock, TrajectoryBlock
from posture_ik.problem.tasks import (
    Angle,
    Bodies,
    Hand,
    Position,
    Task,
    Vertebra,
    expand_bodies,
    task_label,
)
from posture_ik.problem.vibration import VibrationBlock


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

    The mean motion of `bodies` (an RBE3 average) is taken 0.1 m behind the vertebra `at`. Along the
    back it is free, or held by a spring (N/m) and a damper (N s/m).
    """

    kind: Literal["rigid"] = "rigid"
    bodies: Bodies = expand_bodies("T1-T10")
    at: Vertebra = "T7"
    tangential_stiffness: float = Field(0.0, ge=0.0)
    tangential_damping: float = Field(0.0, ge=0.0)


class FoamBack(Block):
    """A backrest of foam: a spring (N/m) and a damper (N s/m) behind the mean of `bodies`.

    They act square to the back at a point 0.1 m behind the vertebra `at`, and others along it where
    asked. The values are those of Toward & Griffin's foam.
    """

    kind: Literal["foam"] = "foam"
    bodies: Bodies = expand_bodies("T1-T10")
    at: Vertebra = "T7"
    stiffness: float = Field(21e3, ge=0.0)
    damping: float = Field(109.0, ge=0.0)
    tangential_stiffness: float = Field(0.0, ge=0.0)
    tangential_damping: float = Field(0.0, ge=0.0)


class LawBack(Block):
    """A backrest by the law of eq 44, that only pushes, or eq 45 (`bilateral`), that also pulls.

    For vibration it is the spring that the law is about its `preload`, the force (N) with which
    the back presses on it; the force of the posture's own backrest if not given. `length` (m): of
    the rod that strains. The law has no damping; that beside it (N s/m) is none if not given. All
    else is as of foam.
    """

    kind: Literal["law"] = "law"
    bodies: Bodies = expand_bodies("T1-T10")
    at: Vertebra = "T7"
    preload: float | None = None
    bilateral: bool = False
    length: float = Field(0.1, gt=0.0)
    damping: float = Field(0.0, ge=0.0)
    tangential_stiffness: float = Field(0.0, ge=0.0)
    tangential_damping: float = Field(0.0, ge=0.0)


class Layer(Block):
    """A mass (kg) on a vertical spring (N/m) and damper (N s/m)."""

    mass: float = Field(gt=0.0)
    stiffness: float = Field(gt=0.0)
    damping: float = Field(ge=0.0)


class Cushion(Block):
    """A seat on the floor and a cushion on the seat, under the person (figure 8).

    The values are those of table 5: Choi and Wereley (2005), the cushion's mass assumed.
    """

    seat: Layer = Layer(mass=13.5, stiffness=22600.0, damping=750.0)
    cushion: Layer = Layer(mass=1.0, stiffness=37700.0, damping=159.0)


Back = Annotated[RigidBack | FoamBack | LawBack, Field(discriminator="kind")]


class Seat(Block):
    """Where one sits.

    `recline_deg`: the backrest's angle from the vertical, positive backwards, turned about the
    seat. For vibration alone: `backrest`, what the back meets, nothing if not given; `cushion`,
    what gives way under the person, on a floor that then is what moves.
    """

    recline_deg: float = Field(0.0, ge=-45.0, le=90.0)
    backrest: Back | None = None
    cushion: Cushion | None = None


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
    def _has_a_backrest_to_move(self) -> Problem:
        if self.vibration and self.vibration.input == "backrest" and self.seat.backrest is None:
            raise ValueError(
                'vibration.input = "backrest" needs a backrest to move; give one under [seat], '
                'as backrest = { kind = "foam" }, or take input = "seat"'
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
