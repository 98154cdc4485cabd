"""How fast the muscles' paths are: `pytest tests/benchmarks --benchmark-enable`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import posture_ik as pik
from posture_ik.muscle import Paths
from posture_ik.muscle.path import _graph, _kept, _lengths

Benchmark = Any  # pytest-benchmark's fixture is callable and has no public type


@pytest.fixture(scope="module")
def paths() -> Paths:
    return Paths.of(pik.build_body(pik.Subject()))


@pytest.mark.benchmark(group="muscle paths")
def test_lengths_and_moment_arms(benchmark: Benchmark, paths: Paths) -> None:
    """50 lengths and their slopes, as they are called."""
    benchmark(paths.evaluate, paths.body.q_reference)


@pytest.mark.benchmark(group="muscle paths")
def test_lengths_and_moment_arms_in_the_machine(benchmark: Benchmark, paths: Paths) -> None:
    """The same in CasADi's virtual machine alone."""
    paths.evaluate(paths.body.q_reference)
    benchmark(_kept(_lengths, 0).run)


@pytest.mark.benchmark(group="muscle paths")
def test_curvature(benchmark: Benchmark, paths: Paths) -> None:
    benchmark(paths.curvature, paths.body.q_reference, np.ones(50))


@pytest.mark.benchmark(group="muscle paths")
def test_polylines(benchmark: Benchmark, paths: Paths) -> None:
    benchmark(paths.polylines, paths.body.q_reference)


@pytest.mark.benchmark(group="build")
def test_build_graph(benchmark: Benchmark, paths: Paths) -> None:
    """The graph and its functions, once a process."""

    def build() -> None:
        for function in (_graph, _lengths, _kept):
            function.cache_clear()
        paths.evaluate(paths.body.q_reference)

    benchmark.pedantic(build, rounds=3)
