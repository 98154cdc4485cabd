"""The 3D page as a browser without network shows it, and as meshcat's server serves it."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page

from posture_ik.body import build_body
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_view

SERVER = """
from posture_ik.body import build_body
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import view
problem = load_problem("upright")
view(solve_posture(build_body(problem.subject), problem), browse=False)
"""
#: Middle of what is drawn of L3, in pixels of the window.
MIDDLE_OF_L3 = """
() => {
  const middle = object("person/L3").getWorldPosition(new THREE.Vector3());
  const [x, y] = on_screen(viewer.scene.worldToLocal(middle));
  const frame = pane.getBoundingClientRect();
  return [x + frame.left, y + frame.top];
}
"""


@pytest.fixture(scope="module")
def view(tmp_path_factory: pytest.TempPathFactory) -> Path:
    problem = load_problem("reclined_15")
    path = tmp_path_factory.mktemp("view") / "view.html"
    write_view(solve_posture(build_body(problem.subject), problem), path)
    return path


def picture(page: Page) -> np.ndarray:
    """The canvas, (rows, columns, 3), once it has been drawn anew."""
    page.evaluate("() => new Promise(done => { viewer.render(); requestAnimationFrame(done); })")
    shot = page.locator("#pane").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), float)


def test_view_opens_offline_and_answers(view: Path, page: Page, console_errors: list[str]) -> None:
    page.goto(view.as_uri())
    pictures = {}
    for name in ("side", "front", "quarter"):
        page.locator(f"[data-view={name}]").click()
        pictures[name] = picture(page)
        assert pictures[name].std() > 15.0, "the canvas is blank"
    assert np.abs(pictures["side"] - pictures["front"]).mean() > 3.0

    page.locator("[data-view=reset]").click()
    whole = picture(page)
    assert np.abs(whole - pictures["side"]).mean() < 0.5
    for layer in ("ghost", "forces", "ribs", "skin"):
        page.locator(f"[data-layer={layer}]").uncheck()
        bare = picture(page)
        assert np.abs(whole - bare).mean() > 0.05, f"{layer} cannot be hidden"
        whole = bare
    assert page.locator("#labels span").count() == 3
    assert not page.locator("#labels").is_visible()

    page.mouse.move(*page.evaluate(MIDDLE_OF_L3))
    assert page.locator("#tip").is_visible()
    assert "L3–L4" in page.locator("#tip").inner_text()
    assert "flexion" in page.locator("#tip").inner_text()
    assert console_errors == []


def test_view_fits_a_phone(view: Path, page: Page, console_errors: list[str]) -> None:
    page.set_viewport_size({"width": 390, "height": 800})
    page.goto(view.as_uri())
    assert picture(page).std() > 15.0
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for label in page.locator("#labels span").all():
        box = label.bounding_box()
        assert box is not None
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= 390.0
    assert page.locator(".dg.main").is_hidden()
    assert console_errors == []


def test_served_view_shows_the_same(browser: Browser) -> None:
    server = subprocess.Popen(
        [sys.executable, "-u", "-c", SERVER],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert server.stdout is not None
        line = next(line for line in server.stdout if "/posture" in line)
        page = browser.new_page()
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(next(word for word in line.split() if word.startswith("http")))
        page.wait_for_function("viewer.num_messages_received > 300", timeout=20_000)
        assert picture(page).std() > 15.0
        assert errors == []
        page.close()
    finally:
        server.terminate()
        server.wait()
