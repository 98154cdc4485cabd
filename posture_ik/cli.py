"""The command line: `posture-ik`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from posture_ik.body import Body, build_body
from posture_ik.errors import BadProblem, PostureIKError
from posture_ik.exchange import (
    DECKS,
    read_posture,
    write_activation,
    write_mbdyn,
    write_motion,
    write_nastran,
    write_posture,
    write_trajectory,
    write_urdf,
)
from posture_ik.files import whole_folder
from posture_ik.muscle import Activity, reach, solve_activation
from posture_ik.posture import Motion, Posture, Trajectory, solve_posture
from posture_ik.posture import move as solve_motion
from posture_ik.problem import Problem, example_problems, load_problem
from posture_ik.show import view as serve
from posture_ik.show import (
    write_activation_report,
    write_motion_report,
    write_report,
    write_view,
)
from posture_ik.show.muscle_summary import activation_record, activation_summary
from posture_ik.show.summary import (
    as_record,
    motion_record,
    motion_summary,
    summary,
    trajectory_record,
    trajectory_summary,
)

app = typer.Typer(
    help="The posture a seated person takes, from one problem file.",
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
_FORMATS = {"urdf": ("model.urdf",), "mbdyn": ("posture.mbd",), **DECKS}
Json = Annotated[bool, typer.Option("--json", help="Print for machines.")]


@app.command()
def run(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a problem and write results, report and 3D page to a folder."""
    folder = output or Path("out") / Path(problem).stem
    with _progress(quiet=as_json) as progress:
        step = progress.add_task("reading the problem")
        with whole_folder(folder) as scratch:
            body, stated = _read(problem, set_)
            progress.update(step, description="solving the posture")
            posture = solve_posture(body, stated)
            if stated.motion or stated.trajectory:
                progress.update(step, description="moving")
            moving = _moving(body, stated, quiet=True)
            if stated.activation and not stated.trajectory:
                progress.update(step, description="activating the muscles")
            activity = _activity(posture, moving)
            progress.update(step, description="writing the results")
            write_posture(posture, scratch)
            _write_moving(moving, scratch)
            if activity is not None:
                write_activation(activity, scratch)
            progress.update(step, description="drawing report and 3D page")
            _draw(posture, moving, activity, scratch)
    _tell(posture, as_json)
    if not as_json:
        if moving is not None:
            _tell_moving(moving, as_json)
        if activity is not None:
            _out.print(activation_summary(activity))
        _out.print(f"Open {_pages(folder, moving, activity)}.")


@app.command()
def solve(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a posture and print what it carries; write its numbers where -o says."""
    if output is None:
        posture = _solve(problem, set_)
    else:
        with whole_folder(output) as scratch:
            posture = _solve(problem, set_)
            write_posture(posture, scratch)
    _tell(posture, as_json)


@app.command()
def move(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Move through a problem's signals: rates, torques, reactions; write them where -o says."""
    if output is None:
        motion = _move(*_read(problem, set_), quiet=as_json)
    else:
        with whole_folder(output) as scratch:
            motion = _move(*_read(problem, set_), quiet=as_json)
            _write_moving(motion, scratch)
    _tell_moving(motion, as_json)


@app.command()
def activate(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Find the muscle activations that hold a posture or drive a motion; write them with -o."""
    if output is None:
        activity = _activate(*_read(problem, set_), quiet=as_json)
    else:
        with whole_folder(output) as scratch:
            activity = _activate(*_read(problem, set_), quiet=as_json)
            write_activation(activity, scratch)
    if as_json:
        print(json.dumps([activation_record(activity)]))
    else:
        _out.print(activation_summary(activity))


@app.command()
def trajectory(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Reach a problem's tasks with least effort or in least time; write it where -o says."""
    if output is None:
        found = _reach(*_read(problem, set_), quiet=as_json)
    else:
        with whole_folder(output) as scratch:
            found = _reach(*_read(problem, set_), quiet=as_json)
            _write_moving(found, scratch)
    _tell_moving(found, as_json)


@app.command()
def view(directory: ResultFolder) -> None:
    """Serve the 3D page of a result live through meshcat until Ctrl-C."""
    posture = read_posture(directory)
    moving = _moving(posture.body, posture.problem, quiet=False)
    serve(moving or posture, activity=_activity(posture, moving))


@app.command()
def report(directory: ResultFolder) -> None:
    """Write report and 3D page of a result anew."""
    posture = read_posture(directory)
    moving = _moving(posture.body, posture.problem, quiet=False)
    activity = _activity(posture, moving)
    with whole_folder(directory) as scratch:
        _draw(posture, moving, activity, scratch)
    _out.print(f"Wrote {_pages(directory, moving, activity)}.")


@app.command()
def export(
    problem: ProblemName,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            help="Format: urdf (the body), mbdyn (its posture), nastran or nastran95 (its "
            "finite-element spine).",
        ),
    ],
    output: Output = None,
    set_: Overrides = None,
) -> None:
    """Write a problem's body, posture or finite-element spine for other programs."""
    if to not in _FORMATS:
        raise BadProblem(f"--to {to}", f"no such format; valid are {', '.join(_FORMATS)}")
    folder = output or Path("out") / Path(problem).stem
    with whole_folder(folder) as scratch:
        body, stated = _read(problem, set_)
        if to == "mbdyn":
            write_mbdyn(solve_posture(body, stated), scratch)
        elif to in DECKS:
            write_nastran(stated, scratch, to)
        else:
            write_urdf(body, scratch / "model.urdf")
    _out.print(f"Wrote {' and '.join(str(folder / name) for name in _FORMATS[to])}.")


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


