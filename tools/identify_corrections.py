"""Identifies the corrections of the anthropometric law on the open measurements, and records them.

    python tools/identify_corrections.py

Eight numbers against the 48 of tables 15, 17 (`tabled`) and 24 (`typical`): four of the law, two of
how Toward and Griffin's people sat (`thigh_on_seat`, `tension`), the spring and the damper along
their rigid backrest. A difference counts relative to half the source's own mean error for the same
quantity and table, each table and factor alike, and grows linearly for what is far off (soft l1):
tables 15 and 24 put the mean subject's resonance at 4.6 and 4.9 Hz, and no law meets both. Weak
priors (`PRIOR`) hold what the rows do not tell; a firmer one, that the resonance falls with the
body mass index, as section 5.2.2 has it and the four rows of table 24 alone hardly show.

Writes `corrections.csv`, `corrections_record.json` (residuals, 95 % intervals, error on rows left
out by one Gauss-Newton step each) and `docs/scaling.md`. What is not the law's belongs into the
problem files.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
from scipy.optimize import least_squares

from posture_ik.arrays import Array, one_thread
from posture_ik.body.corrections import Corrections
from posture_ik.body.scaling_anthropometric import anthropometric
from posture_ik.problem import RigidBack, Subject
from posture_ik.validation import QUANTITIES, Case, Numbers, cases
from posture_ik.vibration import LinearSystem, build_finite_element

#: What is sought: where the search starts and the prior's centre, and the prior's deviation.
PRIOR = {
    "share_bmi": (-0.5, 0.5),
    "stiffness_bmi": (-0.4, 0.1),
    "stiffness_per_decade": (0.08, 0.10),
    "damping_bmi": (-0.2, 0.5),
    "thigh_on_seat": (0.9, 0.1),
    "log_tension": (0.1, 0.2),
    "log_tangential_stiffness": (np.log(5e3), 1.0),
    "log_tangential_damping": (np.log(100.0), 1.0),
}
LAW = len(Corrections._fields)
FREQUENCIES = np.array([0.6, *np.arange(3.0, 8.0, 0.05)])
MODES = 40
BODY = Path(__file__).resolve().parents[1] / "posture_ik" / "body" / "data"
DOCS = Path(__file__).resolve().parents[1] / "docs" / "scaling.md"


def open_cases() -> list[Case]:
    """The measured rows, each with the person to compare it with."""
    wanted = {15: "tabled", 17: "tabled", 24: "typical"}
    return [case for case in cases() if case.measured and wanted.get(case.table) == case.kind]


def group(case: Case) -> str:
    """The table, or the factor of table 24, a case belongs to."""
    return f"table {case.table}, {case.condition}" if case.table == 24 else f"table {case.table}"


def half_errors(todo: list[Case]) -> dict[str, Array]:
    """Half the source's own mean error in each group, (3,), %."""
    halves = {}
    for name in dict.fromkeys(map(group, todo)):
        errors = [
            np.abs(case.thesis.errors(case.measured))
            for case in todo
            if group(case) == name and case.thesis and case.measured
        ]
        halves[name] = np.mean(errors, axis=0) / 2
    return halves


def predict(values: Array, case: Case) -> Numbers:
    """The apparent mass's numbers with eight values, in the order of `PRIOR`."""
    corrections = Corrections(*values[:LAW])
    thigh, tension = float(np.clip(values[LAW], 0.0, 1.0)), float(np.exp(values[LAW + 1]))
    sits: Subject = case.person.model_copy(update={"thigh_on_seat": thigh, "tension": tension})
    stiffness, damping = np.exp(values[LAW + 2 :])
    back = RigidBack(tangential_stiffness=stiffness, tangential_damping=damping)
    system = build_finite_element(
        backrest=back if case.seat == "toward_rigid_upright" else None,
        scale=anthropometric(sits, corrections),
    )
    return numbers_of(system)


def numbers_of(system: LinearSystem) -> Numbers:
    """Resonance, peak and static value; the peak between frequencies is that of a parabola."""
    mass = apparent_mass(system)
    at = int(np.argmax(mass[2:-1])) + 2
    before, peak, after = mass[at - 1 : at + 2]
    offset = (before - after) / (before - 2 * peak + after) / 2
    step = FREQUENCIES[2] - FREQUENCIES[1]
    return Numbers(
        FREQUENCIES[at] + step * offset, peak - (before - after) * offset / 4, float(mass[0])
    )


