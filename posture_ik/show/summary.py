"""A posture in a table for the terminal, and as a record for machines."""

from __future__ import annotations

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from posture_ik.posture import Motion, Posture, Trajectory


def summary(posture: Posture) -> Group:
    """What a person wants to know first: energy, what holds, what gives, can it be trusted."""
    certificate = posture.certificate
    verdict = (
        Text("holds", style="bold green") if certificate.holds else Text("fails", style="bold red")
    )
    head = Table(title=posture.problem.title, title_justify="left", show_header=False, box=None)
    head.add_column(style="dim")
    head.add_column()
    head.add_row(
        "strain energy",
        f"{posture.elastic_energy:.4g} J" if posture.elastic_energy > 1e-12 else "none",
    )
    if posture.problem.posture.gravity:
        head.add_row("weight's potential", f"{posture.gravity_energy:.5g} J")
    solved = f"{posture.iterations} iterations, {1e3 * posture.seconds:.1f} ms"
    head.add_row("solved in", solved)
    head.add_row(
        "certificate",
        Text.assemble(
            verdict,
            f": tasks to {certificate.primal:.0e}, gradient to {certificate.dual:.0e}, "
            f"least curvature {certificate.curvature:.2g}",
        ),
    )
    if posture.redundant:
        head.add_row("rows implied by others", ", ".join(posture.redundant))
    # What is left of rounding is no energy.
    joints = _joints(posture) if posture.elastic_energy > 1e-12 else Text("Every joint rests.")
    return Group(head, "", _forces(posture), "", joints, *_limits(posture))


def _forces(posture: Posture) -> Table:
    table = Table(title="What acts on the person (world axes)", title_justify="left", box=None)
    table.add_column("at")
    for axis in ("x", "y", "z"):
        table.add_column(f"F{axis} / N", justify="right")
    for axis in ("x", "y", "z"):
        table.add_column(f"M{axis} / N m", justify="right")
    for wrench in (*posture.wrenches, posture.seat):
        numbers = [*wrench.force, *wrench.moment]
        table.add_row(wrench.label, *[_number(value) for value in numbers])
    return table


def _joints(posture: Posture) -> Table:
    """The joints that store most energy."""
    table = Table(title="Where the energy is", title_justify="left", box=None)
    table.add_column("degree of freedom")
    for name in ("from rest", "carries", "energy / J"):
        table.add_column(name, justify="right")
    for i in np.argsort(-posture.energies)[:6]:
        dof, moved = posture.body.dofs[i], posture.displacement[i]
        slide = dof.endswith("_axial")
        table.add_row(
            dof,
            f"{1e3 * moved:.2f} mm" if slide else f"{np.degrees(moved):.2f}°",
            f"{_number(-posture.prestrain_force[i])} {'N' if slide else 'N m'}",
            f"{posture.energies[i]:.3g}",
        )
    return table


def _limits(posture: Posture) -> list[Text]:
    active = posture.active_limits
    if not active:
        return []
    named = ", ".join(f"{limit.dof} ({limit.side})" for limit in active[:8])
    more = f" and {len(active) - 8} more" if len(active) > 8 else ""
    return [Text(f"\nAt the end of their range: {named}{more}.")]


def _number(value: float) -> str:
    return f"{value:.1f}" if abs(value) >= 0.05 else "0"


def as_record(posture: Posture) -> dict[str, object]:
    """The same for machines: plain numbers, SI units in the keys."""
    certificate = posture.certificate
    return {
        "title": posture.problem.title,
        "status": posture.status,
        "energy_J": posture.energy,
        "elastic_energy_J": posture.elastic_energy,
        "iterations": posture.iterations,
        "seconds": posture.seconds,
        "certificate": {
            "holds": certificate.holds,
            "primal_residual": certificate.primal,
            "dual_residual": certificate.dual,
            "reduced_curvature": certificate.curvature,
            "redundant": list(posture.redundant),
        },
        "wrenches": [
            {
                "at": wrench.label,
                "force_N": wrench.force.tolist(),
                "moment_Nm": wrench.moment.tolist(),
                "point_m": wrench.point.tolist(),
            }
            for wrench in (*posture.wrenches, posture.seat)
        ],
        "active_limits": [limit._asdict() for limit in posture.active_limits],
        "q": dict(zip(posture.body.dofs, posture.q.tolist(), strict=True)),
    }


