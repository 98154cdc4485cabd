"""Forces and recruitment against OpenSim: De Groote's law, and its static optimisation."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import opensim_arms as peer
import pytest

import posture_ik as pik
from posture_ik.muscle.activity import ARMS
from posture_ik.muscle.hill import de_groote

#: Postures and loads on the hands, N; a lever's weight and spring load the right hand in the last.
CASES = {
    "pilot": ("pilot", ()),
    "pilot, loaded": (
        "pilot",
        ("activation.hand_force={right=[5, -10, -20], left=[0, 8, 3]}",),
    ),
    "pilot_push": ("pilot_push", ("activation.hand_force.left=[0, 0, -10]",)),
}


@pytest.fixture(scope="module")
def body() -> pik.Body:
    return pik.build_body(pik.Subject())


@pytest.fixture(scope="module", params=CASES)
def activity(body: pik.Body, request: pytest.FixtureRequest) -> pik.Activity:
    name, settings = CASES[request.param]
    problem = pik.load_problem(name, ("activation.law=de_groote", *settings))
    activity = pik.solve_activation(body, pik.solve_posture(body, problem), problem)
    assert activity.shortfalls == ()
    return activity


def test_forces_are_opensims(body: pik.Body, opensim: ProcessPoolExecutor) -> None:
    """Active and passive, still and moving, all over the arms' range: to rounding, 1e-9 N.

    Both state the same closed forms, so nothing but the order of operations may differ.
    """
    random = np.random.default_rng(7)
    problem = pik.load_problem("pilot")
    posture = pik.solve_posture(body, problem)
    paths = pik.Paths.of(body)
    for speed in (0.0, 0.0, 1.0, 3.0):
        q = posture.q.copy()
        q[paths.rows] = random.uniform(paths.lower, paths.upper)
        activity = pik.solve_activation(body, replace(posture, q=q), problem)
        arms = peer.arms_of(activity)
        speeds, activation = speed * random.normal(size=14), random.uniform(0.0, 1.0, 50)
        active, passive = opensim.submit(peer.forces, arms, speeds, activation).result()
        ours = de_groote(activity.muscles, arms.length, arms.jacobian @ speeds, activation)
        np.testing.assert_allclose(passive, ours.passive, rtol=0, atol=1e-9)
        np.testing.assert_allclose(active, ours.force - ours.passive, rtol=0, atol=1e-9)


def test_static_optimisation_recruits_the_same(
    activity: pik.Activity, opensim: ProcessPoolExecutor
) -> None:
    """Every activation to 1e-4, from bodies, joints, loads, moment arms and muscles.

    OpenSim works out the demand from weight and loads, and each muscle's force along its path, and
    finds the least sum of squares with IPOPT to 1e-8. Its reserves, at most 1e-4 N m, shift
    activations by less than the tolerance.
    """
    arms = peer.arms_of(activity)
    strength, passive = opensim.submit(peer.forces, arms, np.zeros(14), np.ones(50)).result()
    opensim.submit(
        peer.prepare, arms, -arms.jacobian.T @ passive, strength=strength, tolerance=1e-8
    ).result()
    activation, reserve = opensim.submit(peer.follow, 3).result()
    assert np.abs(reserve).max() < 1e-4
    np.testing.assert_allclose(activation, activity.activation[0], rtol=0, atol=1e-4)
    for arm in ARMS.values():
        assert np.count_nonzero(activation[arm[0]] > 0.01) > 5


def test_the_same_muscles_work_in_opensim_as_it_comes(
    activity: pik.Activity, opensim: ProcessPoolExecutor
) -> None:
    """Its own scaling and tolerance: within 0.05, and the same muscles above 0.05.

    The scaling leaves out the cosine of the pennation, so that muscles count as up to 1.4 times as
    strong and the shares shift, by 0.031 at most here.
    """
    arms, ours = peer.arms_of(activity), activity.activation[0]
    opensim.submit(peer.prepare, arms, activity.passive[0]).result()
    activation, _ = opensim.submit(peer.follow, 1).result()
    np.testing.assert_allclose(activation, ours, rtol=0, atol=0.05)
    assert set(np.flatnonzero(activation > 0.05)) == set(np.flatnonzero(ours > 0.05))


@pytest.mark.parametrize("activity", ["pilot, loaded"], indirect=True)
def test_another_law_recruits_alike(activity: pik.Activity, opensim: ProcessPoolExecutor) -> None:
    """Millard's curves, active and passive: within 0.04; who is busy in one works in both.

    Its passive curve starts only at the optimal length, ours below; that is 30 N at most. Loaded
    hands ask for more than that; with a hand in the lap activations would differ by up to 0.3.
    """
    arms, ours = peer.arms_of(activity), activity.activation[0]
    strength, passive = opensim.submit(
        peer.forces, arms, np.zeros(14), np.ones(50), peer.MILLARD
    ).result()
    torque = -arms.jacobian.T @ passive
    opensim.submit(peer.prepare, arms, torque, strength=strength, law=peer.MILLARD).result()
    activation, _ = opensim.submit(peer.follow, 1).result()
    np.testing.assert_allclose(activation, ours, rtol=0, atol=0.04)
    assert np.all(ours[activation > 0.1] > 0.05)
    assert np.all(activation[ours > 0.1] > 0.05)
