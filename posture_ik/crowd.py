"""Random people of the whole allowed range, each seated and shaken: who cannot be, and why.

Where `validate` asks whether the numbers are right, this asks whether there are any. Ages, statures
and body mass indices are drawn evenly and apart from each other between the ends that a `Subject`
allows, so that most of the people are ones whom nobody ever met; the first are the corners of the
range.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from itertools import product
from math import ceil
from multiprocessing import get_context
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from posture_ik.arrays import Array, one_thread
from posture_ik.body import build_body
from posture_ik.errors import PostureIKError
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, Subject
from posture_ik.problem.subject import AGES, BODY_MASS_INDICES, STATURES
from posture_ik.vibration import apparent_mass, frequency_response, linearise, transmissibility

#: Where the response is asked for, Hz: coarse, but no resonance hides between.
FREQUENCIES: Array = np.arange(0.5, 20.01, 0.25)
STAGES = ("body", "posture", "linearised", "response")
#: People for whom it is worth starting one more process, and who are handed over at a time.
_SHARE, _HANDFUL = 100, 20
_READ = ("Head x", "Head y", "Head z", "seat force")


class Outcome(NamedTuple):
    """What became of one person.

    Attributes:
        subject: who.
        trouble: why there is no answer, or what is wrong with it; empty where all is well.
        seconds: of each of the `STAGES` that were passed.
        solver: the status with which the posture's solver ended.
        method: by which the response was found.
        resonance: frequency of the largest vertical apparent mass, Hz.
        peak: that largest mass, kg; `static`, the one at the lowest frequency.
        head: largest vertical motion of the head over that of the seat.
    """

    subject: Subject
    trouble: str
    seconds: tuple[float, ...]
    solver: str = ""
    method: str = ""
    resonance: float = np.nan
    peak: float = np.nan
    static: float = np.nan
    head: float = np.nan

    def record(self) -> dict[str, Any]:
        """The outcome as it is printed for machines; what there is not is None."""
        who = self.subject
        numbers = {
            "resonance_hz": self.resonance,
            "peak_kg": self.peak,
            "static_kg": self.static,
            "head_z": self.head,
        }
        return {
            "gender": who.gender,
            "age": who.age,
            "stature_m": who.stature,
            "weight_kg": who.weight,
            "bmi": who.body_mass_index,
            "trouble": self.trouble,
            **{name: float(x) if np.isfinite(x) else None for name, x in numbers.items()},
            "solver": self.solver,
            "method": self.method,
            "seconds": float(sum(self.seconds)),
        }


def random_people(count: int, seed: int, like: Subject | None = None) -> list[Subject]:
    """People anywhere in the allowed range, the corners of it first.

    Args:
        count: how many.
        seed: of the draw.
        like: whom they are like in all but gender, age, weight and stature.
    """
    like, random = like or Subject(), np.random.default_rng(seed)
    ranges = np.array([AGES, STATURES, BODY_MASS_INDICES])
    drawn = random.uniform(ranges[:, 0], ranges[:, 1], (count, 3))
    genders = random.choice(["male", "female"], size=count)
    corners = list(product(("male", "female"), *ranges))[:count]
    for i, (gender, *corner) in enumerate(corners):
        genders[i], drawn[i] = gender, corner
    return [
        like.model_copy(
            update={
                "gender": str(gender),
                "age": float(age),
                "stature": float(stature),
                "weight": float(bmi * stature**2),
            }
        )
        for gender, (age, stature, bmi) in zip(genders, drawn, strict=True)
    ]


def examine(problem: Problem, subject: Subject) -> Outcome:
    """Build a person, seat them as a problem asks and shake the seat."""
    ticks = [perf_counter()]
    try:
        with one_thread():
            return _examined(problem, subject, ticks)
    except PostureIKError as error:
        trouble = str(error)
    except (ArithmeticError, ValueError, RuntimeError) as error:  # found here, not met by a user
        trouble = f"{type(error).__name__}: {error}"
    return Outcome(subject, trouble, tuple(np.diff([*ticks, perf_counter()])))


def _examined(problem: Problem, subject: Subject, ticks: list[float]) -> Outcome:
    body = build_body(subject)
    ticks.append(perf_counter())
    posture = solve_posture(body, problem)
    ticks.append(perf_counter())
    system = linearise(body, posture, problem)
    ticks.append(perf_counter())
    response = frequency_response(system.of(["seat"], _READ), FREQUENCIES)
    mass = apparent_mass(response).sel(force="z", motion="z").values
    head = transmissibility(response).sel({"to": "z", "from": "z"}).values
    ticks.append(perf_counter())
    size = np.abs(mass)
    if not all(np.isfinite(part).all() for part in (posture.q, response["response"].values)):
        trouble = "not a number"
    elif not posture.certificate.holds:
        trouble = "the posture's certificate does not hold"
    elif not system.stable:
        trouble = "unstable"
    else:
        trouble = ""
    return Outcome(
        subject,
        trouble,
        tuple(np.diff(ticks)),
        posture.status,
        response.method,
        float(FREQUENCIES[np.argmax(size)]),
        float(np.max(size)),
        float(size[0]),
        float(np.max(np.abs(head))),
    )


def examine_all(
    problem: Problem,
    people: Sequence[Subject],
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> list[Outcome]:
    """Examine everybody, on as many processors as are worth it, in the order given.

    Args:
        problem: the seat and the tasks; its own subject does not count.
        people: who.
        tell: called with how many are done, of how many.
    """
    processes = min(os.cpu_count() or 1, ceil(len(people) / _SHARE))
    one, outcomes = partial(examine, problem), []
    with ExitStack() as stack:
        found: Iterator[Outcome] = map(one, people)
        if processes > 1:
            # Spawned: a process forked from one with threads may wait for these for ever.
            pool = stack.enter_context(ProcessPoolExecutor(processes, get_context("spawn")))
            found = pool.map(one, people, chunksize=_HANDFUL)
        for outcome in found:
            outcomes.append(outcome)
            tell(len(outcomes), len(people))
    return outcomes
