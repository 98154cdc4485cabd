"""Vibration in tables for the terminal, and as a record for machines."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from posture_ik.show.resonance import (
    WAYS,
    cautions,
    head_peaks,
    mass_on_base,
    mass_shares,
    model_name,
    modes_in_range,
    peak_of,
    seat_in_words,
)
from posture_ik.vibration import Mode, Vibration

#: Modes listed.
_MOST = 10


def vibration_summary(vibration: Vibration) -> Group:
    """What a person wants to know first: whether it stands, what reaches the head, and when."""
    data = vibration.response
    head = Table(title=vibration.problem.title, title_justify="left", show_header=False, box=None)
    head.add_column(style="dim")
    head.add_column()
    head.add_row("model", model_name(vibration.asked.model))
    head.add_row("sits", seat_in_words(vibration.problem))
    first, last = float(data["frequency"][0]), float(data["frequency"][-1])
    head.add_row("moved", f"at the {vibration.base}, {first:g} to {last:g} Hz")
    if vibration.stability.stable:
        head.add_row("stability", Text.assemble(("stable", "bold green"), ": all motion dies away"))
    how = (
        "solved directly at every frequency"
        if data.method == "direct"
        else f"{data.method}, within {data.miss:.0e} of the direct solution"
    )
    head.add_row("certificate", Text.assemble(("holds", "bold green"), f": {how}"))
    notes = [Text(f"\n{line}", style="yellow") for line in cautions(vibration)]
    return Group(*_unstable(vibration), head, "", _peaks(vibration), "", _modes(vibration), *notes)


def _unstable(vibration: Vibration) -> Iterator[Panel]:
    """What falls, before all else."""
    if not vibration.stability.stable:
        yield Panel(
            f"The posture does not hold by itself: {vibration.stability}.\nThe responses below "
            "belong to someone who would be held while falling; nobody will measure them.",
            title="UNSTABLE",
            style="bold red",
            expand=False,
        )


def _peaks(vibration: Vibration) -> Table:
    """Peaks of each model: the head's motion over the base's, and the apparent mass."""
    table = Table(
        title=f"Peaks: head over {vibration.base}, apparent mass at the {vibration.base}",
        title_justify="left",
        box=None,
    )
    table.add_column("model", no_wrap=True)
    for axis in WAYS:
        table.add_column(axis, justify="right")
        table.add_column("Hz", justify="right", style="dim")
    lowest = float(vibration.response["frequency"][0])
    table.add_column("kg", justify="right")
    table.add_column("Hz", justify="right", style="dim")
    table.add_column(f"kg at {lowest:g} Hz", justify="right")
    for model in vibration.responses:
        peaks, mass = head_peaks(vibration, model), mass_on_base(vibration, model)
        cells = [
            cell
            for axis in WAYS
            for cell in (
                (f"{peaks[axis].value:.2f}", f"{peaks[axis].frequency:.2f}")
                if axis in peaks
                else ("", "")
            )
        ]
        most = peak_of(mass)
        static = abs(complex(mass[0]))
        table.add_row(
            model_name(model),
            *cells,
            *(f"{most.value:.1f}", f"{most.frequency:.2f}", f"{static:.1f}"),
        )
    return table


def _modes(vibration: Vibration) -> Table:
    """The lowest modes with damping, and what moves in them."""
    table = Table(title="Lowest modes", title_justify="left", box=None)
    table.add_column("Hz", justify="right")
    table.add_column("damping", justify="right")
    table.add_column("kind")
    table.add_column("what moves", overflow="fold")
    for mode in modes_in_range(vibration, vibration.damped)[:_MOST]:
        style = "bold red" if mode.eigenvalue.real > 0.0 else ""
        ratio = f"{mode.damping_ratio:.2f}"
        table.add_row(f"{mode.frequency:.2f}", ratio, mode.symmetry, mode.words, style=style)
    return table


def vibration_record(vibration: Vibration) -> dict[str, object]:
    """The same for machines: plain numbers, SI units in the keys."""
    data, worst = vibration.response, vibration.stability.worst
    return {
        "title": vibration.problem.title,
        "model": vibration.asked.model,
        "base": vibration.base,
        "frequencies": len(data["frequency"]),
        "stable": vibration.stability.stable,
        "worst": _record(vibration, worst) | {"growth_per_s": worst.eigenvalue.real},
        "certificate": {"method": data.method, "miss": data.miss},
        "responses": {model: _peak_record(vibration, model) for model in vibration.responses},
        **{
            f"{kind}_modes": [_record(vibration, mode) for mode in modes_in_range(vibration, modes)]
            for kind, modes in (("undamped", vibration.undamped), ("damped", vibration.damped))
        },
        "cautions": cautions(vibration),
    }


def _peak_record(vibration: Vibration, model: str) -> dict[str, object]:
    mass = mass_on_base(vibration, model)
    most = peak_of(mass)
    return {
        "head": {
            axis: {"peak": peak.value, "frequency_Hz": peak.frequency}
            for axis, peak in head_peaks(vibration, model).items()
        },
        "apparent_mass": {
            "peak_kg": most.value,
            "frequency_Hz": most.frequency,
            "lowest_frequency_kg": abs(complex(mass[0])),
        },
    }


def _record(vibration: Vibration, mode: Mode) -> dict[str, object]:
    return {
        "frequency_Hz": mode.frequency,
        "damping_ratio": mode.damping_ratio,
        "symmetry": mode.symmetry,
        "words": mode.words,
        "mass_share": mass_shares(vibration, mode),
    }
