"""Scaling against the laws it must obey."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from posture_ik.body import build_body
from posture_ik.body.geometry import BodyGeometry
from posture_ik.body.laws import LAWS, scale_of
from posture_ik.body.parts import Inertia
from posture_ik.body.scaling import REFERENCE, REGIONS, Scale
from posture_ik.body.spine import SPINE_DOFS
from posture_ik.problem import Subject

ONES = Scale.alike((1.0, 1.0, 1.0), 1.0)


def body_of(scale, monkeypatch):
    """The geometry that a law of these factors gives."""
    monkeypatch.setitem(LAWS, "anthropometric", lambda subject: scale)
    return BodyGeometry.of(REFERENCE)


@pytest.mark.parametrize("law", LAWS)
def test_reference_subject_is_not_scaled(law):
    assert scale_of(REFERENCE.model_copy(update={"scaling": law})) == ONES


def test_doubled_lengths_have_the_exponents_of_similarity(monkeypatch):
    """Masses 2³, forces per length 2, per angle 2³, inertias 2⁵; the arms' springs are assumed."""
    small = body_of(ONES, monkeypatch)
    large = body_of(Scale.alike((2.0, 2.0, 2.0), 8.0), monkeypatch)
    for dof in small.stiffness:
        ratio = large.stiffness[dof] / small.stiffness[dof]
        if dof[-2:] in ("_r", "_l"):
            assert ratio == 1.0
        else:
            assert ratio == pytest.approx(2.0 if dof.endswith("axial") else 8.0)
        assert large.damping[dof] / small.damping[dof] == pytest.approx(ratio)
        grown = small.lower[dof] * (2.0 if dof.endswith("axial") else 1.0)
        assert large.lower[dof] == pytest.approx(grown)
    for link, inertia in small.inertias.items():
        assert large.inertias[link].mass == pytest.approx(8.0 * inertia.mass)
        np.testing.assert_allclose(large.inertias[link].centre, 2 * inertia.centre, atol=1e-12)
        np.testing.assert_allclose(large.inertias[link].tensor, 32 * inertia.tensor, atol=1e-12)
    for name, node in small.nodes.items():
        np.testing.assert_allclose(large.nodes[name], 2.0 * node, atol=1e-12)


def test_softer_tissue_is_softer_and_nothing_else(monkeypatch):
    stiff = body_of(ONES, monkeypatch)
    soft = body_of(replace(ONES, modulus=0.5, viscosity=0.25), monkeypatch)
    for dof in SPINE_DOFS:
        assert soft.stiffness[dof] == pytest.approx(0.5 * stiff.stiffness[dof])
        assert soft.damping[dof] == pytest.approx(0.25 * stiff.damping[dof])
    assert soft.lower == stiff.lower


def test_stretched_inertia_is_that_of_the_stretched_points():
    random = np.random.default_rng(3)
    points, masses = random.normal(size=(40, 3)), random.uniform(0.1, 1.0, 40)
    length = np.array([1.2, 0.9, 0.8])
    scale = Scale.alike(tuple(length), 1.3)

    def inertia(points, masses):
        centre = masses @ points / masses.sum()
        r = points - centre
        tensor = sum(
            m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, r, strict=True)
        )
        return Inertia(masses.sum(), centre, tensor)

    ours = scale.inertia(inertia(points, masses), "lumbar")
    direct = inertia(points * length, 1.3 * masses)
    assert ours.mass == pytest.approx(direct.mass)
    np.testing.assert_allclose(ours.centre, direct.centre)
    np.testing.assert_allclose(ours.tensor, direct.tensor)


def test_heights_change_smoothly_from_region_to_region():
    """Each region's end stands where its own growth puts it, and no vertebra overtakes another."""
    regions = dict(ONES.length) | {"lumbar": (1.0, 1.0, 1.3), "cervical": (1.0, 1.0, 0.7)}
    scale = replace(ONES, length=regions)
    ends = np.array([0.0, *REGIONS.values()])
    grown = np.diff(ends) * [regions[region][2] for region in REGIONS]
    np.testing.assert_allclose(scale.heights(ends), [0.0, *np.cumsum(grown)], atol=1e-12)
    z = np.linspace(0.0, ends[-1], 2000)
    slopes = np.diff(scale.heights(z)) / np.diff(z)
    assert slopes.min() > 0.5
    assert np.abs(np.diff(slopes)).max() < 0.02


def test_bending_is_that_of_the_stretched_section():
    """Second moments of an elliptic section, and Saint-Venant's polar one, over the height."""
    x, y, z = 0.9, 1.1, 1.2
    scale = Scale.alike((x, y, z), 1.0)
    a, b, h = 0.02, 0.02, 0.03

    def section(a, b, h):
        return {
            "axial": np.pi * a * b / h,
            "rx": np.pi * a * b**3 / 4 / h,
            "ry": np.pi * a**3 * b / 4 / h,
            "rz": (np.pi * a * b**3 / 4 + np.pi * a**3 * b / 4) / h,
        }

    before, after = section(a, b, h), section(x * a, y * b, z * h)
    for component, value in before.items():
        assert scale.stiffness("lumbar", component) == pytest.approx(after[component] / value)


@pytest.mark.parametrize("stature", [1.40, 1.60, 1.90, 2.10])
@pytest.mark.parametrize("body_mass_index", [14.5, 22.0, 35.0, 54.5])
def test_every_valid_subject_has_a_body(stature, body_mass_index):
    """Also where a stretch would turn an inertia that is no body's negative (table 9's T1)."""
    subject = Subject(stature=stature, weight=body_mass_index * stature**2)
    body = build_body(subject)
    assert pin.computeTotalMass(body.model) == pytest.approx(61.39 * subject.weight / 80)
    assert all(np.all(np.diag(inertia.inertia) >= 0) for inertia in body.model.inertias)
