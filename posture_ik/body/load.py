"""Reads a URDF into Pinocchio, once it is known to be a seated person of this package's naming.

All that the model needs is checked here and handed on in a bare copy without shapes, its numbers
written anew, so that a fault is told in one sentence naming the place, and never by the parser
underneath.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

from posture_ik.body.geometry import DOFS
from posture_ik.body.spine import SPINE_DOFS
from posture_ik.errors import BadURDF, nearest
from posture_ik.problem import SPINE


def read_urdf(path: Path) -> str:
    """A URDF file's text.

    Raises:
        BadURDF: If there is no such file, or it is not text.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise BadURDF(path, "there is no such file.") from None
    except UnicodeDecodeError:
        raise BadURDF(path, "this is not a text file; a URDF is XML in UTF-8.") from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise BadURDF(path, f"the file cannot be read ({reason}).") from None


def load_model(text: str, where: Path | str) -> pin.Model:
    """The Pinocchio model of a URDF.

    Args:
        text: The URDF.
        where: Where it came from, for messages.

    Raises:
        BadURDF: If it is not a tree with the spine joints of this package, or any number in it is
            not one a body can have.
    """
    try:
        model = pin.buildModelFromXML(ET.tostring(_checked(text), encoding="unicode"))
    except _Fault as fault:
        raise BadURDF(where, str(fault)) from None
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split()).rstrip(".")
        raise BadURDF(where, f"Pinocchio cannot build a model from it ({reason}).") from None
    return model


class _Fault(Exception):
    """What is wrong, before it is known in which file."""


def _checked(text: str) -> ET.Element:
    if not text.strip():
        raise _Fault("the file is empty.")
    try:
        robot = ET.fromstring(text)
    except ET.ParseError as error:
        raise _Fault(f"this is not XML ({error}).") from None
    if robot.tag != "robot":
        raise _Fault(f"the outermost element is <{robot.tag}>; a URDF's is <robot>.")
    bare = ET.Element("robot", name=robot.get("name", "seated_person"))
    links, joints = robot.findall("link"), robot.findall("joint")
    for kind, elements in (("link", links), ("joint", joints)):
        _names_unique(kind, [element.get("name", "") for element in elements])
    bare.extend([_link(link) for link in links])
    bare.extend([_joint(joint) for joint in joints])
    _tree({link.get("name", "") for link in links}, joints)
    _seated_person([link.get("name", "") for link in links], joints)
    return bare


def _names_unique(kind: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if not name.strip():
            raise _Fault(f"a {kind} has no name.")
        if name in seen:
            raise _Fault(f"two {kind}s are called {name!r}.")
        seen.add(name)


def _link(link: ET.Element) -> ET.Element:
    """A link's mass alone."""
    name = f"link {link.get('name')!r}"
    bare = ET.Element("link", name=link.get("name", ""))
    inertial = link.find("inertial")
    if inertial is None:
        return bare
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        raise _Fault(f"the inertial of {name} lacks its mass or its inertia.")
    if (kilograms := _number(mass, "value", name)) <= 0.0:
        raise _Fault(f"the mass of {name} is {kilograms:g} kg; a mass must be positive.")
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    xx, xy, xz, yy, yz, zz = entries = [_number(inertia, entry, name) for entry in names]
    least = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))[0]
    if least < -1e-9:
        raise _Fault(f"the inertia of {name} is negative about an axis ({least:.3g} kg m²).")
    part = ET.SubElement(bare, "inertial")
    part.append(_origin(inertial, name))
    ET.SubElement(part, "mass", value=repr(kilograms))
    ET.SubElement(part, "inertia", dict(zip(names, map(repr, entries), strict=True)))
    return bare


