"""Fits how people are built to ANSUR II, and records how well.

    python tools/fit_anthropometry.py TABLE

TABLE is the survey as one CSV file, a person a row, measures in mm by the survey's names, weight in
kg (`weight_kg`), `age` and `gender`. It does not ship; what is written to
`posture_ik/anthropometry/data/ansur_ii.json` does: by gender, the regressions and the covariance of
their residuals, the quantiles of age, stature and weight and the correlation of their normal
scores; with R², residual standard deviation, percentiles of the survey for the tests, and, of
40,000 people drawn from the fit, rounded as the survey is, the Kolmogorov-Smirnov distance of each
measure's distribution from the survey's and the largest difference between any two measures'
correlation and the survey's.
"""

from __future__ import annotations

import csv
import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import ks_2samp, rankdata

from posture_ik import anthropometry
from posture_ik.anthropometry import AGE, STATURE, WEIGHT, Fit, Gender, sample_measures
from posture_ik.arrays import Array

#: Our name and the survey's; those of `SEATED` are heights, taken above the seat by what sitting
#: height and stature differ by.
MEASURES = {
    "sitting_height": "sittingheight",
    "cervicale_height": "cervicaleheight",
    "suprasternale_height": "suprasternaleheight",
    "shoulder_height": "acromialheight",
    "iliac_crest_height": "iliocristaleheight",
    "upper_arm_length": "acromionradialelength",
    "forearm_length": "radialestylionlength",
    "hand_length": "handlength",
    "buttock_knee_length": "buttockkneelength",
    "popliteal_height": "poplitealheight",
    "head_length": "headlength",
    "head_breadth": "headbreadth",
    "neck_circumference": "neckcircumference",
    "biacromial_breadth": "biacromialbreadth",
    "chest_breadth": "chestbreadth",
    "chest_depth": "chestdepth",
    "chest_circumference": "chestcircumference",
    "waist_breadth": "waistbreadth",
    "waist_depth": "waistdepth",
    "waist_circumference": "waistcircumference",
    "hip_breadth": "hipbreadthsitting",
    "buttock_depth": "buttockdepth",
    "buttock_circumference": "buttockcircumference",
    "thigh_clearance": "thighclearance",
}
SEATED = ("cervicale_height", "suprasternale_height", "shoulder_height", "iliac_crest_height")
#: Shares at which quantiles are kept to draw from, and those kept to test against.
LEVELS = (0.0, 0.005, 0.01, 0.025, 0.05, *np.arange(0.1, 0.95, 0.1).round(1).tolist())
LEVELS = (*LEVELS, 0.95, 0.975, 0.99, 0.995, 1.0)
PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
DRAWN, SEED = 40_000, 1
#: Decimals that the survey gives, where not 3.
ROUNDED = {"age": 0, "weight": 1}
FILE = Path(anthropometry.__file__).parent / "data" / "ansur_ii.json"


def read(path: Path) -> dict[Gender, dict[str, Array]]:
    """The survey by gender: years, m and kg, each (n,)."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    survey: dict[Gender, dict[str, Array]] = {}
    for gender in ("male", "female"):
        people = [row for row in rows if row["gender"].lower() == gender]

        def column(name: str, people: list[dict[str, str]] = people) -> Array:
            return np.array([float(row[name]) for row in people])

        found = {"age": column("age"), "stature": column("stature_mm") / 1e3}
        found["weight"] = column("weight_kg")
        found |= {ours: column(theirs) / 1e3 for ours, theirs in MEASURES.items()}
        for name in SEATED:
            found[name] = (found[name] + found["sitting_height"] - found["stature"]).round(3)
        survey[gender] = found
    return survey


def fit(people: dict[str, Array]) -> dict[str, Any]:
    """What `anthropometry.Fit` reads, with how good it is."""
    age, stature, weight = (people[name] for name in ("age", "stature", "weight"))
    terms = np.stack(
        [
            np.ones_like(age),
            (age - AGE) / 10,
            np.log(stature / STATURE),
            np.log(weight / WEIGHT),
        ],
        axis=1,
    )
    logs = np.log(np.stack([people[name] for name in MEASURES], axis=1))
    found, *_ = np.linalg.lstsq(terms, logs)
    residuals = logs - terms @ found
    freedom = len(age) - terms.shape[1]
    covariance = residuals.T @ residuals / freedom
    scores = [ndtri((rankdata(p) - 0.5) / len(p)) for p in (age, stature, weight)]
    return {
        "count": len(age),
        "quantiles": {
            name: np.quantile(people[name], LEVELS).round(4).tolist()
            for name in ("age", "stature", "weight")
        },
        "correlation": np.corrcoef(scores).round(4).tolist(),
        "measures": {
            name: {
                "coefficients": found[:, i].round(5).tolist(),
                "residual_sd": round(float(np.sqrt(covariance[i, i])), 4),
                "r_squared": round(float(1 - residuals[:, i].var() / logs[:, i].var()), 3),
            }
            for i, name in enumerate(MEASURES)
        },
        "residual_covariance": [
            [float(f"{entry:.5g}") for entry in row] for row in covariance.tolist()
        ],
        "percentiles": {
            name: np.percentile(numbers, PERCENTILES).round(4).tolist()
            for name, numbers in people.items()
        },
    }


def distances(gender: Gender, people: dict[str, Array]) -> dict[str, Any]:
    """How far people drawn from the written fit are from the survey's."""
    drawn = sample_measures(gender, DRAWN, np.random.default_rng(SEED))
    ours, theirs = (np.corrcoef([each[name] for name in people]) for each in (drawn, people))
    return {
        "kolmogorov_smirnov": {
            name: round(
                float(ks_2samp(drawn[name].round(ROUNDED.get(name, 3)), numbers).statistic), 4
            )
            for name, numbers in people.items()
        },
        "correlation_difference": round(float(np.abs(ours - theirs).max()), 3),
    }


def write(data: dict[str, Any]) -> None:
    """A number list a line, so that changes can be read."""
    text = json.dumps(data, indent=1)
    FILE.write_text(_joined(text) + "\n", encoding="utf-8")


def _joined(text: str) -> str:
    """Lists of numbers on one line each."""
    return re.sub(
        r"\[\s+([-\d.e,\s]+?)\s+\]", lambda m: "[" + re.sub(r"\s+", " ", m[1]) + "]", text
    )


def main() -> None:
    """Fit, write, draw, and write how far what is drawn lies."""
    survey = read(Path(sys.argv[1]))
    data: dict[str, Any] = {
        "source": "ANSUR II (US Army, 2012), fitted by tools/fit_anthropometry.py; lengths in m, "
        "weight in kg, age in years; heights above the seat; percentiles are the survey's own",
        "levels": LEVELS,
        "percents": PERCENTILES,
        "genders": {gender: fit(people) for gender, people in survey.items()},
    }
    write(data)
    Fit.of.cache_clear()
    for gender, people in survey.items():
        data["genders"][gender]["drawn"] = distances(gender, people)
        print(gender, json.dumps(data["genders"][gender]["drawn"], indent=1))
    write(data)


if __name__ == "__main__":
    main()
