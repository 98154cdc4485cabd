"""The 3D page draws the posture found, needs nothing from outside, and bears any body."""

import base64
import json
import re
import struct
from dataclasses import replace
from xml.etree import ElementTree as ET

import meshcat
import numpy as np
import pinocchio as pin
import pytest
import umsgpack

from posture_ik.body import build_body
from posture_ik.body.laws import scale_of
from posture_ik.errors import UnwritableOutput
from posture_ik.kinematics import frame_poses
from posture_ik.posture import Wrench, solve_posture
from posture_ik.problem import SPINE, load_problem
from posture_ik.resources import resource
from posture_ik.show import write_view
from posture_ik.show.arrows import acting, arrows, labels, turns
from posture_ik.show.looks import looks_of
from posture_ik.show.scene import draw, floor_height
from posture_ik.show.skin import back_of, skin
from posture_ik.show.strain import RAMP, colour, full_scale, parts_of, place_on_scale


class Recorder:
    def __init__(self):
        self.objects, self.transforms = {}, {}

    def send(self, command):
        lowered = umsgpack.unpackb(umsgpack.packb(command.lower()))
        if lowered["type"] == "set_object":
            self.objects[lowered["path"].removeprefix("/meshcat/")] = lowered["object"]
        if lowered["type"] == "set_transform":
            path = lowered["path"].removeprefix("/meshcat/")
            self.transforms[path] = np.reshape(lowered["matrix"], (4, 4)).T


def solved(name, **subject):
    problem = load_problem(name)
    problem = problem.model_copy(update={"subject": problem.subject.model_copy(update=subject)})
    return solve_posture(build_body(problem.subject), problem)


def drawn(posture):
    recorder = Recorder()
    draw(meshcat.Visualizer(window=recorder), posture)
    return recorder


@pytest.fixture(scope="module")
def reclined():
    return solved("reclined_15")


@pytest.fixture(scope="module")
def leaning():
    return solved("reclined_15_gravity")


@pytest.fixture(scope="module")
def scene(reclined):
    return drawn(reclined)


@pytest.fixture(scope="module")
def page(reclined, tmp_path_factory):
    path = tmp_path_factory.mktemp("view") / "view.html"
    write_view(reclined, path)
    return path.read_text(encoding="utf-8")


def vertices(obj):
    position = obj["geometries"][0]["data"]["attributes"]["position"]["array"].data
    return np.array(struct.unpack(f"<{len(position) // 4}f", position)).reshape(-1, 3)


def part(posture):
    return parts_of(posture, {look.link for look in looks_of(posture.body)})


def test_every_link_stands_where_the_posture_puts_it(reclined, scene):
    reference = frame_poses(reclined.body.model, reclined.body.q_reference)
    for name in SPINE:
        assert np.allclose(scene.transforms[f"person/{name}"], reclined.frames[name].homogeneous)
        if name != "S1":
            assert np.allclose(scene.transforms[f"ghost/{name}"], reference[name].homogeneous)
    for look in looks_of(reclined.body):
        assert f"person/{look.link}/{look.name}" in scene.objects


def test_backrest_touches_the_back(reclined, scene):
    reference = frame_poses(reclined.body.model, reclined.body.q_reference)
    girth = scale_of(reclined.body.subject).length["thoracic"][0]
    back = back_of(skin(reference, reclined.frames, girth), reference, girth)
    pose = scene.transforms["seat/backrest"]
    front = np.max(vertices(scene.objects["seat/backrest"])[:, 0])
    gaps = (back - pose[:3, 3]) @ pose[:3, 0] - front
    assert abs(gaps.min()) < 1e-3
    assert np.degrees(np.arctan2(-pose[0, 2], pose[2, 2])) == pytest.approx(15.0)


def test_skin_follows_its_vertebrae(reclined):
    reference = frame_poses(reclined.body.model, reclined.body.q_reference)
    rest = skin(reference, reference, 1.0)
    turn = pin.SE3(pin.utils.rotate("y", -0.3), np.array([0.1, 0.0, 0.2]))
    carried = skin(reference, {name: turn * pose for name, pose in reference.items()}, 1.0)
    high = rest.vertices[:, 2] > reference["S1"].translation[2]
    expected = rest.vertices @ turn.rotation.T + turn.translation
    assert np.allclose(carried.vertices[high], expected[high])
    assert np.allclose(skin(reference, reference, 1.0).vertices, rest.vertices)


