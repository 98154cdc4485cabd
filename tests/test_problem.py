"""Problem files: examples, overrides, and what a resolved problem says."""

from __future__ import annotations

from pathlib import Path

import pytest
import tomli_w

import posture_ik as pik
from posture_ik.errors import BadProblem
from posture_ik.problem import SPINE, example_problems

EXAMPLES = {
    "upright",
    "reclined_15",
    "reclined_30",
    "reclined_45",
    "reclined_15_gravity",
    "look_left",
    "slouched",
    "pilot",
    "reach_cyclic",
    "reach_collective",
    "reach_activation",
}


def test_the_examples_are_those_promised() -> None:
    assert set(example_problems()) >= EXAMPLES


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_examples_load_and_teach(name: str) -> None:
    """Each has a title of its own and comments that explain its keys."""
    problem = pik.load_problem(name)
    text = example_problems()[name].read_text(encoding="utf-8")
    assert problem.title != "Untitled"
    assert text.count("#") >= 3


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_a_resolved_problem_reads_back_the_same(name: str, tmp_path: Path) -> None:
    problem = pik.load_problem(name)
    resolved = tomli_w.dumps(problem.model_dump(mode="json", exclude_none=True))
    (tmp_path / "problem.toml").write_text(resolved, encoding="utf-8")
    assert pik.load_problem(tmp_path / "problem.toml") == problem


def test_defaults_are_the_reference_subject() -> None:
    subject = pik.Subject()
    assert (subject.gender, subject.age, subject.weight, subject.stature) == ("male", 30, 80, 1.80)
    assert subject.body_mass_index == pytest.approx(24.69, abs=0.01)


def test_ranges_of_vertebrae_run_either_way() -> None:
    up = pik.Backrest(bodies="L2-T11").bodies
    assert up == pik.Backrest(bodies="T11-L2").bodies == ("L2", "L1", "T12", "T11")
    assert pik.Backrest(bodies=["T1", "T5"]).bodies == ("T1", "T5")
    assert SPINE[0] == "S1"
    assert SPINE[-1] == "Head"
    assert len(SPINE) == 26


def test_overrides_reach_blocks_tasks_and_words() -> None:
    problem = pik.load_problem(
        "pilot",
        (
            "seat.recline_deg=20",
            "title=A plain word or two",
            "task.backrest.slide=false",
            "task.4.side=left",
            "task.head.looking={ turn_deg = 5 }",
            "posture.stiffness.L4_L5_ry=700",
            "subject.stature=1.9",
        ),
    )
    assert problem.seat.recline_deg == 20
    assert problem.title == "A plain word or two"
    assert problem.task[0] == pik.Backrest(slide=False)
    assert problem.task[1].looking.turn_deg == 5
    assert problem.posture.stiffness == {"buttocks_S1_ry": 81.6, "L4_L5_ry": 700}
    assert problem.subject.stature == 1.9


def test_a_urdf_is_looked_for_beside_its_problem_file(tmp_path: Path) -> None:
    text = '[subject]\nurdf = "mine.urdf"\n[[task]]\nkind = "head"\n'
    (tmp_path / "problem.toml").write_text(text)
    assert pik.load_problem(tmp_path / "problem.toml").subject.urdf == tmp_path / "mine.urdf"


def test_a_urdf_set_by_command_is_looked_for_where_it_was_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    problem = pik.load_problem("upright", ("subject.urdf=mine.urdf",))
    assert problem.subject.urdf == tmp_path / "mine.urdf"


def test_problems_do_not_change() -> None:
    problem = pik.load_problem("upright")
    with pytest.raises(ValueError, match="frozen"):
        problem.title = "other"  # type: ignore[misc]


def test_a_bad_value_is_a_bad_problem() -> None:
    with pytest.raises(BadProblem, match=r"upright\.toml: seat\.recline_deg = 95"):
        pik.load_problem("upright", ("seat.recline_deg=95",))
