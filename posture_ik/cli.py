"""The command line: `posture-ik`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from posture_ik.body import build_body
from posture_ik.errors import BadProblem, PostureIKError
from posture_ik.exchange import read_posture, write_posture, write_urdf
from posture_ik.files import whole_folder
from posture_ik.posture import Posture, solve_posture
from posture_ik.problem import example_problems, load_problem
from posture_ik.show import serve_view, write_report, write_view
from posture_ik.show.summary import as_record, summary

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
            progress.update(step, description="solving the posture")
            posture = _solve(problem, set_)
            progress.update(step, description="writing the results")
            write_posture(posture, scratch)
            progress.update(step, description="drawing the report")
            write_report(posture, scratch / "report.html")
            progress.update(step, description="drawing the 3D page")
            write_view(posture, scratch / "view.html")
    _tell(posture, as_json)
    if not as_json:
        _out.print(f"Open [bold]{folder / 'report.html'}[/] and [bold]{folder / 'view.html'}[/].")


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
def view(directory: ResultFolder) -> None:
    """Serve the 3D page of a result live through meshcat until Ctrl-C."""
    serve_view(read_posture(directory))


@app.command()
def report(directory: ResultFolder) -> None:
    """Write report and 3D page of a result anew."""
    posture = read_posture(directory)
    with whole_folder(directory) as scratch:
        write_report(posture, scratch / "report.html")
        write_view(posture, scratch / "view.html")
    _out.print(f"Wrote {directory / 'report.html'} and {directory / 'view.html'}.")


@app.command()
def export(
    problem: ProblemName,
    to: Annotated[str, typer.Option("--to", help="Format: urdf.")],
    output: Output = None,
    set_: Overrides = None,
) -> None:
    """Write a problem's body for other programs."""
    if to != "urdf":
        raise BadProblem(f"--to {to}", "no such format; valid is urdf")
    subject = load_problem(problem, tuple(set_ or ())).subject
    folder = output or Path("out") / Path(problem).stem
    with whole_folder(folder) as scratch:
        write_urdf(build_body(subject), scratch / "model.urdf")
    _out.print(f"Wrote {folder / 'model.urdf'}.")


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


def _solve(problem: str, overrides: list[str] | None) -> Posture:
    stated = load_problem(problem, tuple(overrides or ()))
    return solve_posture(build_body(stated.subject), stated)


def _tell(posture: Posture, as_json: bool) -> None:
    if as_json:
        print(json.dumps([as_record(posture)]))
    else:
        _out.print(summary(posture))


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
