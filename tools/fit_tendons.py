"""Fits the tendons to the paths and writes `fitted_slack_m` in `arm_muscles.csv`.

    python tools/fit_tendons.py

Slack lengths are published with paths of their own; along those of myo-sim, of the same lineage,
some fibres would be stretched half as long again in postures that people take at ease, and pull
with most of their strength at rest. So each slack length is changed by the least that keeps the
fibres between 0.5 and 1.3 of their optimal length (the ascending limb, the plateau and what comes
before passive force rules; assumed) in nine tenths of the postures of `arm_range.csv`, evenly
sampled; where they change length by more than that, by what centres them.
"""

from __future__ import annotations

import csv

import numpy as np

from posture_ik.body import build_body
from posture_ik.body.tables import read_table
from posture_ik.muscle.arm import DATA
from posture_ik.muscle.path import Paths
from posture_ik.problem import Subject

#: Fibre lengths to keep to, in optimal lengths along the tendon.
SHORTEST, LONGEST = 0.5, 1.3
#: Share of the postures that may lie beyond either end, and how many there are.
BEYOND, POSTURES = 0.05, 4000


def shift(low: float, high: float) -> float:
    """Least change of length, in optimal lengths, that takes low and high between the ends."""
    if high - low > LONGEST - SHORTEST:
        return (SHORTEST + LONGEST - low - high) / 2
    return max(SHORTEST - low, 0.0) - max(high - LONGEST, 0.0)


def fitted() -> dict[str, float]:
    """Slack length of each tendon, m."""
    body = build_body(Subject())
    paths = Paths.of(body)
    random = np.random.default_rng(1)
    lengths = []
    for _ in range(POSTURES):
        q = body.q_reference.copy()
        q[paths.rows] = random.uniform(paths.lower, paths.upper)
        lengths.append(paths.evaluate(q)[0][:25] / paths.scale)
    ends = np.quantile(lengths, [BEYOND, 1 - BEYOND], axis=0).T
    found = {}
    for (low, high), (name, row) in zip(
        ends, read_table(DATA / "arm_muscles.csv").items(), strict=True
    ):
        slack = float(row["slack_length_m"])
        unit = float(row["optimal_length_m"]) * np.cos(np.radians(float(row["pennation_deg"])))
        change = -shift((low - slack) / unit, (high - slack) / unit) * unit
        found[name] = round(slack + change, 4)
    return found


def main() -> None:
    """Write the column anew."""
    path = DATA / "arm_muscles.csv"
    comment = path.read_text(encoding="utf-8").splitlines()[0]
    rows, slack = read_table(path), fitted()
    columns = list(next(iter(rows.values())))
    if "fitted_slack_m" not in columns:
        columns.insert(columns.index("slack_length_m") + 1, "fitted_slack_m")
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(comment + "\n")
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        for name, row in rows.items():
            table.writerow(row | {"fitted_slack_m": slack[name]})


if __name__ == "__main__":
    main()
