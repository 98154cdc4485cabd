"""What the links of a body look like: the visuals of its URDF as geometry for meshcat."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import meshcat.geometry as g
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.solids import Mesh, read_obj
from posture_ik.problem import SPINE
from posture_ik.resources import resource

#: Radius of the rod that stands for a bone where a URDF shows nothing, m.
_ROD = 0.012
_PALE = (0.80, 0.82, 0.84, 1.0)
_LOADERS = {".stl": g.StlMeshGeometry, ".dae": g.DaeMeshGeometry}


class Look(NamedTuple):
    """One shape on a link.

    Attributes:
        link: the link that carries it.
        name: its own name there, such as `lumbar`.
        geometry: meshcat's.
        pose: (4, 4), places and scales it in the link's frame, m.
        rgba: colour and opacity, 0 to 1.
    """

    link: str
    name: str
    geometry: g.Geometry
    pose: Array
    rgba: tuple[float, ...]


def looks_of(body: Body) -> list[Look]:
    """Every shape a body shows; rods from joint to joint where its URDF has none that can be read.

    Mesh files are looked for beside the subject's own URDF if there is one, then in the shipped
    `urdf/`.
    """
    robot = ET.fromstring(body.urdf)
    own = body.subject.urdf
    folders = [resource("urdf")] if own is None else [own.parent, resource("urdf")]
    palette = {
        str(material.get("name")): _numbers(colour.get("rgba"), _PALE)
        for material in robot.iter("material")
        if (colour := material.find("color")) is not None
    }
    found = []
    for link in robot.iter("link"):
        for number, visual in enumerate(link.iter("visual")):
            # What a person looks like is a courtesy: a shape that cannot be read is left out.
            with suppress(OSError, ValueError, IndexError):
                found.append(_look(str(link.get("name")), number, visual, palette, folders))
    return found or _rods(body.model)


def _look(
    link: str,
    number: int,
    visual: ET.Element,
    palette: Mapping[str, tuple[float, ...]],
    folders: Sequence[Path],
) -> Look:
    """Read one visual.

    Raises:
        OSError, ValueError, IndexError: it cannot be read.
    """
    shape = visual.find("geometry/*")
    if shape is None:
        raise ValueError("no geometry")
    turn, scale, name = np.eye(3), np.ones(3), f"{shape.tag}_{number}"
    if shape.tag == "mesh":
        path = _found(str(shape.get("filename")), folders)
        geometry, name = _read(path), path.stem
        scale = np.array(_numbers(shape.get("scale"), (1.0, 1.0, 1.0)))
    elif shape.tag == "box":
        geometry = g.Box(list(_numbers(shape.get("size"), ())))
    elif shape.tag == "sphere":
        geometry = g.Sphere(float(shape.get("radius", "")))
    elif shape.tag in ("cylinder", "capsule"):
        geometry = g.Cylinder(float(shape.get("length", "")), float(shape.get("radius", "")))
        turn = pin.utils.rotate("x", np.pi / 2)  # meshcat's stand along y
    else:
        raise ValueError(f"no shape is called {shape.tag}")
    origin, pose = visual.find("origin"), np.eye(4)
    if origin is not None:
        pose[:3, :3] = pin.rpy.rpyToMatrix(*_numbers(origin.get("rpy"), (0.0, 0.0, 0.0)))
        pose[:3, 3] = _numbers(origin.get("xyz"), (0.0, 0.0, 0.0))
    pose[:3, :3] = pose[:3, :3] @ turn @ np.diag(scale)
    material = visual.find("material")
    rgba = _PALE if material is None else palette.get(str(material.get("name")), _PALE)
    return Look(link, name, geometry, pose, rgba)


def _found(filename: str, folders: Sequence[Path]) -> Path:
    """The file a mesh's name stands for: `package://name/` starts at the folder too."""
    plain = re.sub(r"^(package://[^/]+/|file://)", "", filename)
    for folder in folders:
        if (folder / plain).is_file():
            return folder / plain
    raise FileNotFoundError(filename)


def _read(path: Path) -> g.Geometry:
    """Geometry of a mesh file; OBJ as shared vertices, which shade smoothly."""
    if path.suffix.lower() in _LOADERS:
        return _LOADERS[path.suffix.lower()].from_file(str(path))
    return g.TriangularMeshGeometry(*_mesh(path, path.stat().st_mtime))


@lru_cache(maxsize=128)
def _mesh(path: Path, _changed: float) -> Mesh:
    return read_obj(path)


def _rods(model: pin.Model) -> list[Look]:
    """A ball for the head, and a rod from every joint to the next, on the link between."""
    shown = [Look("Head", "head", g.Sphere(0.09), np.eye(4), _PALE)]
    for joint in range(2, model.njoints):
        end = np.array(model.jointPlacements[joint].translation)
        length = float(np.linalg.norm(end))
        links = [
            frame
            for frame in model.frames
            if frame.type == pin.FrameType.BODY and frame.parentJoint == model.parents[joint]
        ]
        if length > 1e-3 and links:
            link = next((frame for frame in links if frame.name in SPINE), links[0])
            pose = np.eye(4)
            pose[:3, :3] = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), end).matrix()
            pose[:3, 3] = end / 2
            pose = link.placement.inverse().homogeneous @ pose
            shown.append(Look(link.name, f"rod_{joint}", g.Cylinder(length, _ROD), pose, _PALE))
    return shown


def _numbers(text: str | None, default: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(float(word) for word in text.split()) if text else default
