"""The multibody person linearised about a posture.

Coordinates x are those of the posture, relative joint motions, and two for each viscus. What is
prescribed, u, are motions: of the seat, six at the origin under the buttocks along the world's
axes, that carries the backrest and the levers' pivots with it; of the backrest, at a point 0.1 m
behind a vertebra along its own axes, and of each lever's pivot, beside that. All of u and x have

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
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.linalg import qr

from posture_ik.arrays import Array, call, one_thread
from posture_ik.body import Body
from posture_ik.body.levers import with_levers
from posture_ik.errors import PostureIKError, nearest
from posture_ik.posture import Posture
from posture_ik.posture.tasks import Gripped
from posture_ik.problem import COMPONENTS, Hand, Problem, RigidBack, VibrationBlock
from posture_ik.vibration.backrest import BEHIND, mean_motion, rigid_motion, turned
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.person import MOTIONS, Person
from posture_ik.vibration.system import LinearSystem, Port

_PER_MOTION = tuple("rad" if motion.startswith("r") else "m" for motion in MOTIONS)
_FORCES = tuple(f"force {motion}" for motion in MOTIONS)
_PER_FORCE = ("N", "N", "N", "N m", "N m", "N m")
_RATES = (("", ""), ("velocity ", "/s"), ("acceleration ", "/s²"))


def linearise(
    body: Body,
    posture: Posture,
    problem: Problem,
    frames: Sequence[str] | None = None,
    forces: Sequence[str] = (),
) -> LinearSystem:
    """Linearise the multibody person about a posture.

    Args:
        body: who.
        posture: about which.
        problem: its `vibration`, `seat` and hands on levers count.
        frames: links whose position, velocity and acceleration are outputs, along the world's axes
            (`Head z`, `Head acceleration z`); the head, the pelvis and all grips if not given.
        forces: links on which forces and moments are inputs (`grip_r force x`).

    Returns:
        The model. Inputs: `seat x` to `seat rz`, and likewise `backrest` and each lever (its
        pivot) that is held or follows; then forces. Outputs: motions; then of each of these the
        force and moment with which it acts on the person or lever, `seat force x` to
        `seat force rz`; and `total`, of all that moves with the seat, at the seat's origin.

    Raises:
        PostureIKError: the posture is of another body, a link is not the body's, or what is held
            rigidly cannot be.
    """
    if with_levers(body, problem.lever) is not posture.body:
        raise PostureIKError("vibration: the posture is of another body; solve it for this one.")
    with one_thread():
        assembly = _assembled(posture, problem)
        return _system(assembly, _frames(assembly, frames), forces)


def _assembled(posture: Posture, problem: Problem) -> _Assembly:
    assembly = _Assembly.of(posture, problem)
    block = problem.vibration or VibrationBlock()
    if block.prestress:
        at = slice(assembly.inputs, assembly.inputs + len(posture.q))
        assembly.stiffness[at, at] += _prestress(posture)
    assembly.tie_viscera()
    if problem.seat.backrest is not None:
        assembly.lean(problem)
    if block.grip:
        assembly.grip(posture)
    return assembly


@dataclass(eq=False)
class _Assembly:
    """Matrices over u and x, (p + n, p + n), while they are put together.

    Attributes:
        moved: what is prescribed, and where in u.
        carried: from the seat's motion to that of each other, (6, 6): what moves it along.
        held: rows A (m, p + n) of what is held rigidly.
    """

    person: Person
    data: pin.Data
    moved: dict[str, slice]
    mass: Array
    damping: Array
    stiffness: Array
    carried: dict[str, Array] = field(default_factory=dict)
    held: list[Array] = field(default_factory=list)

    @classmethod
    def of(cls, posture: Posture, problem: Problem) -> _Assembly:
        """Take mass matrix, gravity and the joints' springs and dampers from the model."""
        person, block = Person.of(posture.body), problem.vibration or VibrationBlock()
        model, data = person.model, person.data
        q = person.configuration(posture.q)
        names = list(person.moved)
        names += ["backrest"] if problem.seat.backrest is not None else []
        if block.grip:
            names += [name for name in _gripped(posture) if name not in names]
        moved = {name: slice(6 * i, 6 * i + 6) for i, name in enumerate(names)}
        p, n = 6 * len(names), len(person.coordinates)
        order, own = person.order, np.r_[: 6 * len(person.moved), p : p + n]
        matrices = np.zeros((3, p + n, p + n))
        mass, damping, stiffness = matrices
        pin.crba(model, data, q)
        full = np.triu(data.M) + np.triu(data.M, 1).T
        mass[np.ix_(own, own)] = full[np.ix_(order, order)]
        softer, damped = Factors.of(block.parameters).of_coordinates(person.coordinates)
        stiffness[own, own] = np.r_[np.zeros(6 * len(person.moved)), softer * person.stiffness]
        damping[own, own] = np.r_[np.zeros(6 * len(person.moved)), damped * person.damping]
        if block.gravity:
            falls = pin.computeGeneralizedGravityDerivatives(model, data, q)
            stiffness[np.ix_(own, own)] += falls[np.ix_(order, order)]
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        assembly = cls(person, data, moved, mass, damping, stiffness)
        for name in person.moved:
            if name != "seat":
                pivot = assembly.pose(name).translation
                assembly.carried[name] = rigid_motion(pivot)
        return assembly

    @property
    def inputs(self) -> int:
        """Number p of prescribed motions."""
        return 6 * len(self.moved)

    def pose(self, frame: str) -> pin.SE3:
        """Pose of a link in the world."""
        return self.data.oMf[self.frame(frame)]

    def frame(self, name: str) -> int:
        """Number of a link.

        Raises:
            PostureIKError: there is none of this name.
        """
        model = self.person.model
        if not model.existFrame(name):
            known = nearest(name, [frame.name for frame in model.frames])
            raise PostureIKError(f"vibration: the body has no link called {name!r}; {known}")
        return int(model.getFrameId(name))

    def jacobian(self, frame: str) -> Array:
        """Motion of a link, (6, p + n), in the world's axes at its origin."""
        motion = pin.getFrameJacobian(
            self.person.model, self.data, self.frame(frame), pin.LOCAL_WORLD_ALIGNED
        )[:, self.person.order]
        own = 6 * len(self.person.moved)
        none = np.zeros((6, self.inputs - own))
        return np.hstack([motion[:, :own], none, motion[:, own:]])

    def join(self, rows: Array, stiffness: float, damping: float) -> None:
        """Add an element that resists the motions `rows` (m, p + n) alike."""
        square = rows.T @ rows
        self.stiffness += stiffness * square
        self.damping += damping * square

    def tie_viscera(self) -> None:
        """Join neighbours of the visceral column by rods, each along the line through both."""
        for upper, lower, stiffness, damping in self.person.column:
            line = self.pose(upper).translation - self.pose(lower).translation
            along = line / np.linalg.norm(line)
            stretch = along @ (self.jacobian(upper) - self.jacobian(lower))[:3]
            self.join(stretch[None], stiffness, damping)

    def lean(self, problem: Problem) -> None:
        """Set the backrest against the mean motion of its vertebrae, beside the seat's."""
        back = problem.seat.backrest
        assert back is not None
        axes = pin.utils.rotate("y", -np.radians(problem.seat.recline_deg))
        point = self.pose(back.at).translation - BEHIND * axes[:, 0]
        positions = [self.pose(body).translation for body in back.bodies]
        mean = mean_motion(positions, point) @ np.vstack([self.jacobian(b) for b in back.bodies])
        motion = turned(axes) @ mean
        self.carried["backrest"] = turned(axes) @ rigid_motion(point)
        motion[:, self.moved["seat"]] -= self.carried["backrest"]
        motion[:, self.moved["backrest"]] -= np.eye(6)
        along = MOTIONS.index("z")
        if isinstance(back, RigidBack):
            self.held.append(np.delete(motion, along, axis=0))
        else:
            self.join(motion[:1], back.stiffness, back.damping)
        self.join(motion[[along]], back.tangential_stiffness, back.tangential_damping)

    def grip(self, posture: Posture) -> None:
        """Hold each hand that is on a lever to its handle, in what its task holds."""
        for task, constraint in zip(posture.problem.task, posture.constraints, strict=True):
            if not isinstance(task, Hand) or task.lever is None:
                continue
            name, hand = f"lever_{task.lever}", constraint.frames[0]
            place = self.pose(hand)
            motion = self.jacobian(hand)
            if isinstance(constraint, Gripped):
                goal = self.pose(f"{name}_grip").rotation @ constraint.target.reshape(3, 3).T
                motion = motion - self.jacobian(f"{name}_grip")
            else:
                goal = constraint.target[3:12].reshape(3, 3).T
                pivot = np.array(posture.problem.lever[task.lever].pivot)
                self.carried[name] = rigid_motion(pivot)
                motion[:, self.moved["seat"]] -= rigid_motion(place.translation)
                motion[:, self.moved[name]] -= rigid_motion(place.translation - pivot)
            seen = turned(goal)
            # Of the angles sin(phi) n of the task: their rate, where some are free and not zero.
            apart = goal.T @ place.rotation
            seen[3:] = (np.trace(apart) * np.eye(3) - apart) @ seen[3:] / 2
            rows = [COMPONENTS.index(component) for component in task.components]
            self.held.append((seen @ motion)[rows])


