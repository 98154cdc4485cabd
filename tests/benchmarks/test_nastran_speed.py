"""How long our response takes, and NASTRAN-95's on the deck we write of the same model.

NASTRAN-95's time is that of its whole run, with reading the deck and printing every body.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nastran95_oracle as nastran95
import numpy as np
import pytest

import posture_ik as pik
from posture_ik.exchange import write_nastran
from posture_ik.problem import VibrationBlock
from posture_ik.problem.vibration import FrequencyBlock
from posture_ik.vibration import build_finite_element, frequency_response

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type

pytestmark = pytest.mark.benchmark(group="finite-element spine, 100 frequencies, from the problem")


@pytest.fixture
def problem() -> pik.Problem:
    asked = VibrationBlock(frequencies=FrequencyBlock(start=0.2, stop=20.0, step=0.2))
    return pik.load_problem("upright").model_copy(update={"vibration": asked})


def test_ours(benchmark: Benchmark, problem: pik.Problem) -> None:
    frequencies = problem.vibration.frequencies.values  # type: ignore[union-attr]

    def work() -> Any:
        system = build_finite_element(problem.subject)
        ports = ["seat x", "seat y", "seat z"], ["Head acceleration", "seat force"]
        return frequency_response(system.of(*ports), frequencies)

    assert np.all(np.isfinite(benchmark(work).to_array()))


@nastran95.needed
def test_nastran_95(benchmark: Benchmark, problem: pik.Problem, tmp_path: Path) -> None:
    write_nastran(problem, tmp_path, "nastran95")
    deck = (tmp_path / "response.inp").read_text()
    printed = benchmark.pedantic(nastran95.run, (deck,), rounds=3)
    assert len(nastran95.accelerations(printed)[3, 1][0]) == 100
