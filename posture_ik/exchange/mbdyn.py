"""A posture as MBDyn input: nodes, bodies, joints with their prestrain, and what holds it.

Every body is a structural node at its pose in the posture. A bushing between two bodies is a `total
joint` for the translations it leaves rigid, a `cardano rotation` (two hinges) or `revolute
rotation` (one) for the rotations, and a `deformable joint` for its springs.

**Signs.** MBDyn's `deformable joint` sees the strain eps = (d, theta) of node 2's joint frame in
node 1's: d = R1ᵀ (p2 - p1) and theta the rotation vector of R1ᵀ R2. Its constitutive law

    w = prestress + K (eps - prestrain) + D deps/dt

is a force R1 w[:3] and a moment R1 w[3:] **on node 1**, both at p2, and their opposites on node 2.
Node 1 is our lower body, and s the wrench of `posture_ik.exchange.bushings` on the upper, so w = -s
and the posture's springs (`Posture.prestrain_force`) are carried by

    prestrain = eps + K⁻¹ s(springs),    prestress = -s(limits);

MBDyn's joint has no stop, so what a joint limit carries stays a constant. The wrench is exact in
the posture. Away from it MBDyn's springs follow the rotation vector and ours the angles of hinges
in sequence: the stiffnesses differ in proportion to prestrain and angle.

Syntax and formulae: MBDyn Input File Format (Masarati et al., Politecnico di Milano): structural
nodes, `body`, `total joint`, `deformable joint`, `linear viscoelastic generic`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin

from posture_ik.arrays import Array
from posture_ik.body import Body
from posture_ik.exchange.bushings import Bushing, bushings, carriers, link_frame, link_inertias
from posture_ik.posture import Posture

_HEAD = """\
# {title}
# Written by posture_ik from a solved posture. Units: m, kg, s, N, rad.
# x forward, y left, z up; the origin lies on the seat under the buttocks.
"""
_ROOT = """\
# Everything stands in the seat's frame: place the person by moving this one. Labels run from
# POSTURE; set it before this file is included where that range is taken.
set: ifndef const integer POSTURE = 1000;

reference: POSTURE,
    reference, global, null,
    reference, global, eye,
    reference, global, null,
    reference, global, null;
"""
_BODIES = """\
# Mass, its centre from the node, and the inertia about that centre in the node's axes. Trunk and
# head: table 9, scaled to the subject; arms: myo-sim, likewise.
"""
_JOINTS = """\
# Node 1 is the lower body, node 2 the upper; x, y, z are the axes of the joint's reference frames.
# Springs exert prestress + K (strain - prestrain) on node 1, the opposite on node 2. Stiffness is
# the posture's; rx, ry, rz of the posture are hinges in sequence, MBDyn's strain a rotation vector.
"""
_FORCES = """\
# What the tasks do to the person, held at its value in the posture, in the seat's axes.
"""
_MAIN = """\
# Runs as it is, `mbdyn -f posture.mbd`: seat clamped, tasks' forces constant; nothing moves.
begin: data;
    problem: initial value;
end: data;

begin: initial value;
    initial time: 0.;
    final time: 0.1;
    time step: 1e-3;
    max iterations: 20;
    tolerance: 1e-8;
    derivatives tolerance: 1e-8;
    derivatives max iterations: 20;
    derivatives coefficient: auto;
end: initial value;

begin: control data;
    structural nodes: {nodes};
    rigid bodies: {bodies};
    joints: {joints};
    forces: {forces};
{counts}    # the posture is assembled already: the springs must not move it beforehand
    skip initial joint assembly;
    default output: all, accelerations;
end: control data;

include: "posture.ref";

begin: nodes;
    include: "posture.nod";
end: nodes;

begin: elements;
    joint: POSTURE, name, "seat", clamp, POSTURE, node, node;
{gravity}    include: "posture.elm";
    include: "posture.loads";
