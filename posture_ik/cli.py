"""The command line: `posture-ik`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from posture_ik.body import Body, build_body
from posture_ik.errors import BadProblem, PostureIKError
from posture_ik.exchange import (
    read_posture,
    write_activation,
    write_identification,
    write_mbdyn,
    write_motion,
    write_posture,
    write_trajectory,
    write_urdf,
    write_vibration,
)
from posture_ik.files import whole_folder
from posture_ik.muscle import solve_activation
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, example_problems, load_problem
from posture_ik.reference import compare as compare_with_source
from posture_ik.results import Results, Tell, moved, reached
from posture_ik.show import view as serve
from posture_ik.show.comparison import comparison, identification, write_comparison
from posture_ik.show.muscle_summary import activation_record, activation_summary
from posture_ik.show.summary import (
    as_record,
    motion_record,
    motion_summary,
    summary,
    trajectory_record,
    trajectory_summary,
)
from posture_ik.show.vibration_summary import vibration_record, vibration_summary
from posture_ik.vibration import vibrate as solve_vibration
from posture_ik.vibration.identify import Parameters
from posture_ik.vibration.identify import identify as search

app = typer.Typer(
    help="The posture a seated person takes, and what it bears, from one problem file.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

ProblemName = Annotated[
    str, typer.Argument(metavar="PROBLEM", help="A TOML file, or the name of an example.")
]
ResultFolder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` wrote.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="DIR", help="Where to write the results.")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value: seat.recline_deg=20"),
]
#: What to open, by format of `export`.
_FORMATS = {"urdf": "model.urdf", "mbdyn": "posture.mbd"}
Json = Annotated[bool, typer.Option("--json", help="Print for machines.")]


@app.command()
def run(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a problem and write results, reports and 3D page to a folder."""
    folder = output or Path("out") / Path(problem).stem
    with _telling(quiet=as_json) as tell, whole_folder(folder) as scratch:
        body, stated = _read(problem, set_)
        tell("solving the posture")
        results = Results.of(solve_posture(body, stated), tell)
        tell("writing the results")
        results.write(scratch)
        tell("drawing reports and 3D page")
        results.draw(scratch)
    if as_json:
        _print(as_record(results.posture))
        return
    for told in results.summaries():
        _out.print(told)
    _out.print(f"Open {_listed(folder, results)}.")


