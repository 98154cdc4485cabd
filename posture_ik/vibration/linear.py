"""The multibody person linearised about a posture.

Coordinates x are those of the posture, relative joint motions, and two for each viscus; on a
cushion also how far seat and cushion rise over the floor. What is prescribed, u, are motions: of
the seat, or the floor under a cushion, six at the origin under the buttocks along the world's axes,
that carries the backrest and the levers' pivots with it; of the backrest, at a point 0.1 m behind
T7 along its own axes, and of each lever's pivot, beside that. All of u and x together have

    M = the joint-space mass matrix of the model on its floor,
    C = dampers,    K = springs + d g/dq  [gravity] + sum lambda d² psi/dq²  [prestress],

C and K with the elements a·(u, x) of the visceral column and of the backrest added as aᵀ k a. At
rest nothing else is of first order. Where something is held rigidly, A (u, x) = 0, dependent
coordinates are written in the others, (u, x) = T (u, x_free), and TᵀMT, TᵀCT, TᵀKT remain. Split in
u and x this is the model; the rows of u are the forces that move what is prescribed:

    force = [M_uu u'' + M_ux x'' + C_uu u' + C_ux x' + K_uu u + K_ux x].

Of the posture's tasks only what a seat does and hands on levers stay (`Seat.backrest`, `grip`); the
rest is let go, its forces counting as `prestress` alone. A spring in a joint pushes its own
coordinate, however far it is stretched, and so adds nothing to K but its stiffness. The weight of
a viscus is taken to be carried by its ties: at rest they balance it, and the column is slack.
Springs are the body's own tissue, whatever stiffness chose the posture; damping stands beside them.
Those of the arms are assumed; where muscles are known to hold an arm, the stiffness and damping of
its muscles, -d tau/dq and -d tau/dq', stand in their place (`posture_ik.muscle.reflex`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from posture_ik.arrays import Array, one_thread
from posture_ik.body import Body
from posture_ik.body.levers import with_levers
from posture_ik.body.spine import COMPONENTS, SPINE_JOINTS
from posture_ik.errors import PostureIKError, nearest
from posture_ik.muscle import Activity
from posture_ik.posture import Posture
from posture_ik.problem import Problem
from posture_ik.vibration.assembly import Assembly
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.network import (
    Readout,
    Spring,
    force,
    force_ports,
    motion_ports,
    strain,
    travel,
)
from posture_ik.vibration.person import MOTIONS
from posture_ik.vibration.system import LinearSystem


def linearise(
    body: Body,
    posture: Posture,
    problem: Problem,
    frames: Sequence[str] | None = None,
    forces: Sequence[str] = (),
    discs: Sequence[str] = (),
    activity: Activity | None = None,
    factors: Factors | None = None,
) -> LinearSystem:
    """Linearise the multibody person about a posture.

    Args:
        body: who.
        posture: about which.
        problem: its `vibration`, `seat` and hands on levers count.
        frames: links whose position, velocity and acceleration are outputs, along the world's axes
            (`Head z`, `Head acceleration z`); the head, the pelvis and all grips if not given.
        forces: links on which forces and moments are inputs (`grip_r force x`).
        discs: joints of the spine, such as `L4_L5`, whose strains and forces are outputs.
        activity: the muscles that hold the posture; they stiffen the arms that hold something.
        factors: on the tables' stiffness and damping, in place of those that the problem names.

    Returns:
        The model. Inputs: `seat x` to `seat rz`, or `floor` under a cushion, and likewise
        `backrest` and each lever (its pivot) that is held or follows; then forces. Outputs:
        motions, with a cushion also `seat z` and `cushion z`; of each disc its strains and the
        forces of spring and damper against them, as the posture's coordinates are named
        (`L4_L5_axial`, `L4_L5_axial force`); of each thing prescribed the force and moment with
        which it acts on the person or lever, and the floor on the seat (`seat force x` to
        `seat force rz`); and `total`, of all that moves with seat or floor, at the seat's origin.

    Raises:
        PostureIKError: posture or activity are of another body or posture, a link or disc is not
            the body's, or what is held rigidly cannot be.
    """
    if with_levers(body, problem.lever) is not posture.body:
        raise PostureIKError("vibration: the posture is of another body; solve it for this one.")
    if activity is not None and activity.shown is not posture:
        raise PostureIKError("vibration: the muscles hold another posture; solve them for this.")
    with one_thread():
        assembly = Assembly.of(posture, problem, activity, factors)
        return _system(assembly, _frames(assembly, frames), forces, discs)


def _frames(assembly: Assembly, frames: Sequence[str] | None) -> Sequence[str]:
    if frames is not None:
        return frames
    names = [frame.name for frame in assembly.person.model.frames]
    grips = [n for n in names if n.startswith(("grip_", "lever_")) and "grip" in n]
    return ["Head", "S1", *grips]


def _system(
    assembly: Assembly, frames: Sequence[str], forces: Sequence[str], discs: Sequence[str]
) -> LinearSystem:
    """Split what is put together in what is prescribed and what moves."""
    p, moved = assembly.inputs, assembly.moved
    transform, stay = assembly.free()
    stiffness, damping, mass = (
        transform.T @ ((matrix + matrix.T) / 2) @ transform
        for matrix in (assembly.stiffness, assembly.damping, assembly.mass)
    )
    matrices = np.array([(matrix + matrix.T) / 2 for matrix in (stiffness, damping, mass)])
    pushed = [(assembly.jacobian(frame) @ transform).T for frame in forces]
    push = np.hstack([np.zeros((len(mass), 0)), *pushed])
    f = push.shape[1]

    def seen(motion: Array) -> Array:
        """A motion over u and x, over u, the coordinates that stay, and forces."""
        return np.hstack([motion @ transform, np.zeros((len(motion), f))])

    readouts = [travel(frame, MOTIONS, seen(assembly.jacobian(frame))) for frame in frames]
    for name, (_, motion) in assembly.layers.items():
        readouts.append(travel(name, "z", seen(motion[2:])))
    for disc in discs:
        names, rows, at = _strains(assembly, disc)
        readouts.append(strain(names, Spring(seen(rows), *assembly.own[:, at])))
    resisted = np.concatenate([matrices[:, :p], np.zeros((3, p, f))], axis=2)
    resisted[0, :, len(mass) :] = -push[:p]
    readouts += _forces(assembly, resisted, seen)

    rows = np.concatenate([readout.rows for readout in readouts], axis=1)
    B = np.zeros((3, len(stay), p + f))
    B[:, :, :p] = -matrices[:, p:, :p]
    B[0, :, p:] = push[p:]
    given = np.r_[:p, len(mass) : len(mass) + f]
    return LinearSystem(
        tuple(assembly.coordinates[i] for i in stay),
        matrices[2, p:, p:],
        matrices[1, p:, p:],
        matrices[0, p:, p:],
        (
            *(port for name in moved for port in motion_ports(name, MOTIONS)),
            *(port for name in forces for port in force_ports(name, MOTIONS)),
        ),
        tuple(port for readout in readouts for port in readout.ports),
        B,
        rows[:, :, p : len(mass)],
        rows[:, :, given],
    )


def _strains(assembly: Assembly, disc: str) -> tuple[list[str], Array, list[int]]:
    """Coordinates of a joint of the spine: names, rows over u and x, and which they are.

    Raises:
        PostureIKError: the body has no such joint.
    """
    names = [f"{disc}_{component}" for component in COMPONENTS]
    at = [assembly.coordinates.index(name) for name in names if name in assembly.coordinates]
    if disc not in SPINE_JOINTS or not at:
        known = nearest(disc, SPINE_JOINTS)
        raise PostureIKError(f"vibration: the body has no disc called {disc!r}; {known}")
    rows = np.eye(len(assembly.mass))[[assembly.inputs + i for i in at]]
    return [assembly.coordinates[i] for i in at], rows, at


def _forces(
    assembly: Assembly, resisted: Array, seen: Callable[[Array], Array]
) -> Iterator[Readout]:
    """What each thing prescribed does to the person, from what it takes to move it.

    Args:
        assembly: put together.
        resisted: rows (3, p, .) of the forces that move what is prescribed.
        seen: takes a motion over u and x to the same columns.
    """
    ground, carried = assembly.ground, assembly.carried
    own = {name: resisted[:, at] for name, at in assembly.moved.items()}
    onto = {name: np.einsum("ji,ojk->oik", carried[name], own[name]) for name in carried}
    total = own[ground]
    own[ground] = total - sum(rows for name, rows in onto.items() if name.startswith("lever_"))
    on_seat = total - sum(onto.values())
    if ground == "floor":
        for mass, motion in assembly.layers.values():
            on_seat[2, :3] -= mass * seen(motion)
        yield force("seat", MOTIONS, on_seat)
    else:
        own[ground] = on_seat
    for name, rows in (*own.items(), ("total", total)):
        yield force(name, MOTIONS, rows)
