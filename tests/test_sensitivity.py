"""Derivatives against closed forms, against other steps, and against the derivative of H itself."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_tables import Tables
from rich.console import Console
from scipy.optimize import minimize_scalar

from posture_ik.arrays import one_thread
from posture_ik.body import build_body
from posture_ik.errors import BadProblem
from posture_ik.exchange import write_sensitivity
from posture_ik.posture import solve_posture
from posture_ik.problem import Problem, load_problem
from posture_ik.problem.paths import number_at, with_numbers
from posture_ik.sensitivity import Sensitivity, sensitivity, study
from posture_ik.sensitivity.parameters import parameters_of
from posture_ik.show.sensitivity_report import sensitivity_summary, write_sensitivity_report
from posture_ik.vibration import (
    Factors,
    LinearSystem,
    build_finite_element,
    linearise,
)

ONE_MASS = """
title = "one mass"
head = "m"
masses = {{ m = 50.0 }}
[[link]]
between = ["m", "seat"]
stiffness = 50e3
damping = {damping}
"""
#: Of each kind one: who sits, how the seat stands, what it gives.
SOME = ("subject.weight", "subject.stature", "seat.recline_deg", "seat.backrest.stiffness")


def of_one_mass(folder: Path, damping: float) -> Sensitivity:
    path = folder / "one.toml"
    path.write_text(ONE_MASS.format(damping=damping), encoding="utf-8")
    return sensitivity(load_problem("upright", (f"vibration.model=lumped:{path}",)))


def keep(monkeypatch: pytest.MonkeyPatch, *paths: str) -> None:
    """Change these parameters alone."""
    monkeypatch.setattr(
        study,
        "parameters_of",
        lambda problem: [p for p in parameters_of(problem) if p.path in paths],
    )


@pytest.fixture(scope="module")
def leaning() -> Problem:
    return load_problem("vibration_reclined_foam", ("vibration.frequencies.step=0.25",))


@pytest.fixture(scope="module")
def found(leaning: Problem) -> Sensitivity:
    with pytest.MonkeyPatch.context() as patch:
        keep(patch, *SOME, "factors.buttocks_shear")
        return sensitivity(leaning)


def resonance_and_peak(m: complex, k: complex, c: complex) -> tuple[complex, complex]:
    """Where the apparent mass of one mass on a spring is largest, Hz, and how large, kg."""
    square = c**2 / (4.0 * k * m)  # of the damping ratio
    r = (np.sqrt(1.0 + 8.0 * square) - 1.0) / (4.0 * square)  # ω² over that without damper
    height = np.sqrt((1.0 + 4.0 * square * r) / ((1.0 - r) ** 2 + 4.0 * square * r))
    return np.sqrt(r * k / m) / (2.0 * np.pi), m * height


def test_one_mass_as_in_closed_form(tmp_path: Path) -> None:
    """By a complex step of the closed form. Fourth-order errors of 1 % steps: (0.01)^4 times 10."""
    of = of_one_mass(tmp_path, 800.0)
    assert [p.path for p in of.parameters] == [
        "lumped.masses.m",
        "lumped.link.1.stiffness",
        "lumped.link.1.damping",
    ]
    assert [r.name for r in of.responses] == ["resonance", "peak apparent mass", "peak head z"]
    values = np.array([50.0, 50e3, 800.0])
    exact = np.array([np.imag(resonance_and_peak(*(values + 1e-30j * e))) for e in np.eye(3)])
    np.testing.assert_allclose(of.derivative[:, :2], exact / 1e-30, rtol=1e-6)
    np.testing.assert_allclose(
        [r.value for r in of.responses[:2]], np.real(resonance_and_peak(*values)), rtol=1e-10
    )
    for i, step in enumerate(np.diag(0.1 * values)):
        np.testing.assert_allclose(of.low[i, :2], np.real(resonance_and_peak(*(values - step))))
        np.testing.assert_allclose(of.high[i, :2], np.real(resonance_and_peak(*(values + step))))
    assert of.largest_miss < 1e-5


def test_with_little_damping_the_resonance_goes_as_the_root_of_k_over_m(tmp_path: Path) -> None:
    """dω/dk = ω/2k and dω/dm = -ω/2m but for the damping ratio squared, 4e-6."""
    elasticity = of_one_mass(tmp_path, 6.0).elasticity
    np.testing.assert_allclose(elasticity[:, 0], [-0.5, 0.5, 0.0], atol=2e-5)


def top(system: LinearSystem, near: float, output: str, power: int) -> tuple[float, float]:
    """Frequency and height of a peak, by SciPy's search of the response solved directly."""

    def size(frequency: float) -> float:
        s = 2j * np.pi * frequency
        _, _, Y, D, X = seen(system, output, s)
        return float(abs((Y @ X + D).item() * s**power))

    with one_thread():
        best = minimize_scalar(
            lambda f: -size(f),
            bounds=(near - 0.3, near + 0.3),
            method="bounded",
            options={"xatol": 1e-7},
        )
    return float(best.x), -float(best.fun)


