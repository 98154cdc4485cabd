"""Commands on the models themselves: beside what is published, and what is identified on it."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer

from posture_ik.cli.terminal import (
    Json,
    Output,
    Overrides,
    ProblemName,
    app,
    out,
    print_records,
    telling,
    written,
)
from posture_ik.crowd import examine_all, random_people
from posture_ik.errors import BadProblem
from posture_ik.exchange import write_identification, write_sensitivity
from posture_ik.problem import load_problem
from posture_ik.reference import compare as compare_with_source
from posture_ik.sensitivity import sensitivity as study
from posture_ik.show.comparison import comparison, identification, write_comparison
from posture_ik.show.crowd_report import crowd_summary, write_crowd
from posture_ik.show.sensitivity_report import sensitivity_summary, write_sensitivity_report
from posture_ik.show.validation_report import validation_summary, write_validation_report
from posture_ik.validation import validate as run_validation
from posture_ik.vibration.identify import Parameters
from posture_ik.vibration.identify import identify as search


@app.command()
def compare(output: Output = None, as_json: Json = False) -> None:
    """Lay the source's published numbers beside ours; write them as a page where -o says."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        rows = compare_with_source(tell)
        if folder:
            write_comparison(rows, folder / "compare.html")
    if as_json:
        print_records(rows)
    else:
        out.print(comparison(rows))


@app.command()
def identify(
    parameters: Annotated[
        Parameters, typer.Argument(help="What to search: source or calibrated.")
    ] = "source",
    output: Output = None,
    as_json: Json = False,
) -> None:
    """Search the values that the source leaves open, or calibrate its model; takes minutes."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        found = search(parameters, tell)
        if folder:
            write_identification(found, folder)
    if as_json:
        print_records([found])
    else:
        out.print(identification(found))


@app.command()
def validate(
    against: Annotated[str, typer.Argument(metavar="DATA", help="toward_griffin or people.")],
    output: Output = None,
    set_: Overrides = None,
    count: Annotated[int, typer.Option(min=1, help="How many people.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Of the draw of people.")] = 1,
    as_json: Json = False,
) -> None:
    """Run the published subjects and seats, or random people; with -o write a page of charts."""
    overrides = tuple(set_ or ())
    if against == "toward_griffin":
        _published(overrides, output, as_json)
    elif against == "people":
        _people(count, seed, overrides, output, as_json)
    else:
        raise BadProblem(f"validate {against}", "no such data; valid are toward_griffin and people")


def _published(overrides: tuple[str, ...], output: Path | None, as_json: bool) -> None:
    """Every subject and seat of the source's tables 14-25."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        results = run_validation(
            overrides, lambda done, of: tell(f"validating: {done} of {of} rows")
        )
        if folder:
            write_validation_report(results, folder / "validation.html")
    if as_json:
        print_records([result.record() for result in results])
        return
    for table in validation_summary(results):
        out.print(table)
    if output is not None:
        out.print(f"Open [bold]{output / 'validation.html'}[/].")


def _people(
    count: int, seed: int, overrides: tuple[str, ...], output: Path | None, as_json: bool
) -> None:
    """Random people of the whole allowed range, each on the seat of `reclined_15`."""
    problem = load_problem("reclined_15", overrides)
    people = random_people(count, seed, problem.subject)
    with written(output) as folder, telling(quiet=as_json) as tell:
        start = perf_counter()
        outcomes = examine_all(
            problem, people, lambda done, of: tell(f"seating and shaking: {done} of {of} people")
        )
        wall = perf_counter() - start
        if folder:
            write_crowd(outcomes, wall, folder)
    if as_json:
        print_records([outcome.record() for outcome in outcomes])
        return
    out.print(crowd_summary(outcomes, wall))
    if output is not None:
        out.print(f"Open [bold]{output / 'people.html'}[/].")


@app.command()
def sensitivity(
    problem: ProblemName,
    at: Annotated[
        float | None,
        typer.Option("--at", metavar="HZ", help="Ask the head's motion there, not at its peak."),
    ] = None,
    output: Output = None,
    set_: Overrides = None,
    as_json: Json = False,
) -> None:
    """Tell what resonance and head motion hang on; with -o write tornado charts."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        stated = load_problem(problem, tuple(set_ or ()))
        found = study(stated, at, lambda done, of: tell(f"changing: {done} of {of} parameters"))
        if folder:
            write_sensitivity(found, folder)
            write_sensitivity_report(found, folder / "sensitivity.html")
    if as_json:
        print_records(found.records())
        return
    out.print(sensitivity_summary(found))
    if output is not None:
        out.print(f"Open [bold]{output / 'sensitivity.html'}[/].")