def _joint(joint: ET.Element) -> ET.Element:
    """A joint's kind, place, axis, limits and damping alone."""
    name, kind = joint.get("name", ""), joint.get("type", "")
    said = f"joint {name!r}"
    ends = [joint.find(end) for end in ("parent", "child")]
    if any(end is None or not end.get("link") for end in ends):
        raise _Fault(f"{said} does not name both a parent and a child link.")
    if kind != "fixed":
        if name not in DOFS:
            raise _Fault(f"movable {said} is not in a seated person; {nearest(name, DOFS)}")
        wanted = "prismatic" if name.endswith("_axial") else "revolute"
        if kind != wanted:
            raise _Fault(f"{said} is of type {kind!r}; it must be {wanted}.")
        if joint.find("mimic") is not None:
            raise _Fault(f"{said} mimics another joint; every joint must move by itself.")
    bare = ET.Element("joint", name=name, type=kind)
    bare.extend([end for end in ends if end is not None])
    bare.append(_origin(joint, said))
    if kind == "fixed":
        return bare
    axis = joint.find("axis")
    if axis is not None:
        direction = _triple(axis, "xyz", said)
        length = math.hypot(*direction)
        if length < 1e-9:
            raise _Fault(f"the axis of {said} has no direction.")
        ET.SubElement(bare, "axis", xyz=_text([value / length for value in direction]))
    bare.append(_limit(joint, said))
    dynamics = joint.find("dynamics")
    if dynamics is not None and "damping" in dynamics.attrib:
        damping = _number(dynamics, "damping", said)
        if damping < 0.0:
            raise _Fault(f"the damping of {said} is negative.")
        ET.SubElement(bare, "dynamics", damping=repr(damping))
    return bare


def _limit(joint: ET.Element, said: str) -> ET.Element:
    limit = joint.find("limit")
    if limit is None:
        raise _Fault(f"{said} has no limit.")
    lower, upper = (_number(limit, end, said) for end in ("lower", "upper"))
    if lower > upper:
        raise _Fault(f"the lower limit {lower:g} of {said} lies above its upper limit {upper:g}.")
    # A URDF must bound effort and velocity too, but nothing here reads those.
    return ET.Element("limit", lower=repr(lower), upper=repr(upper), effort="0", velocity="0")


def _origin(element: ET.Element, said: str) -> ET.Element:
    origin = element.find("origin")
    if origin is None:
        return ET.Element("origin")
    parts = [part for part in ("xyz", "rpy") if part in origin.attrib]
    return ET.Element("origin", {part: _text(_triple(origin, part, said)) for part in parts})


def _text(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))


def _number(element: ET.Element, attribute: str, said: str) -> float:
    text = element.get(attribute)
    if text is None:
        raise _Fault(f"<{element.tag}> of {said} lacks {attribute!r}.")
    return _finite(text, element.tag, attribute, said)


def _triple(element: ET.Element, attribute: str, said: str) -> list[float]:
    text = element.get(attribute, "")
    values = [_finite(word, element.tag, attribute, said) for word in text.split()]
    if len(values) != 3:
        raise _Fault(f"{attribute!r} in <{element.tag}> of {said} is {text!r}, not three numbers.")
    return values


def _finite(text: str, tag: str, attribute: str, said: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _Fault(f"{attribute!r} in <{tag}> of {said} is {text!r}, not a finite number.")
    return value


def _tree(links: set[str], joints: Iterable[ET.Element]) -> None:
    """Every link hangs on one other but for a single root, and none on itself."""
    parents: dict[str, str] = {}
    for joint in joints:
        parent, child = (
            "" if end is None else end.get("link", "")
            for end in (joint.find("parent"), joint.find("child"))
        )
        for link in (parent, child):
            if link not in links:
                raise _Fault(
                    f"joint {joint.get('name')!r} names a link {link!r} that is not there; "
                    f"{nearest(link, links)}"
                )
        if child in parents:
            raise _Fault(
                f"link {child!r} hangs on both {parents[child]!r} and {parent!r}: a closed loop, "
                f"which a URDF cannot have."
            )
        parents[child] = parent
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        raise _Fault(f"there are {len(roots)} roots ({', '.join(roots[:4])}); a body has one.")
    for link in links:
        seen = {link}
        while link in parents:
            link = parents[link]
            if link in seen:
                raise _Fault(f"link {link!r} hangs on itself in the end: a closed loop.")
            seen.add(link)


def _seated_person(links: list[str], joints: Iterable[ET.Element]) -> None:
    if "Head" not in links:
        raise _Fault("there is no link called 'Head'.")
    for link in SPINE:
        if link not in links:
            raise _Fault(f"there is no link called {link!r}, a vertebra of the spine.")
    movable = {joint.get("name") for joint in joints if joint.get("type") != "fixed"}
    for dof in SPINE_DOFS:
        if dof not in movable:
            raise _Fault(f"the spine joint {dof!r} is missing.")
