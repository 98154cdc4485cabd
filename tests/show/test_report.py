"""The report says what the posture says, with units, and needs nothing from outside itself."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_tables import Tables

from posture_ik.body import build_body
from posture_ik.errors import UnwritableOutput
from posture_ik.posture import Posture, solve_posture
from posture_ik.problem import load_problem
from posture_ik.show import write_report
from posture_ik.show.plots import arm_bars, energy_by_region, spine_bars
from posture_ik.show.report import render_report
from posture_ik.show.words import number, power


def solved(name: str) -> Posture:
    problem = load_problem(name)
    return solve_posture(build_body(problem.subject), problem)


@pytest.fixture(scope="module")
def reclined() -> Posture:
    return solved("reclined_15")


@pytest.fixture(scope="module")
def page(reclined: Posture) -> str:
    return render_report(reclined)


@pytest.fixture(scope="module")
def leaning() -> Posture:
    return solved("reclined_15_gravity")


@pytest.fixture(scope="module")
def pilot() -> Posture:
    return solved("pilot")


def value(cell: str) -> float:
    return float(cell.split()[0].replace("−", "-"))


def without_plotly(page: str) -> str:
    """The page without the inlined plotly.js, the first and only large script."""
    return re.sub(r"<script>.*?</script>", "", page, count=1, flags=re.DOTALL)


def figures(page: str) -> list[dict]:
    return json.loads(re.search(r"const figures = (.*);\n", page)[1])


def test_key_numbers_stand_on_top(reclined: Posture, page: str) -> None:
    top = page[: page.index("<h2>")]
    assert reclined.problem.title in top
    assert f"{number(reclined.energy)} <small>J</small>" in top
    assert f"{reclined.iterations} <small>iterations</small>" in top
    for wrench in reclined.wrenches:
        assert number(np.linalg.norm(wrench.moment)) in top
    assert ">Proven<" in top
    for words in ("Male, 30 years, 80 kg, 1.80 m", "backrest 15° back", "without gravity"):
        assert words in top


def test_forces_and_their_balance(leaning: Posture) -> None:
    rows = {row[0]: row[1:] for row in Tables(render_report(leaning)).rows["forces"]}
    for wrench in (*leaning.wrenches, leaning.seat):
        numbers = [value(cell) for cell in rows[wrench.label]]
        np.testing.assert_allclose(numbers[:3], wrench.force, rtol=6e-3, atol=1e-6)
        np.testing.assert_allclose(numbers[4:7], wrench.moment, rtol=6e-3, atol=1e-6)
        np.testing.assert_allclose(numbers[7:], wrench.point, atol=6e-4)
    model = leaning.body.model
    weight = sum(inertia.mass for inertia in model.inertias) * 9.81
    np.testing.assert_allclose(
        [value(cell) for cell in rows["sum, about the seat"][:3]], [0, 0, weight], atol=0.5
    )


def test_every_joint_is_tabled_with_units(reclined: Posture, page: str) -> None:
    rows = Tables(page).rows["prestrain"][1:]
    assert [row[0] for row in rows] == list(reclined.body.dofs)
    for row, displacement, force in zip(
        rows, reclined.displacement, reclined.prestrain_force, strict=True
    ):
        slide = row[0].endswith("_axial")
        shown = 1000 * displacement if slide else np.degrees(displacement)
        assert value(row[1]) == pytest.approx(shown, rel=6e-3, abs=1e-6)
        assert row[1].endswith(" mm" if slide else " deg")
        assert row[3].endswith(" N/mm" if slide else " N m/deg")
        assert value(row[4]) == pytest.approx(force, rel=6e-3, abs=1e-6)
        assert row[4].endswith(" N" if slide else " N m")


def test_certificate_shows_every_equation(reclined: Posture, page: str) -> None:
    tables = Tables(page).rows
    assert [row[3] for row in tables["certificate"][1:]] == ["yes"] * 4
    assert len(tables["tasks"]) - 1 == sum(len(c.rows) for c in reclined.constraints)
    assert power(reclined.certificate.primal) in tables["certificate"][1][1]


def test_limits_say_what_they_carry(reclined: Posture, page: str) -> None:
    rows = Tables(page).rows.get("limits", [[]])[1:]
    assert len(rows) == len(reclined.active_limits)
    for row, limit in zip(rows, reclined.active_limits, strict=True):
        assert row[1] == limit.side
        assert value(row[3]) == pytest.approx(limit.load, rel=6e-3)


def test_contacts_are_listed_where_the_back_may_lift_off(leaning: Posture, page: str) -> None:
    rows = Tables(render_report(leaning)).rows["contacts"][2:]
    assert [row[0] for row in rows] == [contact.label for contact in leaning.contacts]
    assert 'id="contacts"' not in page


def test_charts_hold_the_posture(reclined: Posture, page: str) -> None:
    energy, *levels = figures(page)
    assert sum(energy["data"][0]["x"]) == pytest.approx(reclined.elastic_energy)
    flexion = dict(zip(levels[0]["data"][-1]["y"], levels[0]["data"][-1]["x"], strict=True))
    index = reclined.body.dofs.index("C7_T1_ry")
    assert flexion["C7–T1"] == pytest.approx(np.degrees(reclined.displacement[index]))
    assert len(flexion) == 26
    assert list(flexion)[-1] == "Head–C1", "the head stands on top"


def test_only_what_moves_is_charted(reclined: Posture, pilot: Posture) -> None:
    names = ["Flexion", "Flexion moment", "Stretch", "Axial force"]
    assert [bars.name for bars in spine_bars(reclined)] == names
    assert len(spine_bars(pilot)) == 8
    assert arm_bars(reclined) == []
    assert [len(bars.labels) for bars in arm_bars(pilot)] == [14, 14]
    assert "from the front" not in render_report(reclined)
    assert "After, from the front" in render_report(pilot)


def test_regions_share_all_the_energy(pilot: Posture) -> None:
    shares = energy_by_region(pilot)
    assert sum(shares.values()) == pytest.approx(pilot.elastic_energy)
    assert shares["arms"] > 0.0


def test_nothing_is_loaded_from_outside(page: str) -> None:
    own = without_plotly(page)
    assert len(page) - len(own) > 1_000_000, "plotly.js is inlined, once"
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:)|@import|url\(|https?:""", own)


