"""What the 50 muscles of both arms are: their forces and lengths, in a body's size.

The values are those of a man of median size, whose arm is that of `ARM_STATURE`. Fibres and
tendons grow with the arm. Muscle volume grows as mass times stature (Handsfield et al. 2014), so
that the cross-section, volume over fibre length, and the peak force with it grow as mass.

Slack lengths are not the published ones where these do not fit the paths, which are of another
descendant of the same model: `tools/fit_tendons.py` changes eight of them by the least that keeps
the fibres where they can work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.arms import SIDES, size
from posture_ik.body.laws import scale_of
from posture_ik.body.tables import read_table
from posture_ik.muscle.arm import DATA
from posture_ik.muscle.path import require_arms

#: Weight of the man whose muscles these are (the median of the 4082 men of ANSUR II), kg.
ARM_WEIGHT = 84.6
#: Fastest shortening, in optimal fibre lengths a second (usual, after Zajac 1989).
FASTEST = 10.0


@dataclass(frozen=True, eq=False)
class Muscles:
    """The muscles of both arms, the right arm's before the left's; arrays are (50,).

    Attributes:
        names: Such as `DELT1_r`.
        group: What each is counted to in charts, its main action, such as "elbow flexors".
        peak_force: Isometric, at optimal length, along the fibres, N.
        optimal_length: Of the fibres, m.
        slack_length: Of the tendon, fitted to the paths, m.
        published_slack_length: As published, m.
        pennation: At optimal length, rad.
        fastest: Speed of shortening at which no force is left, m/s.
    """

    names: tuple[str, ...]
    group: tuple[str, ...]
    peak_force: Array
    optimal_length: Array
    slack_length: Array
    published_slack_length: Array
    pennation: Array
    fastest: Array

    @classmethod
    def of(cls, body: Body) -> Muscles:
        """The muscles of a body.

        Raises:
            PostureIKError: If the body lacks an arm.
        """
        require_arms(body)
        rows = read_table(DATA / "arm_muscles.csv")
        length = size(scale_of(body.subject))

        def column(name: str) -> Array:
            return np.tile([float(row[name]) for row in rows.values()], len(SIDES))

        optimal_length = length * column("optimal_length_m")
        return cls(
            tuple(f"{muscle}_{side}" for side in SIDES for muscle in rows),
            tuple(row["group"] for _ in SIDES for row in rows.values()),
            body.subject.weight / ARM_WEIGHT * column("peak_force_N"),
            optimal_length,
            length * column("fitted_slack_m"),
            length * column("slack_length_m"),
            np.radians(column("pennation_deg")),
            FASTEST * optimal_length,
        )
