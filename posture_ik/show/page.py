"""The 3D page of a posture: one file that opens offline, or the same served live by meshcat."""

from __future__ import annotations

import base64
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

import jinja2
import meshcat
import numpy as np
import pinocchio as pin
import tornado.web
import umsgpack
from meshcat.servers.zmqserver import VIEWER_ROOT, ZMQWebSocketBridge
from scipy.spatial import ConvexHull

from posture_ik.arrays import Array
from posture_ik.body.laws import scale_of
from posture_ik.errors import PostureIKError
from posture_ik.files import write_whole
from posture_ik.kinematics import frame_poses
from posture_ik.muscle import Activity
from posture_ik.posture import Motion, Posture, Trajectory, Wrench
from posture_ik.resources import resource
from posture_ik.show.arrows import acting, labels, size
from posture_ik.show.facts import facts_of, joules
from posture_ik.show.looks import Look, looks_of
from posture_ik.show.mode_shapes import draw_viscera, mode_shapes
from posture_ik.show.moving import (
    animation,
    handles,
    largest_wrenches,
    packed,
    peak_parts,
    shown_steps,
    wrenches_at,
)
from posture_ik.show.played import Moving, played
from posture_ik.show.plots import joint_name
from posture_ik.show.scene import CAGE, draw, floor_height
from posture_ik.show.strain import RAMP, Part, action, full_scale, parts_of, place_on_scale
from posture_ik.show.tubes import tubes
from posture_ik.vibration import Vibration


class _Recorder:
    """Stands in for meshcat's window: keeps what would be sent to a browser."""

    def __init__(self) -> None:
        self.commands: list[str] = []

    def send(self, command: Any) -> None:
        self.commands.append(base64.b64encode(umsgpack.packb(command.lower())).decode("ascii"))


def write_view(
    shown: Posture | Motion | Trajectory,
    path: Path,
    activity: Activity | None = None,
    vibration: Vibration | None = None,
) -> None:
    """Write one HTML file that opens in any browser, without any network.

    Args:
        shown: a posture, or a motion or trajectory to play.
        path: of the file; it is written whole or not at all.
        activity: of its muscles, to be drawn too.
        vibration: about the posture shown, whose modes to play.

    Raises:
        PostureIKError: there is a vibration, but not about what is shown.
        UnwritableOutput: the file cannot be written.
    """
    recorder = _Recorder()
    moving = _moving(shown, vibration)
    _draw(meshcat.Visualizer(window=recorder), moving, vibration)
    write_whole(path, _page(moving, facts_of(shown), activity, vibration, recorder.commands))


def view(
    shown: Posture | Motion | Trajectory,
    browse: bool = True,
    activity: Activity | None = None,
    vibration: Vibration | None = None,
) -> None:
    """Serve the same page live through meshcat's server, until interrupted.

    Other programs can draw into it at the server's `zmq_url`, which is printed.

    Args:
        shown: a posture, or a motion or trajectory to play.
        browse: open the page in the user's browser.
        activity: of its muscles, to be drawn too.
        vibration: about the posture shown, whose modes to play.

    Raises:
        PostureIKError: there is a vibration, but not about what is shown.
    """
    moving = _moving(shown, vibration)
    page = _page(moving, facts_of(shown), activity, vibration, None)
    bridge = ZMQWebSocketBridge()
    bridge.app.add_handlers(r".*", [(r"/posture", _PageHandler, {"page": page})])
    address = f"http://{bridge.host}:{bridge.fileserver_port}/posture"

    def fill() -> None:
        _draw(meshcat.Visualizer(zmq_url=bridge.zmq_url), moving, vibration)
        print(f"With legend and labels: {address} (zmq_url={bridge.zmq_url}); Ctrl-C ends it.")
        if browse:
            webbrowser.open(address)

    Thread(target=fill, daemon=True).start()
    with suppress(KeyboardInterrupt):
        bridge.run()


class _PageHandler(tornado.web.RequestHandler):
    """Answers with one page."""

    def initialize(self, page: str) -> None:
        self.page = page

    def get(self) -> None:
        self.finish(self.page)


def _draw(
    visualizer: meshcat.Visualizer, shown: Posture | Moving, vibration: Vibration | None
) -> None:
    """Draw a posture, or where a motion starts with every force that it will need."""
    if isinstance(shown, Posture):
        draw(visualizer, shown)
    else:
        draw(visualizer, shown.postures[0], largest_wrenches(shown), *handles(shown, [0]))
    if vibration is not None:
        draw_viscera(visualizer, vibration)


def _moving(shown: Posture | Motion | Trajectory, vibration: Vibration | None) -> Posture | Moving:
    if vibration is not None and vibration.posture is not shown:
        raise PostureIKError("view: modes are shown about the posture of their vibration alone.")
    return shown if isinstance(shown, Posture) else played(shown)