def test_same_posture_gives_same_page(reclined: Posture, page: str) -> None:
    assert render_report(reclined) == page


def test_a_bad_posture_is_called_bad(reclined: Posture) -> None:
    shifted = replace(reclined, q=reclined.q + 1e-3)
    page = render_report(shifted)
    assert "Not proven" in page
    assert ">Proven<" not in page
    assert "not so: every task is met" in page


def test_a_title_is_text_and_never_markup(reclined: Posture) -> None:
    problem = reclined.problem.model_copy(update={"title": "<script>alert(1)</script>"})
    posture = replace(reclined, statement=replace(reclined.statement, problem=problem))
    assert "<script>alert" not in render_report(posture)


def test_written_whole_or_not_at_all(reclined: Posture, page: str, tmp_path: Path) -> None:
    write_report(reclined, tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(UnwritableOutput):
        write_report(reclined, tmp_path / "file" / "report.html")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "report.html"]


@pytest.mark.parametrize(
    ("given", "shown"),
    [(0.0, "0"), (-4e-7, "0"), (1234.5, "1234"), (-0.01234, "−0.0123"), (9.999, "10.00")],
)
def test_numbers_have_three_figures(given: float, shown: str) -> None:
    assert number(given) == shown


def test_powers_are_written_as_people_do() -> None:
    assert power(3.14e-16) == "3.1 × 10⁻¹⁶"
    assert power(0.0) == "0"
