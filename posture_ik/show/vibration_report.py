"""One page that tells how a person vibrates: what reaches the head, what the seat feels, modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from plotly.offline import get_plotlyjs

from posture_ik.files import write_whole
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
from posture_ik.show.vibration_charts import (
    NOTHING,
    force_charts,
    model_colours,
    motion_charts,
    power_charts,
    printed_peaks,
)
from posture_ik.show.words import number, power, template, who
from posture_ik.vibration import Mode, Vibration, absorbed_power
from posture_ik.vibration.response import CHECKS, TOLERANCE

Row = dict[str, Any]

#: Power below nothing by no more than this, of the most, is rounding.
_ROUNDING = 1e-9


def write_vibration_report(vibration: Vibration, path: Path | str) -> None:
    """Write the report of vibration as one HTML file that needs no network.

    Raises:
        UnwritableOutput: the file cannot be written.
    """
    page = render_vibration_report(vibration)
    write_whole(path, page)


def render_vibration_report(vibration: Vibration) -> str:
    """Render the report as HTML, with styles, scripts and charts inside."""
    checks = _checks(vibration)
    motions, forces, powers = (of(vibration) for of in (motion_charts, force_charts, power_charts))
    return template("vibration.html").render(
        title=vibration.problem.title,
        base=vibration.base,
        asked=_asked(vibration),
        stability=vibration.stability,
        cautions=cautions(vibration),
        cards=_cards(vibration),
        holds=all(check["good"] for check in checks),
        models={model_name(name): colour for name, colour in model_colours(vibration).items()},
        printed=bool(printed_peaks(vibration)),
        powers={name: WAYS[name[-1]].capitalize() for name in powers},
        modes={
            "damped": _modes(vibration, vibration.damped),
            "undamped": _modes(vibration, vibration.undamped),
        },
        ways={way: WAYS[way] for way in head_peaks(vibration, vibration.asked.model)},
        shares=list(mass_shares(vibration, vibration.undamped[0])),
        last=f"{float(vibration.response['frequency'][-1]):g}",
        checks=checks,
        assumptions=_assumptions(vibration),
        motions=motions,
        forces=forces,
        figures=powers,
        plotly=get_plotlyjs(),
    )


def _asked(vibration: Vibration) -> list[str]:
    """What the problem says, in words."""
    asked, seat = vibration.asked, vibration.problem.seat
    block = asked.frequencies
    lines = [
        who(vibration.problem.subject),
        seat_in_words(vibration.problem),
        *([f"{seat.recline_deg:g}° back"] if seat.recline_deg else []),
        f"moved at the {vibration.base}",
        f"{block.start:g} to {block.stop:g} Hz in steps of {block.step:g} Hz",
    ]
    if asked.model == "multibody":
        lines.append("with" if asked.gravity else "without")
        lines[-1] += " the stiffness of weight"
        lines += ["with that of holding forces"] if asked.prestress else []
    if asked.parameters != "source" and "finite_element" in vibration.responses:
        lines.append(f"finite elements with {asked.parameters} parameters")
    return lines


def _cards(vibration: Vibration) -> list[Row]:
    """Key numbers: the head's peaks, the apparent mass, the lowest mode."""
    model = vibration.asked.model
    cards = [
        {
            "name": f"Head, {WAYS[axis]}",
            "value": f"{peak.value:.2f}",
            "unit": f"× {vibration.base}",
            "more": f"most, {peak}",
        }
        for axis, peak in head_peaks(vibration, model).items()
        if peak.value > NOTHING
    ]
    mass = mass_on_base(vibration, model)
    most, lowest = peak_of(mass), float(mass["frequency"][0])
    cards.append(
        {
            "name": "Apparent mass",
            "value": number(most.value),
            "unit": "kg",
            "more": f"most, {most}; {number(abs(complex(mass[0])))} kg at {lowest:g} Hz",
        }
    )
    modes = modes_in_range(vibration, vibration.damped)
    if modes:
        cards.append(
            {
                "name": "Lowest mode",
                "value": f"{modes[0].frequency:.2f}",
                "unit": "Hz",
                "more": f"{modes[0].symmetry}, damping ratio {modes[0].damping_ratio:.2f}",
            }
        )
    return cards


