"""Muscles and moment arms, read once for all tests of the room."""

from __future__ import annotations

import importlib.util
import os

import numpy as np
import pytest
from arm_muscles import RANGES, TABLE, Arm, Table


@pytest.fixture(scope="session")
def muscles() -> Table:
    force, optimal, slack, pennation = np.array(list(TABLE.values())).T
    # 10 optimal lengths a second (assumed)
    return Table(tuple(TABLE), force, optimal, slack, np.radians(pennation), 10 * optimal)


@pytest.fixture(scope="session")
def arm() -> Arm:
    missing = [name for name in ("mujoco", "myo_sim") if importlib.util.find_spec(name) is None]
    if missing and os.environ.get("CI") != "true":
        pytest.skip(f"not installed: {', '.join(missing)}")
    return Arm()


@pytest.fixture(scope="session")
def postures(arm: Arm) -> tuple[np.ndarray, ...]:
    """1000 random postures: angles (1000, 7), lengths, Jacobians of the paths and of the hand."""
    random = np.random.default_rng(5)
    q = random.uniform(RANGES[:, 0], RANGES[:, 1], (1000, 7))
    return q, *(np.array(part) for part in zip(*(arm(x) for x in q), strict=True))
