"""Writes a body as a URDF."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple
from xml.etree import ElementTree as ET

from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.parts import Inertia, Vector

#: URDF demands limits of effort and speed, which nothing here reads: a human's are not known so.
_EFFORT, _VELOCITY = "100000", "100"


class Visual(NamedTuple):
    """A shape on a link.

    Attributes:
        link: Link that carries it.
        mesh: File, relative to the URDF, such as `"meshes/disc.obj"`.
        scale: Factors along the mesh's own axes.
        xyz: The mesh's origin in the link's frame, m.
        rpy: Its rotation there, about fixed x, y, z, rad.
        rgba: Colour and opacity, 0 to 1.
    """

    link: str
    mesh: str
    scale: Vector = (1.0, 1.0, 1.0)
    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    rgba: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)


def write_urdf(geometry: BodyGeometry, visuals: Sequence[Visual] = ()) -> str:
    """The URDF of a body, as text; numbers in full, so that a reader gets the very same body.

    Args:
        geometry: The body.
        visuals: Shapes to hang on its links.
    """
    robot = ET.Element("robot", name="seated_person")
    for link in ("seat", *(joint.child for joint in geometry.joints)):
        element = ET.SubElement(robot, "link", name=link)
        if link in geometry.inertias:
            _inertial(element, geometry.inertias[link])
        for visual in visuals:
            if visual.link == link:
                _visual(element, visual)
    for joint in geometry.joints:
        element = ET.SubElement(robot, "joint", name=joint.name, type=joint.kind)
        ET.SubElement(element, "parent", link=joint.parent)
        ET.SubElement(element, "child", link=joint.child)
        ET.SubElement(element, "origin", xyz=_text(joint.xyz), rpy=_text(joint.rpy))
        if joint.kind != "fixed":
            ET.SubElement(element, "axis", xyz=_text(joint.axis))
            ET.SubElement(element, "dynamics", damping=repr(geometry.damping[joint.name]))
            ET.SubElement(
                element,
                "limit",
                lower=repr(geometry.lower[joint.name]),
                upper=repr(geometry.upper[joint.name]),
                effort=_EFFORT,
                velocity=_VELOCITY,
            )
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _inertial(link: ET.Element, inertia: Inertia) -> None:
    element = ET.SubElement(link, "inertial")
    ET.SubElement(element, "origin", xyz=_text(inertia.centre), rpy="0 0 0")
    ET.SubElement(element, "mass", value=repr(inertia.mass))
    entries = {
        f"i{a}{b}": repr(float(inertia.tensor[i, j]) + 0.0)
        for i, a in enumerate("xyz")
        for j, b in enumerate("xyz")
        if i <= j
    }
    ET.SubElement(element, "inertia", entries)


def _visual(link: ET.Element, visual: Visual) -> None:
    element = ET.SubElement(link, "visual")
    ET.SubElement(element, "origin", xyz=_text(visual.xyz), rpy=_text(visual.rpy))
    shape = ET.SubElement(element, "geometry")
    ET.SubElement(shape, "mesh", filename=visual.mesh, scale=_text(visual.scale))
    material = ET.SubElement(element, "material", name="_".join(f"{c:g}" for c in visual.rgba))
    ET.SubElement(material, "color", rgba=_text(visual.rgba))


def _text(values: Iterable[float]) -> str:
    """Numbers as URDF lists them, each in the shortest form that reads back the same."""
    return " ".join(repr(float(value)) for value in values)
