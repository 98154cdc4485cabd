"""The forms of the person: sound meshes, in step with their files, standing where the body is."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body, solids
from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.shapes import meshes, visuals, write_meshes
from posture_ik.kinematics import frame_poses
from posture_ik.problem import SPINE, Subject
from posture_ik.resources import resource

MESHES = meshes()


def shown(subject=REFERENCE):
    geometry = BodyGeometry.of(subject)
    return geometry, visuals(geometry.nodes, geometry.scale)


def mesh_of(visual):
    return MESHES[Path(visual.mesh).stem]


def test_checked_in_meshes_are_what_the_code_draws(tmp_path):
    """`python -m posture_ik.body` brings them back into step."""
    write_meshes(tmp_path)
    shipped = resource("urdf/meshes")
    assert {p.name for p in shipped.iterdir()} == {p.name for p in tmp_path.iterdir()}
    for path in tmp_path.iterdir():
        new, old = solids.read_obj(path), solids.read_obj(shipped / path.name)
        assert np.array_equal(new.faces, old.faces), path.name
        assert np.allclose(new.vertices, old.vertices, atol=2e-5), path.name


def test_meshes_are_light():
    assert sum(p.stat().st_size for p in resource("urdf/meshes").iterdir()) < 2_000_000
    assert sum(len(mesh_of(visual).faces) for visual in shown()[1]) < 60_000


@pytest.mark.parametrize("name", MESHES)
def test_mesh_is_closed_and_seen_from_outside(name):
    shape = MESHES[name]
    assert np.isfinite(shape.vertices).all()
    assert shape.faces.min() == 0
    assert shape.faces.max() == len(shape.vertices) - 1
    assert solids.signed_volume(shape) > 0.0
    # Every edge is walked as often one way as the other.
    edges = np.vstack([shape.faces[:, [0, 1]], shape.faces[:, [1, 2]], shape.faces[:, [2, 0]]])
    there = np.sort(edges[:, 0] * 10**6 + edges[:, 1])
    back = np.sort(edges[:, 1] * 10**6 + edges[:, 0])
    assert np.array_equal(there, back)


def test_ball_is_a_ball():
    ball = solids.mesh(
        solids.ellipsoid((0.1, 0.0, 0.0), (0.05,) * 3),
        (0.05, -0.05, -0.05),
        (0.15, 0.05, 0.05),
        0.008,
    )
    radius = np.linalg.norm(ball.vertices - (0.1, 0.0, 0.0), axis=1)
    assert np.abs(radius - 0.05).max() < 1e-5
    assert solids.signed_volume(ball) == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.02)


def test_obj_survives_writing_and_reading(tmp_path):
    solids.write_obj(MESHES["disc"], tmp_path / "disc.obj")
    read = solids.read_obj(tmp_path / "disc.obj")
    assert np.array_equal(read.faces, MESHES["disc"].faces)
    assert np.allclose(read.vertices, MESHES["disc"].vertices, atol=1e-5)


def test_polygons_and_counting_from_the_end_are_read(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1//1 2//1 3//1 4//1\nf -4 -3 -2\n"
    )
    assert solids.read_obj(tmp_path / "a.obj").faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]


@pytest.mark.parametrize("stature", [1.50, 1.80, 2.05])
def test_every_shape_stands_on_a_link_and_vertebrae_fill_their_gaps(stature):
    subject = Subject(gender="female", stature=stature, weight=23.0 * stature**2)
    geometry, looks = shown(subject)
    links = {joint.child for joint in geometry.joints} | {"seat"}
    assert all(visual.link in links for visual in looks)
    assert all(Path(visual.mesh).stem in MESHES for visual in looks)
    bodies = {v.link: v for v in looks if Path(v.mesh).stem in ("cervical", "thoracic", "lumbar")}
    discs = {v.link: v for v in looks if Path(v.mesh).stem == "disc"}
    drawn = {"cervical": 0.012, "thoracic": 0.022, "lumbar": 0.027}
    for lower, upper in pairwise(SPINE):
        if lower in bodies and upper in bodies:
            gap = np.linalg.norm(geometry.nodes[upper] - geometry.nodes[lower])
            bone = sum(
                bodies[body].scale[2] * drawn[Path(bodies[body].mesh).stem] / 2
                for body in (lower, upper)
            )
            assert 0.6 * gap < bone < 0.9 * gap
            assert bone + discs[upper].scale[2] == pytest.approx(gap + 0.0015, abs=1e-9)


def test_left_arm_mirrors_the_right():
    body = build_body(REFERENCE)
    frames = frame_poses(body.model, body.q_reference)
    for right in (v for v in shown()[1] if v.link.endswith("_r")):
        left = next(v for v in shown()[1] if v.mesh == right.mesh.replace("_r.", "_l."))
        here, there = (
            frames[v.link].translation
            + (mesh_of(v).vertices * v.scale + v.xyz) @ frames[v.link].rotation.T
            for v in (right, left)
        )
        if left.link == right.link:  # legs share their meshes
            continue
        assert np.allclose(here * (1, -1, 1), there, atol=1e-9), right.link


def test_urdf_shows_the_person():
    body = build_body(REFERENCE)
    shapes = pin.buildGeomFromUrdfString(
        body.model, body.urdf, pin.GeometryType.VISUAL, package_dirs=[str(resource("urdf"))]
    )
    assert shapes.ngeoms == len(shown()[1])
