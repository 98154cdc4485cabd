"""Write files and folders whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from posture_ik.errors import UnwritableOutput


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
