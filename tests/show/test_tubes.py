"""What the 3D page is given of the muscles: where they run and how active, at each instant."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from posture_ik.muscle import Activity
from posture_ik.show import write_view
from posture_ik.show.tubes import along, tubes


def unpacked(text: str, kind: str, *shape: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind).reshape(shape)


def test_points_lie_along_the_paths(raising: Activity) -> None:
    """To half a grain, 0.05 mm, at the ends; between them on the path's own broken line."""
    given = tubes(raising)
    time = unpacked(given["time"], "<f4", -1)
    points = given["grain"] * unpacked(given["points"], "<i2", len(time), 50, given["count"], 3)
    assert (time[0], time[-1]) == (0.0, 2.0)
    for frame in (0, len(time) // 2):
        step = int(np.argmin(np.abs(raising.time - time[frame])))
        for line, drawn in zip(
            raising.paths.polylines(raising.q[step]), points[frame], strict=True
        ):
            np.testing.assert_allclose(drawn[[0, -1]], line[[0, -1]], atol=5.1e-5)
            np.testing.assert_allclose(drawn, along(line), atol=5.1e-5)


def test_points_are_evenly_spaced() -> None:
    line = np.array([[0.0, 0, 0], [0.03, 0, 0], [0.03, 0.04, 0], [0.03, 0.04, 0.12]])
    points = along(line, 20)
    assert points[3] == pytest.approx([0.03, 0, 0])  # 0.19 m in steps of 0.01 m
    assert points[7] == pytest.approx([0.03, 0.04, 0])
    assert points[-1] == pytest.approx(line[-1])


def test_colours_are_of_the_instant(raising: Activity) -> None:
    given = tubes(raising)
    time = unpacked(given["time"], "<f4", -1)
    steps = [int(np.argmin(np.abs(raising.time - t))) for t in time]
    shown = unpacked(given["activation"], "<f4", len(time), 50)
    np.testing.assert_allclose(shown, raising.activation[steps], atol=1e-7)
    assert given["names"][0] == "right anterior deltoid"
    assert given["names"][25] == "left anterior deltoid"


def test_page_holds_the_muscles_and_stays_small(raising: Activity, tmp_path: Path) -> None:
    write_view(raising.shown, tmp_path / "bare.html")
    write_view(raising.shown, tmp_path / "view.html", raising)
    bare, page = ((tmp_path / name).read_text("utf-8") for name in ("bare.html", "view.html"))
    assert "const muscles = null;" in bare
    assert 'data-layer="muscles"' not in bare
    assert 'data-layer="muscles"' in page
    given = json.loads(re.search(r"const muscles = (\{.*?\});\n", page)[1])
    assert given["points"] == tubes(raising)["points"]
    assert len(page) - len(bare) < 2_000_000
