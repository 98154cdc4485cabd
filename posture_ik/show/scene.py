"""The person in 3D, drawn through meshcat: live, or recorded for a page that opens offline.

Whatever moves has one path of its own that is placed by one transform: `person/<link>` for a link,
`ghost/<link>`, `forces/<name>`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import meshcat
import meshcat.geometry as g
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.laws import scale_of
from posture_ik.body.solids import mesh, plate, tube
from posture_ik.kinematics import frame_poses
from posture_ik.posture import Posture, Wrench
from posture_ik.problem import SPINE, Hand, Lever
from posture_ik.show.arrows import Arrow, Turn, acting, arrows, turns
from posture_ik.show.looks import Look, looks_of
from posture_ik.show.skin import back_of, skin
from posture_ik.show.strain import Part, colour, full_scale, parts_of

Colour = Sequence[float]
#: Poses of handles in the world, by the lever's name or the hand's side.
Handles = Mapping[str, pin.SE3]

#: Shapes of the rib cage and shoulders, which a page can hide.
CAGE = ("rib", "false_rib", "sternum", "clavicle_r", "clavicle_l", "scapula_r", "scapula_l")
#: Shapes that keep their own colour whatever their joint carries: they are large, or far from it.
_PLAIN = ("head", "pelvis", *CAGE)
#: What the reference shape shows: enough to see where spine and head were.
_GHOST = ("head", "atlas", "cervical", "thoracic", "lumbar")
_FORCE, _MOMENT = (0.75, 0.22, 0.17), (0.61, 0.18, 0.50)
_GLASS, _SKIN = (0.20, 0.42, 0.72), (0.56, 0.66, 0.74)
_CUSHION, _FRAME, _STICK = (0.36, 0.42, 0.49), (0.62, 0.66, 0.70), (0.20, 0.23, 0.27)
#: Sole of the foot below the ankle's frame, m.
_SOLE = 0.075


def draw(
    visualizer: meshcat.Visualizer,
    posture: Posture,
    wrenches: Sequence[Wrench] | None = None,
    handles: Handles | None = None,
) -> None:
    """Draw a posture: the person, the reference shape as a ghost, the seat, forces and levers.

    Args:
        visualizer: meshcat's, live or recording.
        posture: what to draw.
        wrenches: the forces and moments to draw; what acts in the posture if not given.
        handles: where the levers stand; as the posture has them if not given.
    """
    body = posture.body
    now, reference = posture.frames, frame_poses(body.model, body.q_reference)
    looks = looks_of(body)
    parts = parts_of(posture, {look.link for look in looks})
    scale = scale_of(body.subject)
    girth = scale.length["thoracic"][0]
    trunk = skin(reference, now, girth)
    _studio(visualizer)
    _person(visualizer["person"], looks, now, parts)
    _ghost(visualizer["ghost"], looks, reference)
    _glass(visualizer["skin"], g.TriangularMeshGeometry(*trunk), _SKIN, 0.22)
    back = back_of(trunk, reference, girth)
    _seat(visualizer["seat"], leaning(posture, back), scale.stature)
    _floor(visualizer["floor"], floor_height(posture))
    wrenches = acting(posture) if wrenches is None else wrenches
    for arrow in arrows(wrenches):
        _arrow(visualizer[f"forces/{arrow.name}/force"], arrow)
    for turn in turns(wrenches):
        _turn(visualizer[f"forces/{turn.name}/moment"], turn)
    for name, handle in (handles or handles_of(posture)).items():
        lever = posture.problem.lever.get(name)
        _lever(visualizer[f"levers/{name}"], handle, lever)


def handles_of(posture: Posture) -> dict[str, pin.SE3]:
    """Pose of every handle: the levers', and one in each hand that holds none, by its side."""
    hands = [task for task in posture.problem.task if isinstance(task, Hand) and not task.lever]
    free = {hand.side: posture.frames[f"grip_{hand.side[0]}"] for hand in hands}
    return free | posture.levers


def floor_height(posture: Posture) -> float:
    """Where the floor lies, under the soles, m; for a body without feet 0.45 m below the seat."""
    foot = posture.frames.get("foot_r")
    size = scale_of(posture.body.subject).stature
    return size * -0.45 if foot is None else float(foot.translation[2]) - size * _SOLE


