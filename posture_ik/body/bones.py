"""The bones a person is drawn with, as solids, in metres for 1.80 m of stature.

Axes are those of the link that carries a form: x forward, y left, z up for the trunk, the head and
the legs; for the arms the axes of the arm's own frames, x forward, y up the limb, z to the right.
Shapes are the project's own, by eye from anatomy; they carry no mass and no measurement.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from posture_ik.body.solids import (
    Mesh,
    blend,
    both_sides,
    carve,
    drum,
    ellipsoid,
    joined,
    limb,
    loft,
    mesh,
    mirrored,
    plate,
    rod,
    tube,
)


def cervical() -> Mesh:
    """A neck vertebra, body 16 x 20 x 12 mm about the origin."""
    body = drum((0.008, 0.010), 0.012, 0.08, 0.002)
    arch = blend(
        0.002,
        rod((-0.003, 0.010, 0.0), (-0.008, 0.024, -0.003), 0.0038, 0.0030),
        rod((-0.005, 0.010, 0.0), (-0.013, 0.017, 0.0), 0.0035, 0.0050),
        rod((-0.013, 0.018, -0.006), (-0.013, 0.018, 0.006), 0.0050),
        rod((-0.015, 0.016, 0.0), (-0.027, 0.0, -0.002), 0.0035),
        rod((-0.026, 0.0, -0.002), (-0.042, 0.003, -0.009), 0.0040, 0.0028),
    )
    solid = both_sides(blend(0.003, body, arch))
    return mesh(solid, (-0.05, -0.03, -0.018), (0.01, 0.03, 0.014), 0.0036)


def atlas() -> Mesh:
    """C1: a ring without a body, two masses that carry the head, long transverse processes."""
    ring = limb(
        (0.008, 0.0, 0.0, 0.0042),
        (0.004, 0.013, 0.0, 0.0040),
        (-0.012, 0.020, 0.0, 0.0038),
        (-0.030, 0.012, 0.0, 0.0034),
        (-0.037, 0.0, 0.0, 0.0042),
    )
    mass = ellipsoid((-0.003, 0.018, 0.0), (0.010, 0.0075, 0.0065))
    process = rod((-0.006, 0.022, 0.0), (-0.010, 0.038, -0.002), 0.0045, 0.0032)
    solid = both_sides(blend(0.004, ring, mass, process))
    return mesh(solid, (-0.045, -0.044, -0.01), (0.014, 0.044, 0.01), 0.0040)


def thoracic() -> Mesh:
    """A chest vertebra, body 28 x 31 x 22 mm about the origin."""
    body = drum((0.014, 0.0155), 0.022, 0.10, 0.003)
    arch = blend(
        0.003,
        rod((-0.010, 0.010, 0.004), (-0.026, 0.013, 0.004), 0.0050),
        rod((-0.025, 0.013, 0.003), (-0.037, 0.033, 0.009), 0.0055, 0.0050),
        rod((-0.027, 0.013, 0.002), (-0.036, 0.0, -0.003), 0.0048),
        rod((-0.028, 0.012, 0.004), (-0.027, 0.013, 0.015), 0.0048, 0.0040),
        rod((-0.031, 0.010, -0.002), (-0.032, 0.010, -0.014), 0.0048, 0.0040),
        rod((-0.036, 0.0, -0.004), (-0.062, 0.0, -0.028), 0.0052, 0.0038),
    )
    solid = both_sides(blend(0.004, body, arch))
    return mesh(solid, (-0.07, -0.042, -0.036), (0.018, 0.042, 0.022), 0.0058)


def lumbar() -> Mesh:
    """A loin vertebra, body 34 x 46 x 27 mm about the origin."""
    body = drum((0.017, 0.023), 0.027, 0.12, 0.0035)
    arch = blend(
        0.004,
        rod((-0.012, 0.014, 0.005), (-0.030, 0.015, 0.005), 0.0058),
        rod((-0.030, 0.016, 0.004), (-0.034, 0.043, 0.006), 0.0052, 0.0042),
        rod((-0.031, 0.014, 0.003), (-0.043, 0.0, -0.003), 0.0062),
        rod((-0.031, 0.016, 0.004), (-0.030, 0.018, 0.019), 0.0060, 0.0052),
        rod((-0.037, 0.012, -0.002), (-0.040, 0.012, -0.019), 0.0058, 0.0050),
        plate((-0.060, 0.0, -0.007), (0.019, 0.0045, 0.0105), 0.0044, 0.12),
    )
    solid = both_sides(blend(0.005, body, arch))
    return mesh(solid, (-0.085, -0.05, -0.027), (0.02, 0.05, 0.027), 0.0065)


def disc() -> Mesh:
    """A disc of unit depth, width and height: rings of a barrel."""
    angle = 2 * np.pi * np.arange(13) / 13
    section = ((-0.5, 0.46), (-0.2, 0.51), (0.2, 0.51), (0.5, 0.46))
    rings = [
        np.stack([r * np.cos(angle), r * np.sin(angle), np.full(13, z)], 1) for z, r in section
    ]
    return loft(np.array(rings))


def sacrum() -> Mesh:
    """The sacrum below the endplate that carries L5, tapering back and down to the coccyx."""
    solid = blend(
        0.010,
        drum((0.016, 0.024), 0.016, 0.0, 0.004),
        rod((-0.008, 0.020, -0.004), (-0.018, 0.042, -0.012), 0.012, 0.013),
        rod((-0.014, 0.012, -0.012), (-0.042, 0.012, -0.046), 0.016, 0.011),
        rod((-0.018, 0.036, -0.014), (-0.044, 0.014, -0.048), 0.011, 0.008),
        rod((-0.042, 0.0, -0.044), (-0.042, 0.0, -0.076), 0.011, 0.005),
        rod((-0.030, 0.0, -0.004), (-0.056, 0.0, -0.040), 0.007, 0.005),
        rod((-0.022, 0.020, 0.004), (-0.022, 0.021, 0.016), 0.006, 0.005),
    )
    return mesh(both_sides(solid), (-0.075, -0.06, -0.085), (0.02, 0.06, 0.025), 0.0072)


def pelvis() -> Mesh:
    """Two hip bones about S1: wings, crests, sockets, and the ring they stand on when seated."""
    socket = (0.045, 0.080, -0.022)
    crest = (
        (-0.050, 0.045, 0.018),
        (-0.042, 0.070, 0.052),
        (-0.012, 0.105, 0.074),
        (0.024, 0.126, 0.068),
        (0.056, 0.124, 0.040),
        (0.068, 0.112, 0.008),
    )
    blades = [rod(socket, point, 0.015, 0.0065) for point in crest]
    between = [rod(socket, np.mean([a, b], axis=0), 0.014, 0.0060) for a, b in pairwise(crest)]
    rim = limb(*[(*point, 0.0080) for point in crest])
    ring = limb(
        (0.030, 0.076, -0.040, 0.017),
        (-0.010, 0.062, -0.068, 0.017),
        (0.014, 0.048, -0.074, 0.012),
        (0.052, 0.020, -0.052, 0.009),
        (0.066, 0.010, -0.034, 0.011),
        (0.058, 0.050, -0.016, 0.010),
        (0.048, 0.078, -0.010, 0.016),
    )
    joint = limb((-0.016, 0.052, -0.004, 0.014), (0.020, 0.070, -0.012, 0.014))
    cup = carve(
        0.004,
        blend(0.008, *blades, *between, rim, ring, joint, ellipsoid(socket, (0.03, 0.024, 0.03))),
        ellipsoid((0.050, 0.108, -0.026), (0.025, 0.025, 0.025)),
    )
    return mesh(both_sides(cup), (-0.08, -0.14, -0.1), (0.09, 0.14, 0.09), 0.0114)


def rib() -> Mesh:
    """A pair of true ribs: their cartilage rises to meet the sternum."""
    return _rib(((0.80, 0.68, -1.00), (0.94, 0.40, -0.96), (1.00, 0.10, -0.86)))


def false_rib() -> Mesh:
    """A pair of false ribs: they end in cartilage that rises along the rib above."""
    return _rib(((0.78, 0.72, -1.00), (0.90, 0.48, -0.90)))


def _rib(front: tuple[tuple[float, float, float], ...]) -> Mesh:
    """A pair of ribs of unit reach: half width 1 along y, depth 1 along x, fall 1 along z."""
    back = (
        (-0.12, 0.14, 0.06),
        (-0.27, 0.32, 0.06),
        (-0.30, 0.62, -0.04),
        (-0.12, 0.90, -0.24),
        (0.18, 1.00, -0.50),
        (0.52, 0.93, -0.78),
    )
    left = tube((*back, *front), (0.022, 0.07), sides=6, samples=20)
    return joined(left, mirrored(left))


def sternum() -> Mesh:
    """The breastbone: from its notch at the origin 0.18 m down and forward."""
    solid = blend(
        0.012,
        ellipsoid((0.004, 0.0, -0.016), (0.0085, 0.029, 0.019)),
        plate((0.037, 0.0, -0.092), (0.0055, 0.014, 0.058), 0.0053, -0.35),
        rod((0.056, 0.0, -0.145), (0.066, 0.0, -0.175), 0.0065, 0.0040),
    )
    return mesh(solid, (-0.02, -0.04, -0.19), (0.09, 0.04, 0.012), 0.0085)


def femur() -> Mesh:
    """A thigh bone 0.44 m long, from the hip along x to the knee."""
    solid = blend(
        0.012,
        ellipsoid((0.038, 0.0, -0.016), (0.023, 0.023, 0.023)),
        limb((0.040, 0.0, -0.014, 0.016), (0.064, 0.0, 0.004, 0.019), (0.100, 0.0, 0.006, 0.0145)),
        limb((0.090, 0.0, 0.006, 0.015), (0.240, 0.0, 0.010, 0.0130), (0.370, 0.0, 0.002, 0.0160)),
        rod((0.405, 0.017, -0.002), (0.426, 0.020, -0.004), 0.0180, 0.0210),
        rod((0.405, -0.017, -0.002), (0.426, -0.020, -0.004), 0.0180, 0.0210),
    )
    return mesh(solid, (0.01, -0.05, -0.045), (0.46, 0.05, 0.04), 0.0145)


def tibia() -> Mesh:
    """The two bones of a shank and the kneecap, from the knee 0.42 m down."""
    solid = blend(
        0.008,
        ellipsoid((0.000, 0.0, -0.034), (0.022, 0.036, 0.014)),
        limb(
            (0.004, 0.0, -0.040, 0.022), (0.006, 0.0, -0.100, 0.0135), (0.000, 0.0, -0.380, 0.0135)
        ),
        ellipsoid((0.000, 0.0, -0.398), (0.017, 0.021, 0.018)),
        limb(
            (-0.016, 0.026, -0.055, 0.009),
            (-0.014, 0.020, -0.220, 0.006),
            (-0.006, 0.021, -0.400, 0.009),
        ),
        ellipsoid((0.040, 0.0, -0.006), (0.009, 0.018, 0.020)),
    )
    return mesh(solid, (-0.04, -0.05, -0.43), (0.06, 0.05, 0.03), 0.0135)


def clavicle() -> Mesh:
    """A right collar bone from the sternum 0.15 m out along z, bowed forward then back."""
    path = ((0, 0, 0), (0.012, 0.004, 0.045), (0.002, 0.008, 0.100), (-0.012, 0.014, 0.145))
    return tube(path, (0.0065, 0.0055), sides=7, samples=14)


def scapula() -> Mesh:
    """A right shoulder blade about the acromion's joint: socket, spine, acromion and blade."""
    glenoid, root = (-0.014, -0.036, -0.006), (-0.078, -0.030, -0.086)
    tip, top = (-0.085, -0.140, -0.062), (-0.050, -0.006, -0.078)
    border = [np.add(np.multiply(tip, t), np.multiply(top, 1 - t)) for t in (0, 0.25, 0.5, 0.75, 1)]
    solid = blend(
        0.006,
        *[rod(glenoid, point, 0.0085, 0.0045) for point in border],
        limb(*[(*point, 0.0050) for point in border]),
        ellipsoid(glenoid, (0.011, 0.018, 0.011)),
        limb((*root, 0.005), (-0.048, 0.004, -0.030, 0.007), (-0.012, 0.004, 0.006, 0.0075)),
        rod((-0.012, 0.004, 0.006), (0.002, 0.002, 0.000), 0.0075, 0.0065),
        rod((-0.010, -0.016, -0.016), (0.024, -0.020, -0.012), 0.0075, 0.0060),
    )
    return mesh(solid, (-0.11, -0.16, -0.11), (0.04, 0.02, 0.03), 0.0085)


