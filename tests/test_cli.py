"""The command line as a user types it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pinocchio as pin
import pytest

from posture_ik.cli import main


@pytest.fixture
def posture_ik(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> object:
    """Run `posture-ik` with these words in an empty folder and give what it prints."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["posture-ik", *words])
        with pytest.raises(SystemExit) as stopped:
            main()
        assert stopped.value.code == 0, capsys.readouterr().err
        return capsys.readouterr().out

    return run


def test_run_writes_everything(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("run", "reclined_15", "-o", "here")
    names = {path.name for path in (tmp_path / "here").iterdir()}
    assert names == {
        "problem.toml",
        "posture.nc",
        "prestrain.csv",
        "model.urdf",
        "meshes",
        "report.html",
        "view.html",
    }
    assert "strain energy" in said
    assert "holds" in said
    assert "here/report.html" in said
    (tmp_path / "here" / "report.html").unlink()
    posture_ik("report", "here")
    assert (tmp_path / "here" / "report.html").exists()


def test_json_is_for_machines(posture_ik: object, tmp_path: Path) -> None:
    (record,) = json.loads(
        posture_ik("solve", "reclined_15", "--set", "seat.recline_deg=20", "--json")
    )
    assert record["certificate"]["holds"] is True
    assert record["energy_J"] > 1
    assert {wrench["at"] for wrench in record["wrenches"]} == {"backrest", "head", "seat"}
    assert list(tmp_path.iterdir()) == []


def test_solve_writes_numbers_where_asked(posture_ik: object, tmp_path: Path) -> None:
    posture_ik("solve", "upright", "-o", "numbers")
    assert (tmp_path / "numbers" / "posture.nc").exists()
    assert not (tmp_path / "numbers" / "report.html").exists()


def test_export_writes_a_urdf_that_pinocchio_loads(posture_ik: object, tmp_path: Path) -> None:
    posture_ik("export", "upright", "--to", "urdf", "-o", "person", "--set", "subject.stature=1.9")
    model = pin.buildModelFromUrdf(str(tmp_path / "person" / "model.urdf"))
    assert model.nq == 117


def test_export_writes_a_posture_for_mbdyn(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("export", "reclined_15", "--to", "mbdyn", "-o", "deck")
    assert "deck/posture.mbd" in said
    names = {path.name for path in (tmp_path / "deck").iterdir()}
    assert names == {f"posture.{suffix}" for suffix in ("ref", "nod", "elm", "loads", "mbd")}
    elements = (tmp_path / "deck" / "posture.elm").read_text()
    assert elements.count("deformable joint") == elements.count("prestrain, single") == 34


def test_export_writes_nastran_decks(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("export", "reclined_15", "--to", "nastran", "-o", "deck")
    assert "deck/modes.bdf and deck/response.bdf" in said.replace("\n", " ")
    assert "SOL 103" in (tmp_path / "deck" / "modes.bdf").read_text()
    posture_ik("export", "reclined_15", "--to", "nastran95", "-o", "deck")
    assert "SOL 3,0" in (tmp_path / "deck" / "modes.inp").read_text()


def test_problems_lists_the_examples(posture_ik: object) -> None:
    listed = {entry["name"] for entry in json.loads(posture_ik("problems", "--json"))}
    assert "reclined_15" in listed
    assert "Backrest 15° back" in posture_ik("problems")


def test_trajectory_writes_its_course_and_pages(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("run", "reach_cyclic", "-o", "here")
    names = {path.name for path in (tmp_path / "here").iterdir()}
    assert {"posture.nc", "trajectory.nc", "report.html", "trajectory.html", "view.html"} <= names
    assert "m or rad from its tasks" in said
    assert "trajectory.html" in said
    (tmp_path / "here" / "trajectory.html").unlink()
    posture_ik("report", "here")
    assert (tmp_path / "here" / "trajectory.html").exists()


def test_trajectory_for_machines(posture_ik: object, tmp_path: Path) -> None:
    (record,) = json.loads(
        posture_ik(
            *("trajectory", "reach_cyclic", "--json", "-o", "numbers"),
            *("--set", "trajectory.duration=0.8"),
        )
    )
    assert record["duration_s"] == 0.8
    assert record["end_error"] < 1e-3
    assert set(record["peak_tau"]) == set(record["start"]) == set(record["end"])
    assert len(record["peak_tau"]) == 7
    assert [path.name for path in (tmp_path / "numbers").iterdir()] == ["trajectory.nc"]


def test_activate_tells_and_writes_what_muscles_do(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("activate", "pilot_collective", "--set", "motion.rate=10", "-o", "numbers")
    assert "Most active muscles at any time" in said
    assert "the instant of greatest effort" in said
    assert "left shoulder flexion" in said
    assert "right arm" in said
    assert "FALL SHORT" not in said
    assert [path.name for path in (tmp_path / "numbers").iterdir()] == ["activation.nc"]


def test_activate_a_problem_that_says_nothing_of_muscles(posture_ik: object) -> None:
    (record,) = json.loads(posture_ik("activate", "pilot_push", "--set", "motion.rate=5", "--json"))
    assert record["answered"] is True
    assert record["certificate"]["holds"] is True
    assert record["steps"] > 1
    assert len(record["peak_activation"]) == 50
    assert len(record["peak_demand_Nm"]) == 14


def test_activate_beyond_strength_names_the_joints_first(posture_ik: object) -> None:
    words = ("activate", "pilot", "--set", "activation.hand_force.left=[0, 0, -500]")
    said = posture_ik(*words)
    assert said.index("MUSCLES FALL SHORT") < said.index("Most active")
    assert "left elbow flexion lacks" in said
    told = posture_ik(*words, "--json")
    assert "NaN" not in told
    (record,) = json.loads(told)
    assert record["answered"] is False
    worst = record["shortfalls"][0]
    assert record["peak_reserve_Nm"][worst["joint"]] == pytest.approx(abs(worst["torque_Nm"]))
    assert abs(worst["torque_Nm"]) > 10


def test_run_with_muscles_writes_their_page(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("run", "pilot", "-o", "here")
    names = {path.name for path in (tmp_path / "here").iterdir()}
    assert {"activation.nc", "activation.html", "view.html"} <= names
    assert "Most active muscles" in said
    assert "here/activation.html" in said.replace("\n", "")
    assert 'data-layer="muscles"' in (tmp_path / "here" / "view.html").read_text("utf-8")
    (tmp_path / "here" / "activation.html").unlink()
    posture_ik("report", "here")
    assert (tmp_path / "here" / "activation.html").exists()


def test_compare_lays_numbers_side_by_side(posture_ik: object, tmp_path: Path) -> None:
    rows = json.loads(posture_ik("compare", "--json", "-o", "there"))
    assert len(rows) > 70
    assert {row["source"] for row in rows} >= {"table 6", "§3.3", "table 7", "§6.1"}
    page = (tmp_path / "there" / "compare.html").read_text(encoding="utf-8")
    for row in rows:
        assert f'<th scope="row">{row["quantity"]}</th>' in page.replace("&#39;", "'")


def test_identify_writes_values_record_and_page(
    posture_ik: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of one factor alone, from one start: the buttocks' stiffness, which stays near its own."""
    monkeypatch.setattr("posture_ik.vibration.identify.FACTORS", {"buttocks": (0.5, 2.0)})
    monkeypatch.setattr("posture_ik.vibration.identify.STARTS", 0)
    (found,) = json.loads(posture_ik("identify", "calibrated", "--json", "-o", "found"))
    value = found["values"]["buttocks"]
    assert 0.5 < value < 2.0
    folder = tmp_path / "found"
    assert f"buttocks,{value:g},1" in (folder / "calibrated.csv").read_text(encoding="utf-8")
    assert json.loads((folder / "calibrated_record.json").read_text(encoding="utf-8")) == found
    page = (folder / "calibrated.md").read_text(encoding="utf-8")
    assert f"| buttocks | {value:g} |" in page
    assert "| mode 8 Hz | 4.9 |" in page


def test_sensitivity_tells_and_writes(posture_ik: object, tmp_path: Path) -> None:
    """Of a lumped model on a cushion, which takes a moment; more is in test_sensitivity.py."""
    asked = ("sensitivity", "vibration_cushion", "--set", "vibration.model=lumped:wan_schimmels")
    rows = json.loads(posture_ik(*asked, "--json", "--at", "8", "-o", "there"))
    assert {row["response"] for row in rows} == {"resonance", "peak apparent mass", "head z"}
    assert "seat.cushion.seat.stiffness" in {row["parameter"] for row in rows}
    folder = tmp_path / "there"
    whole = json.loads((folder / "sensitivity.json").read_text(encoding="utf-8"))
    assert whole["rows"] == rows
    assert whole["moved"] == "floor z"
    said = posture_ik(*asked, "-o", "there")
    assert "peak head z" in said
    assert "seat stiffness" in said
    assert "Open there/sensitivity.html" in said.replace("\n", "")
    assert "floor z" in (folder / "sensitivity.html").read_text(encoding="utf-8")


def test_vibrate_tells_and_writes_the_response(posture_ik: object, tmp_path: Path) -> None:
    said = posture_ik("vibrate", "vibration_reclined_foam", "-o", "numbers")
    assert "a backrest of foam" in said
    assert "stable: all motion dies away" in said
    assert "Finite elements" in said
    assert "UNSTABLE" not in said
    assert [path.name for path in (tmp_path / "numbers").iterdir()] == ["response.nc"]


def test_vibrate_a_problem_that_says_nothing_of_vibration(posture_ik: object) -> None:
    told = posture_ik("vibrate", "upright", "--json", "--set", "vibration.frequencies.step=0.5")
    assert "NaN" not in told
    (record,) = json.loads(told)
    assert record["stable"] is True
    assert record["frequencies"] == 40
    assert record["responses"]["multibody"]["head"]["z"]["peak"] > 1.5
    assert record["undamped_modes"][0]["symmetry"] == "symmetric"


def test_run_with_vibration_writes_its_page_and_its_modes(
    posture_ik: object, tmp_path: Path
) -> None:
    said = posture_ik(
        *("run", "vibration_cushion", "-o", "here"),
        *("--set", "vibration.frequencies.step=0.5", "--set", "vibration.beside=[]"),
    )
    names = {path.name for path in (tmp_path / "here").iterdir()}
    assert {"response.nc", "vibration.html", "view.html"} <= names
    assert "Peaks: head over floor" in said
    assert "here/vibration.html" in said.replace("\n", "")
    assert "Modes" in (tmp_path / "here" / "view.html").read_text("utf-8")
    (tmp_path / "here" / "vibration.html").unlink()
    posture_ik("report", "here")
    assert (tmp_path / "here" / "vibration.html").exists()