def test_floor_lies_under_the_soles(reclined, scene):
    foot = scene.transforms["person/foot_r"] @ scene.transforms["person/foot_r/foot"]
    sole = vertices(scene.objects["person/foot_r/foot"]) @ foot[:3, :3].T + foot[:3, 3]
    assert sole[:, 2].min() == pytest.approx(floor_height(reclined), abs=2e-3)


def test_parts_share_out_all_strain_energy(reclined):
    for posture in (reclined, solved("pilot")):
        parts = part(posture)
        joints = {p.joint: p for p in parts.values()}  # ribs and shoulder blades share theirs
        assert sum(p.energy for p in joints.values()) == pytest.approx(posture.elastic_energy)
        assert sum(len(p.dofs) for p in joints.values()) == 117
        assert parts["L4"].joint == "L4_L5"
        assert parts["S1"].joint == "buttocks_S1"
        assert parts["humerus_r"].joint == "shoulder_r"
        assert parts["radius_l"].joint == "pronation_l"
        assert "foot_r" not in parts


def test_colour_darkens_with_energy():
    pale = (0.93, 0.90, 0.83)
    assert colour(0.0, 2.0, pale) == pytest.approx(pale)
    assert colour(1.0, 0.0, pale) == pytest.approx(pale)
    assert colour(2.0, 2.0, pale) == pytest.approx(RAMP[-1])
    shades = [np.dot((0.21, 0.72, 0.07), colour(e, 2.0, pale)) for e in np.linspace(0, 2, 40)]
    assert np.all(np.diff(shades) < 0.0)
    assert place_on_scale(0.5, 2.0) == pytest.approx(0.5)


def test_scale_ends_at_a_round_energy(reclined):
    parts = part(reclined)
    assert full_scale(parts) == 2.0
    one = {"L4": parts["L4"]._replace(energy=5.0)}
    assert full_scale(one) == 5.0
    assert full_scale({}) == 0.0


