"""A person's URDF without its arms, for tests."""

from __future__ import annotations

from xml.etree import ElementTree as ET


def without_arms(urdf: str) -> str:
    """The same without what hangs on the shoulders."""
    robot = ET.fromstring(urdf)
    gone = {"shoulder_flexion_r_link", "shoulder_flexion_l_link"}
    joints = {joint.find("child").get("link"): joint for joint in robot.iterfind("joint")}
    while True:
        more = {child for child, j in joints.items() if j.find("parent").get("link") in gone} - gone
        if not more:
            break
        gone |= more
    for link in [link for link in robot.iterfind("link") if link.get("name") in gone]:
        robot.remove(link)
        robot.remove(joints[link.get("name")])
    return ET.tostring(robot, encoding="unicode")