end: elements;
"""


def write_mbdyn(posture: Posture, folder: Path) -> None:
    """Write a posture as MBDyn input into an existing folder.

    `posture.ref` (reference frames), `posture.nod` (nodes), `posture.elm` (bodies and joints) and
    `posture.loads` (forces of the tasks) are to be included in a model of one's own, where the
    seat's node belongs to what carries it; `posture.mbd` is a model that runs as it is.

    Raises:
        BadURDF: joints of a URDF of one's own cannot be written as a bushing.
    """
    inertias = link_inertias(posture.body)
    nodes = carriers(posture.body, inertias)
    found = list(bushings(posture, nodes))
    labels = {name: f"POSTURE + {i}" for i, name in enumerate(nodes.values())}
    labels["seat"] = "POSTURE"
    bodies = list(_bodies(posture.body, inertias, nodes, labels))
    joints = [card for i, joint in enumerate(found) for card in _joint(posture, joint, i, labels)]
    forces = list(_forces(posture, nodes, labels))
    weighs = posture.problem.posture.gravity
    weight = ", ".join(f"const, {_number(g)}" for g in posture.body.model.gravity.linear)
    main = _MAIN.format(
        nodes=len(labels),
        bodies=len(bodies),
        joints=len(joints) + 1,
        forces=len(forces),
        counts="    gravity;\n" if weighs else "",
        gravity=f"    gravity: uniform, component, {weight};\n" if weighs else "",
    )
    head = _HEAD.format(title=" ".join(posture.problem.title.split()))
    for suffix, cards in {
        "ref": [_ROOT, *_references(posture, found, labels)],
        "nod": [_node(name, label) for name, label in labels.items()],
        "elm": [_BODIES, *bodies, _JOINTS, *joints],
        "loads": [_FORCES, *forces],
        "mbd": [main],
    }.items():
        (folder / f"posture.{suffix}").write_text("\n".join([head, *cards]), encoding="utf-8")


def _references(posture: Posture, found: list[Bushing], labels: Mapping[str, str]) -> Iterator[str]:
    """Frames of the bodies in the seat's, and of the joints in their bodies'."""
    yield "# Frames of the bodies: a vertebra's at its node of table 8, an arm's as in myo-sim."
    poses = {**posture.frames, "seat": pin.SE3.Identity()}
    for name in list(labels)[1:]:
        yield _reference(name, labels[name], "POSTURE", poses[name])
    yield "# Frames of the joints, on the lower body and on the upper."
    for i, joint in enumerate(found):
        for k, (body, pose) in enumerate(((joint.lower, joint.first), (joint.upper, joint.second))):
            label = f"POSTURE + {100 * (k + 1) + i}"
            relative = poses[body].actInv(pose)
            yield _reference(f"{joint.name} on {body}", label, labels[body], relative)


def _reference(name: str, label: str, base: str, pose: pin.SE3) -> str:
    return (
        f"# {name}\n"
        f"reference: {label},\n"
        f"    reference, {base}, {_numbers(pose.translation)},\n"
        f"    reference, {base}, {_matrix(pose.rotation)},\n"
        f"    reference, {base}, null,\n"
        f"    reference, {base}, null;\n"
    )


def _node(name: str, label: str) -> str:
    return (
        f'structural: {label}, name, "{name}", {"static" if name == "seat" else "dynamic"},\n'
        f"    reference, {label}, null,\n"
        f"    reference, {label}, eye,\n"
        f"    reference, {label}, null,\n"
        f"    reference, {label}, null;\n"
    )


def _bodies(
    body: Body,
    inertias: Mapping[str, pin.Inertia],
    nodes: Mapping[int, str],
    labels: Mapping[str, str],
) -> Iterator[str]:
    """A card a link with mass; one with no joint of its own hangs on the node of what it is on."""
    for i, (link, inertia) in enumerate(inertias.items(), 1):
        frame = link_frame(body, link)
        if frame.parentJoint == 0:
            continue  # part of the seat, which is clamped
        node = nodes[frame.parentJoint]
        placed = link_frame(body, node).placement.actInv(frame.placement).act(inertia)
        yield (
            f'body: POSTURE + {i}, name, "{link}", {labels[node]},\n'
            f"    {_number(placed.mass)},\n"
            f"    reference, node, {_numbers(placed.lever)},\n"
            f"    reference, node, {_matrix(placed.inertia)};\n"
        )


def _joint(posture: Posture, bushing: Bushing, i: int, labels: Mapping[str, str]) -> Iterator[str]:
    """The cards of a bushing: rigid translations, rigid rotations, springs."""
    first, second = f"reference, POSTURE + {100 + i}", f"reference, POSTURE + {200 + i}"
    lower, upper = labels[bushing.lower], labels[bushing.upper]
    springs = ", ".join(
        f"{posture.body.dofs[dof].removeprefix(bushing.name + '_')} "
        f"{posture.prestrain_force[dof]:.6g}"
        for dof in bushing.dofs
    )
    yield (
        f"# {bushing.name}: {bushing.upper} on {bushing.lower}; "
        f"its springs push with (N, N m): {springs}\n"
        f'joint: POSTURE + {100 + i}, name, "{bushing.name} place", total joint,\n'
        f"    {lower}, position, {first}, null, position orientation, {first}, eye,\n"
        f"    {upper}, position, {second}, null, position orientation, {second}, eye,\n"
        f"    position constraint, active, active, {'in' * bushing.slides}active, null;\n"
    )
    if bushing.hinges == 1:
        yield (
            f'joint: POSTURE + {200 + i}, name, "{bushing.name} hinge", revolute rotation,\n'
            f"    {lower}, orientation, {first}, eye,\n"
            f"    {upper}, orientation, {second}, eye;\n"
        )
    if bushing.hinges == 2:
        # MBDyn's first axis is number 3 of node 1's frame, its second number 2 of node 2's
        yield (
            f'joint: POSTURE + {200 + i}, name, "{bushing.name} hinges", cardano rotation,\n'
            f"    {lower}, orientation, {first}, matr, 0., 0., 1., 1., 0., 0., 0., 1., 0.,\n"
            f"    {upper}, orientation, {second}, eye;\n"
        )
    soft = bushing.stiffness > 0.0
    prestrain = np.zeros(6)
    prestrain[soft] = bushing.strain[soft] + bushing.springs[soft] / bushing.stiffness[soft]
    limits = f"    prestress, {_numbers(-bushing.limits)},\n" if np.any(bushing.limits) else ""
    yield (
        f'joint: POSTURE + {300 + i}, name, "{bushing.name} springs", deformable joint,\n'
        f"    {lower}, position, {first}, null, orientation, {first}, eye,\n"
        f"    {upper}, position, {second}, null, orientation, {second}, eye,\n"
        "    linear viscoelastic generic,\n"
        f"        diag, {_numbers(bushing.stiffness)},\n"
        f"        diag, {_numbers(bushing.damping)},\n"
        f"{limits}"
        f"    prestrain, single, {_numbers(prestrain)}, const, 1.;\n"
    )


def _forces(posture: Posture, nodes: Mapping[int, str], labels: Mapping[str, str]) -> Iterator[str]:
    """A force and a couple for every frame that a task holds, on the body that carries it."""
    held = [(task.label, name) for task in posture.constraints for name in task.frames]
    pairs = zip(held, posture.frame_wrenches, strict=True)
    for i, ((task, name), (push, turn, at)) in enumerate(pairs):
        joint = link_frame(posture.body, name).parentJoint
        if joint == 0:
            continue  # a frame of the seat: the clamp holds it
        node = nodes[joint]
        arm = posture.frames[node].actInv(at)
        yield (
            f"# {task}\n"
            f'force: POSTURE + {100 + i}, name, "{task}: {name}", absolute, {labels[node]},\n'
            f"    position, reference, node, {_numbers(arm)},\n"
            f"    single, reference, POSTURE, {_numbers(push)}, const, 1.;\n"
        )
        yield (
            f'couple: POSTURE + {200 + i}, name, "{task}: {name}", absolute, {labels[node]},\n'
            f"    single, reference, POSTURE, {_numbers(turn)}, const, 1.;\n"
        )


def _number(value: float) -> str:
    """The shortest text that reads back the same, without minus zeros."""
    return repr(float(value) + 0.0)


def _numbers(values: Array) -> str:
    return ", ".join(_number(value) for value in values)


def _matrix(values: Array) -> str:
    return "matr,\n        " + ",\n        ".join(_numbers(row) for row in values)
