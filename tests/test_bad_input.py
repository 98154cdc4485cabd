"""Every bad input: one sentence with place and value, exit code 2, and nothing left behind."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from posture_ik.cli import main
from posture_ik.resources import resource

URDF = (resource("urdf") / "seated_person.urdf").read_text()

HEAD = '[[task]]\nkind = "head"\n'


def problem(text: str) -> Callable[[Path], list[str]]:
    """A run of a problem file of this text."""

    def command(folder: Path) -> list[str]:
        (folder / "bad.toml").write_text(text)
        return ["run", str(folder / "bad.toml"), "-o", str(folder / "out")]

    return command


def person(text: str) -> Callable[[Path], list[str]]:
    """A run of a problem file with this subject."""
    return problem(f"[subject]\n{text}\n{HEAD}")


def changed(*settings: str, name: str = "reclined_15") -> Callable[[Path], list[str]]:
    """A run of an example with values set on the command line."""

    def command(folder: Path) -> list[str]:
        sets = [part for setting in settings for part in ("--set", setting)]
        return ["run", name, "-o", str(folder / "out"), *sets]

    return command


def urdf(text: str | bytes) -> Callable[[Path], list[str]]:
    """A run with a URDF of one's own."""

    def command(folder: Path) -> list[str]:
        path = folder / "mine.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return [*changed(f'subject.urdf="{path}"')(folder)]

    return command


def command(*words: str) -> Callable[[Path], list[str]]:
    return lambda folder: [word.replace("TMP", str(folder)) for word in words]


def without(text: str, start: str, end: str) -> str:
    """Cut a piece out of the URDF, from one mark to the end of another."""
    first = text.index(start)
    return text[:first] + text[text.index(end, first) + len(end) :]


