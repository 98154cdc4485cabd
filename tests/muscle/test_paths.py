"""Lengths, moment arms and drawn paths of both arms."""

import numpy as np
import pytest

from posture_ik.body import build_body
from posture_ik.errors import PostureIKError
from posture_ik.kinematics import frame_poses
from posture_ik.muscle import Muscles, Paths
from posture_ik.muscle.arm import elements
from posture_ik.problem import Subject


@pytest.fixture(scope="module")
def body():
    return build_body(Subject())


@pytest.fixture(scope="module")
def paths(body):
    return Paths.of(body)


def postures(paths, count, seed=0):
    """Configurations anywhere in the range in which the paths hold."""
    random = np.random.default_rng(seed)
    q = np.tile(paths.body.q_reference, (count, 1))
    q[:, paths.rows] = random.uniform(paths.lower, paths.upper, (count, 14))
    return q


def differences(paths, q, function, step):
    """Central differences of a function by the 14 arm joints, last."""
    columns = []
    for row in paths.rows:
        ahead, behind = q.copy(), q.copy()
        ahead[row] += step
        behind[row] -= step
        columns.append((function(ahead) - function(behind)) / (2 * step))
    return np.stack(columns, axis=-1)


def test_shapes_and_names(body, paths):
    lengths, jacobian = paths.evaluate(body.q_reference)
    assert lengths.shape == (50,)
    assert jacobian.shape == (50, 14)
    assert [body.dofs[row] for row in paths.rows] == list(paths.dofs)
    assert Muscles.of(body).names == tuple(f"{name}_{side}" for side in "rl" for name in elements())


def test_moment_arms_are_the_slopes_of_length(paths):
    """1e-6 m: the differences are good to 1e-9 here."""
    for q in postures(paths, 60):
        _, jacobian = paths.evaluate(q)
        found = differences(paths, q, lambda x: paths.evaluate(x)[0], 1e-5)
        np.testing.assert_allclose(jacobian, found, atol=1e-8)


def test_curvature_is_the_slope_of_the_moment_arms(paths):
    """For forces of the order of 1 m/rad², to 1e-6 relative: differences do no better."""
    weights = np.random.default_rng(1).uniform(0.0, 1.0, 50)
    for q in postures(paths, 40):
        curvature = paths.curvature(q, weights)
        np.testing.assert_allclose(curvature, curvature.T, atol=1e-12)
        found = differences(paths, q, lambda x: paths.evaluate(x)[1].T @ weights, 1e-6)
        np.testing.assert_allclose(curvature, found, atol=1e-6)


def test_moment_arms_are_smooth_where_a_surface_takes_hold(paths):
    """BRA leaves its cylinder near 70 deg, BRD and FCR touch near 12: no step, no kink."""
    q = paths.body.q_reference.copy()
    column = paths.dofs.index("elbow_flexion_r")
    q[paths.rows[paths.dofs.index("pronation_r")]] = -1.2
    step = np.radians(0.02)
    sweep = np.arange(paths.lower[column], paths.upper[column], step)
    arms, bends = [], []
    for angle in sweep:
        q[paths.rows[column]] = angle
        arms.append(paths.evaluate(q)[1][:25, column])
        bends.append(paths.curvature(q, np.ones(50))[column, column])
    arms, bends = np.array(arms), np.array(bends)
    # The slopes of the slopes carry from point to point (trapezium rule), steps and kinks would not
    total = arms.sum(axis=1)
    carried = step * (bends[1:] + bends[:-1]) / 2
    np.testing.assert_allclose(np.diff(total), carried, atol=2e-8)
    assert np.abs(np.diff(bends)).max() < 5e-3


def test_equal_joint_values_give_equal_sides(paths):
    for q in postures(paths, 5):
        q[paths.rows[7:]] = q[paths.rows[:7]]
        lengths, jacobian = paths.evaluate(q)
        np.testing.assert_array_equal(lengths[:25], lengths[25:])
        np.testing.assert_array_equal(jacobian[:25, :7], jacobian[25:, 7:])
        assert not jacobian[:25, 7:].any()
        assert not jacobian[25:, :7].any()


def test_lengths_grow_with_the_arm(paths):
    tall = Paths.of(build_body(Subject(stature=2.0)))
    ratio = tall.scale / paths.scale
    q = postures(paths, 1)[0]
    ours, theirs = paths.evaluate(q), tall.evaluate(q)
    np.testing.assert_allclose(theirs[0], ratio * ours[0], rtol=1e-12)
    np.testing.assert_allclose(theirs[1], ratio * ours[1], atol=1e-15)
    weights = np.ones(50)
    np.testing.assert_allclose(
        tall.curvature(q, weights), ratio * paths.curvature(q, weights), atol=1e-14
    )


