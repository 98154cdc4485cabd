"""The head, limbs and hands a person is drawn with, as solids, in metres for 1.80 m of stature.

Axes are those of the link that carries a form: x forward, y left, z up for the trunk, the head and
the legs; for the arms the axes of the arm's own frames, x forward, y up the limb, z to the right.
Shapes are the project's own, by eye from anatomy; they carry no mass and no measurement.
"""

from __future__ import annotations

from posture_ik.body.solids import (
    Mesh,
    Solid,
    blend,
    both_sides,
    carve,
    ellipsoid,
    limb,
    mesh,
    plate,
    rod,
)


def head() -> Mesh:
    """A head about its centre of mass, looking along x: crown at 0.12, chin at -0.11 m."""
    skull = blend(
        0.030,
        ellipsoid((-0.014, 0.0, 0.036), (0.094, 0.074, 0.084)),
        ellipsoid((0.030, 0.0, -0.016), (0.058, 0.059, 0.076)),
        limb(
            (0.0, 0.041, -0.046, 0.019), (0.02, 0.038, -0.072, 0.017), (0.054, 0.016, -0.092, 0.014)
        ),
        ellipsoid((0.064, 0.0, -0.094), (0.012, 0.016, 0.013)),
        rod((0.076, 0.008, 0.026), (0.056, 0.046, 0.018), 0.010, 0.009),
        ellipsoid((0.050, 0.036, -0.028), (0.019, 0.017, 0.020)),
    )
    sockets = carve(0.010, skull, ellipsoid((0.104, 0.031, 0.004), (0.022, 0.017, 0.011)))
    eye = ellipsoid((0.0700, 0.0305, 0.003), (0.0145, 0.0150, 0.0105))
    nose = blend(
        0.007,
        rod((0.083, 0.0, 0.010), (0.101, 0.0, -0.025), 0.005, 0.008),
        ellipsoid((0.094, 0.008, -0.028), (0.009, 0.007, 0.006)),
    )
    lips = blend(
        0.004,
        ellipsoid((0.0765, 0.0, -0.055), (0.0085, 0.019, 0.0055)),
        ellipsoid((0.0755, 0.0, -0.0645), (0.0080, 0.016, 0.0058)),
    )
    ear = carve(
        0.004,
        ellipsoid((-0.014, 0.071, -0.008), (0.016, 0.009, 0.028)),
        ellipsoid((-0.006, 0.083, -0.004), (0.009, 0.010, 0.017)),
    )
    face = blend(0.003, blend(0.012, sockets, nose), eye)
    whole = blend(0.005, blend(0.006, face, lips), ear)
    return mesh(both_sides(whole), (-0.12, -0.09, -0.125), (0.13, 0.09, 0.13), 0.0077)


def thigh() -> Mesh:
    """A thigh 0.44 m long, from the hip along x to the knee."""
    solid = limb(
        (0.00, 0.0, 0.000, 0.080),
        (0.12, 0.0, 0.004, 0.084),
        (0.26, 0.0, 0.006, 0.074),
        (0.38, 0.0, 0.004, 0.060),
        (0.44, 0.0, 0.000, 0.057),
    )
    return mesh(solid, (-0.09, -0.09, -0.09), (0.51, 0.09, 0.1), 0.026)


def shank() -> Mesh:
    """A shank from the knee 0.42 m down to the ankle, calf to the back."""
    solid = limb(
        (0.000, 0.0, 0.000, 0.052),
        (-0.004, 0.0, -0.050, 0.053),
        (-0.014, 0.0, -0.120, 0.058),
        (-0.014, 0.0, -0.200, 0.051),
        (-0.004, 0.0, -0.330, 0.036),
        (-0.002, 0.0, -0.400, 0.033),
    )
    return mesh(solid, (-0.08, -0.07, -0.47), (0.07, 0.07, 0.08), 0.021)


