"""How fast another person is built, seated, linearised and shaken: each stage, and all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import posture_ik as pik
from posture_ik.crowd import examine, random_people
from posture_ik.problem import Cushion, FoamBack
from posture_ik.vibration import build_finite_element

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type
People = list[pik.Subject]


@pytest.fixture(scope="module")
def problem() -> pik.Problem:
    return pik.load_problem("reclined_15")


@pytest.fixture(scope="module")
def people() -> People:
    return random_people(50, seed=1)[16:]


@pytest.mark.benchmark(group="another person")
def test_body(benchmark: Benchmark, people: People) -> None:
    turns = iter(people * 1000)
    assert benchmark(lambda: pik.build_body(next(turns))).model.nv > 100


@pytest.mark.benchmark(group="another person")
def test_body_and_posture(benchmark: Benchmark, people: People, problem: pik.Problem) -> None:
    turns = iter(people * 1000)
    posture = benchmark(lambda: pik.solve_posture(pik.build_body(next(turns)), problem))
    assert posture.certificate.holds


@pytest.mark.benchmark(group="another person")
def test_whole_chain(benchmark: Benchmark, people: People, problem: pik.Problem) -> None:
    """Body, posture, linearised, response at 79 frequencies, certificate, stability."""
    turns = iter(people * 1000)
    assert not benchmark(lambda: examine(problem, next(turns))).trouble


@pytest.mark.benchmark(group="finite-element spine on cushion and foam, 400 frequencies")
@pytest.mark.parametrize("method", ["modal", "direct"])
def test_finite_element_response(benchmark: Benchmark, method: Any) -> None:
    system = build_finite_element(backrest=FoamBack(), cushion=Cushion())
    frequencies = np.linspace(0.05, 20.0, 400)
    data = benchmark(pik.frequency_response, system, frequencies, method)
    assert data.method == method
