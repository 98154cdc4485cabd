"""What to know at a glance of what the 3D page shows."""

from __future__ import annotations

from posture_ik.posture import Motion, Posture, Trajectory
from posture_ik.show.reaching import checks


def facts_of(shown: Posture | Motion | Trajectory) -> list[tuple[str, str]]:
    """Names and values."""
    match shown:
        case Motion():
            return _motion_facts(shown)
        case Trajectory():
            return _reach_facts(shown)
    return _posture_facts(shown)


def _posture_facts(posture: Posture) -> list[tuple[str, str]]:
    certificate = posture.certificate
    residual = max(certificate.primal, certificate.dual)
    return [
        ("Backrest reclined", f"{posture.problem.seat.recline_deg:g}°"),
        ("Strain energy", joules(posture.elastic_energy)),
        ("Certificate", f"{'holds' if certificate.holds else 'fails'}, residual {residual:.0e}"),
    ]


def _motion_facts(motion: Motion) -> list[tuple[str, str]]:
    """The same for a motion; the strain energy is that of its start, until the page plays."""
    reclines = [posture.problem.seat.recline_deg for posture in motion.postures]
    low, high = min(reclines), max(reclines)
    return [
        ("Lasts", f"{motion.time[-1] - motion.time[0]:.3g} s, {len(motion.time)} steps"),
        ("Backrest reclined", f"{low:g}°" if low == high else f"{low:.3g}° to {high:.3g}°"),
        ("Strain energy", joules(motion.postures[0].elastic_energy)),
        ("Tasks and rates met to", f"{motion.worst_residuals().max():.0e}"),
    ]


def _reach_facts(found: Trajectory) -> list[tuple[str, str]]:
    """The same for a trajectory."""
    start = found.postures(found.time[:1])[0]
    holds = all(check["good"] for check in checks(found))
    return [
        ("Takes", f"{found.duration:.3g} s"),
        ("Backrest reclined", f"{found.problem.seat.recline_deg:g}°"),
        ("Strain energy", joules(start.elastic_energy)),
        ("Effort", f"{found.effort:.3g} (N m)² s"),
        ("Certificate", "holds" if holds else "fails"),
        ("Ends within", f"{found.end_error:.0e} m, rad"),
    ]


def joules(energy: float) -> str:
    """An energy as people write it."""
    if energy < 1e-9:
        return "0 J"
    return f"{energy:.3g} J" if energy >= 0.1 else f"{1e3 * energy:.3g} mJ"