def _studio(visualizer: meshcat.Visualizer) -> None:
    """A light neutral room: one soft key light from the right and front, and fill."""
    background = visualizer["/Background"]
    background.set_property("top_color", [0.985, 0.988, 0.992])
    background.set_property("bottom_color", [0.905, 0.922, 0.938])
    for name in ("/Grid", "/Axes", "/Lights/PointLightPositiveX"):
        visualizer[name].set_property("visible", False)
    visualizer["/Lights/SpotLight"].set_property("visible", True)
    for name, key, value in (
        ("SpotLight", "position", [1.6, -2.6, 3.2]),
        ("SpotLight", "intensity", 0.46),
        ("SpotLight", "penumbra", 1.0),
        ("SpotLight", "castShadow", True),
        ("AmbientLight", "intensity", 0.55),
        ("FillLight", "position", [-4.0, -3.0, 1.0]),
        ("FillLight", "intensity", 0.22),
        ("PointLightNegativeX", "position", [2.0, 2.5, 2.0]),
        ("PointLightNegativeX", "intensity", 0.28),
    ):
        visualizer[f"/Lights/{name}/<object>"].set_property(key, value)
    # From the person's right: x to the right of the picture, z up (the camera's own y).
    camera = visualizer["/Cameras/default/rotated/<object>"]
    camera.set_property("fov", 26)
    camera.set_property("position", [0.0, 0.3, 4.4])


def _person(
    place: meshcat.Visualizer,
    looks: Sequence[Look],
    frames: Mapping[str, pin.SE3],
    parts: Mapping[str, Part],
) -> None:
    full = full_scale(parts)
    for look in looks:
        at, rgb, opacity = place[f"{look.link}/{look.name}"], look.rgba[:3], look.rgba[3]
        if opacity < 1.0:
            _glass(at, look.geometry, rgb, opacity)
        else:
            if tinted(look, parts):
                rgb = colour(parts[look.link].energy, full, rgb)
            at.set_object(look.geometry, _matt(rgb))
        at.set_transform(look.pose)
    for link in {look.link for look in looks}:
        place[link].set_transform(frames[link].homogeneous)


def tinted(look: Look, parts: Mapping[str, Part]) -> bool:
    """Whether a shape takes the colour of what its joint carries."""
    return look.rgba[3] >= 1.0 and look.link in parts and look.name not in _PLAIN


def _ghost(
    place: meshcat.Visualizer, looks: Sequence[Look], reference: Mapping[str, pin.SE3]
) -> None:
    own = any(look.name in _GHOST for look in looks)
    for look in looks:
        if look.name in _GHOST if own else look.link in SPINE:
            at = place[f"{look.link}/{look.name}"]
            _glass(at, look.geometry, _GLASS, 0.30)
            at.set_transform(look.pose)
            place[look.link].set_transform(reference[look.link].homogeneous)


def leaning(posture: Posture, back: Array) -> pin.SE3:
    """Where the backrest stands that touches the points `back` (k, 3) of the skin, m."""
    recline = np.radians(posture.problem.seat.recline_deg)
    out = np.array([np.cos(recline), 0.0, np.sin(recline)])
    return pin.SE3(pin.utils.rotate("y", -recline), float((back @ out).min()) * out)


def _seat(place: meshcat.Visualizer, backrest: pin.SE3, size: float) -> None:
    """A pan under the person, a backrest, a foot to stand on."""
    upright = pin.SE3.Identity()
    for name, centre, half, edge, pose, rgb in (
        ("backrest", (-0.028, 0.0, 0.33), (0.028, 0.205, 0.325), 0.026, backrest, _CUSHION),
        ("pan", (0.105, 0.0, -0.036), (0.275, 0.235, 0.036), 0.030, upright, _CUSHION),
        ("stem", (0.09, 0.0, -0.24), (0.035, 0.07, 0.18), 0.020, upright, _FRAME),
        ("base", (0.09, 0.0, -0.410), (0.16, 0.16, 0.017), 0.016, upright, _FRAME),
    ):
        low, high = np.subtract(centre, half), np.add(centre, half)
        pad = mesh(plate(centre, half, edge), low, high, 0.022)
        place[name].set_object(g.TriangularMeshGeometry(*pad), _matt(rgb))
        place[name].set_transform(pose.homogeneous @ np.diag([size, size, size, 1.0]))


def _floor(place: meshcat.Visualizer, height: float) -> None:
    """A grid of 0.1 m squares that fades out, and the shadows that fall on it."""
    lines, tints = [], []
    reach, fade = 1.2, np.array([0.945, 0.955, 0.963])
    steps = np.round(np.arange(-reach, reach + 0.05, 0.1), 3)
    for across in steps:
        for a, b in pairwise(steps):
            for ends in (((a, across), (b, across)), ((across, a), (across, b))):
                for x, y in ends:
                    near = max(0.0, 1.0 - np.hypot(x, y) / reach)
                    lines.append((x + 0.15, y, 0.0))
                    tints.append(fade - near * np.array([0.22, 0.20, 0.18]))
    grid = g.PointsGeometry(np.array(lines, np.float32).T, np.array(tints, np.float32).T)
    place["grid"].set_object(g.LineSegments(grid, g.LineBasicMaterial(vertexColors=True)))
    place["shadow"].set_object(g.Box([6.0, 6.0, 0.001]), _Shadow(opacity=0.16, transparent=True))
    place["shadow/<object>"].set_property("castShadow", False)
    place.set_transform(_at((0.0, 0.0, height)))