def test_answers_are_finite_to_the_limits_of_the_joints(body, paths):
    """Beyond the range the paths may jump, but a solver that passes there gets numbers."""
    random = np.random.default_rng(2)
    lower, upper = body.lower[paths.rows], body.upper[paths.rows]
    for q in [body.lower, body.upper, *np.tile(body.q_reference, (300, 1))]:
        q = q.copy()
        if np.array_equal(q, body.q_reference):
            q[paths.rows] = random.uniform(lower, upper)
        lengths, jacobian = paths.evaluate(q)
        assert np.all((lengths > 0.0) & (lengths < 1.0))
        assert np.isfinite(jacobian).all()
        assert np.isfinite(paths.curvature(q, np.ones(50))).all()


def test_joints_outside_are_named(body, paths):
    q = body.q_reference.copy()
    assert paths.outside(q) == ()
    q[body.dofs.index("elbow_flexion_l")] = 0.0
    q[body.dofs.index("shoulder_abduction_r")] = np.radians(80.0)
    assert paths.outside(q) == ("shoulder_abduction_r", "elbow_flexion_l")


def test_drawn_paths_are_as_long_as_said(paths):
    """To 2e-5 m: chords of 5 deg cut 3e-4 of an arc of at most 60 mm, the switch 3e-6 m."""
    for q in postures(paths, 20):
        lengths, _ = paths.evaluate(q)
        drawn = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in paths.polylines(q)]
        np.testing.assert_allclose(drawn, lengths, atol=2e-5)


def test_drawn_paths_are_fixed_to_the_body(paths):
    """The first point of BRA on its humerus, the last of FCU on its hand; mirrored on the left."""
    q = postures(paths, 1)[0]
    poses = frame_poses(paths.body.model, q)
    lines = dict(zip(Muscles.of(paths.body).names, paths.polylines(q), strict=True))
    for side, mirror in (("r", [1, 1, 1]), ("l", [1, 1, -1])):
        for muscle, link, k in (("BRA", "humerus", 0), ("FCU", "hand", -1)):
            place = paths.scale * elements()[muscle][k].place * mirror
            np.testing.assert_allclose(
                lines[f"{muscle}_{side}"][k], poses[f"{link}_{side}"].act(place), atol=1e-9
            )
        clavicle = paths.scale * np.array([0.00321, -0.00013, 0.05113]) * mirror
        np.testing.assert_allclose(
            lines[f"PECM1_{side}"][-1], poses[f"clavicle_{side}"].act(clavicle), atol=1e-9
        )


@pytest.fixture
def armless(body, tmp_path):
    """The body of a URDF without its left arm."""
    from xml.etree import ElementTree as ET

    robot = ET.fromstring(body.urdf)
    gone = {"T2"}
    for _ in range(20):
        for joint in robot.findall("joint"):
            child, parent = joint.find("child").get("link"), joint.find("parent").get("link")
            if child.endswith(("_l", "_l_link")) and (parent in gone or parent == "T2"):
                gone.add(child)
    gone.discard("T2")
    for joint in robot.findall("joint"):
        if joint.find("child").get("link") in gone:
            robot.remove(joint)
    for link in robot.findall("link"):
        if link.get("name") in gone:
            robot.remove(link)
    path = tmp_path / "armless.urdf"
    path.write_text(ET.tostring(robot, encoding="unicode"))
    return build_body(Subject(), path)


@pytest.mark.parametrize("of", [Muscles.of, Paths.of])
def test_a_body_without_arms_has_no_muscles(armless, of):
    with pytest.raises(PostureIKError, match="no joint 'shoulder_flexion_l'"):
        of(armless)


def test_arms_of_another_size_are_refused(body, tmp_path):
    path = tmp_path / "tall.urdf"
    path.write_text(build_body(Subject(stature=1.9)).urdf)
    with pytest.raises(PostureIKError, match=r"mm off its place in the arm of a person of 1\.8 m"):
        Paths.of(build_body(Subject(stature=1.8), path))


def test_arms_without_the_links_of_the_trunk_are_refused(body, tmp_path):
    path = tmp_path / "renamed.urdf"
    path.write_text(body.urdf.replace('"thorax_l"', '"chest_l"'))
    with pytest.raises(PostureIKError, match="'thorax_l', which this body has not"):
        Paths.of(build_body(Subject(), path))