def foot() -> Mesh:
    """A foot in a plain shoe, the ankle at the origin, the sole at -0.075 m."""
    last = blend(
        0.030,
        limb((-0.002, 0.0, 0.0, 0.043), (-0.004, 0.0, -0.030, 0.041), (-0.022, 0.0, -0.044, 0.037)),
        limb((0.0, 0.0, -0.026, 0.039), (0.070, 0.002, -0.044, 0.037), (0.148, 0.0, -0.056, 0.030)),
        rod((0.09, 0.018, -0.058), (0.115, 0.014, -0.060), 0.026, 0.024),
    )
    sole = plate((0.040, 0.0, -0.185), (0.3, 0.2, 0.11), 0.001)
    return mesh(carve(0.008, last, sole), (-0.09, -0.06, -0.08), (0.2, 0.06, 0.06), 0.0155)


def upper_arm() -> Mesh:
    """An upper arm from the shoulder 0.29 m down to the elbow, the deltoid to the outside."""
    solid = limb(
        (0.000, 0.004, -0.002, 0.054),
        (0.000, -0.050, 0.004, 0.053),
        (0.004, -0.130, 0.000, 0.048),
        (0.006, -0.220, -0.006, 0.042),
        (0.006, -0.290, -0.010, 0.038),
    )
    return mesh(solid, (-0.06, -0.33, -0.065), (0.07, 0.065, 0.065), 0.018)


def forearm_ulna() -> Mesh:
    """The elbow's half of a forearm, on the ulna: from the elbow 0.11 m down."""
    solid = limb(
        (0.000, 0.000, 0.004, 0.038),
        (0.004, -0.055, 0.010, 0.041),
        (0.008, -0.120, 0.015, 0.037),
        (0.009, -0.170, 0.017, 0.024),
    )
    return mesh(solid, (-0.05, -0.21, -0.05), (0.06, 0.045, 0.06), 0.0145)


def forearm_radius() -> Mesh:
    """The wrist's half of a forearm, on the radius: 0.10 m from the elbow to the wrist."""
    solid = limb(
        (0.005, -0.060, -0.008, 0.028),
        (0.007, -0.115, -0.003, 0.0365),
        (0.010, -0.155, 0.002, 0.033),
        (0.016, -0.205, 0.016, 0.026),
        (0.018, -0.246, 0.023, 0.025),
    )
    squeezed = blend(0.012, solid, rod((0.002, -0.235, 0.022), (0.034, -0.235, 0.022), 0.019))
    return mesh(squeezed, (-0.04, -0.28, -0.05), (0.06, -0.02, 0.06), 0.014)


def hand() -> Mesh:
    """A right hand about the wrist closed round a stick along x, thumb at +x, palm at -z."""
    palm = blend(
        0.014,
        rod((0.000, -0.004, 0.002), (0.000, -0.020, 0.004), 0.022, 0.020),
        rod((0.014, -0.020, 0.006), (0.026, -0.076, 0.010), 0.015, 0.013),
        rod((0.000, -0.020, 0.007), (0.006, -0.080, 0.012), 0.015, 0.013),
        rod((-0.012, -0.020, 0.005), (-0.026, -0.070, 0.008), 0.014, 0.011),
        rod((0.014, -0.022, 0.000), (0.027, -0.046, -0.010), 0.015, 0.012),
    )
    fingers = [
        limb(
            (x, y - 0.080, 0.010, 0.0112 * thick),
            (1.02 * x, y - 0.107, -0.006, 0.0102 * thick),
            (1.03 * x, y - 0.106, -0.034, 0.0093 * thick),
            (1.02 * x, y - 0.084, -0.047, 0.0086 * thick),
            (1.00 * x, y - 0.064, -0.038, 0.0080 * thick),
        )
        for x, y, thick in (
            (0.031, 0.002, 0.95),
            (0.0105, -0.003, 1.00),
            (-0.010, 0.000, 0.95),
            (-0.029, 0.008, 0.85),
        )
    ]
    thumb = limb(
        (0.026, -0.034, -0.008, 0.0130),
        (0.042, -0.056, -0.020, 0.0112),
        (0.046, -0.080, -0.034, 0.0102),
        (0.040, -0.100, -0.046, 0.0088),
    )
    solid: Solid = blend(0.006, palm, blend(0.0008, *fingers), thumb)
    return mesh(solid, (-0.05, -0.13, -0.065), (0.06, 0.03, 0.035), 0.0074)