def _gripped(posture: Posture) -> Iterator[str]:
    for task in posture.problem.task:
        if isinstance(task, Hand) and task.lever is not None:
            yield f"lever_{task.lever}"


def _prestress(posture: Posture) -> Array:
    """Second derivatives of the tasks weighted by what they hold with, (b, b), N/m or N m/rad."""
    statement = posture.statement
    held, let_go = (
        call(statement.program.evaluate, posture.q, statement.parameters, multipliers)[3]
        for multipliers in (posture.multipliers, np.zeros_like(posture.multipliers))
    )
    scale = statement.scale
    bend: Array = scale[:, None] * (held - let_go) * scale
    return bend


def _free(assembly: _Assembly) -> tuple[Array, npt.NDArray[np.intp]]:
    """T (p + n, p + k) of what is held, and which k coordinates stay."""
    p, size = assembly.inputs, len(assembly.mass)
    if not assembly.held:
        return np.eye(size), np.arange(size - p)
    rows = np.vstack(assembly.held)
    light = 1.0 / np.sqrt(np.diag(assembly.mass)[p:])
    triangle, order = qr(rows[:, p:] * light, mode="r", pivoting=True)
    count = len(rows)
    pivots = np.abs(np.diag(triangle))
    if count > size - p or pivots[-1] < 1e-9 * pivots[0]:
        raise PostureIKError(
            "vibration: the grips and the rigid backrest hold more than can move; let a grip or a "
            "component of it go, or take a backrest of foam."
        )
    dependent = p + np.sort(order[:count])
    free = np.delete(np.arange(size), dependent)
    transform = np.zeros((size, size - count))
    transform[free, np.arange(len(free))] = 1.0
    transform[dependent] = -np.linalg.solve(rows[:, dependent], rows[:, free])
    return transform, free[p:] - p