def apparent_mass(system: LinearSystem) -> Array:
    """Magnitude of the vertical apparent mass by the lowest undamped modes, (F,), kg.

    Within 0.1 % of the exact one; ten times as fast.
    """
    seen = system.of(["seat z"], ["seat force z"])
    plane = [i for i, name in enumerate(seen.coordinates) if name.split()[-1] in ("x", "z", "ry")]
    M, C, K = (part[np.ix_(plane, plane)] for part in seen[1:4])
    squares, V = scipy.linalg.eigh(K, M, subset_by_index=[0, MODES - 1])
    s = 2j * np.pi * FREQUENCIES
    powers = s[:, None] ** np.arange(3)
    dynamic = powers[:, 2, None, None] * np.eye(MODES) + np.diag(squares)
    dynamic = dynamic + powers[:, 1, None, None] * (V.T @ C @ V)
    x = np.linalg.solve(dynamic, (powers @ (seen.B[:, plane, 0] @ V))[..., None])[..., 0]
    force = np.sum((powers @ (seen.Y[:, 0, plane] @ V)) * x, axis=1) + powers @ seen.D[:, 0, 0]
    return np.asarray(np.abs(force / s**2))


def main() -> None:
    """Search, and write all that is known about what was found."""
    todo = open_cases()
    halves, names = half_errors(todo), list(PRIOR)
    centre, deviation = np.array(list(PRIOR.values())).T
    groups = [group(case) for case in todo]
    weight = np.array([np.sqrt(4 / groups.count(name)) / halves[name] for name in groups])

    def errors(values: Array) -> Array:
        return np.array([predict(values, case).errors(case.measured) for case in todo])

    def residuals(values: Array) -> Array:
        scaled = (weight * errors(values)).ravel()
        soft = np.sign(scaled) * np.sqrt(2 * (np.sqrt(1 + scaled**2) - 1))
        return np.concatenate([soft, (values - centre) / deviation])

    with one_thread():
        found = least_squares(
            residuals, centre, x_scale=deviation, diff_step=1e-3, max_nfev=8, verbose=2
        )
        final = errors(found.x)
    J, r = found.jac, found.fun
    covariance = np.linalg.inv(J.T @ J) * np.sum(r**2) / (len(r) - len(names))
    half_width = 1.96 * np.sqrt(np.diag(covariance))
    left_out = _left_out(J, r, weight, final)
    record = {
        "values": {
            name: {"value": float(v), "interval_95": [float(v - h), float(v + h)], "prior": prior}
            for (name, prior), v, h in zip(PRIOR.items(), found.x, half_width, strict=True)
        },
        "rows": [
            {
                "table": case.table,
                "row": case.row,
                "condition": case.condition,
                "errors_percent": dict(zip(QUANTITIES, map(float, e), strict=True)),
                "left_out_errors_percent": dict(zip(QUANTITIES, map(float, o), strict=True)),
            }
            for case, e, o in zip(todo, final, left_out, strict=True)
        ],
        "groups": [
            {
                "group": name,
                "mean_error_percent": _mean(final, groups, name),
                "left_out_mean_error_percent": _mean(left_out, groups, name),
                "thesis_mean_error_percent": [float(2 * half) for half in halves[name]],
            }
            for name in halves
        ],
        "evaluations": int(found.nfev),
    }
    text = json.dumps(record, indent=1) + "\n"
    (BODY / "corrections_record.json").write_text(text, encoding="utf-8")
    _write_table(found.x)
    DOCS.write_text(_page(record), encoding="utf-8")
    print(_page(record))


def _left_out(J: Array, r: Array, weight: Array, final: Array) -> Array:
    """Errors (rows, 3), %, of each row where the others alone tell, by one Gauss-Newton step.

    To first order an error moves with its softened residual, whose slope is at most the weight.
    """
    moved = np.array(final)
    for i in range(len(final)):
        own = np.arange(3 * i, 3 * i + 3)
        rest = np.delete(np.arange(len(r)), own)
        step = np.linalg.lstsq(J[rest], -r[rest], rcond=None)[0]
        scaled = weight[i] * final[i]
        root = np.sqrt(1 + scaled**2)
        soft = np.maximum(np.sqrt(2 * (root - 1)), 1e-12)
        slope = np.where(np.abs(scaled) < 1e-6, 1.0, np.abs(scaled) / (root * soft))
        moved[i] += (J[own] @ step) / slope / weight[i]
    return moved