@app.command()
def solve(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a posture and print what it carries; write its numbers where -o says."""
    with _written(output) as folder:
        posture = solve_posture(*_read(problem, set_))
        if folder:
            write_posture(posture, folder)
    if as_json:
        _print(as_record(posture))
    else:
        _out.print(summary(posture))


@app.command()
def move(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Move through a problem's signals: rates, torques, reactions; write them where -o says."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        motion = moved(*_read(problem, set_), tell)
        if folder:
            write_motion(motion, folder)
    if as_json:
        _print(motion_record(motion))
    else:
        _out.print(motion_summary(motion))


@app.command()
def trajectory(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Reach a problem's tasks with least effort or in least time; write it where -o says."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        found = reached(*_read(problem, set_), tell)
        if folder:
            write_trajectory(found, folder)
    if as_json:
        _print(trajectory_record(found))
    else:
        _out.print(trajectory_summary(found))


@app.command()
def activate(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Find the muscle activations that hold a posture or drive a motion; write them with -o."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        body, stated = _read(problem, set_)
        shown = moved(body, stated, tell) if stated.motion else solve_posture(body, stated)
        tell("activating the muscles")
        activity = solve_activation(body, shown, stated)
        if folder:
            write_activation(activity, folder)
    if as_json:
        _print(activation_record(activity))
    else:
        _out.print(activation_summary(activity))


@app.command()
def vibrate(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Find modes and frequency responses about a posture; write them where -o says."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        body, stated = _read(problem, set_)
        posture = solve_posture(body, stated)
        tell("vibrating")
        vibration = solve_vibration(body, posture, stated)
        if folder:
            write_vibration(vibration, folder)
    if as_json:
        _print(vibration_record(vibration))
    else:
        _out.print(vibration_summary(vibration))


@app.command()
def view(directory: ResultFolder) -> None:
    """Serve the 3D page of a result live through meshcat until Ctrl-C."""
    with _telling(quiet=False) as tell:
        results = Results.of(read_posture(directory), tell)
    serve(results.shown, activity=results.activity, vibration=results.modes)


@app.command()
def report(directory: ResultFolder) -> None:
    """Write reports and 3D page of a result anew."""
    with _telling(quiet=False) as tell, whole_folder(directory) as scratch:
        results = Results.of(read_posture(directory), tell)
        tell("drawing reports and 3D page")
        results.draw(scratch)
    _out.print(f"Wrote {_listed(directory, results)}.")


@app.command()
def export(
    problem: ProblemName,
    to: Annotated[
        str, typer.Option("--to", help="Format: urdf (the body) or mbdyn (its posture).")
    ],
    output: Output = None,
    set_: Overrides = None,
) -> None:
    """Write a problem's body, or the posture it takes, for other programs."""
    if to not in _FORMATS:
        raise BadProblem(f"--to {to}", f"no such format; valid are {' and '.join(_FORMATS)}")
    folder = output or Path("out") / Path(problem).stem
    with whole_folder(folder) as scratch:
        body, stated = _read(problem, set_)
        if to == "mbdyn":
            write_mbdyn(solve_posture(body, stated), scratch)
        else:
            write_urdf(body, scratch / "model.urdf")
    _out.print(f"Wrote {folder / _FORMATS[to]}.")


@app.command()
def compare(output: Output = None, as_json: Json = False) -> None:
    """Lay the source's published numbers beside ours; write them as a page where -o says."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        rows = compare_with_source(tell)
        if folder:
            write_comparison(rows, folder / "compare.html")
    if as_json:
        print(json.dumps(rows))
    else:
        _out.print(comparison(rows))


@app.command()
def identify(
    parameters: Annotated[
        Parameters, typer.Argument(help="What to search: source or calibrated.")
    ] = "source",
    output: Output = None,
    as_json: Json = False,
) -> None:
    """Search the values that the source leaves open, or calibrate its model; takes minutes."""
    with _written(output) as folder, _telling(quiet=as_json) as tell:
        found = search(parameters, tell)
        if folder:
            write_identification(found, folder)
    if as_json:
        _print(found)
    else:
        _out.print(identification(found))


@app.command()
def problems(as_json: Json = False) -> None:
    """List the example problems."""
    titles = {name: load_problem(path).title for name, path in example_problems().items()}
    if as_json:
        print(json.dumps([{"name": name, "title": title} for name, title in titles.items()]))
        return
    for name, title in titles.items():
        _out.print(f"[bold]{name:<24}[/] {title}", highlight=False)


_out = Console()
_err = Console(stderr=True)


def _read(problem: str, overrides: list[str] | None) -> tuple[Body, Problem]:
    stated = load_problem(problem, tuple(overrides or ()))
    return build_body(stated.subject), stated


@contextmanager
def _written(output: Path | None) -> Iterator[Path | None]:
    """A folder to fill where one is asked for."""
    if output is None:
        yield None
    else:
        with whole_folder(output) as scratch:
            yield scratch


@contextmanager
def _telling(quiet: bool) -> Iterator[Tell]:
    """Tell on the terminal what is going on, while it goes on."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    hidden = quiet or not _err.is_terminal
    with Progress(*columns, console=_err, transient=True, disable=hidden) as progress:
        step = progress.add_task("reading the problem", total=None)
        yield lambda words: progress.update(step, description=words)


def _listed(folder: Path, results: Results) -> str:
    return ", ".join(f"[bold]{folder / name}[/]" for name in results.pages)


def _print(record: dict[str, object]) -> None:
    print(json.dumps([record]))


# Bad options, arguments and commands alike; typer makes only this child of it public.
_UsageError: Any = typer.BadParameter.__base__


def main() -> None:
    """Run the command line; bad input ends in one sentence on stderr and exit code 2."""
    try:
        code = app(standalone_mode=False)
    except PostureIKError as error:
        print(f"posture-ik: {error}", file=sys.stderr)
        sys.exit(2)
    except _UsageError as error:
        print(f"posture-ik: {error.format_message()}", file=sys.stderr)
        sys.exit(2)
    except (KeyboardInterrupt, typer.Abort):
        sys.exit(130)
    sys.exit(code if isinstance(code, int) else 0)
