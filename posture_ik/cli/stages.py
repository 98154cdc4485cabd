"""Commands on one problem: every stage of it, one stage, its pages, its files elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from posture_ik.body import Body, build_body
from posture_ik.cli.terminal import (
    Json,
    Output,
    Overrides,
    ProblemName,
    ResultFolder,
    app,
    out,
    print_records,
    telling,
    written,
)
from posture_ik.errors import BadProblem
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
    write_vibration,
)
from posture_ik.files import whole_folder
from posture_ik.muscle import solve_activation
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, example_problems, load_problem
from posture_ik.results import Results, moved, reached
from posture_ik.show import view as serve
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

#: What to open, by format of `export`.
_FORMATS = {"urdf": ("model.urdf",), "mbdyn": ("posture.mbd",), **DECKS}


@app.command()
def run(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a problem and write results, reports and 3D page to a folder."""
    folder = output or Path("out") / Path(problem).stem
    with telling(quiet=as_json) as tell, whole_folder(folder) as scratch:
        body, stated = _read(problem, set_)
        tell("solving the posture")
        results = Results.of(solve_posture(body, stated), tell)
        tell("writing the results")
        results.write(scratch)
        tell("drawing reports and 3D page")
        results.draw(scratch)
    if as_json:
        print_records([as_record(results.posture)])
        return
    for told in results.summaries():
        out.print(told)
    out.print(f"Open {_listed(folder, results)}.")


@app.command()
def solve(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Solve a posture and print what it carries; write its numbers where -o says."""
    with written(output) as folder:
        posture = solve_posture(*_read(problem, set_))
        if folder:
            write_posture(posture, folder)
    if as_json:
        print_records([as_record(posture)])
    else:
        out.print(summary(posture))


@app.command()
def move(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Move through a problem's signals: rates, torques, reactions; write them where -o says."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        motion = moved(*_read(problem, set_), tell)
        if folder:
            write_motion(motion, folder)
    if as_json:
        print_records([motion_record(motion)])
    else:
        out.print(motion_summary(motion))


@app.command()
def trajectory(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Reach a problem's tasks with least effort or in least time; write it where -o says."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        found = reached(*_read(problem, set_), tell)
        if folder:
            write_trajectory(found, folder)
    if as_json:
        print_records([trajectory_record(found)])
    else:
        out.print(trajectory_summary(found))


@app.command()
def activate(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Find the muscle activations that hold a posture or drive a motion; write them with -o."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        body, stated = _read(problem, set_)
        shown = moved(body, stated, tell) if stated.motion else solve_posture(body, stated)
        tell("activating the muscles")
        activity = solve_activation(body, shown, stated)
        if folder:
            write_activation(activity, folder)
    if as_json:
        print_records([activation_record(activity)])
    else:
        out.print(activation_summary(activity))


@app.command()
def vibrate(
    problem: ProblemName, output: Output = None, set_: Overrides = None, as_json: Json = False
) -> None:
    """Find modes and frequency responses about a posture; write them where -o says."""
    with written(output) as folder, telling(quiet=as_json) as tell:
        body, stated = _read(problem, set_)
        posture = solve_posture(body, stated)
        tell("vibrating")
        vibration = solve_vibration(body, posture, stated)
        if folder:
            write_vibration(vibration, folder)
    if as_json:
        print_records([vibration_record(vibration)])
    else:
        out.print(vibration_summary(vibration))


@app.command()
def view(directory: ResultFolder) -> None:
    """Serve the 3D page of a result live through meshcat until Ctrl-C."""
    with telling(quiet=False) as tell:
        results = Results.of(read_posture(directory), tell)
    serve(results.shown, activity=results.activity, vibration=results.modes)


@app.command()
def report(directory: ResultFolder) -> None:
    """Write reports and 3D page of a result anew."""
    with telling(quiet=False) as tell, whole_folder(directory) as scratch:
        results = Results.of(read_posture(directory), tell)
        tell("drawing reports and 3D page")
        results.draw(scratch)
    out.print(f"Wrote {_listed(directory, results)}.")


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
            solved = stated.vibration is not None and stated.vibration.shape == "solved"
            write_nastran(stated, scratch, to, solve_posture(body, stated) if solved else None)
        else:
            write_urdf(body, scratch / "model.urdf")
    out.print(f"Wrote {' and '.join(str(folder / name) for name in _FORMATS[to])}.")


@app.command()
def problems(as_json: Json = False) -> None:
    """List the example problems."""
    titles = {name: load_problem(path).title for name, path in example_problems().items()}
    if as_json:
        print_records([{"name": name, "title": title} for name, title in titles.items()])
        return
    for name, title in titles.items():
        out.print(f"[bold]{name:<24}[/] {title}", highlight=False)


def _read(problem: str, overrides: list[str] | None) -> tuple[Body, Problem]:
    stated = load_problem(problem, tuple(overrides or ()))
    return build_body(stated.subject), stated


def _listed(folder: Path, results: Results) -> str:
    return ", ".join(f"[bold]{folder / name}[/]" for name in results.pages)
