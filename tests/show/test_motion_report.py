"""The report of a motion says what the motion says, with units and times, and opens offline."""

import base64
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_tables import Tables

from posture_ik.errors import UnwritableOutput
from posture_ik.posture import Motion
from posture_ik.problem.signals import Constant, CosineStep, Sine, Table
from posture_ik.show import write_motion_report
from posture_ik.show.courses import groups_of, joint_courses, wrench_charts
from posture_ik.show.motion_report import describe, render_motion_report, telling_steps
from posture_ik.show.peaks import speeds
from posture_ik.show.words import number


@pytest.fixture(scope="module")
def page(sweep: Motion) -> str:
    return render_motion_report(sweep)


def numbers(packed: dict[str, str]) -> np.ndarray:
    assert packed["dtype"] == "f4"
    return np.frombuffer(base64.b64decode(packed["bdata"]), "<f4")


def test_top_says_what_moves_and_what_is_largest(sweep: Motion, page: str) -> None:
    top = page[: page.index("<h2>")]
    for words in (
        sweep.problem.title,
        "seat recline from 0° to 45° between 0 and 2 s",
        "21 steps, 100 ms each",
        ">Holds<",
        "holding backrest, head",
    ):
        assert words in top
    sizes = np.linalg.norm(sweep.forces, axis=2)
    assert f"{number(sizes.max())} <small>N</small>" in top
    fast = speeds(sweep)["head"]
    assert f"{number(fast.max())} <small>m/s</small>" in top


def test_speed_is_the_derivative_of_the_path(sweep: Motion) -> None:
    way = np.array([posture.frames["Head"].translation for posture in sweep.postures])
    middle = np.linalg.norm(way[2:] - way[:-2], axis=1) / 0.2
    assert speeds(sweep)["head"][1:-1] == pytest.approx(middle, abs=0.02)
    assert max(middle) > 0.3


def test_groups_hold_every_degree_of_freedom_once(sweep: Motion) -> None:
    groups = groups_of(sweep.body.dofs)
    assert sorted(i for index in groups.values() for i in index) == list(range(117))
    assert max(len(index) for index in groups.values()) <= 12
    assert sweep.body.dofs[groups["Neck", "Flexion"][0]] == "Head_C1_ry"
    assert len(groups["Right arm", "Turn"]) == 7


def test_charts_hold_the_motion(sweep: Motion) -> None:
    charts = joint_courses(sweep)
    assert list(charts)[:3] == ["Neck", "Thoracic", "Lumbar and seat"]
    assert "Lateral bending" not in charts["Neck"], "nothing bends sideways"
    both = charts["Lumbar and seat"]["Flexion"]
    line = next(line for line in both["angle"]["data"] if line["name"] == "L4–L5")
    index = sweep.body.dofs.index("L4_L5_ry")
    np.testing.assert_allclose(numbers(line["y"]), np.degrees(sweep.q[:, index]), atol=1e-4)
    assert line["dx"] == pytest.approx(0.1)
    assert "deg" in both["angle"]["layout"]["yaxis"]["title"]["text"]
    torque = next(line for line in both["torque"]["data"] if line["name"] == "L4–L5")
    np.testing.assert_allclose(numbers(torque["y"]), sweep.tau[:, index], rtol=1e-5, atol=1e-5)
    assert "N m" in both["torque"]["layout"]["yaxis"]["title"]["text"]


