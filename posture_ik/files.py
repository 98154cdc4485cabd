"""Write files and folders whole or not at all; read TOML with faults in one sentence."""

from __future__ import annotations

import os
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from posture_ik.errors import BadProblem, UnwritableOutput


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        BadProblem: it is missing, cannot be read, or is not TOML in UTF-8.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8"))
    except FileNotFoundError:
        raise BadProblem(str(path), "there is no such file") from None
    except OSError as error:
        raise BadProblem(str(path), f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadProblem(str(path), "is not a text file in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise BadProblem(str(path), f"is not valid TOML: {error}") from None


@contextmanager
def whole_folder(directory: Path) -> Iterator[Path]:
    """Give an empty folder to fill; its files move into `directory` once all are written.

    An error on the way leaves `directory` as it was.

    Raises:
        UnwritableOutput: the folder, or a file in it, cannot be written.
    """
    try:
        place = directory.expanduser().resolve()
        existing = next(folder for folder in (place, *place.parents) if folder.exists())
        with tempfile.TemporaryDirectory(prefix=".posture-ik-", dir=existing) as scratch:
            yield Path(scratch)
            _move_all(Path(scratch), place)
    except OSError as error:
        raise UnwritableOutput(directory, error.strerror or str(error)) from None


def _move_all(source: Path, target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for item in sorted(source.iterdir()):
        if item.is_dir():
            _move_all(item, target / item.name)
        else:
            os.replace(item, target / item.name)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a scratch path to write; it becomes `path` once written."""
    with whole_folder(path.parent) as scratch:
        yield scratch / path.name


def write_whole(path: Path | str, text: str) -> None:
    """Write a text file in UTF-8.

    Raises:
        UnwritableOutput: it cannot be written.
    """
    with whole_file(Path(path)) as scratch:
        scratch.write_text(text, encoding="utf-8")