def motion_summary(motion: Motion) -> Group:
    """What a motion takes at most, where and when, and how well it respects its tasks."""
    position, velocity, acceleration = motion.worst_residuals()
    head = Table(title=motion.problem.title, title_justify="left", show_header=False, box=None)
    head.add_column(style="dim")
    head.add_column()
    head.add_row("motion", f"{motion.time[-1]:g} s in {len(motion.time)} steps")
    misses = f"{position:.0e} in position, {velocity:.0e} in velocity, {acceleration:.0e} in "
    head.add_row("tasks missed by", misses + "acceleration (m or rad, per s, per s²)")
    if motion.redundant:
        head.add_row("rows implied by others", ", ".join(motion.redundant))
    table = Table(title="What the joints supply at most", title_justify="left", box=None)
    for name in ("degree of freedom", "supplies", "at", "moves at most"):
        table.add_column(name, justify="left" if name.startswith("degree") else "right")
    peaks = np.abs(motion.tau).max(axis=0) / np.sqrt(motion.postures[0].stiffness)
    for i in np.argsort(-peaks)[:6]:
        slide = motion.body.dofs[i].endswith("_axial")
        when = int(np.abs(motion.tau[:, i]).argmax())
        fastest = np.abs(motion.v[:, i]).max()
        table.add_row(
            motion.body.dofs[i],
            f"{_number(motion.tau[when, i])} {'N' if slide else 'N m'}",
            f"{motion.time[when]:.2f} s",
            f"{1e3 * fastest:.1f} mm/s" if slide else f"{np.degrees(fastest):.1f}°/s",
        )
    return Group(head, "", table)


def motion_record(motion: Motion) -> dict[str, object]:
    """The same for machines: plain numbers, SI units in the keys."""
    position, velocity, acceleration = map(float, motion.worst_residuals())
    peak = np.abs(motion.tau).max(axis=0)
    return {
        "title": motion.problem.title,
        "duration_s": float(motion.time[-1]),
        "steps": len(motion.time),
        "position_residual": position,
        "velocity_residual": velocity,
        "acceleration_residual": acceleration,
        "redundant": list(motion.redundant),
        "peak_tau": dict(zip(motion.body.dofs, peak.tolist(), strict=True)),
    }


def trajectory_summary(found: Trajectory) -> Group:
    """How long a reach takes, what it costs and takes at most, and can it be trusted."""
    head = Table(title=found.problem.title, title_justify="left", show_header=False, box=None)
    head.add_column(style="dim")
    head.add_column()
    head.add_row("takes", f"{found.duration:.4g} s, with {found.effort:.4g} (N m)² s of effort")
    head.add_row(
        "found on", " → ".join(str(each.intervals) for each in found.rounds) + " intervals"
    )
    head.add_row(
        "certificate",
        f"equations and limits to {found.primal:.0e}, gradient to {found.dual:.0e}, intervals "
        f"integrated to {found.defect:.0e}",
    )
    head.add_row("integrated, it ends", f"{found.end_error:.0e} m or rad from its tasks")
    if found.actuators:
        highest = found.activation.max(axis=0)
        hardest = ", ".join(
            f"{found.actuators.names[i]} {highest[i]:.2g}" for i in np.argsort(-highest)[:4]
        )
        head.add_row("highest activations", hardest)
        left = np.abs(found.reserve).max()
        head.add_row("muscles leave", f"{left:.0e} N m at most to the reserve")
    table = Table(title="What the joints do at most", title_justify="left", box=None)
    for name in ("degree of freedom", "from", "to", "moves at most", "supplies at most"):
        table.add_column(name, justify="left" if name.startswith("degree") else "right")
    fastest, strongest = (np.abs(each).max(axis=0) for each in (found.v, found.tau))
    for i, dof in enumerate(found.limb.joints):
        slide = dof.endswith("_axial")
        factor, unit = (1e3, " mm") if slide else (np.degrees(1.0), "°")
        table.add_row(
            dof,
            f"{factor * found.q[0, i]:.1f}{unit}",
            f"{factor * found.q[-1, i]:.1f}{unit}",
            f"{factor * fastest[i]:.1f}{unit}/s",
            f"{_number(strongest[i])} {'N' if slide else 'N m'}",
        )
    return Group(head, "", table)


def trajectory_record(found: Trajectory) -> dict[str, object]:
    """The same for machines: plain numbers, SI units in the keys."""
    joints = found.limb.joints
    by_muscles: dict[str, object] = {}
    if found.actuators:
        highest = found.activation.max(axis=0).tolist()
        by_muscles = {
            "peak_activation": dict(zip(found.actuators.names, highest, strict=True)),
            "peak_reserve": dict(
                zip(joints, np.abs(found.reserve).max(axis=0).tolist(), strict=True)
            ),
            "imbalance": found.imbalance,
        }
    peaks = {"peak_speed": found.v, "peak_tau": found.tau}
    return {
        "title": found.problem.title,
        "status": found.status,
        "cost": found.cost,
        "duration_s": found.duration,
        "effort_N2m2s": found.effort,
        "primal_residual": found.primal,
        "dual_residual": found.dual,
        "defect": found.defect,
        "overshoot": found.overshoot,
        "end_error": found.end_error,
        "rounds": [each._asdict() for each in found.rounds],
        "start": dict(zip(joints, found.q[0].tolist(), strict=True)),
        "end": dict(zip(joints, found.q[-1].tolist(), strict=True)),
        **{
            name: dict(zip(joints, np.abs(values).max(axis=0).tolist(), strict=True))
            for name, values in peaks.items()
        },
        **by_muscles,
    }
