"""The pages of a reach as a browser without network shows them."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from posture_ik.body import build_body
from posture_ik.posture import Trajectory, reach
from posture_ik.problem import load_problem
from posture_ik.show import write_motion_report, write_view


@pytest.fixture(scope="module")
def found() -> Trajectory:
    problem = load_problem("reach_collective")
    return reach(build_body(problem.subject), problem)


def scrub(page: Page, time: float) -> None:
    page.locator("#scrub").evaluate(
        "(bar, time) => { bar.value = time; bar.dispatchEvent(new Event('input')); }", time
    )


def test_hand_is_taken_to_the_lever(
    found: Trajectory, page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    write_view(found, tmp_path / "view.html")
    page.goto((tmp_path / "view.html").as_uri())
    place = "object('{}').position.toArray()"
    lever = page.evaluate(place.format("levers/collective"))
    ends = found.postures(np.array([0.0, found.duration]))
    for time, posture in zip((0.0, found.duration), ends, strict=True):
        scrub(page, time)
        hand = page.evaluate(place.format("person/hand_l"))
        assert hand == pytest.approx(posture.frames["hand_l"].translation, abs=1e-5)
        assert page.evaluate(place.format("levers/collective")) == lever, "it stands"
    assert lever == pytest.approx(ends[1].frames["grip_l"].translation, abs=1e-5)
    assert page.locator("#ways .done").count() == 1
    assert page.locator("#loads").count() == 0
    assert page.locator("#speed").input_value() == "0.1", "a short one starts slowly"
    scrub(page, 0.0)
    page.locator("#play").click()
    page.wait_for_function("clock > 0.01", timeout=20_000)
    assert console_errors == []


def test_report_opens_offline_and_answers(
    found: Trajectory, page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    write_motion_report(found, tmp_path / "trajectory.html")
    page.goto((tmp_path / "trajectory.html").as_uri())
    for name in ("way_side", "way_top", "speed"):
        assert page.locator(f"#{name} .scatterlayer .js-line").count() >= 1, name
    for name in ("angle", "torque"):
        assert page.locator(f"#{name} .scatterlayer .js-line").count() == 7, name
    assert page.locator("#certificate .pass").count() == 5
    for width, height in ((1280, 720), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert console_errors == []