BAD = {
    # files
    "no such file": (command("run", "TMP/none.toml"), "none.toml: there is no such file"),
    "no such example": (command("run", "reclined_20"), "reclined_20.*did you mean 'reclined_"),
    "a folder": (command("run", "TMP"), "cannot be read|no example"),
    "empty file": (problem(""), "bad.toml: is empty"),
    "not TOML": (problem("title = 'a"), "not valid TOML"),
    "not text": (
        lambda folder: [
            (folder / "bad.toml").write_bytes(b"\xff\xfe\x00"),
            ["run", str(folder / "bad.toml"), "-o", str(folder / "out")],
        ][1],
        "UTF-8",
    ),
    "no task": (problem('title = "nothing asked"'), "task is missing"),
    "empty task list": (problem("task = []"), "task.*at least 1"),
    # keys and kinds
    "unknown block": (problem(HEAD + "[seet]\nrecline_deg = 3"), "seet.*did you mean 'seat'"),
    "unknown key": (changed("seat.recline=15"), "seat.recline .*did you mean 'recline_deg'"),
    "unknown key in a task": (
        problem(HEAD + "lookin = 'ahead'"),
        r"task 1 \(head\).lookin.*did you mean 'looking'",
    ),
    "unknown kind": (
        problem('[[task]]\nkind = "hed"'),
        "no task is of kind 'hed'; did you mean 'head'",
    ),
    "no kind": (problem("[[task]]\nslide = true"), "task 1 needs a kind"),
    "subject is a number": (problem("subject = 3\n" + HEAD), "subject is 3"),
    "posture is a list": (problem("posture = [1]\n" + HEAD), "posture is"),
    # the subject
    "stature in cm": (changed("subject.stature=180"), r"stature = 180.*did you mean 1\.8 m"),
    "stature too small": (changed("subject.stature=0.9"), "between 1.40 and 2.10 m"),
    "stature is a word": (changed('subject.stature="tall"'), "subject.stature = 'tall'"),
    "stature is NaN": (changed("subject.stature=nan"), "subject.stature = nan"),
    "weight is infinite": (changed("subject.weight=inf"), "subject.weight = inf"),
    "weight negative": (changed("subject.weight=-80"), "subject.weight = -80.*greater than 0"),
    "weight in grams": (changed("subject.weight=80000"), "body mass index.*45 to 178 kg"),
    "weight in pounds": (
        changed("subject.weight=198.4"),
        r"did you mean 89\.99 kg\? 198\.4 fits as lb",
    ),
    "stature in inches": (changed("subject.stature=71"), r"did you mean 1\.803 m\? 71 fits as in"),
    "stature in feet": (changed("subject.stature=5.9"), r"did you mean 1\.798 m\? 5\.9 fits as ft"),
    "stature as weight": (changed("subject.weight=1.8"), r"weight 1\.8 kg.*is it the stature"),
    "more than a thigh": (
        changed("subject.thigh_on_seat=1.4"),
        r"thigh_on_seat = 1\.4.*1",
    ),
    "no tension at all": (changed("subject.tension=0"), r"subject\.tension = 0.*greater than 0"),
    "bmi beside weight": (changed("subject.bmi=25"), "bmi gives the weight too"),
    "bmi of nobody": (person("bmi = 60"), "bmi = 60 must be a number between 14 and 55"),
    "bmi of a giant": (person("bmi = 25\nstature = 180"), r"stature = 180.*did you mean 1\.8 m"),
    "percentile beside stature": (
        changed('subject.percentile="P5 female"'),
        "percentile gives the gender too",
    ),
    "percentile of nobody": (
        person('percentile = "5 % female"'),
        "percentile = '5 % female' must be one from P1 to P99 and a gender, such as 'P5 female'",
    ),
    "percentile off the table": (person('percentile = "P99.9 male"'), "from P1 to P99"),
    "scaling by no law": (
        changed('subject.scaling="linear"'),
        "subject.scaling = 'linear'.*'thesis' or 'anthropometric'",
    ),
    "measured misspelt": (
        changed("subject.measured.siting_height=0.9"),
        "subject.measured.siting_height is not a known key; did you mean 'sitting_height'",
    ),
    "measured in cm": (
        changed("subject.measured.sitting_height=92"),
        r"measured.sitting_height = 92 m; of this person.*did you mean 0\.92 m",
    ),
    "measured of a child": (
        changed("subject.measured.forearm_length=0.18"),
        r"measured.forearm_length = 0\.18 m; of this person it must lie between 0\.22",
    ),
    "measured contradict each other": (
        changed("subject.measured.sitting_height=0.86", "subject.measured.cervicale_height=0.76"),
        "of this person with what else is measured it must lie between",
    ),
    "measured for one stretch": (
        changed('subject.scaling="thesis"', "subject.measured.sitting_height=0.9"),
        "measured counts for nothing where scaling = 'thesis'.*leave it out",
    ),
    "arm of another": (
        changed("subject.measured.arm_mass=9"),
        r"measured.arm_mass = 9 kg; of a person of 80 kg it must lie between 2\.00 and 8\.00 kg",
    ),
    "age of a child": (changed("subject.age=12"), "subject.age = 12.*greater than or equal to 18"),
    "gender misspelt": (
        changed('subject.gender="mal"'),
        "subject.gender = 'mal'.*'male' or 'female'",
    ),
    # the seat
    "recline beyond flat": (changed("seat.recline_deg=120"), "seat.recline_deg = 120.*90"),
    "recline is a word": (changed('seat.recline_deg="far"'), "seat.recline_deg = 'far'"),
    "backrest of wood": (
        changed('seat.backrest.kind="wood"'),
        "seat.backrest: no backrest is of kind 'wood'; valid are rigid, foam, law",
    ),
    "backrest of no kind": (
        changed("seat.backrest={}"),
        "seat.backrest needs a kind, one of rigid, foam, law",
    ),
    "a backrest at no vertebra": (
        changed('seat.backrest={kind="foam", at="T13"}'),
        "seat.backrest.at = 'T13': no vertebra.*did you mean",
    ),
    "unknown parameters": (
        changed('vibration.parameters="fitted"'),
        "vibration.parameters = 'fitted'.*'source' or 'calibrated'",
    ),
    "foam without stiffness": (
        changed('seat.backrest={kind="foam", stiffness=-1}'),
        "seat.backrest.stiffness = -1.*greater than or equal to 0",
    ),
    "a rigid backrest of foam": (
        changed('seat.backrest={kind="rigid", stiffness=2e4}'),
        "seat.backrest.stiffness is not a known key.*did you mean 'tangential_stiffness'",
    ),
    "backrest behind no one": (
        changed('seat.backrest={kind="foam", bodies="T1-T13"}'),
        "seat.backrest.bodies = 'T1-T13': no vertebra is called 'T13'",
    ),
    # vibration
    "model unknown": (changed('vibration.model="multi"'), "vibration.model = 'multi'.*lumped:"),
    "no frequency zero": (
        changed("vibration.frequencies.start=0"),
        "vibration.frequencies.start = 0.*greater than 0",
    ),
    "frequencies descend": (
        changed("vibration.frequencies={start=5.0, stop=1.0}"),
        "vibration.frequencies: stop 1 Hz lies below start 5 Hz",
    ),
    "frequencies without number": (
        changed("vibration.frequencies.step=nan"),
        "vibration.frequencies.step = nan",
    ),
    "frequencies without end": (
        changed("vibration.frequencies.step=1e-6"),
        "more than 100,000 frequencies",
    ),
    "vibration key": (changed("vibration.gravty=true"), "did you mean 'gravity'"),
    "motion of no link": (
        changed('vibration.frames=["T77"]', name="vibration_upright"),
        "no link called 'T77'; did you mean 'T7'",
    ),
    "motion of no finite element": (
        changed('vibration={ model="finite_element", frames=["grip_r"] }'),
        "grip_r",
    ),
    "motion of no mass": (
        changed('vibration={ model="lumped:zhang", frames=["m9"] }'),
        "vibration.frames: the model 'lumped:zhang' tells no motion of 'm9'; did you mean 'm",
    ),
    "a backrest that is not there moves": (
        changed('vibration.input="backrest"'),
        'vibration.input = "backrest" needs a backrest to move; give one under',
    ),
    "a backrest that a model lacks moves": (
        changed(
            'seat.backrest={ kind="foam" }',
            'vibration={ model="lumped:abbas", input="backrest" }',
        ),
        "vibration.input: the model 'lumped:abbas' has no backrest that could move; .* is seat",
    ),
    "no lumped model": (
        changed('vibration.model="lumped:zang"'),
        "zang: no lumped model has this name; did you mean 'zhang'",
    ),
    # the tasks
    "looking nowhere": (changed('task.head.looking="up"'), "looking = 'up'.*write \"ahead\""),
    "position misspelt": (changed('task.head.position="over T1"'), "over C1"),
    "position of two numbers": (changed("task.head.position=[0, 1]"), r"head\)\.position"),
    "position in mm": (changed("task.head.position=[20, 0, 750]"), "metres.*millimetres"),
    "position with a word": (changed('task.head.position=[0, "a", 1]'), "position.*'a'"),
    "unknown vertebra": (changed('task.backrest.bodies="T1-T13"'), "T13.*did you mean 'T"),
    "no vertebrae": (changed("task.backrest.bodies=[]"), "bodies.*T1-T10"),
    "slide is a number": (changed("task.backrest.slide=0.5"), "slide = 0.5.*bool"),
    "unknown component": (
        problem('[[task]]\nkind = "frame"\nframe = "T5"\ncomponents = ["ry", "q"]'),
        "components.*'q'",
    ),
    "no component": (
        problem('[[task]]\nkind = "frame"\nframe = "T5"\ncomponents = []'),
        "components.*at least 1",
    ),
    "unknown frame": (
        problem('[[task]]\nkind = "frame"\nframe = "T55"\ncomponents = ["x"]'),
        "frame T55.*no such link.*did you mean 'T5'",
    ),
    "unknown side": (
        problem('[[task]]\nkind = "hand"\nside = "port"\nposition = [0.4, 0, 0.3]'),
        "side = 'port'.*'right' or 'left'",
    ),
    "hand without position": (
        problem('[[task]]\nkind = "hand"\nside = "left"'),
        "either a lever or a position",
    ),
    "the same task twice": (problem(HEAD + HEAD), "task 2 holds head a second time"),
    "contact without gravity": (
        changed("posture.gravity=false", name="reclined_15_gravity"),
        "backrest_contact needs the weight.*gravity = true",
    ),
    "unknown lever": (
        changed("task.hand.lever=cyclc", name="pilot_cyclic"),
        "no lever called 'cyclc'; did you mean 'cyclic'",
    ),
    "lever that follows nobody": (
        changed(
            "task.hand={ kind='hand', side='right', position=[0.36,0,0.29] }", name="pilot_push"
        ),
        "lever.cyclic follows no hand",
    ),
    "lever that follows half a hand": (
        changed("task.hand.components=['x', 'y']", name="pilot_push"),
        "right hand must hold x, y and z of lever.cyclic, which follows it",
    ),
    "lever that follows and is moved": (
        changed("motion.signal.1.of=lever.cyclic.fore_aft_deg", name="pilot_push"),
        "cannot move: lever.cyclic follows the hand",
    ),
    "lever that follows by an unknown angle": (
        changed("lever.cyclic.follows=['sideways']", name="pilot_push"),
        "lever.cyclic.follows.*'fore_aft' or 'lateral'",
    ),
    "lever without a spring": (
        changed("lever.cyclic.stiffness=0", name="pilot_push"),
        "lever.cyclic.stiffness = 0: .*greater than 0",
    ),
    # the motion
    "nothing moves": (command("move", "upright"), "motion: is missing"),
    "signal of nothing": (
        changed("motion.signal.1.of=seat.tilt", name="nod"),
        "seat.tilt: there is no 'tilt'",
    ),
    "motion out of range": (
        lambda folder: [
            "move",
            "nod",
            *("--set", "motion.signal.1.amplitude=120"),
            *("--set", "motion.rate=20"),
            *("-o", str(folder / "out")),
        ],
        r"at 0\.\d+ s the task",
    ),
    # the muscles
    "unknown law": (
        changed('activation.law="hill"', name="pilot"),
        "activation.law = 'hill'.*'pennestri' or 'de_groote'",
    ),
    "unknown cost of muscles": (
        changed('activation.cost="energy"', name="pilot"),
        "activation.cost = 'energy'.*'squares', 'volume' or 'fatigue'",
    ),
    "unknown key of muscles": (
        changed("activation.cocontraction=0.1", name="pilot"),
        "activation.cocontraction .*did you mean 'co_contraction'",
    ),
    "more than full activation": (
        changed("activation.co_contraction=1.5", name="pilot"),
        "activation.co_contraction = 1.5: .*less than or equal to 1",
    ),
    "negative co-contraction": (
        lambda folder: ["activate", "upright", "--set", "activation.co_contraction=-0.1"],
        "activation.co_contraction = -0.1: .*greater than or equal to 0",
    ),
    "force of two numbers": (
        changed("activation.hand_force.left=[0, -20]", name="pilot"),
        r"activation.hand_force.left",
    ),
    "force of a word": (
        changed('activation.hand_force.left=[0, 0, "down"]', name="pilot"),
        r"activation.hand_force.left.*'down'",
    ),
    "force without end": (
        changed("activation.hand_force.left=[0, 0, -inf]", name="pilot"),
        r"activation.hand_force.left",
    ),
    "force on a third hand": (
        changed("activation.hand_force.middle=[0, 0, 1]", name="pilot"),
        r"activation.hand_force.*middle.*'right' or 'left'",
    ),
    "negative reflex": (
        changed("activation.reflex.proportional=-1", name="pilot"),
        "activation.reflex.proportional = -1: .*greater than or equal to 0",
    ),
    "muscles that a signal moves": (
        changed("motion.signal.1.of=activation.co_contraction", name="pilot_collective"),
        "activation.co_contraction cannot move",
    ),
    "muscles of a trajectory": (
        changed('activation.law="pennestri"', name="reach_cyclic"),
        r'no muscle drives a \[trajectory\] of cost = "effort"; leave it out',
    ),
    "muscles of a missing arm": (
        lambda folder: [
            (folder / "mine.urdf").write_text(
                URDF.replace('"elbow_flexion_l" type="revolute"', '"elbow_flexion_l" type="fixed"')
            ),
            ["activate", "upright", "--set", f'subject.urdf="{folder / "mine.urdf"}"'],
        ][1],
        "this body has no joint 'elbow_flexion_l'",
    ),
    # the trajectory
    "nothing to reach": (command("trajectory", "upright"), "trajectory: is missing"),
    "motion and trajectory": (
        changed("trajectory.duration=1", name="nod"),
        r"\[motion\].*or \[trajectory\].*not both",
    ),
    "no time": (
        changed("trajectory.duration=0", name="reach_cyclic"),
        "trajectory.duration = 0: .*greater than 0",
    ),
    "cost misspelt": (
        changed('trajectory.cost="energy"', name="reach_cyclic"),
        "trajectory.cost = 'energy'.*'effort', 'time' or 'activation'",
    ),
    "least time without limits": (
        changed('trajectory={ cost = "time" }', name="reach_cyclic"),
        "least time needs a limit on torque or speed",
    ),
    "least time in a given time": (
        changed("trajectory.duration=1", name="reach_collective"),
        "least time finds the duration",
    ),
    "lag without muscles": (
        changed("trajectory.activation_dynamics=true", name="reach_cyclic"),
        "activation_dynamics is of muscles; ask for cost = 'activation' too",
    ),
    "muscles of the back": (
        changed('trajectory.joints=["elbow_flexion_r", "L4_L5_ry"]', name="reach_activation"),
        "trajectory.joints: 'L4_L5_ry' has no muscles to move it; .* joints of the arms alone",
    ),
    "torque of zero": (
        changed("trajectory.torque=0", name="reach_cyclic"),
        "trajectory.torque = 0: write a number above zero or a table of joints",
    ),
    "speed of a word": (
        changed('trajectory.speed.elbow_flexion_r="fast"', name="reach_cyclic"),
        "trajectory.speed.*above zero for elbow_flexion_r, not 'fast'",
    ),
    "strength of a joint that stays": (
        changed("trajectory.strength.elbow_flexion_l=3", name="reach_cyclic"),
        "trajectory.strength.elbow_flexion_l: no such joint moves; did you mean 'elbow_flexion_r'",
    ),
    "unknown joint moves": (
        changed('trajectory.joints=["elbow_r"]', name="reach_cyclic"),
        "trajectory.joints: no joint is called 'elbow_r'; did you mean",
    ),
    "no joint moves": (
        changed("trajectory.joints=[]", name="reach_cyclic"),
        "trajectory.joints.*at least 1",
    ),
    "negative smoothness": (
        changed("trajectory.smoothness=-1", name="reach_cyclic"),
        "trajectory.smoothness = -1.*greater than or equal to 0",
    ),
    "loose tolerance": (
        changed("trajectory.tolerance=1", name="reach_cyclic"),
        "trajectory.tolerance = 1.*less than or equal to 0.1",
    ),
    "unknown key along": (
        changed('trajectory.along=[{ kind = "head", lookin = "up" }]', name="reach_cyclic"),
        r"trajectory.along 1 \(head\).lookin is not a known key; did you mean 'looking'",
    ),
    "the same task twice along": (
        changed('trajectory.along=[{ kind = "head" }, { kind = "head" }]', name="reach_cyclic"),
        "along 2 holds head a second time",
    ),
    "two ways to look": (
        changed(
            'trajectory.along=[{ kind = "head", looking = { turn_deg = 20 } }]',
            name="reach_cyclic",
        ),
        "'head' and 'head' cannot be met together",
    ),
    "lever out of reach": (
        changed("lever.cyclic.pivot=[1.1, 0, -0.17]", name="reach_cyclic"),
        "'right hand'.*cannot be met.*mm",
    ),
    "too little time": (
        changed("trajectory.duration=0.05", "trajectory.torque=10", name="reach_cyclic"),
        "no motion to the tasks was found: .*in 0.05 s",
    ),
    # the solve
    "unknown joint": (changed("posture.stiffness.L4_L6_ry=5"), "L4_L6_ry.*did you mean 'L4_L5_ry'"),
    "negative stiffness": (changed("posture.stiffness.L4_L5_ry=-5"), "L4_L5_ry must be above zero"),
    "zero stiffness": (changed("posture.stiffness.L4_L5_ry=0"), "L4_L5_ry must be above zero"),
    "stiffness NaN": (changed("posture.stiffness.L4_L5_ry=nan"), "L4_L5_ry must be above zero"),
    "stiffness misspelt": (changed('posture.stiffness="tisue"'), 'write "tissue", "uniform"'),
    "gravity is a word": (changed('posture.gravity="some"'), "posture.gravity = 'some'"),
    "ergonomic misspelt": (changed('posture.ergonomic="mid"'), "'reference' or 'middle'"),
    "gaze out of range": (
        changed("task.head.looking={ turn_deg = 150 }"),
        "'backrest' and 'head' cannot be met together.*deg.*at its upper limit",
    ),
    "hand out of reach": (
        changed("task.3.position=[1.2, 0, 0.3]", name="pilot"),
        "'right hand'.*cannot be met.*mm",
    ),
    # --set
    "set without a value": (changed("seat.recline_deg"), "--set seat.recline_deg: write key=value"),
    "set of no task": (
        changed("task.hand.side=left"),
        "--set task.hand.side=left: no block is called 'hand'",
    ),
    "set below a value": (changed("title.part=1"), "title holds a value"),
    "set of the task list": (changed("task.slide=true"), "no block is called 'slide'"),
    # the URDF
    "URDF missing": (changed('subject.urdf="none.urdf"'), "none.urdf.*no such file"),
    "URDF empty": (urdf(""), "mine.urdf.*empty"),
    "URDF not XML": (urdf("<robot"), "mine.urdf.*XML"),
    "URDF of nothing": (urdf("<robot name='r'><link name='a'/></robot>"), "mine.urdf"),
    "URDF without a head": (urdf(URDF.replace('"Head"', '"Skull"')), "mine.urdf.*Head"),
    "URDF with a loop": (
        urdf(
            URDF.replace(
                "</robot>",
                '<joint name="loop" type="fixed"><parent link="Head"/><child link="S1"/></joint>'
                "</robot>",
            )
        ),
        "mine.urdf.*S1.*two parents|mine.urdf.*S1.*loop|mine.urdf.*S1",
    ),
    "URDF without a spine joint": (
        urdf(URDF.replace('"L4_L5_ry"', '"L4_L5_pitch"')),
        "mine.urdf.*L4_L5_",
    ),
    "URDF with NaN": (urdf(URDF.replace('mass value="4.33', 'mass value="nan')), "mine.urdf.*nan"),
    # results and places to write
    "no such folder": (command("report", "TMP/none"), "none: there is no such folder"),
    "folder without results": (command("report", "TMP"), "problem.toml: is missing"),
    "view of a file": (
        lambda folder: [(folder / "f").write_text(""), ["view", str(folder / "f")]][1],
        "there is no such folder",
    ),
    "output is a file": (
        lambda folder: [
            (folder / "taken").write_text("mine"),
            ["run", "reclined_15", "-o", str(folder / "taken")],
        ][1],
        "taken: cannot write here",
    ),
    "output below a file": (
        lambda folder: [
            (folder / "taken").write_text("mine"),
            ["solve", "reclined_15", "-o", str(folder / "taken" / "deep")],
        ][1],
        "cannot write here",
    ),
    "unknown export": (
        command("export", "upright", "--to", "step"),
        "--to step.*urdf, mbdyn, nastran",
    ),
    "sensitivity at no frequency": (
        command("sensitivity", "upright", "--at", "-3"),
        "at: -3 Hz",
    ),
    "sensitivity where there is no peak": (
        command("sensitivity", "upright", "--set", "vibration.frequencies.stop=0.5"),
        "vibration.frequencies: the apparent mass has no peak between 0.1 and 0.5 Hz",
    ),
    "sensitivity of a backrest that is not": (
        command(
            "sensitivity",
            "vibration_reclined_foam",
            "--set",
            "vibration.model=lumped:wan_schimmels",
            "--set",
            "vibration.input=backrest",
        ),
        "vibration.input: .*wan_schimmels.* has no backrest",
    ),
    "identify what there is not": (command("identify", "nothing"), "'nothing'.*'calibrated'"),
    "unknown command": (command("sovle", "upright"), "sovle"),
    "unknown option": (command("solve", "upright", "--gravty"), "--gravty"),
    "missing argument": (command("solve"), "PROBLEM"),
}


