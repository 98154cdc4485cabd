"""The report of vibration, as a browser without network shows it."""

from pathlib import Path

from playwright.sync_api import Page

from posture_ik.body import build_body
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_vibration_report
from posture_ik.vibration import vibrate


def test_report_opens_offline_and_answers(
    page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    problem = load_problem("vibration_cushion", ("vibration.frequencies.step=0.5",))
    body = build_body(problem.subject)
    vibration = vibrate(body, solve_posture(body, problem), problem)
    write_vibration_report(vibration, tmp_path / "vibration.html")
    page.goto((tmp_path / "vibration.html").as_uri())

    def lines(name: str) -> int:
        return page.locator(f"#{name} .scatterlayer .js-line").count()

    models = 3
    assert lines("magnitude_z") == lines("phase_z") == lines("mass") == lines("power_z") == models
    assert lines("magnitude_x") == models - 1, "the lumped model moves up and down alone"
    assert page.locator("#magnitude_z .scatterlayer .point").count() >= 1, "a printed peak"
    page.locator("#frame").get_by_role("button", name="Cushion").click()
    assert page.locator("#magnitude_z").is_visible()
    assert not page.locator("#magnitude_x").is_visible(), "the cushion gives up and down alone"
    page.locator("#frame").get_by_role("button", name="Head").click()
    assert page.locator("#magnitude_x").is_visible()

    assert page.locator("#cross_from button").all_text_contents() == [
        "fore-and-aft (x)",
        "lateral (y)",
    ], "the same direction stands above"
    before = page.evaluate("cross_magnitude.data[1].y.bdata ?? [...cross_magnitude.data[1].y]")
    page.locator("#cross_to").get_by_role("button", name="fore-and-aft").click()
    after = page.evaluate("cross_magnitude.data[1].y.bdata ?? [...cross_magnitude.data[1].y]")
    assert before != after
    page.locator("#place").get_by_role("button", name="Floor").click()
    assert lines("impedance") == models

    page.locator("summary").click()
    assert page.locator("#undamped tbody tr").count() > 10
    for width, height in ((1280, 720), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert console_errors == []
