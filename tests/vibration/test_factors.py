"""Factors on springs: what they multiply in either model, and what they leave."""

from itertools import pairwise

import numpy as np
import pytest

from posture_ik.problem import SPINE
from posture_ik.vibration import Factors, build_finite_element
from posture_ik.vibration.identify import FACTORS

GROUPS = {
    "neck_flexion": ("stiffness", 8),
    "trunk_flexion": ("stiffness", 17),
    "lateral_bending": ("stiffness", 25),
    "flexion_damping": ("damping", 25),
    "lateral_damping": ("damping", 25),
    "buttocks": ("stiffness", 3),
    "buttocks_damping": ("damping", 3),
    "buttocks_shear": ("stiffness", 2),
}


def test_groups_are_all_there_is():
    assert set(GROUPS) == set(Factors._fields) == set(FACTORS)
    assert len(list(pairwise(SPINE))) == 25


@pytest.mark.parametrize("name", GROUPS)
def test_a_factor_multiplies_its_springs_alone(name):
    """What doubling adds has the rank of the springs doubled, and grows as the factor does.

    Four level corners of the buttocks carry one plate: along z they lift it and tilt it twice,
    along x they push and twist it.
    """
    of, rank = GROUPS[name]
    once, twice, thrice = (
        getattr(build_finite_element(factors=Factors(**{name: f})), of) for f in (1.0, 2.0, 3.0)
    )
    added = twice - once
    # Above what is left of shear's 1e10 N/m in the difference, rounded to 1e-16 of it.
    sizes = np.linalg.svd(added, compute_uv=False)
    assert np.sum(sizes > 1e-5 * sizes[0]) == rank
    np.testing.assert_allclose(thrice - once, 2 * added, atol=1e-15 * abs(once).max())


def test_the_multibody_person_takes_the_same_factors(models):
    """On its joints' own springs and dampers; all else stays, though viscera hang between them."""
    plain, calibrated = (
        models("upright", f'vibration.parameters="{name}"') for name in ("source", "calibrated")
    )
    factors = Factors.of("calibrated")
    tissue = dict(zip(models.body.dofs, models.body.stiffness, strict=True))
    damping = dict(zip(models.body.dofs, models.body.damping, strict=True))
    added = np.diag(calibrated.stiffness - plain.stiffness)
    damped = np.diag(calibrated.damping - plain.damping)
    expected = {
        "C3_C4_ry": (factors.neck_flexion, factors.flexion_damping),
        "L4_L5_ry": (factors.trunk_flexion, factors.flexion_damping),
        "L4_L5_rx": (factors.lateral_bending, factors.lateral_damping),
        "buttocks_S1_axial": (factors.buttocks, factors.buttocks_damping),
        "L4_L5_rz": (1.0, 1.0),
        "L4_L5_axial": (1.0, 1.0),
        "elbow_flexion_r": (1.0, 1.0),
    }
    for name, (stiff, slow) in expected.items():
        i = plain.coordinates.index(name)
        assert added[i] == pytest.approx((stiff - 1) * tissue[name], rel=1e-9, abs=1e-6)
        assert damped[i] == pytest.approx((slow - 1) * damping[name], rel=1e-9, abs=1e-6)
    off = calibrated.stiffness - plain.stiffness - np.diag(added)
    assert abs(off).max() < 1e-9 * abs(plain.stiffness).max()
