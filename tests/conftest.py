"""OpenSim in a process of its own, for all tests that ask it."""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest


@pytest.fixture(scope="session")
def opensim() -> Iterator[ProcessPoolExecutor]:
    """Where `opensim_arms` runs: OpenSim's CasADi and ours cannot share a process.

    CI must have it where there is a wheel of it, which pyproject.toml asks for.
    """
    there_is_one = sys.platform == "linux" and platform.machine() == "x86_64"
    if importlib.util.find_spec("opensim") is None:
        if there_is_one and os.environ.get("CI") == "true":
            pytest.fail("opensim is not installed; pip install -e '.[test]' brings it")
        pytest.skip("opensim is not installed")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        yield process
