"""The default law: each region has the size and the mass that is typical of the person.

Lengths follow from age, stature, weight, gender and what is measured, by the regressions on ANSUR
II (`posture_ik.anthropometry`); a factor is the subject's length over the reference subject's.

    region      λx                  λy                  λz
    pelvis      buttock depth       hip breadth         iliac crest above the seat
    lumbar      waist depth         waist breadth       so that the cervicale rises
    thoracic    chest depth         chest breadth       as it does above the seat
    cervical    neck circumference  neck circumference  vertex above the cervicale
    head        head length         head breadth        vertex above the cervicale

Masses are table 9's grown with weight, and for women with what their segments are of the body over
what men's are (de Leva 1996). Together they are the share of the weight that the seat carries: of
head, trunk, arms and part of the thighs. Measured masses stand as given, and the rest of that share
is the other regions'. Stiffness and damping change with load, age and build as
`posture_ik.body.corrections` has it.
"""

from __future__ import annotations

from functools import cache

from posture_ik.anthropometry import Gender, typical_measures
from posture_ik.body.corrections import Corrections
from posture_ik.body.scaling import REFERENCE, REGIONS, Scale, region_of
from posture_ik.body.tables import table
from posture_ik.problem import Subject


def anthropometric(subject: Subject, corrections: Corrections | None = None) -> Scale:
    """The factors of a subject of typical build, with corrections in place of those identified."""
    corrections = corrections or Corrections.identified()
    reference, person = _lengths(REFERENCE), _lengths(subject)
    over = {name: person[name] / length for name, length in reference.items()}
    crest, neck = over["iliac_crest_height"], over["neck_circumference"]
    # Crest and cervicale of the model rise as the person's; it is not proportioned as the survey.
    low, high = REGIONS["pelvis"], REGIONS["thoracic"]
    trunk = (over["cervicale_height"] * high - crest * low) / (high - low)
    pelvis = (over["buttock_depth"], over["hip_breadth"], crest)
    mass = _mass_on_seat(subject, corrections) / sum(_table_masses().values())
    pressure = mass * pelvis[2] / (pelvis[0] * pelvis[1])
    return Scale(
        length={
            "pelvis": pelvis,
            "lumbar": (over["waist_depth"], over["waist_breadth"], trunk),
            "thoracic": (over["chest_depth"], over["chest_breadth"], trunk),
            "cervical": (neck, neck, over["above"]),
            "head": (over["head_length"], over["head_breadth"], over["above"]),
        },
        curve=over["cervicale_height"],
        shoulders=(over["biacromial_breadth"], over["shoulder_height"]),
        arm=over["arm"],
        stature=subject.stature / REFERENCE.stature,
        mass=_masses(subject, corrections),
        modulus=corrections.modulus(subject, pressure),
        viscosity=corrections.viscosity(subject, pressure),
    )


def seated_share(subject: Subject) -> float:
    """Share of the body's weight that the seat carries: 0.767 for the reference subject."""
    return _mass_on_seat(subject, Corrections.identified()) / subject.weight


def _lengths(subject: Subject) -> dict[str, float]:
    """Typical lengths of a subject, with those of head and neck and of the whole arm, m."""
    found = typical_measures(
        subject.gender, subject.age, subject.stature, subject.weight, subject.measured.lengths()
    )
    found["above"] = found["sitting_height"] - found["cervicale_height"]
    found["arm"] = found["upper_arm_length"] + found["forearm_length"] + found["hand_length"]
    return found


@cache
def _table_masses() -> dict[str, float]:
    """What table 9 lumps in each region and in both arms, kg."""
    masses = dict.fromkeys((*REGIONS, "arm"), 0.0)
    for name, row in table("table_9_masses").items():
        masses["arm" if name.endswith("_arm") else region_of(name)] += float(row["mass_kg"])
    return masses


@cache
def _shares(gender: Gender, thigh_on_seat: float) -> dict[str, float]:
    """What each region, and both arms, are of the body's mass (de Leva)."""
    percent = {name: float(row[gender]) for name, row in table("de_leva_masses").items()}
    shares = {
        "head": percent["head"],
        "cervical": percent["head"],
        "thoracic": percent["upper_trunk"],
        "lumbar": percent["middle_trunk"],
        "pelvis": percent["lower_trunk"] + 2 * thigh_on_seat * percent["thigh"],
        "arm": 2 * (percent["upper_arm"] + percent["forearm"] + percent["hand"]),
    }
    return {region: share / 100 for region, share in shares.items()}


def _mass_on_seat(subject: Subject, corrections: Corrections) -> float:
    """Mass that the seat carries, kg; table 9's sum for the reference subject."""
    shares, men = (
        sum(share for region, share in _shares_of(who).items() if region != "cervical")
        for who in (subject, REFERENCE)
    )
    share = sum(_table_masses().values()) / REFERENCE.weight * shares / men
    return subject.weight * min(share * corrections.share(subject), 1.0)


def _shares_of(subject: Subject) -> dict[str, float]:
    return _shares(subject.gender, subject.thigh_on_seat)


def _masses(subject: Subject, corrections: Corrections) -> dict[str, float]:
    """Factor on the mass of each region and of the arms."""
    lumped, shares, men = _table_masses(), _shares_of(subject), _shares_of(REFERENCE)
    typical = {region: mass * (shares[region] / men[region]) for region, mass in lumped.items()}
    known: dict[str, float] = {}
    if subject.measured.head_mass is not None:
        for region in ("head", "cervical"):
            part = lumped[region] / (lumped["head"] + lumped["cervical"])
            known[region] = part * subject.measured.head_mass
    if subject.measured.arm_mass is not None:
        known["arm"] = 2 * subject.measured.arm_mass
    rest = sum(mass for region, mass in typical.items() if region not in known)
    grown = (_mass_on_seat(subject, corrections) - sum(known.values())) / rest
    return {
        region: known.get(region, grown * typical[region]) / mass for region, mass in lumped.items()
    }
