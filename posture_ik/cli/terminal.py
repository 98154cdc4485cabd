"""What every command shares: the application, its options, and how it tells and ends."""

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

from posture_ik.errors import PostureIKError
from posture_ik.files import whole_folder
from posture_ik.results import Tell

app = typer.Typer(
    help="The posture a seated person takes, and what it bears, from one problem file.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
out = Console()
_err = Console(stderr=True)

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


@contextmanager
def written(output: Path | None) -> Iterator[Path | None]:
    """A folder to fill where one is asked for."""
    if output is None:
        yield None
    else:
        with whole_folder(output) as scratch:
            yield scratch


@contextmanager
def telling(quiet: bool) -> Iterator[Tell]:
    """Tell on the terminal what is going on, while it goes on."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    hidden = quiet or not _err.is_terminal
    with Progress(*columns, console=_err, transient=True, disable=hidden) as progress:
        step = progress.add_task("reading the problem", total=None)
        yield lambda words: progress.update(step, description=words)


def print_records(records: list[Any]) -> None:
    """Print a list of objects for machines."""
    print(json.dumps(records))


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