def snapshot(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() if p.is_file() else b"" for p in sorted(folder.rglob("*"))}


@pytest.mark.parametrize("name", BAD)
def test_one_sentence_and_exit_code_2(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    prepare, expected = BAD[name]
    words = prepare(tmp_path)
    before = snapshot(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["posture-ik", *words])
    with pytest.raises(SystemExit) as stopped:
        main()
    said = capsys.readouterr()
    assert stopped.value.code == 2
    assert said.out == ""
    assert said.err.startswith("posture-ik: ")
    assert said.err.count("\n") == 1, f"more than a sentence: {said.err}"
    assert "Traceback" not in said.err
    assert len(said.err) < 700
    assert re.search(expected, said.err), said.err
    assert snapshot(tmp_path) == before, "something was left behind"


def test_the_list_is_long_enough() -> None:
    assert len(BAD) >= 40


def test_the_real_command_speaks_alike(tmp_path: Path) -> None:
    """Once through a process: what urdfdom's C++ prints would not show in pytest's capture."""
    broken = tmp_path / "mine.urdf"
    broken.write_text(URDF.replace('lower="-', 'lower="9'))
    run = subprocess.run(
        [sys.executable, "-m", "posture_ik", "solve", "upright", "--set", f"subject.urdf={broken}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.startswith("posture-ik: ")
    assert run.stderr.count("\n") == 1
