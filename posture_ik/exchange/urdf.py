"""The body as a URDF with its meshes beside it, as any robotics program opens it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from posture_ik.body import Body
from posture_ik.resources import resource


def write_urdf(body: Body, path: Path) -> None:
    """Write a body's URDF to `path`, and the meshes it names to the folder `meshes` beside it."""
    path.write_text(body.urdf, encoding="utf-8")
    shipped = resource("urdf")
    for name in sorted(set(re.findall(r'filename="(meshes/[^"]+)"', body.urdf))):
        if (shipped / name).exists():
            (path.parent / name).parent.mkdir(exist_ok=True)
            shutil.copyfile(shipped / name, path.parent / name)