def model(problem: Problem) -> LinearSystem:
    body = build_body(problem.subject)
    return linearise(body, solve_posture(body, problem), problem, ("Head",))


@pytest.mark.parametrize("path", ["subject.weight", "seat.recline_deg"])
def test_differences_of_the_whole_chain_at_other_steps(
    path: str, leaning: Problem, found: Sensitivity
) -> None:
    """Within 2e-4 % per %: a single step of 2 % is of second order, its search good to 1e-7 Hz."""
    i = [p.path for p in found.parameters].index(path)
    parameter = found.parameters[i]
    step = 0.02 * parameter.value
    systems = [
        model(with_numbers(leaning, {path: parameter.value + side * step})) for side in (-1, 1)
    ]
    resonance, mass, head, _ = found.responses
    less, more = (
        np.array(
            [
                *top(system, resonance.value, "seat force z", -2),
                top(system, head.frequency, "Head z", 0)[1],
            ]
        )
        for system in systems
    )
    values = np.array([resonance.value, mass.value, head.value])
    effect = (more - less) / (2.0 * step) * parameter.value / values
    np.testing.assert_allclose(found.elasticity[i, :3], effect, atol=2e-4)


def test_heights_as_the_derivative_of_the_response_says(
    leaning: Problem, found: Sensitivity
) -> None:
    """At a peak only H itself moves the height: d ln|H| = Re(dH / H), with

    dH = dY X + Y Z⁻¹ (dB - dZ X) + dD, from differences of the matrices alone (1e-5: theirs).
    """
    with one_thread():
        base = model(leaning)
        for i, parameter in enumerate(found.parameters[: len(SOME)]):
            h = 1e-3 * parameter.value
            less, more = (
                model(with_numbers(leaning, {parameter.path: parameter.value + side * h}))
                for side in (-1, 1)
            )
            for response, output in (
                (found.responses[1], "seat force z"),
                (found.responses[2], "Head z"),
            ):
                s = 2j * np.pi * response.frequency
                Z, _, Y, D, X = seen(base, output, s)
                dZ, dB, dY, dD = (
                    (b - a) / (2.0 * h)
                    for a, b in zip(
                        seen(less, output, s)[:4], seen(more, output, s)[:4], strict=True
                    )
                )
                H = (Y @ X + D).item()
                dH = (dY @ X + Y @ np.linalg.solve(Z, dB - dZ @ X) + dD).item()
                j = found.responses.index(response)
                slope = (dH / H).real * parameter.value
                assert found.elasticity[i, j] == pytest.approx(slope, abs=1e-5)


def seen(system: LinearSystem, output: str, s: complex) -> tuple[np.ndarray, ...]:
    of = system.of(["seat z"], [output])
    Z = s**2 * of.mass + s * of.damping + of.stiffness
    B, Y, D = (sum(s**k * part for k, part in enumerate(parts)) for parts in (of.B, of.Y, of.D))
    return Z, B, Y, D, np.linalg.solve(Z, B)


def test_certificate_and_ends(found: Sensitivity) -> None:
    assert found.stable
    assert found.moved == "seat z"
    assert found.largest_miss < 1e-3
    # No spring of the multibody person hangs on the buttocks' shear.
    np.testing.assert_array_equal(found.derivative[-1], 0.0)
    values = np.array([r.value for r in found.responses])
    steps = np.array([p.step for p in found.parameters])
    slope = (found.high - found.low) / (2.0 * steps[:, None])
    # Over a whole step the curves bend, but little; of the head's x with the recline most.
    gap = np.abs(slope - found.derivative) * steps[:, None] / values
    assert gap[:, :3].max() < 0.01
    assert gap.max() < 0.05


def test_factors_of_the_finite_element_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stiffer buttocks, by models built here; 1e-3: half a tenth's step is of second order."""
    keep(monkeypatch, "factors.buttocks")
    problem = load_problem("toward_no_backrest", ("vibration.frequencies.step=0.25",))
    of = sensitivity(problem)
    tops = [
        top(
            build_finite_element(problem.subject, factors=Factors(buttocks=1.0 + change)),
            of.responses[0].value,
            "seat force z",
            -2,
        )
        for change in (-0.05, 0.05)
    ]
    np.testing.assert_allclose(of.derivative[0, :2], (np.array(tops[1]) - tops[0]) / 0.1, rtol=1e-3)