def _mean(errors: Array, groups: list[str], name: str) -> list[float]:
    chosen = [error for error, of in zip(errors, groups, strict=True) if of == name]
    return [float(value) for value in np.mean(np.abs(chosen), axis=0)]


def _write_table(values: Array) -> None:
    path = BODY / "corrections.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    units = {line.split(",")[0]: line.split(",")[2] for line in lines[2:]}
    rows = [
        f"{name},{value:.4g},{units[name]}"
        for name, value in zip(Corrections._fields, values[:LAW], strict=True)
    ]
    path.write_text("\n".join([*lines[:2], *rows]) + "\n", encoding="utf-8")


def _page(record: dict[str, Any]) -> str:
    """What a reader wants of the record."""
    lines = [
        "# What changes with age, size and build",
        "",
        "Written by `tools/identify_corrections.py`; the whole record is",
        "`posture_ik/body/data/corrections_record.json`, the law `posture_ik/body/corrections.py`.",
        "Logarithms are natural; stiffness along the backrest in N/m, damping in N s/m.",
        "",
        "| number | value | 95 % interval | prior |",
        "|---|---|---|---|",
    ]
    for name, of in record["values"].items():
        (low, high), (mean, deviation) = of["interval_95"], of["prior"]
        lines.append(
            f"| {name} | {of['value']:.4g} | {low:.3g} to {high:.3g} "
            f"| {mean:.3g} ± {deviation:.3g} |"
        )
    lines += [
        "",
        "Mean errors against the open measurements, %, of resonance, peak and static mass:",
        "",
        "| rows | the law | the row left out | the source's model |",
        "|---|---|---|---|",
    ]
    for of in record["groups"]:
        columns = ("mean_error_percent", "left_out_mean_error_percent", "thesis_mean_error_percent")
        cells = [", ".join(f"{value:.1f}" for value in of[column]) for column in columns]
        lines.append(f"| {of['group']} | {' | '.join(cells)} |")
    lines += [
        "",
        "Errors of each row, %, and where it is left out (by one Gauss-Newton step):",
        "",
        "| row | the law | the row left out |",
        "|---|---|---|",
    ]
    for row in record["rows"]:
        columns = ("errors_percent", "left_out_errors_percent")
        cells = [", ".join(f"{v:.1f}" for v in row[column].values()) for column in columns]
        name = f"table {row['table']}, {row['condition'].replace('_', ' ')}, {row['row']}"
        lines.append(f"| {name} | {' | '.join(cells)} |")
    lines += [
        "",
        "Tables 15 and 24 disagree: the mean subject resonates at 4.56 Hz in the one, and people",
        "like him at 4.9 Hz in the other. No law of the person alone meets both; the errors of",
        "table 15's resonances are not halved. Its lightest row has more on the seat than it",
        "weighs (49.6 kg of 46 kg): the law stops at all of the weight.",
        "",
        "Two of the numbers are no law's: how much of their thighs the people measured had on the",
        "seat, and how stiff they sat or how weak their vibration was, over the reference subject.",
        "They stand in the problems `toward_*`; a problem that says nothing has the tables' own.",
        "",
        "## The source's law",
        "",
        "`scaling = \"thesis\"` has λ's fitted to the source's own open results",
        "(`tools/fit_scaling_thesis.py`, `posture_ik/body/data/thesis_scaling.csv`). Its chapter 5",
        "supposes a base model that is a little lighter and has a fifth less damping than tables",
        "8-12 give here before all scaling (column `base`). With that made up for (`chapter_5`)",
        "every row is met within 0.1 Hz and 3 %, as `posture-ik validate toward_griffin --set",
        "subject.scaling=thesis` runs them (`thesis_scaling_record.json` has each).",
        "The law alone gives the tables back for the source's reference person, and so is off by",
        "what that base differs.",
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
