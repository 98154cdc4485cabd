"""What a search found, in files: the values, the whole record, and what a reader wants of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

#: Names of the files of a parameter set, and what its values are.
_FILES = {
    "source": (
        "finite_element",
        "values that Cocco 2019 leaves open in the finite-element spine, reference subject; found "
        "by `posture-ik identify source` against its table 6 and section 3.3",
    ),
    "calibrated": (
        "calibrated",
        "factors on the stiffness and damping of Cocco 2019, tables 10 and 11; found by "
        "`posture-ik identify calibrated` against the measurements that it quotes",
    ),
}
#: Differences above which a result is called missed, %.
_FAR = 10
_COLUMN = (
    "That the column of viscera ends free at T10 agrees with table 4, which counts constraints for "
    "seven viscera and for one end of the column only, and with T10V's mass of 0. Its first motion "
    "along z is then the source's sixth mode, an axial one of the viscera; tied at both ends the "
    "column has none so low."
)
_UNITS = {"buttock_x": "m", "buttock_y": "m", "visceral_x": "N/m", "visceral_z": "N/m"}


def write_identification(found: dict[str, Any], folder: Path) -> None:
    """Write what `identify` found into an existing folder.

    `finite_element.csv` or `calibrated.csv`, the values as the models read them; beside it
    `..._record.json`, every start, residual and sensitivity; and `....md`, the same in tables.
    """
    name, what = _FILES[found["parameters"]]
    lines = [f"# {what}", "name,value,unit"]
    lines += [f"{key},{v:g},{_UNITS.get(key, '1')}" for key, v in found["values"].items()]
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    record = json.dumps(found, indent=1, ensure_ascii=False)
    (folder / f"{name}_record.json").write_text(record + "\n", encoding="utf-8")
    (folder / f"{name}.md").write_text(_page(found, name), encoding="utf-8")


def _page(found: dict[str, Any], name: str) -> str:
    parameters = found["parameters"]
    results = [
        (key, f"{r['wanted']:g}", f"{r['found']:.4g}", f"{r['difference_percent']:+.1f} %")
        for key, r in found["results"].items()
    ]
    costs = [
        (reading, f"{runs[0]['cost']:.2f}", len(runs), f"{runs[-1]['cost']:.2f}")
        for reading, runs in sorted(found["searches"].items(), key=lambda item: item[1][0]["cost"])
    ]
    moved = []
    for key, changes in found["sensitivity_percent"].items():
        most = sorted(changes, key=lambda result: -abs(changes[result]))[:3]
        told = ", ".join(f"{result} {changes[result]:+.1f} %" for result in most)
        moved.append((key, f"{found['values'][key]:g}", told))
    parts = [
        f"# Parameter set `{parameters}`: what was sought and found",
        f"Written by `posture-ik identify {parameters}`; every start is in `{name}_record.json`. "
        f"Taken: *{found['chosen']}*.",
        _table(("result", "wanted", "found", "difference"), results),
        _missed(found),
        "## The values, and what each moves most",
        "By 10 % more of it; of a tie of 0, by 100 N/m.",
        _table(("value", "found", "moves"), moved),
        "## Readings",
        "Least cost, of how many starts, and that of the worst of them.",
        _table(("reading", "cost", "starts", "worst start"), costs),
    ]
    if found["backrests"]:
        backrests = [
            (f"{b['stiffness'] / 1e3:g} kN/m", b["bodies"], b["at"], b["peak"], b["frequency_Hz"])
            for b in found["backrests"]
        ]
        parts += [
            _COLUMN,
            "## Readings of the backrest of figure 12",
            "Its spring and damper are the cushion's (§3.1.2) or the foam's (§5.2.1); the "
            "vertebrae of its mean, and the one at which it acts, are not told in §3.",
            _table(("spring", "mean of", "at", "peak", "Hz"), backrests),
        ]
    return "\n\n".join(parts) + "\n"


def _missed(found: dict[str, Any]) -> str:
    """What is met least, in words."""
    names = [
        f"{name} ({result['difference_percent']:+.0f} %)"
        for name, result in found["results"].items()
        if abs(result["difference_percent"]) > _FAR
    ]
    met = f"All else is met within {_FAR} %."
    return f"Not met: {', '.join(names)}. {met}" if names else f"All is met within {_FAR} %."


def _table(head: tuple[str, ...], rows: list[tuple[Any, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(str(cell) for cell in line)} |" for line in lines)