def test_reactions_are_charted_where_they_act(sweep: Motion) -> None:
    charts = wrench_charts(sweep)
    assert list(charts) == ["All", *sweep.wrench_labels]
    x, y, z, size = (numbers(line["y"]) for line in charts["seat"]["force"]["data"])
    np.testing.assert_allclose(np.sqrt(x**2 + y**2 + z**2), size, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(z, sweep.forces[:, -1, 2], rtol=1e-5, atol=1e-5)


def test_peaks_name_joint_size_and_time(sweep: Motion, page: str) -> None:
    rows = {(row[0], row[1]): row[2:] for row in Tables(page).rows["peaks"][2:]}
    index = [i for i, dof in enumerate(sweep.body.dofs) if dof.endswith("_ry")]
    lumbar = [i for i in index if sweep.body.dofs[i][0] in "bL"]
    step, joint = np.unravel_index(np.argmax(np.abs(sweep.tau[:, lumbar])), (21, len(lumbar)))
    name, torque, at = rows["Lumbar and seat", "Flexion"][-3:]
    dof = sweep.body.dofs[lumbar[joint]]
    assert name == dof.removesuffix("_ry").replace("buttocks", "seat").replace("_", "–")
    assert torque == f"{number(abs(sweep.tau[step, lumbar[joint]]))} N m"
    assert at == f"{sweep.time[step]:.3f} s"
    assert rows["Right arm", "Turn"][:2] == ["", "still"]


def test_limits_are_those_that_carry(sweep: Motion, page: str) -> None:
    rows = Tables(page).rows["limits"][1:]
    held = np.flatnonzero(np.any(sweep.limit_load != 0.0, axis=0))
    assert len(rows) == len(held) > 0
    assert rows[0][3] == f"{number(np.abs(sweep.limit_load[:, held[0]]).max())} N m"


def test_certificate_tells_each_level_and_a_bad_one(sweep: Motion, page: str) -> None:
    rows = Tables(page).rows["certificate"][1:]
    assert [row[0] for row in rows] == ["Position", "Velocity", "Acceleration"]
    assert [row[-1] for row in rows] == ["yes"] * 3
    residuals = sweep.residuals.copy()
    residuals[7, 1, 2] = 1e-3
    bad = render_motion_report(replace(sweep, residuals=residuals))
    rows = Tables(bad).rows["certificate"][1:]
    assert [row[-1] for row in rows] == ["yes", "no", "yes"]
    assert rows[1][2].endswith("at 0.700 s")
    assert ">Fails<" in bad
    assert ">Holds<" not in bad


def test_pictures_stand_where_the_motion_turns(sweep: Motion) -> None:
    steps = telling_steps(sweep)
    assert (steps[0], steps[-1], len(steps)) == (0, 20, 5)
    still = replace(sweep, postures=sweep.postures[:1] * 21)
    assert telling_steps(still) == [0]


def test_what_stays_is_not_followed(sweep: Motion) -> None:
    still = replace(sweep, postures=sweep.postures[:1] * 21)
    page = render_motion_report(still)
    assert "Head and hands stay where they are" in page
    assert 'id="way_side"' not in page


@pytest.mark.parametrize(
    ("signal", "words"),
    [
        (Sine(of="task.head.looking.nod_deg", kind="sine", amplitude=20, frequency=1), "±20° at 1"),
        (Constant(of="seat.recline_deg", kind="constant", value=5), "seat recline stays at 5°"),
        (
            CosineStep(of="seat.recline_deg", kind="cosine_step", initial=0, final=9, stop=2),
            "from 0° to 9°",
        ),
        (
            Table(of="task.hand.position.0", kind="table", times=(0, 1), values=(0.1, 0.3)),
            "between 0.1 and 0.3",
        ),
    ],
)
def test_signals_are_put_into_words(signal, words: str) -> None:
    assert words in describe(signal)


def test_nothing_is_loaded_from_outside(page: str) -> None:
    own = re.sub(r"<script>.*?</script>", "", page, count=1, flags=re.DOTALL)
    assert len(page) - len(own) > 1_000_000, "plotly.js is inlined, once"
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:)|@import|url\(|https?:""", own)
    assert json.loads(re.search(r"const figures = (.*);\n", page)[1]).keys() >= {
        "speed",
        "residual",
    }


def test_written_whole_or_not_at_all(sweep: Motion, page: str, tmp_path: Path) -> None:
    write_motion_report(sweep, tmp_path / "motion.html")
    assert (tmp_path / "motion.html").read_text(encoding="utf-8") == page
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(UnwritableOutput):
        write_motion_report(sweep, tmp_path / "file" / "motion.html")
