"""Postures and models that the tests of vibration share."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import pytest

import posture_ik as pik
from posture_ik.arrays import one_thread


@pytest.fixture(autouse=True)
def _alone() -> Iterator[None]:
    """Matrices here are too small to share among threads, and many."""
    with one_thread():
        yield


@pytest.fixture(scope="session")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@cache
def _solved(
    body: pik.Body, name: str, settings: tuple[str, ...]
) -> tuple[pik.Posture, pik.Problem]:
    problem = pik.load_problem(name, settings)
    return pik.solve_posture(body, problem), problem


class Models:
    """Examples by name, solved and linearised once for each setting."""

    def __init__(self, body: pik.Body) -> None:
        self.body = body

    def solved(self, name: str, *settings: str) -> tuple[pik.Posture, pik.Problem]:
        return _solved(self.body, name, settings)

    def __call__(self, name: str, *settings: str) -> pik.LinearSystem:
        posture, problem = self.solved(name, *settings)
        return pik.linearise(self.body, posture, problem)


@pytest.fixture(scope="session")
def models(body: pik.Body) -> Models:
    return Models(body)