def test_head_at_a_stated_frequency(tmp_path: Path) -> None:
    """T of one mass at 6 Hz in closed form; its slope by a complex step."""
    path = tmp_path / "one.toml"
    path.write_text(ONE_MASS.format(damping=800.0), encoding="utf-8")
    of = sensitivity(load_problem("upright", (f"vibration.model=lumped:{path}",)), 6.0)
    w = 2.0 * np.pi * 6.0

    def size(m: complex, k: complex, c: complex) -> complex:
        return np.sqrt((k**2 + (c * w) ** 2) / ((k - m * w**2) ** 2 + (c * w) ** 2))

    values = np.array([50.0, 50e3, 800.0])
    assert of.responses[-1].name == "head z"
    assert of.responses[-1].frequency == 6.0
    assert of.responses[-1].value == pytest.approx(size(*values), rel=1e-12)
    slopes = [np.imag(size(*(values + 1e-30j * e))) / 1e-30 for e in np.eye(3)]
    np.testing.assert_allclose(of.derivative[:, -1], slopes, rtol=1e-6)


def test_every_number_of_subject_seat_and_model_once() -> None:
    problem = load_problem(
        "vibration_cushion", ("subject.measured.sitting_height=0.93", "seat.recline_deg=0")
    )
    paths = [p.path for p in parameters_of(problem)]
    assert len(set(paths)) == len(paths)
    assert {
        "subject.age",
        "subject.measured.sitting_height",
        "seat.recline_deg",
        "seat.cushion.cushion.mass",
        *(f"factors.{name}" for name in Factors._fields),
    } <= set(paths)
    for parameter in parameters_of(problem):
        assert parameter.step > 0.0
        if not parameter.path.startswith("factors."):
            assert number_at(problem, parameter.path) == parameter.value


@pytest.mark.parametrize(
    ("overrides", "frequency", "told"),
    [
        ((), 0.0, "at: 0 Hz"),
        (("vibration.frequencies.stop=1.0",), None, "no peak between 0.1 and 1 Hz"),
    ],
)
def test_what_cannot_be_asked(
    overrides: tuple[str, ...], frequency: float | None, told: str
) -> None:
    problem = load_problem("vibration_upright", overrides)
    with pytest.raises(BadProblem, match=told):
        sensitivity(problem, frequency)


def test_page_and_file_tell_the_same(tmp_path: Path, found: Sensitivity) -> None:
    write_sensitivity_report(found, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    rows = Tables(page).rows["derivatives"][2:]
    assert [row[0] for row in rows] == [
        "weight",
        "stature",
        "recline",
        "backrest stiffness",
        "buttocks shear",
    ]
    assert [row[2] for row in rows] == ["kg", "m", "°", "kN/m", "1"]

    def number(text: str) -> float:
        return float(text.replace("−", "-"))

    for i, row in enumerate(rows):
        per = 1e3 if row[2] == "kN/m" else 1.0
        for j in range(4):
            told, elasticity = number(row[3 + 2 * j]), number(row[4 + 2 * j])
            assert told == pytest.approx(per * found.derivative[i, j], rel=6e-3, abs=1e-6)
            assert elasticity == pytest.approx(found.elasticity[i, j], abs=6e-4)
    assert page.count('class="plot"') == 4
    assert "By less than 0.1 %: " in page
    assert "unstable" not in page
    write_sensitivity(found, tmp_path)
    whole = json.loads((tmp_path / "sensitivity.json").read_text(encoding="utf-8"))
    assert whole["rows"] == found.records()
    assert whole["largest_miss"] == found.largest_miss
    with (console := Console(width=120)).capture() as told:
        console.print(sensitivity_summary(found))
    assert "Without effect: buttocks shear." in told.get()
    line = next(line for line in told.get().splitlines() if line.split()[:2] == ["weight", "kg"])
    assert number(line.split()[2]) == pytest.approx(found.derivative[0, 0], rel=6e-3)


def test_a_peak_that_is_lost_is_told(tmp_path: Path, found: Sensitivity) -> None:
    """On the way to 10 % less weight the head's x loses its peak."""
    low, derivative = found.low.copy(), found.derivative.copy()
    low[0, 3] = derivative[0, 3] = np.nan
    lost = replace(found, low=low, derivative=derivative)
    row = lost.records()[3 * len(lost.parameters)]
    assert (row["response"], row["parameter"]) == ("peak head x", "subject.weight")
    assert row["low"] is row["derivative"] is row["elasticity"] is None
    assert row["high"] == found.high[0, 3]
    write_sensitivity_report(lost, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert Tables(page).rows["derivatives"][2][9:] == ["lost", "lost"]
    assert "72 kg: the peak is lost" in page
    write_sensitivity(lost, tmp_path)
    assert "NaN" not in (tmp_path / "sensitivity.json").read_text(encoding="utf-8")
