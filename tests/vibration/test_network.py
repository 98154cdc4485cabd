"""The parts of networks against kinematics, least squares and constrained dynamics."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from posture_ik.vibration.network import Mass, Spring, assemble, average, carry, exerted, hold

RANDOM = np.random.default_rng(2)


def test_a_rigid_link_moves_as_a_small_rigid_motion_does():
    """Against the displacement of a point under a finite motion of size ε: they differ by ε²."""
    offset, motion, epsilon = RANDOM.normal(size=3), RANDOM.normal(size=6), 1e-6
    turned = Rotation.from_rotvec(epsilon * motion[3:]).apply(offset) - offset
    finite = epsilon * motion[:3] + turned
    linear = carry(offset) @ (epsilon * motion)
    np.testing.assert_allclose(linear[:3], finite, atol=20 * epsilon**2)
    np.testing.assert_allclose(linear[3:], epsilon * motion[3:])


def test_an_average_of_rigidly_linked_points_is_their_motion():
    """Also of points on a line, whose displacements alone would leave a rotation open."""
    at, motion = RANDOM.normal(size=3), RANDOM.normal(size=(6, 4))
    points = [np.array([0.1, 0.0, z]) for z in (0.0, 0.3, 0.7)]
    motions = [carry(point - at) @ motion for point in points]
    np.testing.assert_allclose(average(motions, points, at), motion, atol=1e-12)


def test_an_average_is_the_nearest_rigid_motion():
    """Against NumPy's least squares of the weighted equations."""
    at = RANDOM.normal(size=3)
    points, motions = RANDOM.normal(size=(5, 3)), RANDOM.normal(size=(5, 6))
    length = np.mean(np.linalg.norm(points - at, axis=1))
    weight = np.r_[np.ones(3), np.full(3, length)]
    rows = np.vstack([weight[:, None] * carry(point - at) for point in points])
    nearest = np.linalg.lstsq(rows, np.concatenate(weight * motions), rcond=None)[0]
    found = average([motion[:, None] for motion in motions], list(points), at)[:, 0]
    np.testing.assert_allclose(found, nearest, atol=1e-12)


def random_network(n):
    masses = [Mass(RANDOM.normal(size=(6, n)), np.diag(RANDOM.uniform(1, 2, 6))) for _ in range(3)]
    springs = [
        Spring(RANDOM.normal(size=(4, n)), RANDOM.uniform(10, 20, 4), RANDOM.uniform(0.1, 0.2, 4))
        for _ in range(3)
    ]
    return masses, springs


def test_matrices_give_the_energies_of_their_parts():
    masses, springs = random_network(8)
    stiffness, damping, mass = assemble(masses, springs)
    x = RANDOM.normal(size=8)
    kinetic = sum((m.motion @ x) @ m.matrix @ (m.motion @ x) for m in masses)
    elastic = sum(np.sum(s.stiffness * (s.stretch @ x) ** 2) for s in springs)
    lost = sum(np.sum(s.damping * (s.stretch @ x) ** 2) for s in springs)
    assert x @ mass @ x == pytest.approx(kinetic)
    assert x @ stiffness @ x == pytest.approx(elastic)
    assert x @ damping @ x == pytest.approx(lost)


def test_held_coordinates_move_as_lagrange_multipliers_make_them():
    """Motion and holding force under a load, against the saddle-point system of both."""
    n, free, c, s = 12, 10, 3, 2j
    matrices = assemble(*random_network(n))
    constraint = RANDOM.normal(size=(c, n))
    held = hold(constraint, matrices, free)
    powers = s ** np.arange(3)
    dynamic = np.tensordot(powers, matrices, 1)
    given, load = RANDOM.normal(size=n - free), RANDOM.normal(size=free)
    load[np.setdiff1d(np.arange(n), held.kept)] = 0.0
    saddle = np.block(
        [
            [dynamic[:free, :free], -constraint[:, :free].T],
            [constraint[:, :free], np.zeros((c, c))],
        ]
    )
    right = np.r_[load - dynamic[:free, free:] @ given, -constraint[:, free:] @ given]
    solved = np.linalg.solve(saddle, right)
    kept = held.kept[: free - c]
    reduced = held.every.T @ dynamic @ held.every
    x = np.linalg.solve(
        reduced[: free - c, : free - c], load[kept] - reduced[: free - c, free - c :] @ given
    )
    whole = held.every @ np.r_[x, given]
    np.testing.assert_allclose(whole[:free], solved[:free], rtol=1e-9)
    forces = np.tensordot(powers, held.forces, 1) @ whole
    np.testing.assert_allclose(forces, solved[free:], rtol=1e-9)


def test_the_force_of_springs_does_the_work_that_they_store():
    """Moving only the support by v stores ½ vᵀ E K Eᵀ v; the support does it, F · v / 2."""
    ends, stiffness, damping = RANDOM.normal(size=(4, 6)), RANDOM.uniform(1, 2, 4), np.ones(4)
    spring = Spring(-ends, stiffness, damping)
    motion = RANDOM.normal(size=6)
    stored = 0.5 * np.sum(stiffness * (ends @ motion) ** 2)
    force = exerted(spring, ends)
    assert 0.5 * motion @ force[0] @ motion == pytest.approx(stored)
    np.testing.assert_allclose(force[1], ends.T @ ends)
    assert not force[2].any()
