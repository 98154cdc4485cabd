"""The laws of scaling against the published apparent masses they are identified on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from posture_ik.body import scaling, tables
from posture_ik.body.corrections import Corrections
from posture_ik.body.scaling_thesis import KITAZAKI, thesis
from posture_ik.problem import Subject, load_problem
from posture_ik.validation import Numbers, apparent_mass_of, cases, frequencies_of

DATA = Path(tables.__file__).parent / "data"


def own_rows():
    """The source's model where it is open: tables 15, 17 and 25."""
    kept = (15, 17, 25)
    return [c for c in cases() if c.thesis and c.table in kept and c.kind == "tabled"]


def test_thesis_law_reproduces_the_sources_own_rows():
    """As `validate` runs them: within 0.1 Hz and 3 %, tables 15, 17 and 25."""
    for case in own_rows():
        seat = "toward_rigid_upright" if case.table == 17 else "toward_no_backrest"
        problem = load_problem(seat, ("subject.scaling=thesis",))
        ours = Numbers.of(frequencies_of(problem), apparent_mass_of(problem, case.person))
        assert ours.resonance == pytest.approx(case.thesis.resonance, abs=0.1 + 1e-9)
        np.testing.assert_allclose(ours[1:], case.thesis[1:], rtol=0.03)


def test_thesis_law_is_eq_57():
    """K' = K λxλy/λz, and mass as volume, of whatever λ's a person has."""
    person = Subject(gender="female", age=60, weight=60, stature=1.6)
    scale = thesis(person)
    x, y, z = scale.length["lumbar"]
    assert scale.stiffness("lumbar", "axial") == pytest.approx(x * y / z)
    assert scale.damping("lumbar", "rx") == pytest.approx(x * y**3 / z)
    assert scale.mass["lumbar"] == pytest.approx(x * y * z)
    assert thesis(KITAZAKI) == scaling.Scale.alike((1.0, 1.0, 1.0), 1.0)


def test_problem_files_sit_as_identified():
    """The four seats hold the values of the record: how people sat, and what is along the back."""
    record = json.loads((DATA / "corrections_record.json").read_text(encoding="utf-8"))
    value = {name: of["value"] for name, of in record["values"].items()}
    for name in Corrections._fields:
        assert getattr(Corrections.identified(), name) == pytest.approx(value[name], rel=1e-3)
    for seat in ("no_backrest", "rigid_upright", "rigid_reclined", "foam_reclined"):
        problem = load_problem(f"toward_{seat}")
        assert problem.subject.thigh_on_seat == pytest.approx(value["thigh_on_seat"], abs=0.005)
        assert problem.subject.tension == pytest.approx(np.exp(value["log_tension"]), abs=0.005)
        if seat.startswith("rigid"):
            back = problem.seat.backrest
            for name in ("tangential_stiffness", "tangential_damping"):
                assert getattr(back, name) == pytest.approx(np.exp(value[f"log_{name}"]), rel=0.01)


def test_multibody_model_follows_the_same_law():
    """Both models change alike from the mean subject to others: within 6 % of the change's base."""
    few = [c for c in cases() if c.table == 25 and c.kind == "tabled"]
    chosen = [c.person for c in few if (c.condition, c.row) in {("BMI", 31), ("age", 53)}]
    base = load_problem("toward_no_backrest")
    people = [base.subject, *chosen]
    numbers = {}
    for model in ("finite_element", "multibody"):
        problem = load_problem("toward_no_backrest", (f"vibration.model={model}",))
        f = frequencies_of(problem)
        numbers[model] = np.array([Numbers.of(f, apparent_mass_of(problem, p)) for p in people])
    ratio = {model: of[1:] / of[0] for model, of in numbers.items()}
    np.testing.assert_allclose(ratio["multibody"], ratio["finite_element"], rtol=0.06)