def _modes(vibration: Vibration, modes: tuple[Mode, ...]) -> list[Row]:
    """The modes in range, with the share of the mass that moves in each, in per cent."""
    return [
        {
            "frequency": f"{mode.frequency:.2f}",
            "ratio": f"{mode.damping_ratio:.3f}".replace("-", "−"),
            "grows": mode.eigenvalue.real > 1e-6,
            "symmetry": mode.symmetry,
            "words": mode.words,
            "shares": [f"{100.0 * share:.1f}" for share in mass_shares(vibration, mode).values()],
        }
        for mode in modes_in_range(vibration, modes)
    ]


def _checks(vibration: Vibration) -> list[Row]:
    """Each check as a row: what, its number, what it must be, whether it is, and what it means."""
    rows = [
        {
            "what": f"{model_name(name)}: {data.method} solution, over the direct",
            "value": power(data.miss),
            "must": f"at most {power(TOLERANCE)}",
            "good": data.miss <= TOLERANCE,
            "means": "solved directly at every frequency"
            if data.method == "direct"
            else f"at {min(CHECKS, len(data['frequency']))} frequencies the fast way gives what "
            "solving the equations there gives",
        }
        for name, data in vibration.responses.items()
    ]
    system = vibration.system
    skew = max(
        float(np.abs(part - part.T).max() / max(np.abs(part).max(), np.finfo(float).tiny))
        for part in (system.mass, system.damping, system.stiffness)
    )
    fed = absorbed_power(vibration.response, vibration.base).values
    least = float(fed.min() / fed.max())
    return [
        *rows,
        {
            "what": "Matrices equal their transposes",
            "value": power(skew),
            "must": "at most 10⁻⁹",
            "good": skew <= 1e-9,
            "means": "what one place does to another, that one does to it",
        },
        {
            "what": "Least power taken in, over the most",
            "value": power(least) if least >= 0.0 else f"−{power(-least)}",
            "must": "not below 0",
            "good": least >= -_ROUNDING,
            "means": "no motion draws energy from the person",
        },
    ]


def _assumptions(vibration: Vibration) -> list[str]:
    """What the numbers rest on and a reader should know."""
    asked, seat = vibration.asked, vibration.problem.seat
    lines = [
        "Motions are small: everything answers in proportion, and springs and dampers are those "
        "about the posture. People soften as they are shaken harder; that is not counted.",
        "Legs and feet are left out: what the seat carries is the trunk, the arms and the head.",
    ]
    if "multibody" in vibration.responses:
        lines += [
            "Multibody: joints give along the spine and in three turns, about the solved posture; "
            "shear is rigid. Springs are those of tissue, whatever chose the posture.",
            _arms(vibration),
            f"The stiffness of weight, negative for what stands, is {_counted(asked.gravity)}; "
            f"that of the forces that hold the posture is {_counted(asked.prestress)}.",
        ]
    if "finite_element" in vibration.responses:
        lines.append(
            "Finite elements: vertebrae with six motions each, arms as point masses on T2; "
            + (
                "of the solved posture's shape. "
                if asked.shape == "solved"
                else "the erect person, reclined as a whole. "
            )
            + "What is not published was identified from the modes and peaks of Cocco (2019)."
        )
    if any(model.startswith("lumped:") for model in vibration.responses):
        lines.append(
            "Lumped models move up and down alone, and are of their authors' subjects: posture, "
            "person, backrest and recline do not change them."
        )
    if seat.backrest is not None:
        held = seat.backrest.tangential_stiffness or seat.backrest.tangential_damping
        lines.append(
            "The backrest holds the mean motion of its vertebrae, as if the back never left it, "
            f"and along it the back {'is held by spring and damper' if held else 'slides'}."
        )
    if vibration.base == "backrest":
        lines.append(
            "The backrest moves along its own axes: fore-and-aft is square to it, vertical along "
            "it. Links are told along the world's."
        )
    if seat.cushion is not None:
        lines.append("Seat and cushion give up and down alone; else they move with the floor.")
    return lines


def _arms(vibration: Vibration) -> str:
    grip = (
        "Hands that hold a lever keep hold of it; what else chose the posture is let go. "
        if vibration.asked.grip
        else "What chose the posture is let go, and so are levers. "
    )
    if vibration.problem.activation is None:
        return grip + "Arms hang on springs that are assumed."
    return grip + "Arms at work are as stiff as their active muscles; others hang on springs."


def _counted(counted: bool) -> str:
    return "counted" if counted else "not counted"
