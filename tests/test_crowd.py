"""Random people of the whole allowed range: who they are, what is told, and that nobody is lost."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from posture_ik import cli, crowd
from posture_ik.body import build_body
from posture_ik.crowd import FREQUENCIES, examine, examine_all, random_people
from posture_ik.posture import solve_posture
from posture_ik.problem import load_problem
from posture_ik.vibration import vibrate


@pytest.fixture(scope="module")
def problem():
    return load_problem("reclined_15")


@pytest.fixture(scope="module")
def outcomes(problem):
    """All sixteen corners of the range, and four people inside it."""
    return examine_all(problem, random_people(20, seed=7))


def test_people_fill_the_range_to_its_corners():
    people = random_people(4000, seed=1)
    of = np.array([(p.age, p.stature, p.body_mass_index) for p in people])
    ends = np.array([(18.0, 1.40, 14.0), (99.0, 2.10, 55.0)])
    corners = {(p.gender, *np.round(row, 9)) for p, row in zip(people[:16], of, strict=False)}
    assert len(corners) == 16
    assert np.isin(np.round(of[:16], 9), ends).all()
    # Of a uniform draw: mean within 5 standard errors, no two numbers together, half women.
    share = (of[16:] - ends[0]) / (ends[1] - ends[0])
    assert np.all((share >= 0.0) & (share <= 1.0))
    np.testing.assert_allclose(share.mean(axis=0), 0.5, atol=5 / np.sqrt(12 * len(share)))
    assert np.abs(np.corrcoef(share.T) - np.eye(3)).max() < 5 / np.sqrt(len(share))
    women = np.mean([p.gender == "female" for p in people])
    assert women == pytest.approx(0.5, abs=2.5 / np.sqrt(len(people)))
    assert people[20:30] != random_people(30, seed=2)[20:]


def test_everybody_sits_and_answers(outcomes):
    assert [outcome.trouble for outcome in outcomes] == [""] * 20
    numbers = np.array([outcome[5:] for outcome in outcomes])
    assert np.isfinite(numbers).all()
    assert np.all(numbers > 0.0)


def test_by_the_sources_scaling_too():
    problem = load_problem("reclined_15", ("subject.scaling=thesis",))
    found = examine_all(problem, random_people(16, 7, problem.subject))
    assert {outcome.subject.scaling for outcome in found} == {"thesis"}
    assert [outcome.trouble for outcome in found] == [""] * 16


def test_is_the_vibration_of_the_stage(problem, outcomes):
    """The short way of the study against `vibrate`; the same matrices, other ports: rounding."""
    person = outcomes[-1]
    of = problem.model_copy(update={"subject": person.subject})
    body = build_body(person.subject)
    response = vibrate(body, solve_posture(body, of), of).response
    response = response.sel(frequency=FREQUENCIES, method="nearest")
    mass = np.abs(response["apparent_mass"].sel(force="z", motion="z").values)
    assert person.peak == pytest.approx(mass.max(), rel=1e-8)
    assert person.static == pytest.approx(mass[0], rel=1e-8)
    assert person.resonance == FREQUENCIES[mass.argmax()]
    head = np.abs(response["stht"].sel({"to": "z", "from": "z"}).values)
    assert person.head == pytest.approx(head.max(), rel=1e-8)


def test_who_cannot_be_seated_is_told_with_the_reason(problem):
    """No neck turns by half a turn: the study goes on and says so."""
    turned = load_problem("reclined_15", ("task.head.looking={turn_deg=170}",))
    found = examine(turned, problem.subject)
    assert "head" in found.trouble
    assert found.record()["peak_kg"] is None
    # Nothing but the springs of the spine holds its weight up: it falls, however slowly.
    loaded = load_problem("reclined_15", ("vibration={gravity=true}",))
    assert examine(loaded, problem.subject).trouble == "unstable"


def test_processes_find_what_one_finds(problem, outcomes, monkeypatch):
    monkeypatch.setattr(crowd, "_SHARE", 2)
    monkeypatch.setattr(crowd, "_HANDFUL", 2)
    done = []
    people = [outcome.subject for outcome in outcomes[:4]]
    found = examine_all(problem, people, lambda now, of: done.append((now, of)))
    assert done == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert [outcome.subject for outcome in found] == people
    for one, other in zip(outcomes, found, strict=False):
        assert other.peak == pytest.approx(one.peak, rel=1e-9)


def test_command_tells_counts_times_and_writes_the_page(monkeypatch, tmp_path, capsys):
    folder = tmp_path / "people"
    run(monkeypatch, "people", "--count", "3", "-o", str(folder))
    told = capsys.readouterr().out
    assert "3 of 3" in told
    assert "time: everybody" in told
    with (folder / "people.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["stature_m"]) for row in rows] == [1.4, 1.4, 2.1]
    page = (folder / "people.html").read_text(encoding="utf-8")
    assert "3 random people" in page
    assert f"{float(rows[0]['peak_kg']):.3f}"[:-1] in page

    run(monkeypatch, "people", "--count", "2", "--seed", "4", "--json")
    records = json.loads(capsys.readouterr().out)
    assert [record["trouble"] for record in records] == ["", ""]
    assert records[0]["peak_kg"] == pytest.approx(float(rows[0]["peak_kg"]))


def test_nobody_is_refused(monkeypatch, capsys):
    assert run(monkeypatch, "people", "--count", "0") == 2
    assert "--count" in capsys.readouterr().err


def run(monkeypatch, *arguments):
    monkeypatch.setattr("sys.argv", ["posture-ik", "validate", *arguments])
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    return stopped.value.code
