"""Writes `urdf/seated_person.urdf`, the reference subject, and its meshes."""

from __future__ import annotations

from posture_ik.body import build_body
from posture_ik.body.scaling import REFERENCE
from posture_ik.body.shapes import write_meshes
from posture_ik.resources import resource

if __name__ == "__main__":
    folder = resource("urdf")
    (folder / "seated_person.urdf").write_text(build_body(REFERENCE).urdf, encoding="utf-8")
    (folder / "meshes").mkdir(exist_ok=True)
    write_meshes(folder / "meshes")
