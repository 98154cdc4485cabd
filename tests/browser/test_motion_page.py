"""The pages of a motion as a browser without network shows them, and as meshcat serves them."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page

from posture_ik.body import build_body
from posture_ik.posture import Motion, move
from posture_ik.problem import load_problem
from posture_ik.show import write_motion_report, write_view

SERVER = """
from posture_ik.body import build_body
from posture_ik.posture import move
from posture_ik.problem import load_problem
from posture_ik.show import view
problem = load_problem("recline_sweep", ("motion.rate=2",))
view(move(build_body(problem.subject), problem), browse=False)
"""
PLACE_OF_HEAD = "object('person/Head').position.toArray()"
BACKMOST_SKIN = "Math.min(...object('skin/<object>').geometry.attributes.position.array)"


@pytest.fixture(scope="module")
def sweep() -> Motion:
    problem = load_problem("recline_sweep", ("motion.rate=10",))
    return move(build_body(problem.subject), problem)


@pytest.fixture(scope="module")
def view(sweep: Motion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("view") / "view.html"
    write_view(sweep, path)
    return path


def picture(page: Page) -> np.ndarray:
    """The canvas, (rows, columns, 3), once it has been drawn anew."""
    page.evaluate("() => new Promise(done => { viewer.render(); requestAnimationFrame(done); })")
    shot = page.locator("#pane").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), float)


def scrub(page: Page, time: float) -> None:
    page.locator("#scrub").evaluate(
        "(bar, time) => { bar.value = time; bar.dispatchEvent(new Event('input')); }", time
    )


def test_motion_starts_paused_and_can_be_scrubbed(
    view: Path, sweep: Motion, page: Page, console_errors: list[str]
) -> None:
    page.goto(view.as_uri())
    assert page.locator("#told").inner_text() == "0.00 s"
    page.wait_for_timeout(150)
    assert page.locator("#told").inner_text() == "0.00 s", "it starts paused"
    start, skin = picture(page), page.evaluate(BACKMOST_SKIN)
    for step in (0, 7, 20):
        scrub(page, sweep.time[step])
        expected = sweep.postures[step].frames["Head"].translation
        assert page.evaluate(PLACE_OF_HEAD) == pytest.approx(expected, abs=1e-5)
        shown = page.locator("#loads tbody tr").first.inner_text().split()
        force = np.linalg.norm(sweep.forces[step, 0])
        assert float(shown[1]) == pytest.approx(force, rel=6e-3)
    assert page.locator("#told").inner_text() == "2.00 s"
    assert np.abs(picture(page) - start).mean() > 2.0
    assert page.evaluate(BACKMOST_SKIN) < skin - 0.1, "the skin lies back with the trunk"
    assert page.locator("#labels span:visible").count() == 3

    halfway = (sweep.time[7] + sweep.time[8]) / 2
    scrub(page, halfway)
    ends = [sweep.postures[step].frames["Head"].translation for step in (7, 8)]
    assert page.evaluate(PLACE_OF_HEAD) == pytest.approx(np.mean(ends, axis=0), abs=1e-5)
    assert console_errors == []


def test_motion_plays_loops_and_answers_keys(
    view: Path, page: Page, console_errors: list[str]
) -> None:
    page.goto(view.as_uri())
    page.locator("#speed").select_option("2")
    page.locator("#play").click()
    assert page.locator("#play").get_attribute("aria-label") == "Pause"
    page.wait_for_function("clock > 0.2", timeout=20_000)
    scrub(page, 1.9)
    assert page.locator("#play").get_attribute("aria-label") == "Play", "a hand on the bar stops it"
    page.locator("#scrub").press(" ")
    page.wait_for_function("clock < 1", timeout=20_000)
    page.keyboard.press(" ")
    assert page.locator("#play").get_attribute("aria-label") == "Play"

    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.locator("#told").inner_text() == "0.20 s"
    page.keyboard.press("Shift+ArrowRight")
    assert page.locator("#told").inner_text() == "1.20 s"
    page.keyboard.press("ArrowLeft")
    assert page.locator("#told").inner_text() == "1.10 s"
    page.keyboard.press("End")
    assert page.locator("#told").inner_text() == "2.00 s"
    assert console_errors == []


def test_paths_and_forces_can_be_hidden(view: Path, page: Page, console_errors: list[str]) -> None:
    page.goto(view.as_uri())
    scrub(page, 1.0)
    whole = picture(page)
    assert page.locator("#ways .done").count() == 3
    assert page.locator("#ways text:visible").count() >= 4
    page.locator("[data-layer=ways]").uncheck()
    assert not page.locator("#ways").is_visible()
    page.locator("[data-layer=forces]").uncheck()
    assert np.abs(picture(page) - whole).mean() > 0.05
    scrub(page, 1.5)
    assert not page.locator("#labels").is_visible(), "what is hidden stays hidden"
    assert page.evaluate("object('forces').visible") is False
    assert console_errors == []


def test_motion_fits_a_phone(view: Path, page: Page, console_errors: list[str]) -> None:
    page.set_viewport_size({"width": 390, "height": 800})
    page.goto(view.as_uri())
    scrub(page, 1.5)
    assert picture(page).std() > 15.0
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for part in ("#play", "#scrub", "#told", "#speed"):
        box = page.locator(part).bounding_box()
        assert box is not None
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= 390.0
    assert console_errors == []


def test_served_motion_can_be_scrubbed(browser: Browser) -> None:
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
        start = page.evaluate(PLACE_OF_HEAD)
        scrub(page, 2.0)
        assert page.evaluate(PLACE_OF_HEAD)[0] < start[0] - 0.2
        assert picture(page).std() > 15.0
        assert errors == []
        page.close()
    finally:
        server.terminate()
        server.wait()


def test_motion_report_opens_offline_and_answers(
    sweep: Motion, page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    write_motion_report(sweep, tmp_path / "motion.html")
    page.goto((tmp_path / "motion.html").as_uri())
    for name in ("way_side", "way_top", "speed", "residual", "angle", "torque", "force", "moment"):
        assert page.locator(f"#{name} .scatterlayer .js-line").count() >= 3, name
    angle = page.locator("#angle .legendtext")
    assert "Head–C1" in angle.all_text_contents()
    page.get_by_role("button", name="Lumbar and seat").click()
    assert "L4–L5" in angle.all_text_contents()
    assert page.locator("#angle .js-line").count() <= 12
    page.get_by_role("button", name="Stretch").click()
    assert "mm" in page.locator("#angle .ytitle").text_content()
    page.get_by_role("button", name="Thoracic").click()
    pressed = page.locator("#turn [aria-pressed=true]")
    assert pressed.inner_text() == "Stretch", "a choice stays where it can"
    page.get_by_role("button", name="seat", exact=True).click()
    assert page.locator("#force .legendtext").all_text_contents() == ["x", "y", "z", "size"]
    for width, height in ((1280, 720), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert console_errors == []
