"""The report as a browser without network shows it."""

from pathlib import Path

import pytest
from playwright.sync_api import Page

from posture_ik.body import build_body
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_report

#: Words of a drawing that reach out of its window, or lie on one another, by more than a pixel.
UNREADABLE = """
() => [...document.querySelectorAll("svg.person")].flatMap(svg => {
  const window = svg.getBoundingClientRect();
  const labels = [...svg.querySelectorAll("text.force, text.moment")];
  const boxes = labels.map(label => label.getBoundingClientRect());
  return labels.filter((label, i) => boxes.some((other, j) =>
    i < j && boxes[i].left + 1 < other.right && other.left + 1 < boxes[i].right
    && boxes[i].top + 3 < other.bottom && other.top + 3 < boxes[i].bottom)
    || boxes[i].left < window.left - 1 || boxes[i].right > window.right + 1
    || boxes[i].top < window.top - 1 || boxes[i].bottom > window.bottom + 1
  ).map(label => label.textContent);
})
"""


@pytest.mark.parametrize("name", ["reclined_45", "reclined_15_gravity", "pilot"])
def test_report_opens_offline_and_reads_well(
    name: str, page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    problem = load_problem(name)
    write_report(solve_posture(build_body(problem.subject), problem), tmp_path / "report.html")
    page.goto((tmp_path / "report.html").as_uri())
    places = page.locator("[data-figure]")
    assert places.count() >= 5
    assert all(place.locator(".bars .point path").count() >= 5 for place in places.all())
    assert page.evaluate(UNREADABLE) == []

    prestrain = page.locator("#prestrain")
    assert not prestrain.is_visible()
    page.get_by_text("degrees of freedom").click()
    assert prestrain.is_visible()
    assert prestrain.locator("tbody tr").count() == 117

    for width, height in ((1280, 720), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for drawing in page.locator("svg.person").all():
            box = drawing.bounding_box()
            assert box is not None
            assert min(box["width"], box["height"]) > 250
    assert console_errors == []