def _solve(problem: str, overrides: list[str] | None) -> Posture:
    return solve_posture(*_read(problem, overrides))


def _move(body: Body, problem: Problem, quiet: bool) -> Motion:
    with _progress(quiet) as progress:
        step = progress.add_task("moving", total=None)
        return solve_motion(
            body,
            problem,
            lambda done, of: progress.update(step, description=f"moving: {done} of {of} steps"),
        )


def _reach(body: Body, problem: Problem, quiet: bool) -> Trajectory:
    with _progress(quiet) as progress:
        step = progress.add_task("reaching", total=None)

        def tell(mesh: int, intervals: int) -> None:
            progress.update(step, description=f"reaching: mesh {mesh}, {intervals} intervals")

        return reach(body, problem, on_mesh=tell)


def _moving(body: Body, problem: Problem, quiet: bool) -> Motion | Trajectory | None:
    """What a problem asks for beside its posture, if anything."""
    if problem.motion is not None:
        return _move(body, problem, quiet)
    return None if problem.trajectory is None else _reach(body, problem, quiet)


def _activate(body: Body, problem: Problem, quiet: bool) -> Activity:
    """What the muscles do in a problem's motion, or else in its posture."""
    shown = _move(body, problem, quiet) if problem.motion else solve_posture(body, problem)
    with _progress(quiet) as progress:
        progress.add_task("activating the muscles", total=None)
        return solve_activation(body, shown, problem)


def _activity(posture: Posture, moving: Motion | Trajectory | None) -> Activity | None:
    """What the muscles do, if a problem asks for it."""
    problem = posture.problem
    if problem.activation is None or problem.trajectory is not None:
        return None  # a reach tells its own
    shown = moving if isinstance(moving, Motion) else posture
    return solve_activation(posture.body, shown, problem)


def _write_moving(moving: Motion | Trajectory | None, folder: Path) -> None:
    match moving:
        case Motion():
            write_motion(moving, folder)
        case Trajectory():
            write_trajectory(moving, folder)


def _draw(
    posture: Posture,
    moving: Motion | Trajectory | None,
    activity: Activity | None,
    folder: Path,
) -> None:
    """Write the pages: what moves and the muscles have reports of their own; the 3D page plays."""
    write_report(posture, folder / "report.html")
    if moving is not None:
        write_motion_report(moving, folder / _report_of(moving))
    if activity is not None:
        write_activation_report(activity, folder / "activation.html")
    write_view(moving or posture, folder / "view.html", activity)


def _report_of(moving: Motion | Trajectory) -> str:
    return "motion.html" if isinstance(moving, Motion) else "trajectory.html"


def _pages(folder: Path, moving: Motion | Trajectory | None, activity: Activity | None) -> str:
    names = ["report.html", *([_report_of(moving)] if moving else [])]
    names += [*(["activation.html"] if activity else []), "view.html"]
    return ", ".join(f"[bold]{folder / name}[/]" for name in names)


def _tell(posture: Posture, as_json: bool) -> None:
    if as_json:
        print(json.dumps([as_record(posture)]))
    else:
        _out.print(summary(posture))


def _tell_moving(moving: Motion | Trajectory, as_json: bool) -> None:
    if as_json:
        of = motion_record(moving) if isinstance(moving, Motion) else trajectory_record(moving)
        print(json.dumps([of]))
    elif isinstance(moving, Motion):
        _out.print(motion_summary(moving))
    else:
        _out.print(trajectory_summary(moving))


def _progress(quiet: bool) -> Progress:
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    return Progress(*columns, console=_err, transient=True, disable=quiet or not _err.is_terminal)


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
