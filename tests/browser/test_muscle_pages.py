"""The muscles in the 3D page and their report, as a browser without network shows them."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page

from posture_ik.body import build_body
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import move, solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_activation_report, write_view
from posture_ik.show.effort import muscle_name

#: Middle of the tube of a muscle half way along, m, and where that is in the window.
MIDDLE = """
k => {
  const at = muscle_meshes[k].geometry.attributes.position, ring = SIDES * (muscles.count / 2);
  const middle = new THREE.Vector3();
  for (let s = 0; s < SIDES; s++) middle.add(new THREE.Vector3().fromBufferAttribute(at, ring + s));
  middle.divideScalar(SIDES);
  const [x, y] = on_screen(middle), frame = pane.getBoundingClientRect();
  return [...middle.toArray(), x + frame.left, y + frame.top];
}
"""
#: The muscles that are told of where their middle is seen.
IN_FRONT = """
places => {
  const frame = pane.getBoundingClientRect();
  const title = ([x, y]) => told_at(x - frame.left, y - frame.top)?.title;
  return places.flatMap((place, k) => title(place) === muscles.names[k] ? [k] : []);
}
"""


@pytest.fixture(scope="module")
def raising() -> Activity:
    problem = load_problem("pilot_collective", ("motion.rate=10",))
    body = build_body(problem.subject)
    return solve_activation(body, move(body, problem), problem)


@pytest.fixture(scope="module")
def view(raising: Activity, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("view") / "view.html"
    write_view(raising.shown, path, raising)
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


def test_muscles_move_with_the_arm_and_change_colour(
    view: Path, raising: Activity, page: Page, console_errors: list[str]
) -> None:
    page.goto(view.as_uri())
    muscle = raising.muscles.names.index("BRA_l")
    rise = raising.activation[10] - raising.activation[0]
    most = int(np.argmax(rise))
    assert rise[most] > 0.01
    colours = []
    for time, step in ((0.0, 0), (1.0, 10)):
        scrub(page, time)
        line = raising.paths.polylines(raising.q[step])[muscle]
        ends = np.linalg.norm(np.diff(line, axis=0), axis=1)
        half = np.array([np.interp(ends.sum() * 10 / 19, [0, *ends.cumsum()], x) for x in line.T])
        assert page.evaluate(MIDDLE, muscle)[:3] == pytest.approx(half, abs=2e-4)
        colours.append(page.evaluate(f"muscle_meshes[{most}].material.color.toArray()"))
    assert sum(colours[1]) < sum(colours[0]), "darker where more active"
    assert console_errors == []


def test_muscles_can_be_hidden_and_pointed_at(
    view: Path, raising: Activity, page: Page, console_errors: list[str]
) -> None:
    page.goto(view.as_uri())
    for layer in ("forces", "ghost", "ways"):
        page.locator(f"[data-layer={layer}]").uncheck()
    shown = picture(page)
    places = [page.evaluate(MIDDLE, k)[3:] for k in range(50)]
    seen = page.evaluate(IN_FRONT, places)
    assert len(seen) > 5
    muscle = seen[0]
    page.mouse.move(*places[muscle])
    tip = page.locator("#tip")
    name = muscle_name(raising.muscles.names[muscle])
    assert f"{name}\nactivation {raising.activation[0, muscle]:.2f}, " in tip.inner_text()
    page.mouse.move(5, 300)
    page.locator("[data-layer=muscles]").uncheck()
    assert np.abs(picture(page) - shown).mean() > 0.05
    assert page.evaluate(IN_FRONT, places) == []
    assert console_errors == []


def test_muscles_of_a_posture_and_a_shortfall_in_the_page(
    page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    problem = load_problem("pilot", ("activation.hand_force.right=[0, 0, -500]",))
    body = build_body(problem.subject)
    posture = solve_posture(body, problem)
    write_view(posture, tmp_path / "view.html", solve_activation(body, posture, problem))
    page.goto((tmp_path / "view.html").as_uri())
    assert page.evaluate("muscle_meshes.length") == 50
    assert "Muscles fall short: right" in page.locator("aside .alarm").inner_text()
    assert picture(page).std() > 15.0
    assert console_errors == []


def test_report_opens_offline_and_answers(
    raising: Activity, page: Page, console_errors: list[str], tmp_path: Path
) -> None:
    write_activation_report(raising, tmp_path / "activation.html")
    page.goto((tmp_path / "activation.html").as_uri())
    for name in ("activation", "torque", "room", "stiffness"):
        assert page.locator(f"#{name}_left .barlayer .point").count() >= 7, name
    for name in ("course", "arms"):
        assert page.locator(f"#{name}_left .heatmaplayer image").count() == 1, name
    for plane in ("side", "top", "front"):
        ellipse = page.locator(f"#ellipse_{plane}_left .scatterlayer .js-line")
        assert ellipse.count() >= 1
    page.get_by_role("button", name="elbow flexion").click()
    names = page.locator("#course .legendtext").all_text_contents()
    assert names == ["asked", "passive", "active", "reserve"]
    for width, height in ((1280, 720), (390, 800)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert console_errors == []


def test_view_with_muscles_fits_a_phone(view: Path, page: Page, console_errors: list[str]) -> None:
    page.set_viewport_size({"width": 390, "height": 800})
    page.goto(view.as_uri())
    assert picture(page).std() > 15.0
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert console_errors == []
