"""A URDF of one's own: the shipped file in step with the code, and every fault in one sentence."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body
from posture_ik.body.scaling import REFERENCE
from posture_ik.errors import BadURDF
from posture_ik.problem import Subject
from posture_ik.resources import resource

SHIPPED = "urdf/seated_person.urdf"


@pytest.fixture(scope="module")
def text():
    return build_body(REFERENCE).urdf


def same(ours, theirs):
    """Alike but for the last digits that another machine may round differently."""
    assert (ours.tag, len(ours)) == (theirs.tag, len(theirs))
    assert ours.attrib.keys() == theirs.attrib.keys()
    for key, value in ours.attrib.items():
        words, others = value.split(), theirs.attrib[key].split()
        try:
            numbers = np.array([words, others], float)
        except ValueError:
            assert words == others
        else:
            np.testing.assert_allclose(numbers[0], numbers[1], rtol=1e-9, atol=1e-12)
    for child, other in zip(ours, theirs, strict=True):
        same(child, other)


def test_shipped_file_is_in_step(text):
    """If this fails, run `python -m posture_ik.body` and look at what changed."""
    same(ET.fromstring(text), ET.fromstring(resource(SHIPPED).read_text(encoding="utf-8")))


def test_meshes_it_names_are_shipped(text):
    for mesh in set(re.findall(r'filename="([^"]+)"', text)):
        assert resource(f"urdf/{mesh}").stat().st_size > 0


def test_pinocchio_loads_the_shipped_file_itself():
    model = pin.buildModelFromUrdf(str(resource(SHIPPED)))
    assert model.nv == 117


def test_own_file_gives_the_same_body(text):
    built, read = build_body(REFERENCE), build_body(REFERENCE, resource(SHIPPED))
    named = build_body(Subject(urdf=resource(SHIPPED)))
    for other in (read, named):
        assert other.dofs == built.dofs
        np.testing.assert_array_equal(other.stiffness, built.stiffness)
        np.testing.assert_allclose(other.q_reference, built.q_reference)
        np.testing.assert_allclose(other.upper, built.upper)
        np.testing.assert_allclose(
            pin.computeTotalMass(other.model), pin.computeTotalMass(built.model)
        )


def test_extra_fixed_links_and_other_elements_are_welcome(text, tmp_path):
    more = '<link name="helmet"/><joint name="on" type="fixed"><parent link="Head"/>'
    more += '<child link="helmet"/></joint><transmission name="t"/></robot>'
    path = tmp_path / "own.urdf"
    path.write_text("\ufeff" + text.replace("</robot>", more), encoding="utf-8")
    assert build_body(REFERENCE, path).model.existFrame("helmet")


def test_arms_may_be_left_out(text, tmp_path):
    robot = ET.fromstring(text)
    gone = {"seat"}
    arm = re.compile(r"(shoulder|elbow|pronation|wrist|humerus|ulna|radius|hand|grip)_")
    for element in list(robot):
        if arm.match(element.get("name", "")):
            robot.remove(element)
            gone.add(element.get("name"))
    path = tmp_path / "armless.urdf"
    path.write_text(ET.tostring(robot, encoding="unicode"), encoding="utf-8")
    body = build_body(REFERENCE, path)
    assert body.model.nv == 103
    assert len(body.stiffness) == 103


JOINT = re.compile(r'<joint name="L4_L5_rx".*?</joint>', re.S)
LINK = re.compile(r'<link name="L4">.*?</link>', re.S)


def in_joint(before, after):
    """Change something in the joint L4_L5_rx."""

    def change(text):
        old = JOINT.search(text)[0]
        new = re.sub(before, after, old, flags=re.S)
        assert new != old
        return text.replace(old, new)

    return change


def in_link(before, after):
    """Change something in the link L4."""

    def change(text):
        old = LINK.search(text)[0]
        new = re.sub(before, after, old, count=1, flags=re.S)
        assert new != old
        return text.replace(old, new)

    return change


def end(more):
    return lambda text: text.replace("</robot>", f"{more}</robot>")


def joint(name, kind="fixed", parent="seat", child="extra", inside=""):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


EXTRA = '<link name="extra"/>'
BAD = {
    "empty": (lambda text: " \n", "the file is empty"),
    "not XML": (lambda text: "solid cube", "this is not XML"),
    "cut short": (lambda text: text[: len(text) // 2], "this is not XML"),
    "another XML": (lambda text: "<sdf/>", "the outermost element is <sdf>"),
    "no links": (lambda text: "<robot name='r'/>", "no link called 'Head'"),
    "no head": (lambda text: text.replace('"Head"', '"Kopf"'), "no link called 'Head'"),
    "no vertebra": (lambda text: text.replace('"T7"', '"Th7"'), "no link called 'T7'"),
    "loop": (end(joint("again", parent="T1", child="Head")), "closed loop"),
    "ring": (
        end(
            '<link name="a"/><link name="b"/>'
            + joint("ab", parent="a", child="b")
            + joint("ba", parent="b", child="a")
        ),
        "hangs on itself",
    ),
    "two roots": (end(EXTRA), "2 roots (extra, seat)"),
    "joint missing": (
        lambda text: text.replace("L4_L5_ry", "L4_L5_ryy"),
        "did you mean 'L4_L5_ry'",
    ),
    "joint fixed": (
        in_joint('type="revolute"', 'type="fixed"'),
        "the spine joint 'L4_L5_rx' is missing",
    ),
    "unknown joint": (end(EXTRA + joint("knee_flexion_r", "revolute")), "'knee_flexion_r' is not"),
    "wrong type": (in_joint("revolute", "prismatic"), "must be revolute"),
    "continuous": (in_joint("revolute", "continuous"), "must be revolute"),
    "no type": (in_joint(' type="revolute"', ""), "of type ''"),
    "no parent": (in_joint("<parent.*?/>", ""), "both a parent and a child"),
    "unknown parent": (in_joint('parent link="', 'parent link="un'), "did you mean"),
    "unnamed link": (end("<link/>"), "a link has no name"),
    "link twice": (end('<link name="L4"/>'), "two links are called 'L4'"),
    "joint twice": (end(EXTRA + joint("L4_node")), "two joints are called 'L4_node'"),
    "no limit": (in_joint("<limit.*?/>", ""), "has no limit"),
    "no lower": (in_joint('lower="[^"]*"', ""), "lacks 'lower'"),
    "limits crossed": (in_joint('lower="[^"]*"', 'lower="1.5"'), "lies above its upper limit"),
    "limit NaN": (in_joint('upper="[^"]*"', 'upper="nan"'), "'nan', not a finite number"),
    "limit a word": (in_joint('upper="[^"]*"', 'upper="${up}"'), "not a finite number"),
    "reference outside": (
        in_joint('lower="[^"]*"', 'lower="0.01"'),
        "leave out its reference value",
    ),
    "no axis": (in_joint('axis xyz="[^"]*"', 'axis xyz="0 0 0"'), "no direction"),
    "axis of two": (in_joint('axis xyz="[^"]*"', 'axis xyz="1 0"'), "not three numbers"),
    "origin infinite": (in_joint('rpy="[^"]*"', 'rpy="0 inf 0"'), "not a finite number"),
    "damping negative": (in_joint('damping="', 'damping="-'), "damping of joint"),
    "mimic": (in_joint("</joint>", '<mimic joint="L3_L4_rx"/></joint>'), "mimics"),
    "no mass": (in_link("<mass[^>]*>", ""), "lacks its mass"),
    "mass zero": (in_link('mass value="[^"]*"', 'mass value="0"'), "must be positive"),
    "mass negative": (in_link('mass value="', 'mass value="-'), "must be positive"),
    "mass NaN": (in_link('mass value="[^"]*"', 'mass value="NaN"'), "not a finite number"),
    "inertia negative": (in_link('ixx="', 'ixx="-'), "negative about an axis"),
    "inertia missing": (in_link('iyz="[^"]*"', ""), "lacks 'iyz'"),
}


@pytest.mark.parametrize("fault", BAD)
def test_a_fault_is_told_in_one_sentence(text, tmp_path, capfd, fault):
    change, told = BAD[fault]
    path = tmp_path / "own.urdf"
    path.write_text(change(text), encoding="utf-8")
    with pytest.raises(BadURDF) as error:
        build_body(REFERENCE, path)
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    assert told in message
    assert "\n" not in message
    assert message[-1] in ".?"
    assert capfd.readouterr() == ("", "")


def test_no_file(tmp_path):
    with pytest.raises(BadURDF, match="no such file"):
        build_body(REFERENCE, tmp_path / "none.urdf")


def test_a_folder(tmp_path):
    with pytest.raises(BadURDF, match="cannot be read"):
        build_body(REFERENCE, tmp_path)


def test_a_picture(tmp_path):
    path = tmp_path / "own.urdf"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    with pytest.raises(BadURDF, match="not a text file"):
        build_body(REFERENCE, path)
