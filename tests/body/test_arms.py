"""The arms: mirrored, held as people hold them, and those of myo-sim."""

import csv
import importlib.util
import os
from copy import copy
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body
from posture_ik.body.arms import ARM_JOINTS, ARM_STATURE
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.tables import table

MIRROR = np.diag([1.0, -1.0, 1.0])
TOOL = Path(__file__).resolve().parents[2] / "tools" / "extract_arm.py"


@pytest.fixture(scope="module")
def body():
    return build_body(REFERENCE)


@pytest.fixture(scope="module")
def tool():
    """The extraction script, where what it reads is installed; CI must have it."""
    missing = [name for name in ("mujoco", "myo_sim") if importlib.util.find_spec(name) is None]
    if missing and os.environ.get("CI") != "true":
        pytest.skip(f"not installed: {', '.join(missing)}")
    assert not missing
    spec = importlib.util.spec_from_file_location("extract_arm", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def arm(tool):
    return tool.build()


def poses(body, angles, sides="rl", q=None):
    q = body.q_reference.copy() if q is None else q
    for joint, angle in zip(ARM_JOINTS, angles, strict=True):
        for side in sides:
            q[body.dofs.index(f"{joint}_{side}")] = angle
    data = body.model.createData()
    pin.framesForwardKinematics(body.model, data, q)
    return {frame.name: data.oMf[i] for i, frame in enumerate(body.model.frames)}


def test_equal_joint_values_give_mirrored_arms(body):
    at = poses(body, np.random.default_rng(1).uniform(-1, 1, 7))
    for link in ("thorax", "clavicle", "scapula", "humerus", "ulna", "radius", "hand", "grip"):
        right, left = at[f"{link}_r"], at[f"{link}_l"]
        np.testing.assert_allclose(left.translation, MIRROR @ right.translation, atol=1e-12)
    np.testing.assert_allclose(
        at["grip_l"].rotation, MIRROR @ at["grip_r"].rotation @ MIRROR, atol=1e-12
    )


@pytest.mark.parametrize("side", ["r", "l"])
def test_frames_of_the_hanging_arm(body, side):
    at = poses(body, np.zeros(7))
    for link in ("humerus", "ulna", "radius", "hand"):
        np.testing.assert_allclose(
            at[f"{link}_{side}"].rotation.T, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-12
        )
    # Along the forearm, to the left, to the thumb: world axes once the forearm points forward.
    hanging = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    np.testing.assert_allclose(at[f"grip_{side}"].rotation, hanging, atol=1e-12)
    forward = pin.rpy.rpyToMatrix(0, -np.pi / 2, 0) @ at[f"grip_{side}"].rotation
    np.testing.assert_allclose(forward, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    ("joint", "expected"),
    [
        ("shoulder_flexion", "forward"),
        ("shoulder_abduction", "outward"),
        ("elbow_flexion", "forward"),
        ("wrist_deviation", "forward"),
        ("wrist_flexion", "inward"),
    ],
)
def test_positive_moves_the_hanging_hand(body, joint, expected):
    angles = np.zeros(7)
    rest = poses(body, angles)["grip_r"].translation
    angles[ARM_JOINTS.index(joint)] = 0.2
    moved = poses(body, angles)["grip_r"].translation - rest
    way = {"forward": [1, 0, 0], "outward": [0, -1, 0], "inward": [0, 1, 0]}[expected]
    assert moved @ way > 0.005


@pytest.mark.parametrize("joint", ["shoulder_rotation", "pronation"])
def test_positive_turns_the_thumb_inward(body, joint):
    angles = np.zeros(7)
    angles[ARM_JOINTS.index(joint)] = 0.2
    thumb = poses(body, angles)["grip_r"].rotation[:, 2]
    assert thumb[1] > 0.1


def test_hands_rest_on_the_thighs(body):
    data = body.model.createData()
    pin.framesForwardKinematics(body.model, data, body.q_reference)
    for side, sign in (("r", -1), ("l", 1)):
        grip = data.oMf[body.model.getFrameId(f"grip_{side}")]
        np.testing.assert_allclose(grip.translation, [0.40, sign * 0.14, 0.20], atol=2e-3)
        palm = -sign * grip.rotation[:, 1]
        assert palm[2] < -0.8


def test_mass_is_what_table_9_lumps_there(body):
    for side, lumped in (("r", 4.00), ("l", 4.01)):
        joints = [body.model.getJointId(f"{joint}_{side}") for joint in ARM_JOINTS]
        assert sum(body.model.inertias[i].mass for i in joints) == pytest.approx(lumped, abs=1e-12)


def test_csv_is_what_the_tool_reads(tool, arm):
    for name, (read, _, columns) in tool.TABLES.items():
        text = (Path(build_body.__code__.co_filename).parent / "data" / f"{name}.csv").read_text()
        comment, header, *lines = text.splitlines()
        assert comment.startswith("# myo-sim")
        assert header == columns
        for ours, theirs in zip(csv.reader(lines), read(*arm), strict=True):
            assert ours[0] == theirs[0]
            np.testing.assert_allclose(
                [float(number) for number in ours[1:]], theirs[1:], atol=1e-9
            )


def test_ranges_are_those_of_myo_sim(tool, arm):
    model, _ = arm
    for joint, (theirs, *_) in tool.JOINTS.items():
        row = table("joint_ranges")[joint]
        ours = [float(row["lower_deg"]), float(row["upper_deg"])]
        if joint == "wrist_deviation":
            ours = [-ours[1], -ours[0]]
        np.testing.assert_allclose(ours, np.degrees(model.joint(theirs).range), atol=0.02)


def test_poses_are_those_of_mujoco(tool, arm, body):
    """Same angles, same frames, once myo-sim's shoulder turns the humerus as ours."""
    import mujoco

    model, state = arm[0], copy(arm[1])
    random = np.random.default_rng(2)
    length = REFERENCE.stature / ARM_STATURE
    for _ in range(5):
        plane, elevation, rotation = random.uniform(0.1, 1.0, 3)
        angles = dict(zip(tool.JOINTS, random.uniform(-0.6, 0.9, 4), strict=True))
        set_to = {"elv_angle_r": plane, "shoulder1_r2_r": -plane, "shoulder_rot_r": rotation}
        set_to |= {"shoulder_elv_r": elevation}
        set_to |= {theirs: angles[joint] for joint, (theirs, *_) in tool.JOINTS.items()}
        for joint, angle in set_to.items():
            state.joint(joint).qpos[0] = angle
        mujoco.mj_kinematics(model, state)
        R, _ = tool.pose(state, "humerus_r", "scapphant_r")
        # R = Rz(flexion) Rx(-abduction) Ry(rotation)
        shoulder = (
            np.arctan2(-R[0, 1], R[1, 1]),
            -np.arcsin(R[2, 1]),
            np.arctan2(-R[2, 0], R[2, 2]),
        )
        at = poses(body, [*shoulder, *angles.values()], "r")
        for link, theirs in {**tool.BODIES, **tool.FRAMES}.items():
            R, p = tool.pose(state, theirs, "scapphant_r")
            ours = at[f"{link}_r"]
            centre = at["humerus_r"].translation
            hanging = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
            np.testing.assert_allclose(ours.rotation, hanging @ R, atol=1e-9)
            np.testing.assert_allclose(ours.translation - centre, length * hanging @ p, atol=1e-9)
