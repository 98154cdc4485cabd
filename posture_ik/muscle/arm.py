"""The reference arm's muscle paths as one graph in its seven joint angles.

The arm is the right one of a man of `ARM_STATURE`, in the axes of the hanging arm at the
glenohumeral centre, as `posture_ik.body.arms` has it. Every piece of a path between two points
crosses one of the shoulder, the forearm's two joints or the wrist, and is written in the frame of
the surface beside it, so that its slopes have two or three entries.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body.arms import ARM_JOINTS
from posture_ik.body.tables import numbers, read_table, table
from posture_ik.kinematics.joints import Pose
from posture_ik.muscle.wrap import Ring, Surface, bend, straight

DATA = Path(__file__).resolve().parent / "data"
#: Links that paths are fixed to, the inner first, and the joints before each.
CHAIN = {
    "trunk": (),
    "humerus": ARM_JOINTS[:3],
    "ulna": ARM_JOINTS[3:4],
    "radius": ARM_JOINTS[4:5],
    "hand": ARM_JOINTS[5:],
}
_LINKS = tuple(CHAIN)
#: Points that tell where a frame lies.
MARKS = np.vstack([np.zeros(3), np.eye(3)])


class Element(NamedTuple):
    """A point of a path, or a surface beside it.

    Attributes:
        link: Where it is fixed, one of `CHAIN`.
        place: Point or centre in the link's frame, (3,), m.
        surface: The surface, or None for a point.
    """

    link: str
    place: Array
    surface: Surface | None


@cache
def elements() -> dict[str, tuple[Element, ...]]:
    """Each muscle's path, its elements in order."""
    trunk = trunk_frames()
    found: dict[str, list[Element]] = {}
    for row in read_table(DATA / "arm_paths.csv").values():
        frame = trunk.get(row["link"], pin.SE3.Identity())
        link = "trunk" if row["link"] in trunk else row["link"]
        place, surface = frame.act(np.array(numbers(row, "x_m", "y_m", "z_m"))), None
        if row["kind"] == "cylinder":
            axis = frame.rotation @ np.array(numbers(row, "axis_x", "axis_y", "axis_z"))
            turn = np.radians(float(row["turn_deg"]))
            surface = Surface("cylinder", place, float(row["radius_m"]), axis, turn)
        elif row["kind"] != "point":
            surface = Surface(row["kind"], place, float(row["radius_m"]))
        found.setdefault(row["muscle"], []).append(Element(link, place, surface))
    return {muscle: tuple(path) for muscle, path in found.items()}


@cache
def trunk_frames() -> dict[str, pin.SE3]:
    """Thorax, clavicle and scapula from the glenohumeral centre, in the hanging arm's axes."""
    return {
        link: pin.SE3(
            np.array(numbers(row, *(f"r{i}{j}" for i in "123" for j in "123"))).reshape(3, 3),
            np.array(numbers(row, "x_m", "y_m", "z_m")),
        )
        for link, row in table("arm_frames").items()
        if link != "grip"
    }


