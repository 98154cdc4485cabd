"""Every subject and seat of the source's tables 14-25, run and put beside what is published.

The source scales its finite-element model to single subjects; Toward and Griffin measured people.
Tables 15-18 are three subjects on four seats. Tables 24 (measured) and 25 (the source's model) vary
one factor of the mean subject, without a backrest; there a measured row is a group, and a group of
short people is also light. So those rows are run twice: `tabled`, the subject of tables 19-23 with
all else held, for comparison with the source's model, and `typical`, the person typical of such a
group, for comparison with the measurement.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from functools import cache
from math import exp
from typing import Any, Literal, NamedTuple

import numpy as np

from posture_ik.anthropometry import sample_measures
from posture_ik.arrays import Array
from posture_ik.body import build_body
from posture_ik.body.scaling_thesis import chapter_5
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, Subject, load_problem
from posture_ik.vibration import build_finite_element, frequency_response
from posture_ik.vibration.seat import DATA
from posture_ik.vibration.vibrate import model_of

QUANTITIES = ("resonance_hz", "peak_kg", "static_kg")
_COLUMNS = ("resonance_Hz", "peak_kg", "static_kg")
#: Virtual people from whom it is learned how weight goes with stature and age, and their seed.
_PEOPLE, _SEED = 20_000, 1


class Numbers(NamedTuple):
    """What is read off an apparent mass; resonance in Hz, peak and static in kg.

    The resonance is the frequency of the largest apparent mass, static is the value at the lowest
    frequency, 0.6 Hz.
    """

    resonance: float
    peak: float
    static: float

    @classmethod
    def of(cls, frequencies: Array, magnitude: Array) -> Numbers:
        """Read them off a curve, both (F,), Hz and kg."""
        at = int(np.argmax(magnitude))
        return cls(float(frequencies[at]), float(magnitude[at]), float(magnitude[0]))

    def errors(self, published: Numbers) -> Array:
        """Differences from what is published, (3,), %."""
        errors: Array = 100.0 * (np.array(self) / np.array(published) - 1.0)
        return errors


class Case(NamedTuple):
    """A row of the tables with the person to run for it.

    Attributes:
        table: its number.
        row: `max`, `mean` or `min`; in tables 24 and 25 the factor's value.
        condition: the seat in tables 15-18, the factor that varies in 24 and 25.
        kind: whether the person is the one of the tables or one typical of the group.
        person: gender, age, weight and stature.
        thesis: the source's model, None where held out.
        measured: Toward and Griffin's, None where held out.
    """

    table: int
    row: str | int
    condition: str
    kind: Literal["tabled", "typical"]
    person: Subject
    thesis: Numbers | None
    measured: Numbers | None

    @property
    def seat(self) -> str:
        """The example problem that describes the seat."""
        return f"toward_{self.condition if self.table < 20 else 'no_backrest'}"


class Result(NamedTuple):
    """A case, the apparent mass (F,) found at some frequencies (F,), kg and Hz, and its numbers."""

    case: Case
    frequencies: Array
    magnitude: Array
    numbers: Numbers

    def record(self) -> dict[str, Any]:
        """The result as it is printed for machines."""
        case = self.case
        return {
            "table": case.table,
            "row": case.row,
            "condition": case.condition,
            "subject": case.kind,
            **_named(self.numbers),
            "thesis": case.thesis and _named(case.thesis),
            "measured": case.measured and _named(case.measured),
        }


def cases() -> Iterator[Case]:
    """All cases, in the order of the tables."""
    with (DATA / "toward_griffin.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    for row in rows:
        number, name, condition = int(row["table"]), row["row"], row["condition"]
        person = Subject.model_validate(
            {
                "gender": row["gender"],
                "age": row["age"],
                "weight": row["weight_kg"],
                "stature": row["stature_m"],
            }
        )
        label = int(name) if name.isdigit() else name
        published = (_published(row, of) for of in ("thesis", "measured"))
        case = Case(number, label, condition, "tabled", person, *published)
        yield case
        if number > 20:
            yield case._replace(kind="typical", person=_typical(person, condition))


def validate(
    overrides: tuple[str, ...] = (), tell: Callable[[int, int], None] = lambda done, of: None
) -> list[Result]:
    """Run all cases.

    Args:
        overrides: on each of the seats' problems, such as `vibration.model=multibody`.
        tell: called with how many are done, of how many.

    Raises:
        PostureIKError: an override is not valid, or a case cannot be solved.
    """
    todo = list(cases())
    seats = {seat: load_problem(seat, overrides) for seat in dict.fromkeys(c.seat for c in todo)}
    curves: dict[tuple[str, Subject], Array] = {}
    results = []
    for done, case in enumerate(todo, 1):
        problem = seats[case.seat]
        frequencies = frequencies_of(problem)
        if (key := (case.seat, case.person)) not in curves:
            curves[key] = apparent_mass_of(problem, case.person)
        numbers = Numbers.of(frequencies, curves[key])
        results.append(Result(case, frequencies, curves[key], numbers))
        tell(done, len(todo))
    return results


def mean_errors(results: list[Result]) -> list[dict[str, Any]]:
    """Mean absolute errors of each table, and of each factor, where anything is published.

    Each row says how far ours are from the measurement, the source's model is from it, and ours
    are from the source's model, (3,), %, or None. Against the measurements of table 24 it is the
    `typical` person who counts, everywhere else the `tabled`.
    """
    rows = []
    for table in dict.fromkeys(result.case.table for result in results):
        of = [result for result in results if result.case.table == table]
        for condition in dict.fromkeys(result.case.condition for result in of):
            kind = "typical" if table == 24 else "tabled"
            here = [r for r in of if r.case.condition == condition and r.case.kind == kind]
            rows.append(
                {
                    "table": table,
                    "condition": condition,
                    "subject": kind,
                    "measured": _mean([(r.numbers, r.case.measured) for r in here]),
                    "thesis_measured": _mean([(r.case.thesis, r.case.measured) for r in here]),
                    "thesis": _mean([(r.numbers, r.case.thesis) for r in here]),
                }
            )
    return rows


def apparent_mass_of(problem: Problem, person: Subject) -> Array:
    """Magnitude (F,), kg, of the vertical apparent mass at the seat of a person on a seat."""
    fields = ("gender", "age", "weight", "stature")
    sits = problem.subject.model_copy(update={name: getattr(person, name) for name in fields})
    problem = problem.model_copy(update={"subject": sits})
    model, seat = problem.vibration.model if problem.vibration else "multibody", problem.seat
    if model == "finite_element":
        backrest, scale = seat.backrest, None
        if sits.scaling == "thesis":
            # The source's own model of that chapter, whose back slides freely.
            scale = chapter_5(sits)
            free = {"tangential_stiffness": 0.0, "tangential_damping": 0.0}
            backrest = backrest and backrest.model_copy(update=free)
        recline = float(np.radians(seat.recline_deg))
        system = build_finite_element(sits, recline, backrest, scale=scale)
    else:
        body = build_body(sits)
        system = model_of(model, body, solve_posture(body, problem), problem)
    response = frequency_response(
        system.of(["seat z"], ["seat force z"]), frequencies_of(problem), "modal"
    )
    return np.asarray(np.abs(response["apparent_mass"].values[:, 0, 0]))


def frequencies_of(problem: Problem) -> Array:
    """The frequencies (F,), Hz, at which a problem asks for the response."""
    if problem.vibration is None:
        raise TypeError("the problem has no [vibration]")
    return problem.vibration.frequencies.values


def _typical(person: Subject, factor: str) -> Subject:
    """The person typical of a group that one factor picks, whose other numbers go with it.

    The mean subject stands for Toward and Griffin's people, half of them women. What changes with
    the factor is learned of as mixed a sample of ANSUR II's: its soldiers are heavier, but among
    them, too, the tall are heavy and the women short.
    """
    mean = load_problem("toward_no_backrest").subject
    weight, stature = person.weight, person.stature
    if factor == "BMI":
        stature = mean.stature * (person.body_mass_index / mean.body_mass_index) ** _goes_with(
            "stature", "bmi"
        )
        weight = person.body_mass_index * stature**2
    elif factor == "weight":
        stature = mean.stature * (weight / mean.weight) ** _goes_with("stature", "weight")
    elif factor == "stature":
        weight = mean.weight * (stature / mean.stature) ** _goes_with("weight", "stature")
    elif factor == "age":
        older = person.age - mean.age
        stature = mean.stature * exp(_goes_with("stature", "age") * older)
        weight = mean.weight * exp(_goes_with("weight", "age") * older)
    else:
        people, middle = _sample(person.gender), _mixed()
        stature = mean.stature * _mean_ratio(people["stature"], middle["stature"])
        weight = mean.weight * _mean_ratio(people["weight"], middle["weight"])
    return person.model_copy(update={"stature": stature, "weight": weight})


@cache
def _sample(gender: Literal["male", "female"]) -> dict[str, Array]:
    people = sample_measures(gender, _PEOPLE, np.random.default_rng(_SEED))
    return people | {"bmi": people["weight"] / people["stature"] ** 2}


def _mixed() -> dict[str, Array]:
    """As many men as women."""
    men, women = _sample("male"), _sample("female")
    return {name: np.concatenate([men[name], women[name]]) for name in men}


@cache
def _goes_with(what: str, by: str) -> float:
    """Slope of the logarithm of what is asked over that of another number, or over years of age."""
    people = _mixed()
    x = people[by] if by == "age" else np.log(people[by])
    return float(np.polyfit(x, np.log(people[what]), 1)[0])


def _mean_ratio(some: Array, of: Array) -> float:
    return exp(float(np.mean(np.log(some)) - np.mean(np.log(of))))


def _published(row: dict[str, str], of: str) -> Numbers | None:
    values = [row[f"{of}_{column}"] for column in _COLUMNS]
    return Numbers(*map(float, values)) if all(values) else None


def _named(numbers: Numbers) -> dict[str, float]:
    return dict(zip(QUANTITIES, numbers, strict=True))


def _mean(pairs: list[tuple[Numbers | None, Numbers | None]]) -> Array | None:
    errors = [np.abs(ours.errors(theirs)) for ours, theirs in pairs if ours and theirs]
    return np.mean(errors, axis=0) if errors else None
