"""The multibody person ready to vibrate: on a floor that moves, with viscera that swing.

The posture's model, joint by joint, on six joints of the floor, three slides and then three hinges;
beside it each lever that follows the hand, on six joints of its own. The seven viscera from T11V
to L5V, rigid on their vertebrae in the posture, slide along their vertebra's x and z. Joints stand
depth first, as Pinocchio's derivatives want them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.body.laws import scale_of
from posture_ik.body.scaling import region_of
from posture_ik.body.spine import VISCERA
from posture_ik.body.tables import numbers, table
from posture_ik.kinematics import data_of
from posture_ik.vibration.spine_elements import LOOSE, TIE_DAMPING_TIME, OpenValues

MOTIONS = ("x", "y", "z", "rx", "ry", "rz")
_JOINTS = (
    pin.JointModelPX,
    pin.JointModelPY,
    pin.JointModelPZ,
    pin.JointModelRX,
    pin.JointModelRY,
    pin.JointModelRZ,
)


@dataclass(frozen=True, eq=False)
class Person:
    """A body as a model of Pinocchio's with a floor.

    Attributes:
        model: Pinocchio's model.
        moved: joints of the floor and the levers' pivots, by what they move: 6 velocities each.
        coordinates: all others, those of the body in its order and then the viscera's.
        of_body, of_coordinates: their places in the model's velocity; (b,), (n,).
        stiffness, damping: springs and dampers of the coordinates, (n,).
        column: the links of the visceral column, and the spring (N/m) and damper (N s/m) between.
    """

    model: pin.Model
    moved: dict[str, list[int]]
    coordinates: tuple[str, ...]
    of_body: npt.NDArray[np.intp]
    of_coordinates: npt.NDArray[np.intp]
    stiffness: Array
    damping: Array
    column: tuple[tuple[str, str, float, float], ...]

    _known: ClassVar[WeakKeyDictionary[Body, Person]] = WeakKeyDictionary()

    @classmethod
    def of(cls, body: Body) -> Person:
        """Give the vibrating model of a body, levers included, built once for each."""
        if body not in cls._known:
            cls._known[body] = _person(body)
        return cls._known[body]

    @cached_property
    def order(self) -> npt.NDArray[np.intp]:
        """Places in the model's velocity of what is moved, and then of the coordinates."""
        return np.concatenate([*self.moved.values(), self.of_coordinates])

    @property
    def data(self) -> pin.Data:
        """The model's work space; the next computation overwrites it."""
        return data_of(self.model)

    def configuration(self, q: Array) -> Array:
        """The model's configuration in a posture q (b,): the floor and the viscera at rest."""
        full = np.zeros(self.model.nq)
        full[self.of_body] = q
        return full


def _person(body: Body) -> Person:
    source, model = body.model, pin.Model()
    model.gravity = source.gravity
    weights = _viscera(body)
    carried: dict[int, list[str]] = {}
    for name in weights:
        carried.setdefault(source.frames[source.getFrameId(name)].parentJoint, []).append(name)

    moved: dict[str, list[int]] = {}

    def base(name: str, parent: int, place: pin.SE3) -> int:
        joint = parent
        for i, (kind, motion) in enumerate(zip(_JOINTS, MOTIONS, strict=True)):
            at = pin.SE3.Identity() if i else place
            joint = model.addJoint(joint, kind(), at, f"{name} {motion}")
            moved.setdefault(name, []).append(model.joints[joint].idx_v)
        return joint

    floor = base("seat", 0, pin.SE3.Identity())
    model.appendBodyToJoint(floor, source.inertias[0], pin.SE3.Identity())
    now = {0: floor}
    viscera: dict[str, int] = {}
    for i in range(1, source.njoints):
        parent, place, name = source.parents[i], source.jointPlacements[i], source.names[i]
        above = now[parent]
        if parent == 0 and name.startswith("lever_"):
            pivot = base(_lever_of(name), floor, pin.SE3(np.eye(3), place.translation))
            above, place = pivot, pin.SE3(place.rotation, np.zeros(3))
        joint = now[i] = model.addJoint(above, source.joints[i], place, name)
        inertia = source.inertias[i]
        for viscus in carried.get(i, ()):
            frame = source.frames[source.getFrameId(viscus)]
            weight = weights[viscus]
            inertia = inertia - frame.placement.act(weight)
            slide = model.addJoint(joint, pin.JointModelPX(), frame.placement, f"{viscus}_x")
            slide = model.addJoint(slide, pin.JointModelPZ(), pin.SE3.Identity(), f"{viscus}_z")
            model.appendBodyToJoint(slide, weight, pin.SE3.Identity())
            viscera[viscus] = slide
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    for frame in source.frames:
        if frame.type == pin.FrameType.BODY:
            joint, place = now[frame.parentJoint], frame.placement
            if frame.name in viscera:
                joint, place = viscera[frame.name], pin.SE3.Identity()
            model.addFrame(pin.Frame(frame.name, joint, 0, place, pin.FrameType.BODY))

    swinging = [f"{viscus}_{axis}" for viscus in viscera for axis in "xz"]
    place_of = {name: model.joints[i].idx_v for i, name in enumerate(model.names) if i}
    values = OpenValues.identified("multibody")
    tie = {"x": values.visceral_x, "z": values.visceral_z}
    ties = np.array([tie[name[-1]] for name in swinging])
    stiffer, damper = _axial_scale(body)
    coordinates = (*body.dofs, *swinging)
    return Person(
        model,
        moved,
        coordinates,
        np.array([place_of[name] for name in body.dofs]),
        np.array([place_of[name] for name in coordinates]),
        np.concatenate([body.stiffness, stiffer * ties]),
        np.concatenate([body.damping, damper * TIE_DAMPING_TIME * ties]),
        tuple(_column(body, values.column_top)),
    )


def _lever_of(joint: str) -> str:
    return joint.removesuffix("_lateral" if joint.endswith("_lateral") else "_fore_aft")


def _viscera(body: Body) -> dict[str, pin.Inertia]:
    """Inertia of each swinging viscus in its link, kept by the fixed joint that merged it."""
    weights, frames = {}, body.model.frames
    for link in LOOSE[::-1]:
        if body.model.existFrame(link):
            joint = frames[frames[body.model.getFrameId(link)].parentFrame]
            if joint.type == pin.FrameType.FIXED_JOINT and joint.inertia.mass > 0.0:
                weights[link] = joint.inertia
    return weights


def _column(body: Body, top: float) -> Iterator[tuple[str, str, float, float]]:
    stiffer, damper = _axial_scale(body)
    for upper, lower in pairwise(reversed(VISCERA)):
        if body.model.existFrame(upper) and body.model.existFrame(lower):
            k, c = numbers(table("table_12_viscera")[f"{upper}_{lower}"], "k33_N_m", "c33_N_s_m")
            share = top if upper == VISCERA[-1] else 1.0
            yield upper, lower, share * stiffer * k, share * damper * c


def _axial_scale(body: Body) -> tuple[float, float]:
    """Factors on the stiffness and the damping of the viscera's springs."""
    scale, region = scale_of(body.subject), region_of(VISCERA[0])
    return scale.stiffness(region, "axial"), scale.damping(region, "axial")
