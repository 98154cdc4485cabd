"""The joints between two bodies as one bushing: frames, springs, and the wrench they carry.

Between two bodies with mass stand a slide along z, hinges about axes at right angles through one
point, or both. The joint's frame is fixed to the lower body, the one nearer to the seat, its z axis
along the slide; its twin, fixed to the upper body, coincides with it where all coordinates are 0.

The joint's generalized forces tau amount to a wrench s on the upper body at its frame's origin, in
the lower frame's axes. By virtual work s_z = tau of the slide and a_i·s = tau_i with the axis a_i
of each hinge as it stands in the posture. What keeps rigid directions rigid is not in s.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.errors import BadURDF
from posture_ik.posture import Posture

#: Components of rotation that are elastic, by the number of hinges.
_TURNS = {1: [2], 2: [0, 1], 3: [0, 1, 2]}


class Bushing(NamedTuple):
    """The joints between two bodies, in a posture.

    Attributes:
        name: what its degrees of freedom share, such as `L4_L5`.
        dofs: its degrees of freedom, indices in the model's order, a slide first.
        lower, upper: the bodies it joins.
        first, second: pose of its frame on the lower and on the upper body, in the world.
        slides: whether it gives along z.
        hinges: how many: about x, y and z of its frame, about x and y, or about z alone.
        stiffness, damping: by component x, y, z, rx, ry, rz, (6,), 0 where rigid; SI.
        strain: displacement of `second` in `first`, and the rotation vector there, (6,), m, rad.
        springs, limits: wrench s of springs and of limits on the upper body, (6,), N, N m.
    """

    name: str
    dofs: list[int]
    lower: str
    upper: str
    first: pin.SE3
    second: pin.SE3
    slides: bool
    hinges: int
    stiffness: Array
    damping: Array
    strain: Array
    springs: Array
    limits: Array


def link_inertias(body: Body) -> dict[str, pin.Inertia]:
    """Inertia of every link with mass, and of levers, about its centre, in the link's axes."""
    found = {}
    for link in ET.fromstring(body.urdf).findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        numbers = {key: text for part in inertial for key, text in part.items()}
        centre, angles = (
            np.array(numbers.get(key, "0 0 0").split(), dtype=float) for key in ("xyz", "rpy")
        )
        tensor = np.array(
            [[float(numbers["i" + "".join(sorted(a + b))]) for a in "xyz"] for b in "xyz"]
        )
        turn = pin.rpy.rpyToMatrix(angles)
        found[link.attrib["name"]] = pin.Inertia(
            float(numbers["value"]), centre, turn @ tensor @ turn.T
        )
    model = body.model
    for joint, dof in enumerate(body.dofs, 1):  # levers are no links of the URDF
        if dof.startswith("lever_") and model.inertias[joint].mass > 0.0:
            found[dof.rpartition("_")[0].removesuffix("_fore")] = model.inertias[joint]
    return found


def link_frame(body: Body, link: str) -> pin.Frame:
    """A link's frame, even where a joint has the same name."""
    return body.model.frames[body.model.getFrameId(link, pin.FrameType.BODY)]


def carriers(body: Body, inertias: Mapping[str, pin.Inertia]) -> dict[int, str]:
    """The body on each of the model's joints with mass, by the joint's index; 0 is the seat."""
    nodes = {0: "seat"}
    for frame in body.model.frames:
        if frame.name in inertias and frame.type == pin.FrameType.BODY:
            nodes.setdefault(frame.parentJoint, frame.name)
    return dict(sorted(nodes.items()))


def bushings(posture: Posture, bodies: Mapping[int, str]) -> Iterator[Bushing]:
    """The bushings of a posture, from the seat outward.

    Args:
        posture: whose joints.
        bodies: the `carriers` of its body.

    Raises:
        BadURDF: the axes of a URDF of one's own do not meet as told above.
    """
    model, names = posture.body.model, posture.body.dofs
    data, straight = model.createData(), model.createData()
    pin.computeJointJacobians(model, data, posture.q)
    pin.computeJointJacobians(model, straight, np.zeros(model.nq))
    used: list[int] = []
    for last in list(bodies)[1:]:
        chain = [last]
        while (below := model.parents[chain[0]]) not in bodies:
            chain.insert(0, below)
        dofs = [joint - 1 for joint in chain]
        used += dofs
        slides = names[dofs[0]].endswith("_axial")
        turning = dofs[1:] if slides else dofs
        turns = _TURNS.get(len(turning))
        placement = model.jointPlacements[chain[0]]
        first, rest = data.oMi[below] * placement, straight.oMi[below] * placement
        axes = rest.rotation.T @ straight.J[3:, turning]
        offsets = [model.jointPlacements[joint].translation for joint in chain[1:]]
        if not turns or not np.allclose(offsets, 0.0, atol=1e-9):
            raise _unfit(posture, names[dofs[-1]])
        frame = pin.SE3(_frame(axes), np.zeros(3))
        found = frame.rotation.T @ axes
        along = frame.rotation.T @ rest.rotation.T @ straight.J[:3, dofs[0]]
        if not np.allclose(np.abs(found), np.eye(3)[:, turns], atol=1e-6) or (
            slides and not np.allclose(np.abs(along), [0.0, 0.0, 1.0], atol=1e-6)
        ):
            raise _unfit(posture, names[dofs[-1]])
        second = data.oMi[last] * straight.oMi[last].actInv(rest) * frame
        first = first * frame
        now = (first.rotation.T @ data.J[3:, turning])[turns]
        components = [*([2] if slides else []), *(3 + turn for turn in turns)]
        # generalized forces to wrench: along z, and the axes' transposed inverse
        to_wrench = np.zeros((6, len(dofs)))
        to_wrench[2, 0] = along[2] if slides else 0.0
        to_wrench[np.ix_(components[slides:], range(slides, len(dofs)))] = np.linalg.inv(now.T)
        relative = first.actInv(second)
        stiffness, damping = np.zeros(6), np.zeros(6)
        stiffness[components] = posture.stiffness[dofs]
        damping[components] = posture.body.damping[dofs]
        yield Bushing(
            _shared([names[dof] for dof in dofs]),
            dofs,
            bodies[below],
            bodies[last],
            first,
            second,
            slides,
            len(turning),
            stiffness,
            damping,
            np.concatenate([relative.translation, pin.log3(relative.rotation)]),
            to_wrench @ posture.prestrain_force[dofs],
            to_wrench @ -posture.limit_multipliers[dofs],
        )
    for dof, name in enumerate(names):
        if used.count(dof) != 1:
            raise _unfit(posture, name)


def _frame(axes: Array) -> Array:
    """Axes of the joint's frame, (3, 3): x and y along two hinges, or z along a single one."""
    if axes.shape[1] == 1:
        turn: Array = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axes[:, 0]).matrix()
        return turn
    x, y = axes[:, 0], axes[:, 1] - (axes[:, 0] @ axes[:, 1]) * axes[:, 0]
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def _shared(names: list[str]) -> str:
    """The words that all the names share, in their order."""
    common = set.intersection(*(set(name.split("_")) for name in names))
    return "_".join(word for word in names[0].split("_") if word in common)


def _unfit(posture: Posture, dof: str) -> BadURDF:
    return BadURDF(
        posture.problem.subject.urdf or "seated_person.urdf",
        f"joint {dof!r} does not fit MBDyn's: between two links with mass it takes at most a slide "
        "and then one to three hinges, at right angles through one point.",
    )
