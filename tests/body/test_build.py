"""The built body against the tables it comes from, read and summed here by hand."""

import csv
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body
from posture_ik.body.load import load_model
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.spine import SPINE_DOFS
from posture_ik.kinematics import Kinematics
from posture_ik.kinematics.twin import read_structure
from posture_ik.problem import SPINE, Subject

DATA = Path(build_body.__code__.co_filename).parent / "data"


def rows(name):
    lines = (DATA / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# ")
    return list(csv.DictReader(lines[1:]))


@pytest.fixture(scope="module")
def body():
    return build_body(REFERENCE)


@pytest.fixture(scope="module")
def posed(body):
    data = body.model.createData()
    pin.ccrba(body.model, data, body.q_reference, np.zeros(body.model.nv))
    pin.framesForwardKinematics(body.model, data, body.q_reference)
    return data


def pose(body, data, frame):
    return data.oMf[body.model.getFrameId(frame)]


def test_tables_hold_what_the_source_prints():
    assert len(rows("table_8_nodes")) == 39
    assert sum(float(row["mass_kg"]) for row in rows("table_9_masses")) == pytest.approx(61.39)
    assert len(rows("table_10_damping")) == len(rows("table_11_stiffness")) == 27
    assert len(rows("table_12_viscera")) == 8


def test_degrees_of_freedom(body):
    assert body.model.nq == body.model.nv == len(body.dofs) == 117
    assert [dof for dof in body.dofs if dof in SPINE_DOFS] == list(SPINE_DOFS)
    assert len(SPINE_DOFS) == 103
    assert sorted(set(body.dofs) - set(SPINE_DOFS))[:2] == ["elbow_flexion_l", "elbow_flexion_r"]


def test_nodes_stand_where_table_8_puts_them(body, posed):
    for row in rows("table_8_nodes"):
        if row["label"] in SPINE or row["label"].endswith("V"):
            at = pose(body, posed, row["label"])
            node = [float(row[f"{axis}_m"]) for axis in "xyz"]
            np.testing.assert_allclose(at.translation, node, atol=1e-12)
            np.testing.assert_allclose(at.rotation, np.eye(3), atol=1e-12)
    for label, link in (("R_arm", "humerus_r"), ("L_arm", "humerus_l")):
        (row,) = (row for row in rows("table_8_nodes") if row["label"] == label)
        node = [float(row[f"{axis}_m"]) for axis in "xyz"]
        np.testing.assert_allclose(pose(body, posed, link).translation, node, atol=1e-12)


def test_mass_centre_and_inertia_are_the_tables_own_sum(body, posed):
    places = {
        r["label"]: np.array([float(r[f"{a}_m"]) for a in "xyz"]) for r in rows("table_8_nodes")
    }
    parts = []
    for row in rows("table_9_masses"):
        if not row["label"].endswith("_arm"):
            offset = [float(row[f"offset_{axis}_m"]) for axis in "xyz"]
            tensor = np.diag([float(row[f"i{axis}{axis}_kg_m2"]) for axis in "xyz"])
            parts.append((float(row["mass_kg"]), places[row["label"]] + offset, tensor))
    assert sum(mass for mass, _, _ in parts) == pytest.approx(61.39 - 8.01)
    length = 1.80 / 1.755
    for side, lumped in (("r", 4.00), ("l", 4.01)):
        flip = np.array([1.0, 1.0, 1.0 if side == "r" else -1.0])
        arm = rows("arm_bodies")
        factor = lumped / sum(float(row["mass_kg"]) for row in arm)
        for row in arm:
            at = pose(body, posed, f"{row['link']}_{side}")
            centre = at.act(length * flip * [float(row[f"{axis}_m"]) for axis in "xyz"])
            upper = [float(row[f"i{ij}_kg_m2"]) for ij in ("xx", "xy", "xz", "yy", "yz", "zz")]
            tensor = np.zeros((3, 3))
            tensor[np.triu_indices(3)] = upper
            tensor = np.outer(flip, flip) * (tensor + np.triu(tensor, 1).T)
            turned = at.rotation @ tensor @ at.rotation.T
            parts.append((factor * float(row["mass_kg"]), centre, factor * length**2 * turned))
    total = sum(mass for mass, _, _ in parts)
    centre = sum(mass * place for mass, place, _ in parts) / total
    inertia = sum(
        tensor + mass * ((p - centre) @ (p - centre) * np.eye(3) - np.outer(p - centre, p - centre))
        for mass, p, tensor in parts
    )
    assert total == pytest.approx(61.39, abs=1e-12)
    assert pin.computeTotalMass(body.model) == pytest.approx(61.39, abs=1e-12)
    np.testing.assert_allclose(posed.com[0], centre, atol=1e-12)
    np.testing.assert_allclose(posed.Ig.inertia, inertia, atol=1e-10)


def test_bushings_stand_at_022_and_slide_along_the_chord(body):
    nodes = {
        r["label"]: np.array([float(r[f"{a}_m"]) for a in "xyz"]) for r in rows("table_8_nodes")
    }
    data = body.model.createData()
    pin.forwardKinematics(body.model, data, body.q_reference)
    for lower, upper in pairwise(SPINE):
        at = data.oMi[body.model.getJointId(f"{upper}_{lower}_axial")]
        chord = nodes[upper] - nodes[lower]
        np.testing.assert_allclose(at.translation, nodes[lower] + 0.22 * chord, atol=1e-12)
        tangent = chord / np.linalg.norm(chord)
        np.testing.assert_allclose(at.rotation @ [0, 0, 1], tangent, atol=1e-12)
        np.testing.assert_allclose(at.rotation @ [0, 1, 0], [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("component", "moved"),
    [("axial", "up"), ("rx", "right"), ("ry", "forward"), ("rz", "left")],
)
def test_signs(body, component, moved):
    q = body.q_reference.copy()
    q[body.dofs.index(f"L1_L2_{component}")] = 0.01
    data = body.model.createData()
    pin.framesForwardKinematics(body.model, data, q)
    head = pose(body, data, "Head")
    came = {
        "up": head.translation[2] - 0.75375,
        "right": -head.translation[1],
        "forward": head.translation[0] - 0.02617,
        "left": (head.rotation @ [1, 0, 0])[1],
    }
    assert came[moved] > 1e-3


def test_springs_and_dampers_are_the_tables_of_the_same_joint(body):
    stiffness = dict(zip(body.dofs, body.stiffness, strict=True))
    damping = dict(zip(body.dofs, body.damping, strict=True))
    assert stiffness["L4_L5_axial"] == 1922950.7
    assert [stiffness[f"L4_L5_r{axis}"] for axis in "xyz"] == [1264.3, 586.7, 787.5]
    assert [damping[f"Head_C1_{part}"] for part in ("axial", "rx", "ry", "rz")] == [
        *(15570, 560, 336, 119)
    ]
    assert stiffness["buttocks_S1_axial"] == 58.8e3
    assert stiffness["buttocks_S1_rx"] == stiffness["buttocks_S1_ry"] == 7.40e3
    for dof in ("buttocks_S1_axial", "buttocks_S1_rx", "elbow_flexion_l"):
        assert damping[dof] == pytest.approx(0.025 * stiffness[dof])
    np.testing.assert_allclose(body.model.damping, body.damping)
    assert min(body.stiffness) > 0
    assert min(body.damping) > 0


def test_every_range_has_a_source_and_holds_the_reference(body):
    ranges = {row["dof"]: row for row in rows("joint_ranges")}
    for i, dof in enumerate(body.dofs):
        row = ranges[dof] if dof in ranges else ranges[dof[:-2]]
        assert row["source"]
        assert body.lower[i] < body.q_reference[i] < body.upper[i] or dof.startswith("wrist")
        if dof in SPINE_DOFS:
            assert body.lower[i] < 0 < body.upper[i]
    # Flexion of the whole lumbar spine stays below what is measured over it (Christophy 2012).
    lumbar = [i for i, dof in enumerate(body.dofs) if dof.startswith("L") and dof.endswith("_ry")]
    assert 40 < np.degrees(body.upper[lumbar].sum()) < 70
    assert -26 < np.degrees(body.lower[lumbar].sum()) < -15


@pytest.mark.parametrize(
    "subject", [REFERENCE, Subject(gender="female", age=60, stature=1.52, weight=71.0)]
)
def test_model_is_what_pinocchio_reads_from_the_urdf(subject):
    """To the rounding of a rotation written as angles, and of one structure, zeros included."""
    body = build_body(subject)
    ours, read = body.model, load_model(body.urdf, "here")
    assert read_structure(ours) == read_structure(read)
    assert list(ours.names) == list(read.names)
    for mine, theirs in zip(ours.jointPlacements, read.jointPlacements, strict=True):
        np.testing.assert_allclose(mine.homogeneous, theirs.homogeneous, atol=1e-12)
    for mine, theirs in zip(ours.inertias, read.inertias, strict=True):
        np.testing.assert_allclose(mine.matrix(), theirs.matrix(), atol=1e-12)
    for mine, theirs in zip(ours.frames, read.frames, strict=True):
        np.testing.assert_allclose(
            mine.placement.homogeneous, theirs.placement.homogeneous, atol=1e-12
        )
        np.testing.assert_allclose(mine.inertia.matrix(), theirs.inertia.matrix(), atol=1e-12)
    for limits in ("lowerPositionLimit", "upperPositionLimit", "damping"):
        np.testing.assert_array_equal(getattr(ours, limits), getattr(read, limits))


def test_all_subjects_share_one_twin():
    """So every function compiled for one serves all."""
    people = [Subject(stature=1.45, weight=32.0), Subject(gender="female", weight=150.0)]
    twins = {Kinematics.of(build_body(person).model) for person in people}
    assert twins == {Kinematics.of(build_body(REFERENCE).model)}
