"""The report of muscle activity says what the muscles do, what is missing first, and is offline."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from page_tables import Tables

from posture_ik.body import build_body
from posture_ik.errors import UnwritableOutput
from posture_ik.muscle import Activity, solve_activation
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_activation_report
from posture_ik.show.effort import hardest, held, muscle_name
from posture_ik.show.muscle_charts import (
    Instant,
    activation_chart,
    course_chart,
    ellipse_charts,
    moment_arm_chart,
    stiffness_chart,
    torque_chart,
)
from posture_ik.show.muscle_report import render_activation_report
from posture_ik.show.plots import joint_name


def solved(name: str, *settings: str) -> Activity:
    problem = load_problem(name, settings)
    body = build_body(problem.subject)
    return solve_activation(body, solve_posture(body, problem), problem)


@pytest.fixture(scope="module")
def page(pilot: Activity) -> str:
    return render_activation_report(pilot)


@pytest.fixture(scope="module")
def instant(pilot: Activity) -> Instant:
    return Instant.of(pilot, "left", 0)


def test_top_says_whether_strength_is_enough(pilot: Activity, page: str) -> None:
    top = page[: page.index("<h2>")]
    for words in (">Enough<", ">Holds<", "sum of squared activations", "(0, 0, −20.0) N"):
        assert words in top
    left = pilot.activation[0, 25:]
    assert muscle_name(pilot.muscles.names[25 + int(left.argmax())]) in top
    assert f"{100 * left.max():.0f} <small>%</small>" in top
    assert 'role="alert"' not in page


def test_a_load_beyond_strength_is_told_first_and_by_joint() -> None:
    weak = solved("pilot", "activation.hand_force.right=[0, 0, -500]")
    page = render_activation_report(weak)
    assert page.index("Muscles fall short") < page.index('aria-label="Key numbers"')
    assert ">Too little<" in page
    rows = {row[0]: row[1:] for row in Tables(page).rows["shortfalls"][1:]}
    assert set(rows) == {joint_name(fall.joint) for fall in weak.shortfalls}
    worst = weak.shortfalls[0]
    assert float(rows[joint_name(worst.joint)][0].split()[0]) == pytest.approx(
        abs(worst.torque), rel=5e-3
    )
    assert not re.search(r"\bnan\b", page[: page.index("<script>")], re.IGNORECASE)
    assert "NaN" not in page[page.rindex("const figures") :]
    verdicts = {row[0]: row[3] for row in Tables(page).rows["certificate"][1:]}
    assert verdicts["Largest reserve"] == "no"
    assert verdicts["Torque balance"] == "yes"


def test_torques_add_up_to_what_is_asked(pilot: Activity, page: str) -> None:
    rows = {row[0]: row[1:] for row in Tables(page).rows["torques"][1:]}
    assert len(rows) == 14
    for i, dof in enumerate(pilot.paths.dofs):
        asked, passive, active, delivered, reserve = (
            float(x.replace("−", "-")) for x in rows[joint_name(dof)]
        )
        assert asked == pytest.approx(pilot.demand[0, i], abs=6e-3)
        assert passive + active + reserve == pytest.approx(asked, abs=0.02)
        assert delivered == pytest.approx(asked, abs=6e-3)
    *parts, mark = torque_chart(pilot, "left")["data"]
    np.testing.assert_allclose(np.sum([part["x"] for part in parts], axis=0), mark["x"], atol=1e-9)


def test_bars_show_each_muscle_once_by_group(pilot: Activity) -> None:
    bars = activation_chart(pilot, "right")["data"][0]
    names = [muscle_name(name) for name in pilot.muscles.names[:25]]
    assert sorted(bars["y"]) == sorted(names)
    for name, value in zip(bars["y"], bars["x"], strict=True):
        assert value == pilot.activation[0, names.index(name)]
    colours = bars["marker"]["color"]
    assert len(set(colours)) == 9
    assert [c for i, c in enumerate(colours) if i == 0 or c != colours[i - 1]] == list(
        dict.fromkeys(colours)
    ), "a group's muscles stand together"


def test_heat_map_holds_every_step(raising: Activity) -> None:
    figure = course_chart(raising, "left")
    (heat,) = figure["data"]
    values = np.frombuffer(base64.b64decode(heat["z"]["bdata"]), "<f4").reshape(25, 21)
    assert heat["z"]["shape"] == "25, 21"
    names = [muscle_name(name) for name in raising.muscles.names[25:]]
    for name, row in zip(heat["y"], values, strict=True):
        np.testing.assert_allclose(row, raising.activation[:, 25 + names.index(name)], atol=1e-7)
    assert (heat["zmin"], heat["zmax"]) == (0.0, 1.0)
    assert figure["layout"]["shapes"][0]["x0"] == raising.time[hardest(raising)]


def test_moment_arms_are_the_slopes_of_the_lengths(pilot: Activity) -> None:
    """Central differences of the lengths: steps of 1e-5 rad leave 1e-5 mm."""
    (heat,) = moment_arm_chart(pilot, "left")["data"]
    column = heat["x"].index("elbow flexion")
    row = pilot.paths.rows[7 + column]
    ends = []
    for step in (-1e-5, 1e-5):
        q = pilot.q[0].copy()
        q[row] += step
        ends.append(pilot.paths.evaluate(q)[0][25:])
    expected = -1000 * (ends[1] - ends[0]) / 2e-5
    names = [muscle_name(name) for name in pilot.muscles.names[25:]]
    for name, values in zip(heat["y"], heat["z"], strict=True):
        assert values[column] == pytest.approx(expected[names.index(name)], abs=1e-4)


def test_all_ways_to_hold_give_the_same_torques(instant: Instant) -> None:
    capacity = instant.held.recruitment.capacity
    torques = [capacity @ hold.recruitment.activation for hold in instant.ways.values()]
    np.testing.assert_allclose(torques, [torques[0]] * 3, atol=1e-6)
    soft, held_, stiff = (np.trace(h.stiffness.total) for h in instant.ways.values())
    assert soft < held_ < stiff


def test_stiffness_bars_add_up(pilot: Activity, instant: Instant) -> None:
    *parts, mark = stiffness_chart(pilot, instant)["data"]
    assert [part["name"] for part in parts] == ["active", "passive", "reflexive", "geometric"]
    np.testing.assert_allclose(np.sum([part["x"] for part in parts], axis=0), mark["x"], atol=1e-9)
    np.testing.assert_allclose(mark["x"], np.diag(instant.held.stiffness.total))


def test_ellipses_are_the_force_of_a_unit_push_on_equal_axes(instant: Instant) -> None:
    charts = ellipse_charts(instant)
    stiffness = instant.held.endpoint.stiffness
    for plane, (a, b) in {"side": (0, 2), "top": (0, 1), "front": (1, 2)}.items():
        curves = {line["name"]: line for line in charts[plane]["data"]}
        curve = curves["as held"]
        assert (curve["x"][0], curve["y"][0]) == pytest.approx((stiffness[a, a], stiffness[b, a]))
        axes = charts[plane]["layout"]
        assert axes["xaxis"]["range"] == axes["yaxis"]["range"]
        assert axes["yaxis"]["scaleanchor"] == "x"
        assert max(np.abs([*curve["x"], *curve["y"]])) < axes["xaxis"]["range"][1]


def test_an_arm_that_holds_nothing_is_left_out(raising: Activity) -> None:
    assert held(raising) == ("left",)
    page = render_activation_report(raising)
    assert "The right arm holds nothing" in page
    assert 'id="activation_left"' in page
    assert 'id="activation_right"' not in page
    assert all(row[0].startswith("left") for row in Tables(page).rows["torques"][1:])
    assert f"at {raising.time[hardest(raising)]:.2f} s, the instant of greatest effort" in page


def test_an_arm_that_rests_does_not_co_contract() -> None:
    tense = solved("pilot_collective", "activation.co_contraction=0.2")
    assert tense.activation[:, :25].max() < 1e-9
    assert tense.activation[:, 25:].mean() > 0.1


def test_arms_that_both_rest_make_a_page_too() -> None:
    page = render_activation_report(solved("upright"))
    assert "Neither arm holds anything" in page
    assert "Who works" not in page


def test_the_hardest_instant_is_where_most_is_missing_or_done(raising: Activity) -> None:
    effort = np.sum(raising.activation**2, axis=1)
    assert effort[hardest(raising)] == effort.max()
    problem = load_problem(
        "pilot_collective", ("motion.rate=10", "activation.hand_force.left=[0, 0, -500]")
    )
    weak = solve_activation(raising.shown.body, raising.shown, problem)
    missing = np.sum(weak.reserve**2, axis=1)
    assert missing[hardest(weak)] == missing.max() > 0.0


def test_an_arm_that_folds_up_by_itself_has_no_ellipse() -> None:
    """500 N hung on the hand: muscles at their end stiffen less than the load takes away."""
    heavy = solved("pilot", "activation.hand_force.right=[0, 0, -500]")
    assert heavy.hold("right").endpoint.idle < 0.0 < heavy.hold("left").endpoint.idle
    page = render_activation_report(heavy)
    assert 'id="ellipse_side_left"' in page
    assert 'id="ellipse_side_right"' not in page
    assert page.count("swivel away by itself") == 1


def test_nothing_is_loaded_from_outside(page: str) -> None:
    own = re.sub(r"<script>.*?</script>", "", page, count=1, flags=re.DOTALL)
    assert len(page) - len(own) > 1_000_000, "plotly.js is inlined, once"
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:)|@import|url\(|https?:""", own)


def test_written_whole_or_not_at_all(pilot: Activity, page: str, tmp_path: Path) -> None:
    write_activation_report(pilot, tmp_path / "activation.html")
    assert (tmp_path / "activation.html").read_text(encoding="utf-8") == page
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(UnwritableOutput):
        write_activation_report(pilot, tmp_path / "file" / "activation.html")
