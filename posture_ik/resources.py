"""Finds the files that ship beside the code: `urdf/`, `problems/` and `viz/`."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def resource(name: str) -> Path:
    """Where a shipped file or folder lies.

    Args:
        name: Path below the repository's root, such as `"problems"` or
            `"urdf/seated_person.urdf"`.

    Returns:
        Its place inside the installed package, where a wheel puts it, else beside the package,
        where a checkout keeps it.

    Raises:
        FileNotFoundError: If neither holds it.
    """
    for root in (_PACKAGE, _PACKAGE.parent):
        if (root / name).exists():
            return root / name
    raise FileNotFoundError(f"the resource {name!r} is neither in {_PACKAGE} nor beside it")