def test_arrows_push_at_their_points_in_proportion():
    def wrench(name, force, moment):
        return Wrench(name, np.array(force), np.array(moment), np.array([0.1, 0.2, 0.3]))

    wrenches = [
        wrench("big", [0.0, 0.0, 100.0], [0.0, 4.0, 0.0]),
        wrench("half", [-50.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        wrench("nothing", [0.0, 1e-9, 0.0], [0.0, 0.0, 0.0]),
    ]
    big, half = arrows(wrenches)
    assert np.allclose(big.tip - big.tail, [0.0, 0.0, 0.30])
    assert np.allclose(half.tip - half.tail, [-0.15, 0.0, 0.0])
    assert np.allclose(big.tip, [0.1, 0.2, 0.3])
    first, second = turns(wrenches)
    assert np.allclose(first.axis, [0.0, 1.0, 0.0])
    assert np.allclose(second.axis, [0.0, 0.0, -1.0])
    assert first.radius > second.radius
    assert [(w.name, w.force, w.moment) for w in labels(wrenches)] == [
        ("big", "100 N", "4 N m"),
        ("half", "50 N", "1 N m"),
    ]


def test_drawn_arrow_runs_from_tail_to_tip(reclined, scene):
    backrest = next(a for a in arrows(acting(reclined)) if a.name == "backrest")
    pose = scene.transforms["forces/backrest/force"]
    assert np.allclose(pose[:3, 3], backrest.tail)
    force = next(w.force for w in reclined.wrenches if w.label == "backrest")
    assert np.allclose(pose[:3, 1], force / np.linalg.norm(force))


def test_contacts_stand_in_for_the_backrest_where_it_can_only_push(leaning):
    names = [wrench.label for wrench in acting(leaning)]
    assert "backrest contact" not in names
    assert {contact.label for contact in leaning.contacts} <= set(names)
    assert names[-1] == "seat"


def test_pilot_has_levers():
    scene = drawn(solved("pilot"))
    assert {"levers/right/stick", "levers/left/stick"} <= set(scene.objects)


def test_page_needs_nothing_from_outside(page):
    markup = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!data:)', markup) == []
    assert "@import" not in page.split("</style>")[0]
    assert "url(" not in page.split("</style>")[0]
    assert len(page) < 6_000_000


def test_page_says_what_the_posture_says(page, reclined):
    text = " ".join(re.sub(r"<[^>]+>", " ", page.split("<script>")[0]).split())
    backrest = next(w for w in reclined.wrenches if w.label == "backrest")
    assert (
        f"backrest {np.linalg.norm(backrest.force):.3g} {np.linalg.norm(backrest.moment):.3g}"
        in text
    )
    assert f"Strain energy {reclined.elastic_energy:.3g} J" in text
    assert "Backrest reclined 15°" in text
    assert "Certificate holds, residual" in text
    assert "force, N moment, N m" in text
    assert "buttocks–S1" in text


def test_page_holds_the_drawing(page, scene):
    commands = json.loads(re.search(r"const commands = (\[.*?\]);\n", page).group(1))
    paths = [umsgpack.unpackb(base64.b64decode(command))["path"] for command in commands]
    assert {f"/meshcat/{path}" for path in scene.objects} <= set(paths)


def test_title_is_only_text(reclined, tmp_path):
    problem = reclined.problem.model_copy(update={"title": "</script><script>alert(1)"})
    statement = replace(reclined.statement, problem=problem)
    write_view(replace(reclined, statement=statement), tmp_path / "view.html")
    assert "<script>alert(1)" not in (tmp_path / "view.html").read_text(encoding="utf-8")


def test_unwritable_place_is_told_and_left_alone(reclined, tmp_path):
    (tmp_path / "file").write_text("kept")
    with pytest.raises(UnwritableOutput):
        write_view(reclined, tmp_path / "file" / "view.html")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def with_visual(visual):
    """The shipped URDF with one shape in place of those of every link that has any."""
    robot = ET.parse(resource("urdf/seated_person.urdf")).getroot()
    for link in robot.iter("link"):
        shapes = link.findall("visual")
        for shape in shapes:
            link.remove(shape)
        if shapes and visual:
            link.append(ET.fromstring(f"<visual>{visual}</visual>"))
    return ET.tostring(robot, encoding="unicode")


@pytest.mark.parametrize(
    ("visual", "name"),
    [
        ('<geometry><box size="0.02 0.03 0.01"/></geometry>', "box_0"),
        ('<geometry><sphere radius="0.02"/></geometry>', "sphere_0"),
        (
            '<origin rpy="1 0 0"/><geometry><cylinder radius="0.02" length="0.1"/></geometry>',
            "cylinder_0",
        ),
        ('<geometry><mesh filename="own.obj" scale="2 2 2"/></geometry>', "own"),
        ('<geometry><mesh filename="package://mine/own.obj"/></geometry>', "own"),
        ('<geometry><mesh filename="meshes/disc.obj"/></geometry>', "disc"),
    ],
)
def test_own_urdf_shows_its_own_shapes(visual, name, tmp_path):
    (tmp_path / "own.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "own.urdf").write_text(with_visual(visual))
    scene = drawn(solved("reclined_15", urdf=tmp_path / "own.urdf"))
    assert f"person/L4/{name}" in scene.objects
    assert f"ghost/L4/{name}" in scene.objects


@pytest.mark.parametrize(
    "visual",
    [
        "",
        "<geometry/>",
        '<geometry><blob radius="1"/></geometry>',
        '<geometry><sphere radius="big"/></geometry>',
        "<geometry><sphere/></geometry>",
        '<geometry><mesh filename="gone.obj"/></geometry>',
        '<geometry><mesh filename="own.obj"/></geometry>',
        '<origin xyz="1 2"/><geometry><sphere radius="0.1"/></geometry>',
    ],
)
def test_body_without_readable_shapes_is_drawn_as_rods(visual, tmp_path):
    (tmp_path / "own.obj").write_text("v 0 0\nf 1 two 3\n")
    (tmp_path / "own.urdf").write_text(with_visual(visual))
    posture = solved("reclined_15", urdf=tmp_path / "own.urdf")
    scene = drawn(posture)
    assert "person/Head/head" in scene.objects
    assert len([path for path in scene.objects if "/rod_" in path]) > 25
    rod = next(look for look in looks_of(posture.body) if look.link == "L4")
    low, high = (rod.pose @ [0, y * rod.geometry.height / 2, 0, 1] for y in (-1, 1))
    joint = posture.body.model.getJointId("L3_L4_axial")
    frame = posture.body.model.frames[posture.body.model.getFrameId("L4")]
    end = frame.placement.inverse().act(posture.body.model.jointPlacements[joint].translation)
    assert np.allclose(high[:3], end)
    assert np.allclose(low[:3], frame.placement.inverse().translation)
