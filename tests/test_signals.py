"""Signals against differences: rate and acceleration are what the value does, without a jump."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from posture_ik.errors import BadProblem
from posture_ik.problem import load_problem
from posture_ik.problem.signals import Signal

SIGNALS = {
    "constant": {"value": 3.0},
    "sine": {"amplitude": 20.0, "frequency": 1.3, "offset": 5.0, "phase_deg": 30.0},
    "cosine_step": {"initial": 2.0, "final": 45.0, "start": 0.3, "stop": 1.7},
    "ramp": {"initial": 10.0, "final": -5.0, "start": 0.2, "stop": 1.5},
    "table": {"times": [0.0, 0.4, 1.1, 2.0], "values": [0.0, 10.0, -4.0, 6.0]},
}


def signal(kind: str) -> Signal:
    return TypeAdapter(Signal).validate_python({"of": "x", "kind": kind, **SIGNALS[kind]})


@pytest.mark.parametrize("kind", SIGNALS)
def test_rates_equal_central_differences(kind: str) -> None:
    """Away from joints of pieces the error is of second order: 1e-4 of the largest rate here."""
    h = 1e-4
    t = np.linspace(0.01, 1.99, 397)
    (before, *_), (value, rate, acceleration), (after, *_) = (
        signal(kind).at(t + shift) for shift in (-h, 0.0, h)
    )
    scale = 1.0 + np.abs(acceleration).max()
    np.testing.assert_allclose((after - before) / (2 * h), rate, atol=1e-4 * scale)
    curvature = (after - 2 * value + before) / h**2
    np.testing.assert_allclose(curvature, acceleration, atol=2e-2 * scale)


@pytest.mark.parametrize("kind", SIGNALS)
def test_accelerations_do_not_jump(kind: str) -> None:
    """Between samples 1e-5 s apart the acceleration changes by no more than a slope allows."""
    acceleration = signal(kind).at(np.arange(0.0, 2.0, 1e-5))[2]
    assert np.abs(np.diff(acceleration)).max() < 1e-3 * (1.0 + np.abs(acceleration).max())


@pytest.mark.parametrize("kind", ["cosine_step", "ramp"])
def test_changes_start_and_end_at_rest(kind: str) -> None:
    change = signal(kind)
    value, rate, acceleration = change.at(np.array([0.0, change.start, change.stop, 2.0]))
    np.testing.assert_allclose(value, [change.initial] * 2 + [change.final] * 2, atol=1e-12)
    np.testing.assert_allclose(rate, 0.0, atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-10)


def test_a_table_passes_through_its_values() -> None:
    table = signal("table")
    np.testing.assert_allclose(table.at(np.array(table.times))[0], table.values, atol=1e-12)


def test_times_that_turn_back_are_refused() -> None:
    with pytest.raises(ValidationError, match="a target that jumps has no velocity"):
        TypeAdapter(Signal).validate_python(
            {"of": "x", "kind": "table", "times": [0, 1, 1], "values": [0, 1, 2]}
        )


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("motion.signal.1.of=task.head.looking.nodd_deg", "no 'nodd_deg'; did you mean 'nod_deg'"),
        ("motion.signal.1.of=seat", "can only move a number"),
        ("motion.signal.1.of=title", "can only move a number"),
        ("motion.signal.1.of=title.part", "has no parts"),
        ("motion.signal.1.frequency=0", "frequency = 0"),
        ("motion.duration=0", "motion.duration = 0"),
        ("motion.rate=1", "too few steps"),
        ("motion.signal.1.kind=cosine", "cosine"),
        (
            'motion.signal.1={ of="seat.recline_deg", kind="ramp", initial=0, final=9, stop=0 }',
            "take",
        ),
        (
            'motion.signal.1={of="seat.recline_deg",kind="table",times=[0,1],values=[0,1]}',
            "spans 0 to 1 s, but the motion 0 to 2 s",
        ),
    ],
)
def test_bad_motions_are_said(override: str, message: str) -> None:
    with pytest.raises(BadProblem, match=message):
        load_problem("nod", (override,))
