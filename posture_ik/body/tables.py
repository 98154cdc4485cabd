"""The tables behind the rooms: CSV files of a `data/`, each with its source and its units."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

_DATA = Path(__file__).resolve().parent / "data"


@cache
def table(name: str) -> dict[str, dict[str, str]]:
    """One of the body's tables, by name."""
    return read_table(_DATA / f"{name}.csv")


@cache
def read_table(path: Path) -> dict[str, dict[str, str]]:
    """A table's rows, each column name to text, by the row's first column, in the file's order."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {next(iter(row.values())): row for row in rows}


def numbers(row: dict[str, str], *columns: str) -> tuple[float, ...]:
    """Some columns of a row as numbers."""
    return tuple(float(row[column]) for column in columns)
