"""The report and the 3D page of a reach say what the trajectory says, and open offline."""

import base64
import re
from dataclasses import replace
from html import unescape
from io import StringIO

import numpy as np
import pinocchio as pin
import pytest
from page_tables import Tables
from rich.console import Console

from posture_ik.body import build_body
from posture_ik.muscle import reach as reach_by_muscles
from posture_ik.posture import Trajectory, reach
from posture_ik.problem import load_problem
from posture_ik.show import write_view
from posture_ik.show.looks import looks_of
from posture_ik.show.motion_report import render_motion_report
from posture_ik.show.moving import animation, peak_parts
from posture_ik.show.played import Sampled
from posture_ik.show.reaching import activations
from posture_ik.show.strain import parts_of
from posture_ik.show.summary import trajectory_record, trajectory_summary
from posture_ik.show.words import number


@pytest.fixture(scope="module")
def found() -> Trajectory:
    problem = load_problem("reach_cyclic")
    return reach(build_body(problem.subject), problem)


@pytest.fixture(scope="module")
def page(found: Trajectory) -> str:
    return render_motion_report(found)


def test_sampled_at_even_steps_it_is_the_same_motion(found: Trajectory) -> None:
    """The torques are those of Pinocchio's rnea; the joints at rest carry none."""
    seen = Sampled.of(found)
    assert np.ptp(np.diff(seen.time)) < 1e-12
    assert seen.time[-1] == found.duration
    moves = np.isin(np.arange(117), found.limb.rows)
    assert np.all(seen.q[:, ~moves] == found.limb.start[~moves])
    assert np.all(seen.tau[:, ~moves] == 0.0)
    step = 60
    a = np.zeros(117)
    a[moves] = found.at(seen.time[step : step + 1]).a[0]
    model = seen.body.model
    total = pin.rnea(model, model.createData(), seen.q[step], seen.v[step], a)
    statement = found.limb.statement
    total += statement.stiffness * (seen.q[step] - statement.q_ergo)
    total += seen.body.damping * seen.v[step]
    # between the points torque and motion agree to the order of the polynomials
    np.testing.assert_allclose(seen.tau[step, moves], total[moves], atol=0.05)


def test_top_says_what_was_asked_and_what_it_takes(found: Trajectory, page: str) -> None:
    top = unescape(page[: page.index("<h2>")])
    for words in (
        found.problem.title,
        "least effort",
        "in 0.7 s",
        "the right arm moves",
        ">Holds<",
    ):
        assert words in top
    assert f"{number(found.effort)} <small>(N m)² s" in top
    assert "Fastest: right hand" in top


def test_tables_hold_certificate_and_meshes(found: Trajectory, page: str) -> None:
    tables = Tables(page).rows
    assert [row[3] for row in tables["certificate"][1:]] == ["yes"] * 5
    assert [int(row[0]) for row in tables["rounds"][1:]] == [r.intervals for r in found.rounds]
    fastest = np.degrees(np.abs(found.v).max(axis=0))
    assert [row[3] for row in tables["moves"][1:]] == [f"{number(v)} deg/s" for v in fastest]
    assert "forces" not in tables, "what holds the body firm is not computed"
    bad = Tables(render_motion_report(replace(found, end_error=2e-3))).rows["certificate"]
    assert [row[3] for row in bad[1:]] == ["yes"] * 4 + ["no"]
    assert "not so: these torques alone" in bad[-1][-1]


def test_player_takes_the_hand_to_a_lever_that_stands(found: Trajectory, tmp_path) -> None:
    seen, looks = Sampled.of(found), looks_of(found.body)
    parts = peak_parts(seen, parts_of(seen.postures[0], {look.link for look in looks}))
    given = animation(seen, looks, parts)
    poses = np.frombuffer(base64.b64decode(given["poses"]), "<f4")
    poses = poses.reshape(-1, len(given["paths"]), 7)
    lever = poses[:, given["paths"].index("levers/cyclic"), :3]
    hand = poses[:, given["paths"].index("person/hand_r"), :3]
    assert np.ptp(lever, axis=0).max() == 0.0
    assert np.linalg.norm(hand[0] - hand[-1]) > 0.05
    end = seen.postures[-1].frames["grip_r"].translation
    np.testing.assert_allclose(lever[0], end, atol=1e-6)
    write_view(found, tmp_path / "view.html")
    markup = (tmp_path / "view.html").read_text(encoding="utf-8")
    markup = re.sub(r"<script>.*?</script>", "", markup, flags=re.DOTALL)
    assert 'id="player"' in markup
    assert 'id="loads"' not in markup
    assert "Effort" in markup


def test_a_page_of_muscles_says_how_hard_they_work() -> None:
    """What chart and summaries say is the trajectory's."""
    sets = ("trajectory.joints=['elbow_flexion_r']", "task=[{ kind = 'hand', side = 'right', "
            "position = [0.5, -0.16, 0.3], components = ['z'] }]")  # fmt: skip
    problem = load_problem("reach_activation", sets)
    found = reach_by_muscles(build_body(problem.subject), problem)
    page = render_motion_report(found)
    assert "muscles drive the joints · least activation" in unescape(page)
    assert "Six checks" in page
    assert "Muscles beside inverse dynamics" in page
    assert "those of the joints that move are left out" in page
    chart = activations(found)["data"][0]
    assert found.actuators is not None
    peaks = dict(zip(found.actuators.names, found.activation.max(axis=0), strict=True))
    assert chart["y"] == sorted((name for name in peaks if peaks[name] > 0.005), key=peaks.get)
    assert max(chart["z"][-1]) == max(peaks.values())
    hardest = max(peaks, key=lambda name: peaks[name])
    assert f"The hardest working is {hardest}, at {number(100 * peaks[hardest])} %" in page
    record = trajectory_record(found)
    assert record["peak_activation"] == pytest.approx(peaks)
    assert record["imbalance"] == found.imbalance
    console = Console(width=120, file=StringIO())
    console.print(trajectory_summary(found))
    assert f"{hardest} {peaks[hardest]:.2g}" in console.file.getvalue()