def humerus() -> Mesh:
    """A right upper arm bone from the shoulder 0.29 m down."""
    solid = blend(
        0.010,
        ellipsoid((0.000, 0.0, 0.000), (0.023, 0.023, 0.023)),
        ellipsoid((0.004, -0.006, 0.016), (0.016, 0.020, 0.014)),
        limb(
            (0.0, -0.010, 0.004, 0.017),
            (0.002, -0.080, 0.004, 0.0115),
            (0.006, -0.250, -0.008, 0.0115),
        ),
        rod((0.005, -0.286, -0.034), (0.005, -0.286, 0.012), 0.0120, 0.0110),
    )
    return mesh(solid, (-0.04, -0.31, -0.05), (0.04, 0.04, 0.04), 0.0105)


def ulna() -> Mesh:
    """A right ulna: its hook behind the elbow, its head at the wrist."""
    solid = blend(
        0.006,
        limb(
            (-0.016, 0.012, 0.000, 0.009),
            (-0.014, -0.014, 0.002, 0.012),
            (0.004, -0.030, 0.002, 0.0095),
        ),
        limb(
            (-0.008, -0.024, 0.002, 0.010),
            (-0.010, -0.110, 0.014, 0.0075),
            (0.000, -0.236, 0.044, 0.0075),
        ),
        ellipsoid((0.001, -0.242, 0.046), (0.010, 0.008, 0.010)),
    )
    return mesh(solid, (-0.04, -0.26, -0.02), (0.03, 0.03, 0.065), 0.0085)


def radius() -> Mesh:
    """A right radius from its head at the elbow to the wrist."""
    solid = blend(
        0.006,
        ellipsoid((0.000, -0.002, 0.000), (0.0115, 0.007, 0.0115)),
        limb(
            (0.001, -0.004, 0.000, 0.008),
            (0.010, -0.110, 0.002, 0.0078),
            (0.018, -0.215, 0.020, 0.0110),
        ),
        ellipsoid((0.018, -0.230, 0.023), (0.018, 0.010, 0.012)),
    )
    return mesh(solid, (-0.025, -0.25, -0.025), (0.045, 0.02, 0.05), 0.0085)