def _page(
    shown: Posture | Moving,
    facts: list[tuple[str, str]],
    activity: Activity | None,
    vibration: Vibration | None,
    commands: list[str] | None,
) -> str:
    """The page: with the drawing in it, or, without commands, listening to the live server."""
    files = resource("viz")
    pages = jinja2.Environment(
        loader=jinja2.FileSystemLoader(files), autoescape=True, undefined=jinja2.StrictUndefined
    )
    looks = looks_of(shown.body)
    links = {look.link for look in looks}
    modes = mode_shapes(vibration, looks, activity) if vibration else None
    scripts = ["view.js", *(["muscles.js"] if activity else [])]
    if isinstance(shown, Posture):
        postures = [shown]
        parts = parts_of(shown, links)
        wrenches, motion = acting(shown), None
        loads = _loads((*shown.wrenches, shown.seat))
        scripts += ["follow.js", "modes.js"] if modes and modes["kinds"] else []
    else:
        postures = [shown.postures[i] for i in shown_steps(shown.time)]
        parts = peak_parts(shown, parts_of(postures[0], links))
        wrenches = largest_wrenches(shown)
        motion, loads = animation(shown, looks, parts), _loads(wrenches_at(shown, 0))
        scripts += ["follow.js", "play.js"]
    return pages.get_template("view.html").render(
        title=shown.problem.title,
        facts=facts,
        loads=loads,
        legend=_legend(parts),
        data=_data(postures, looks, parts, wrenches),
        motion=motion,
        modes=modes,
        muscles=_muscles(activity) if activity else None,
        commands=commands,
        viewer=(Path(VIEWER_ROOT) / "main.min.js").read_text(encoding="utf-8"),
        style=(files / "view.css").read_text(encoding="utf-8"),
        script="\n".join((files / name).read_text(encoding="utf-8") for name in scripts),
    )


def _loads(wrenches: Sequence[Wrench]) -> list[tuple[str, str, str]]:
    """What acts on the person: where, force in N, moment in N m."""
    return [(w.label, size(w.force), size(w.moment)) for w in wrenches]


def _legend(parts: Mapping[str, Part]) -> dict[str, Any]:
    """The colour bar: its colours, ticks at round energies in %, J, and the joints with most."""
    full = full_scale(parts)
    ticks, last = [], 1.3
    for decade in 10.0 ** np.arange(6, -10, -1):
        for energy in (5 * decade, 2 * decade, decade):
            at = place_on_scale(energy, full)
            if 0.12 < at <= 1.0 and last - at > 0.17:
                ticks.append((100 * at, f"{energy:g}"))
                last = at
    by_joint = {part.joint: part.energy for part in parts.values()}
    most = sorted(by_joint, key=lambda joint: -by_joint[joint])[:3]
    return {
        "colours": _css(RAMP),
        "ticks": [(0.0, "0"), *ticks],
        "most": [(_joint(name), joules(by_joint[name])) for name in most if by_joint[name] > 1e-6],
    }


def _muscles(activity: Activity) -> dict[str, Any]:
    """The muscles to draw, their colour bar, the most active, and what they cannot give."""
    drawn, peaks = tubes(activity), activity.activation.max(axis=0)
    missing = ", ".join(joint_name(joint) for joint, _ in activity.shortfalls)
    return {
        "drawn": drawn,
        "colours": _css(drawn["ramp"]),
        "most": [
            (drawn["names"][i], f"{peaks[i]:.2f}") for i in np.argsort(-peaks)[:3] if peaks[i] > 0
        ],
        "alarm": f"Muscles fall short: {missing}." if missing else "",
    }


def _css(ramp: Sequence[Sequence[float]]) -> list[str]:
    """Colours of 0 to 1 as style sheets write them."""
    return [f"rgb({', '.join(f'{255 * c:.0f}' for c in stop)})" for stop in ramp]


def _joint(name: str) -> str:
    """A joint's name for people: `L4–L5`, `right shoulder`."""
    for end, side in (("_r", "right"), ("_l", "left")):
        if name.endswith(end):
            return f"{side} {name.removesuffix(end).replace('_', ' ')}"
    return name.replace("_", "–")


def _data(
    postures: Sequence[Posture],
    looks: Sequence[Look],
    parts: Mapping[str, Part],
    wrenches: Sequence[Wrench],
) -> dict[str, Any]:
    """What the page's script needs besides the drawing: what to frame, write and tell."""
    written = labels(wrenches)
    first = postures[0]
    seen = postures[:: max(1, len(postures) // 12)]
    points = np.vstack([_outline(p, [label.at for label in written]) for p in seen])
    return {
        "frame": points[ConvexHull(points).vertices].tolist(),
        "labels": [
            {
                "name": label.name,
                "force": label.force,
                "moment": label.moment,
                "at": label.at.tolist(),
                "start": label.start.tolist(),
            }
            for label in written
        ],
        "parts": {
            link: {"joint": _joint(part.joint), "dofs": part.dofs} for link, part in parts.items()
        },
        "dofs": [
            {"does": action(dof), "stretch": dof.endswith("_axial"), "stiffness": float(k)}
            for dof, k in zip(first.body.dofs, first.stiffness, strict=True)
        ],
        "moved": packed([posture.displacement for posture in postures]),
        "ribs": [f"person/{look.link}/{look.name}" for look in looks if look.name in CAGE],
    }


def _outline(posture: Posture, more: list[Array]) -> Array:
    """Points (k, 3) that a view must hold: around every link now and at rest, seat and floor."""
    size = scale_of(posture.body.subject).stature
    reference = frame_poses(posture.body.model, posture.body.q_reference)
    links = [pose.translation for pose in (*posture.frames.values(), *reference.values())]
    around = 0.10 * size * np.vstack([np.eye(3), -np.eye(3)])
    heads = [frames["Head"].translation for frames in (posture.frames, reference)]
    floor = floor_height(posture)
    seat = [(x, y, floor) for x in (-0.15, 0.62 * size) for y in (-0.2, 0.2)]
    lean = pin.utils.rotate("y", -np.radians(posture.problem.seat.recline_deg))
    back = size * np.array([(-0.17, y, z) for y in (-0.2, 0.2) for z in (0.0, 0.66)]) @ lean.T
    return np.vstack([links, *[head + 1.4 * around for head in heads], seat, back, *more])
