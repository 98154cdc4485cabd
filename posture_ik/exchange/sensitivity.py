"""A study of sensitivity as a file."""

from __future__ import annotations

import json
from pathlib import Path

from posture_ik.sensitivity import Sensitivity


def write_sensitivity(found: Sensitivity, folder: Path) -> None:
    """Write `sensitivity.json` into an existing folder: each number with its unit."""
    whole = {
        "title": found.problem.title,
        "moved": found.moved,
        "stable": found.stable,
        "largest_miss": found.largest_miss,
        "rows": found.records(),
    }
    text = json.dumps(whole, indent=1, ensure_ascii=False)
    (folder / "sensitivity.json").write_text(text + "\n", encoding="utf-8")