class ArmGraph:
    """Lengths of the muscles of the reference arm and their derivatives, as expressions.

    Attributes:
        angles: Of the joints in the order of `ARM_JOINTS`, SX (7,), rad.
        lengths: SX (25,), m.
        slopes: dl/dq, SX (25, 7), m/rad.
        weights: SX (25,).
        curvature: sum of weights_i d²l_i/dq², SX (7, 7).
    """

    def __init__(self) -> None:
        self.angles = ca.SX.sym("angles", len(ARM_JOINTS))
        self._chain()
        self._rings: list[Ring] = []
        self.lengths = ca.SX.zeros(len(elements()))
        slopes = ca.SX(len(elements()), len(ARM_JOINTS))
        for i, path in enumerate(elements().values()):
            points = [k for k, element in enumerate(path) if element.surface is None]
            for k, after in pairwise(points):
                beside = path[k + 1] if after == k + 2 else None
                length, slope = self._piece(path[k], path[after], beside)
                self.lengths[i] += length
                for joint, entry in slope.items():
                    slopes[i, joint] += entry

        incidence = ca.vertcat(*[ring.incidence for ring in self._rings])
        value = ca.vertcat(*[ring.value for ring in self._rings])
        condition = ca.vertcat(*[ring.condition for ring in self._rings])
        self.weights = ca.SX.sym("weights", len(elements()))
        gradient = slopes.T @ self.weights
        # Slopes are those at fixed incidence; as these change, the incidence follows its condition.
        follow = -ca.jacobian(condition, self.angles) / ca.diag(ca.jacobian(condition, incidence))
        curvature = ca.jacobian(gradient, self.angles)
        curvature += ca.jacobian(gradient, incidence) @ follow
        self.lengths, self.slopes, self.curvature = ca.substitute(
            [self.lengths, slopes, curvature], [incidence], [value]
        )

    def marks(self) -> ca.SX:
        """Origin and unit points of each link after the trunk, in its frame, SX (3, 16)."""
        return ca.horzcat(
            *[
                self._seen(ca.SX(mark), level, 0)
                for level in range(1, len(_LINKS))
                for mark in MARKS
            ]
        )

    def _chain(self) -> None:
        """Pose of each link in the one before, and the axes and centres of the joints between."""
        self._steps: list[Pose] = []
        self._hinges: list[list[tuple[int, ca.SX, ca.SX]]] = []
        for joints in list(CHAIN.values())[1:]:
            pose, hinges = Pose(ca.SX.eye(3), ca.SX.zeros(3)), []
            for joint in joints:
                k, row = ARM_JOINTS.index(joint), table("arm_joints")[joint]
                axis = np.array(numbers(row, "axis_x", "axis_y", "axis_z"))
                axis /= np.linalg.norm(axis)
                centre = pose.position + pose.rotation @ ca.DM(numbers(row, "x_m", "y_m", "z_m"))
                hinges.append((k, pose.rotation @ ca.sparsify(ca.DM(axis)), centre))
                pose = Pose(pose.rotation @ _rotation(axis, self.angles[k]), centre)
            self._steps.append(pose)
            self._hinges.append(hinges)

    def _piece(
        self, start: Element, end: Element, beside: Element | None
    ) -> tuple[ca.SX, dict[int, ca.SX]]:
        """Length of a piece and its slopes by the joints that it crosses."""
        surface = None if beside is None else beside.surface
        here = _LINKS.index(start.link if beside is None else beside.link)
        if _LINKS.index(end.link) == here:  # then seen from here the start moves, if either
            start, end = end, start
            surface = surface and surface.reversed()
        there = _LINKS.index(end.link)
        near, far = ca.SX(start.place), self._seen(ca.SX(end.place), there, here)
        piece = straight(near, far) if surface is None else bend(near, far, surface)
        if piece.ring is not None:
            self._rings.append(piece.ring)
        moment = ca.cross(far, piece.pull)
        slopes = {}
        for level in range(min(here, there), max(here, there)):
            for k, axis, centre in self._hinges[level]:
                axis = self._seen(axis, level, here, direction=True)
                centre = self._seen(centre, level, here)
                slope = ca.dot(axis, moment) + ca.dot(ca.cross(centre, axis), piece.pull)
                slopes[k] = slope if there > here else -slope
        return piece.length, slopes

    def _seen(self, vector: ca.SX, there: int, here: int, direction: bool = False) -> ca.SX:
        """A point or a direction of one link in the frame of another."""
        for rotation, position in reversed(self._steps[here:there]):
            vector = rotation @ vector if direction else rotation @ vector + position
        for rotation, position in self._steps[there:here]:
            vector = rotation.T @ (vector if direction else vector - position)
        return vector


def _rotation(axis: Array, angle: ca.SX) -> ca.SX:
    """About a unit axis (Rodrigues)."""
    across = ca.sparsify(ca.skew(ca.DM(axis)))
    return ca.DM.eye(3) + ca.sin(angle) * across + (1 - ca.cos(angle)) * (across @ across)