def _arrow(place: meshcat.Visualizer, arrow: Arrow) -> None:
    """A shaft and a head along the arrow's own y, drawn over all else."""
    span = arrow.tip - arrow.tail
    length = float(np.linalg.norm(span))
    head = min(0.055, 0.5 * length)
    for name, shape, middle in (
        ("shaft", g.Cylinder(length - head, 0.0065), (length - head) / 2),
        ("head", g.Cylinder(head, radiusTop=0.0, radiusBottom=0.019), length - head / 2),
    ):
        place[name].set_object(shape, _over(_FORCE))
        place[name].set_transform(_at((0.0, middle, 0.0)))
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), span).matrix()
    place.set_transform(pin.SE3(turn, arrow.tail).homogeneous)


def _turn(place: meshcat.Visualizer, turn: Turn) -> None:
    """Three quarters of a ring about the moment's axis, with a head where it turns to."""
    angle = np.linspace(-0.9, 1.5 * np.pi - 1.35, 25)
    ring = turn.radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    place["ring"].set_object(
        g.TriangularMeshGeometry(*tube(ring, (0.0055, 0.0055), 8, 40)), _over(_MOMENT)
    )
    place["head"].set_object(g.Cylinder(0.04, radiusTop=0.0, radiusBottom=0.016), _over(_MOMENT))
    tip = pin.SE3(pin.utils.rotate("z", float(angle[-1])), ring[-1] + 0.012 * _tangent(angle[-1]))
    place["head"].set_transform(tip.homogeneous)
    about = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), turn.axis).matrix()
    place.set_transform(pin.SE3(about, turn.centre).homogeneous)


def _tangent(angle: float) -> Array:
    return np.array([-np.sin(angle), np.cos(angle), 0.0])


def _lever(place: meshcat.Visualizer, handle: pin.SE3, lever: Lever | None) -> None:
    """A handle and the stick from it to its pivot, or, without a lever, to below the hand."""
    bend, length = (0.0, 0.32) if lever is None else (np.radians(lever.handle_deg), lever.length)
    down = -length * np.array([-np.sin(bend), 0.0, np.cos(bend)])  # to the pivot, in the handle
    stand = pin.SE3(pin.utils.rotate("x", np.pi / 2), np.zeros(3))  # meshcat's stand along y
    along = pin.SE3(pin.utils.rotate("y", -bend), down / 2)
    for name, shape, pose in (
        ("stick", g.Cylinder(length, 0.010), along * stand),
        ("handle", g.Cylinder(0.13, 0.0165), stand),
        ("boot", g.Sphere(0.026), pin.SE3(np.eye(3), down)),
    ):
        place[name].set_object(shape, _matt(_STICK))
        place[name].set_transform(pose.homogeneous)
    place.set_transform(handle.homogeneous)


class _Shadow(g.GenericMaterial):  # type: ignore[misc]
    """A surface that shows nothing but the shadows on it."""

    _type = "ShadowMaterial"


def _matt(rgb: Colour) -> g.Material:
    return g.MeshPhongMaterial(color=_hex(rgb), specular=0x1C1C1C, shininess=16)


def _over(rgb: Colour) -> g.Material:
    """What is seen through everything that stands before it."""
    return g.MeshPhongMaterial(
        color=_hex(rgb),
        emissive=_hex([0.25 * c for c in rgb]),
        side=0,
        transparent=True,
        opacity=0.999,
        depthTest=False,
        depthWrite=False,
        shininess=8,
    )


def _glass(place: meshcat.Visualizer, shape: g.Geometry, rgb: Colour, opacity: float) -> None:
    """A translucent shell, which casts no shadow."""
    material = g.MeshPhongMaterial(
        color=_hex(rgb), opacity=opacity, side=0, depthWrite=False, specular=0, shininess=1
    )
    place.set_object(shape, material)
    place["<object>"].set_property("castShadow", False)
    place["<object>"].set_property("receiveShadow", False)


def _hex(rgb: Colour) -> int:
    r, gr, b = (round(255 * min(max(float(c), 0.0), 1.0)) for c in rgb)
    return r << 16 | gr << 8 | b


def _at(point: Colour) -> Array:
    pose = np.eye(4)
    pose[:3, 3] = point
    return pose
