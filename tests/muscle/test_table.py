"""What the muscles are."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from posture_ik.body import build_body
from posture_ik.muscle import Muscles, Paths
from posture_ik.muscle.table import ARM_WEIGHT
from posture_ik.problem import Subject


@pytest.fixture(scope="module")
def median():
    return build_body(Subject(stature=1.755, weight=ARM_WEIGHT))


def test_values_of_the_man_they_were_measured_for(median):
    """A line of the source's table, both sides, in an arm of the size of his."""
    muscles, size = Muscles.of(median), Paths.of(median).scale
    assert size == pytest.approx(1.0, abs=0.01)
    for side in "rl":
        i = muscles.names.index(f"TRIlong_{side}")
        assert muscles.group[i] == "elbow extensors"
        assert muscles.peak_force[i] == pytest.approx(771.8)
        assert muscles.optimal_length[i] == pytest.approx(0.134 * size)
        assert muscles.published_slack_length[i] == pytest.approx(0.143 * size)
        assert muscles.pennation[i] == pytest.approx(np.radians(12.0))
        assert muscles.fastest[i] == pytest.approx(1.34 * size)
    assert all(len(getattr(muscles, name)) == 50 for name in vars(muscles))


def test_tendons_are_fitted_by_the_least_change(median):
    """The table is what `tools/fit_tendons.py` writes, and most are as published."""
    path = Path(__file__).resolve().parents[2] / "tools" / "fit_tendons.py"
    spec = importlib.util.spec_from_file_location("fit_tendons", path)
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    muscles = Muscles.of(median)
    slack = muscles.slack_length[:25] / Paths.of(median).scale
    np.testing.assert_allclose(slack, [*tool.fitted().values()], atol=1e-9)
    changed = muscles.slack_length != muscles.published_slack_length
    assert changed[:25].sum() == 8
    assert tool.shift(0.6, 1.2) == 0.0
    assert tool.shift(0.6, 1.35) == pytest.approx(-0.05)
    assert tool.shift(0.4, 1.1) == pytest.approx(0.1)
    assert tool.shift(0.4, 1.6) == pytest.approx(-0.1)


def test_sizes_follow_the_subject(median):
    """Lengths as the arm's; forces as volume over length, mass times stature over stature."""
    tall = build_body(Subject(stature=1.9, weight=1.3 * ARM_WEIGHT))
    ours, theirs = Muscles.of(median), Muscles.of(tall)
    longer = Paths.of(tall).scale / Paths.of(median).scale
    assert longer > 1.05
    for name, factor in (
        ("peak_force", 1.3),
        ("optimal_length", longer),
        ("slack_length", longer),
        ("pennation", 1.0),
        ("fastest", longer),
    ):
        np.testing.assert_allclose(getattr(theirs, name), factor * getattr(ours, name), rtol=1e-12)


def test_fibres_fit_the_paths(median):
    """Over the range, on a stiff tendon, no fibre goes slack or beyond where it can work."""
    muscles, paths = Muscles.of(median), Paths.of(median)
    random = np.random.default_rng(0)
    q = median.q_reference.copy()
    for _ in range(500):
        q[paths.rows] = random.uniform(paths.lower, paths.upper)
        lengths, _ = paths.evaluate(q)
        along = lengths - muscles.slack_length
        across = muscles.optimal_length * np.sin(muscles.pennation)
        fibre = np.hypot(along, across) / muscles.optimal_length
        assert along.min() > 0.0
        assert fibre.min() > 0.25
        assert fibre.max() < 1.75


def test_moment_arms_have_the_signs_of_anatomy(median):
    """With the arm lifted aside by 40 deg, each group pulls the way of its name."""
    muscles, paths = Muscles.of(median), Paths.of(median)
    q = median.q_reference.copy()
    q[median.dofs.index("shoulder_abduction_r")] = np.radians(40.0)
    q[median.dofs.index("pronation_r")] = np.radians(20.0)
    arms = -paths.evaluate(q)[1][:25, :7]
    columns = {dof[:-2]: k for k, dof in enumerate(paths.dofs[:7])}

    def arm(muscle, joint):
        return arms[muscles.names.index(f"{muscle}_r"), columns[joint]]

    for muscle, joint, sign in (
        ("DELT1", "shoulder_flexion", 1),
        ("DELT3", "shoulder_flexion", -1),
        ("LAT1", "shoulder_flexion", -1),
        ("DELT2", "shoulder_abduction", 1),
        ("SUPSP", "shoulder_abduction", 1),
        ("TMAJ", "shoulder_abduction", -1),
        ("SUBSC", "shoulder_rotation", 1),
        ("INFSP", "shoulder_rotation", -1),
        ("TMIN", "shoulder_rotation", -1),
        ("BIClong", "elbow_flexion", 1),
        ("BRA", "elbow_flexion", 1),
        ("BRD", "elbow_flexion", 1),
        ("TRImed", "elbow_flexion", -1),
        ("SUP", "pronation", -1),
        ("BICshort", "pronation", -1),
        ("PT", "pronation", 1),
        ("FCR", "wrist_flexion", 1),
        ("FCU", "wrist_flexion", 1),
        ("ECRB", "wrist_flexion", -1),
        ("ECU", "wrist_flexion", -1),
        ("ECRL", "wrist_deviation", 1),
        ("ECU", "wrist_deviation", -1),
    ):
        assert sign * arm(muscle, joint) > 0.002, (muscle, joint, arm(muscle, joint))