def _frames(assembly: _Assembly, frames: Sequence[str] | None) -> Sequence[str]:
    if frames is not None:
        return frames
    names = [frame.name for frame in assembly.person.model.frames]
    grips = [n for n in names if n.startswith(("grip_", "lever_")) and "grip" in n]
    return ["Head", "S1", *grips]


def _system(assembly: _Assembly, frames: Sequence[str], forces: Sequence[str]) -> LinearSystem:
    """Split what is put together in what is prescribed and what moves."""
    p, moved = assembly.inputs, assembly.moved
    transform, stay = _free(assembly)
    mass, damping, stiffness = (
        transform.T @ matrix @ transform
        for matrix in (assembly.mass, assembly.damping, assembly.stiffness)
    )
    symmetric = [(matrix + matrix.T) / 2 for matrix in (mass, damping, stiffness)]
    mass, damping, stiffness = symmetric
    pushed = [(assembly.jacobian(frame) @ transform).T for frame in forces]
    push = np.hstack([np.zeros((len(mass), 0)), *pushed])

    n, f = len(stay), push.shape[1]
    B = np.zeros((3, n, p + f))
    B[0, :, p:] = push[p:]
    forced = np.zeros((3, p, p + n + f))
    for order, matrix in enumerate((stiffness, damping, mass)):
        B[order, :, :p] = -matrix[p:, :p]
        forced[order, :, : p + n] = matrix[:p]
    forced[0, :, p + n :] = -push[:p]

    outputs: list[Port] = []
    rows: list[Array] = []
    for frame in frames:
        motion = np.hstack([assembly.jacobian(frame) @ transform, np.zeros((6, f))])
        for order, (word, per) in enumerate(_RATES):
            outputs += [
                Port(f"{frame} {word}{name}", unit + per)
                for name, unit in zip(MOTIONS, _PER_MOTION, strict=True)
            ]
            at = np.zeros((3, *motion.shape))
            at[order] = motion
            rows.append(at)
    own = {name: forced[:, at] for name, at in moved.items()}
    total = own["seat"]
    own["seat"] = total - sum(
        np.einsum("ji,ojk->oik", assembly.carried[name], own[name])
        for name in own
        if name != "seat"
    )
    for name, force in (*own.items(), ("total", total)):
        outputs += [
            Port(f"{name} {kind}", unit) for kind, unit in zip(_FORCES, _PER_FORCE, strict=True)
        ]
        rows.append(force)
    read = np.concatenate(rows, axis=1)
    inputs = [
        *(
            Port(f"{name} {m}", unit)
            for name in moved
            for m, unit in zip(MOTIONS, _PER_MOTION, strict=True)
        ),
        *(
            Port(f"{name} {k}", unit)
            for name in forces
            for k, unit in zip(_FORCES, _PER_FORCE, strict=True)
        ),
    ]
    return LinearSystem(
        tuple(assembly.person.coordinates[i] for i in stay),
        mass[p:, p:],
        damping[p:, p:],
        stiffness[p:, p:],
        tuple(inputs),
        tuple(outputs),
        B,
        read[:, :, p : p + n],
        np.concatenate([read[:, :, :p], read[:, :, p + n :]], axis=2),
    )
