"""The multibody person's matrices, put together over what is prescribed and what moves.

Matrices and motions are over (u, x): six motions of each thing that is prescribed, and then the
coordinates. The person's own come from Pinocchio; each element that spans several coordinates adds
its rows a as aᵀ k a, and what is held rigidly collects rows A, A (u, x) = 0.

On a cushion the ground is the floor; the buttocks stand on the cushion, the backrest on the seat,
the levers on the floor. Seat and cushion go up and down over the floor, and all else goes with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.linalg import qr

from posture_ik.arrays import Array, call
from posture_ik.errors import PostureIKError, nearest
from posture_ik.muscle import ARMS, Activity
from posture_ik.posture import Posture
from posture_ik.posture.tasks import Gripped
from posture_ik.problem import (
    COMPONENTS,
    Cushion,
    FoamBack,
    Hand,
    Problem,
    RigidBack,
    VibrationBlock,
)
from posture_ik.vibration.backrest import at_preload, lean, rest_on
from posture_ik.vibration.factors import Factors
from posture_ik.vibration.network import carry
from posture_ik.vibration.person import Person

_LAYERS = ("seat", "cushion")


@dataclass(eq=False)
class Assembly:
    """Matrices over u and x, (p + n, p + n), while they are put together.

    Attributes:
        person, data: Pinocchio's model, its joints and links placed.
        ground: what carries all: the seat, or the floor under a cushion.
        moved: what is prescribed, and where in u.
        coordinates: names of x, (n,).
        own: stiffness and damping of the spring and damper in each joint, (2, n).
        rides: what one unit of the cushion's rise moves, (p + n,); none if there is no cushion.
        carried: from the ground's motion to that of each other thing prescribed, (6, 6).
        layers: mass, kg, and motion (3, p + n) of seat and cushion, if there are any.
        held: rows A (m, p + n) of what is held rigidly.
    """

    person: Person
    data: pin.Data
    ground: str
    moved: dict[str, slice]
    coordinates: tuple[str, ...]
    mass: Array
    damping: Array
    stiffness: Array
    own: Array
    rides: Array | None = None
    carried: dict[str, Array] = field(default_factory=dict)
    layers: dict[str, tuple[float, Array]] = field(default_factory=dict)
    held: list[Array] = field(default_factory=list)

    @classmethod
    def of(
        cls,
        posture: Posture,
        problem: Problem,
        activity: Activity | None,
        factors: Factors | None = None,
    ) -> Assembly:
        """Put a person together about a posture, as a problem says (`linearise`)."""
        block = problem.vibration or VibrationBlock()
        assembly = cls._of_person(posture, problem, block, factors or Factors.of(block.parameters))
        if activity is not None:
            assembly.activate(activity)
        if block.prestress:
            assembly.prestress(posture)
        if problem.seat.cushion is not None:
            assembly.stand_on(problem.seat.cushion)
        assembly.tie_viscera()
        if problem.seat.backrest is not None:
            back = at_preload(problem.seat.backrest, posture)
            assembly.lean_on(back, float(np.radians(problem.seat.recline_deg)))
        if block.grip:
            assembly.grip(posture)
        return assembly

    @classmethod
    def _of_person(
        cls, posture: Posture, problem: Problem, block: VibrationBlock, factors: Factors
    ) -> Assembly:
        """Take mass matrix, gravity and the joints' springs and dampers from the model."""
        person, cushion = Person.of(posture.body), problem.seat.cushion
        model, data = person.model, person.data
        q = person.configuration(posture.q)
        ground = "floor" if cushion else "seat"
        names = [ground, *(name for name in person.moved if name != "seat")]
        names += ["backrest"] if problem.seat.backrest is not None else []
        if block.grip:
            names += [name for name in _gripped(posture) if name not in names]
        moved = {name: slice(6 * i, 6 * i + 6) for i, name in enumerate(names)}
        coordinates = person.coordinates
        coordinates += tuple(f"{layer} z" for layer in _LAYERS) if cushion else ()
        own, p, n = 6 * len(person.moved), 6 * len(names), len(person.coordinates)
        order, at = person.order, np.r_[:own, p : p + n]
        matrices = np.zeros((3, p + len(coordinates), p + len(coordinates)))
        mass, damping, stiffness = matrices
        pin.crba(model, data, q)
        full = np.triu(data.M) + np.triu(data.M, 1).T
        mass[np.ix_(at, at)] = full[np.ix_(order, order)]
        softer, damped = factors.of_coordinates(person.coordinates)
        springs, dampers = softer * person.stiffness, damped * person.damping
        stiffness[at, at] += np.r_[np.zeros(own), springs]
        damping[at, at] += np.r_[np.zeros(own), dampers]
        if block.gravity:
            falls = pin.computeGeneralizedGravityDerivatives(model, data, q)
            stiffness[np.ix_(at, at)] += falls[np.ix_(order, order)]
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        assembly = cls(
            person,
            data,
            ground,
            moved,
            coordinates,
            mass,
            damping,
            stiffness,
            np.array([springs, dampers]),
        )
        for name in person.moved:
            if name != "seat":
                assembly.carried[name] = carry(assembly.pose(name).translation)
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
        order, own = self.person.order, 6 * len(self.person.moved)
        motion = pin.getFrameJacobian(
            self.person.model, self.data, self.frame(frame), pin.LOCAL_WORLD_ALIGNED
        )[:, order]
        whole = np.zeros((6, len(self.mass)))
        whole[:, :own] = motion[:, :own]
        whole[:, self.inputs : self.inputs + len(order) - own] = motion[:, own:]
        if self.rides is not None:
            whole[:, -1] = whole @ self.rides
        return whole

    def motion(self, name: str) -> Array:
        """Six motions of what is prescribed, beside what carries it, (6, p + n)."""
        rows: Array = np.eye(len(self.mass))[self.moved[name]]
        return rows

    def seat(self) -> Array:
        """Motion of the seat, which carries the backrest, at the origin, (6, p + n)."""
        rows = self.motion(self.ground)
        if self.ground == "floor":
            rows[2, self.coordinates.index("seat z") + self.inputs] = 1.0
        return rows

    def join(self, rows: Array, stiffness: Array | float, damping: Array | float) -> None:
        """Add an element that resists the motions `rows` (m, p + n), each or all alike."""
        for matrix, size in ((self.stiffness, stiffness), (self.damping, damping)):
            matrix += rows.T @ (np.broadcast_to(size, len(rows))[:, None] * rows)

    def activate(self, activity: Activity) -> None:
        """Let the muscles of the arms at work stiffen them, in place of the springs assumed."""
        for side in activity.working:
            stiffness, damping = activity.impedance(side)
            rows = activity.paths.rows[ARMS[side][1]]
            at = self.inputs + rows
            self.stiffness[at, at] -= self.own[0, rows]
            self.damping[at, at] -= self.own[1, rows]
            self.stiffness[np.ix_(at, at)] += stiffness.total
            self.damping[np.ix_(at, at)] += damping.total

    def prestress(self, posture: Posture) -> None:
        """Add the tasks' second derivatives weighted by what they hold with."""
        statement = posture.statement
        held, let_go = (
            call(statement.program.evaluate, posture.q, statement.parameters, multipliers)[3]
            for multipliers in (posture.multipliers, np.zeros_like(posture.multipliers))
        )
        at = slice(self.inputs, self.inputs + len(posture.q))
        self.stiffness[at, at] += statement.scale[:, None] * (held - let_go) * statement.scale

    def stand_on(self, cushion: Cushion) -> None:
        """Put the person on a cushion on a seat on the floor."""
        rides = np.zeros(len(self.mass))
        rides[self.moved[self.ground]][2] = 1.0
        for name in self.person.moved:
            if name != "seat":
                rides[self.moved[name]][2] = -1.0
        self.rides = rides
        for matrix in (self.mass, self.damping, self.stiffness):
            matrix[:, -1] = matrix @ rides
            matrix[-1] = rides @ matrix
        below = np.zeros(len(self.mass))
        for name, layer in zip(_LAYERS, (cushion.seat, cushion.cushion), strict=True):
            rise = np.eye(len(self.mass))[self.inputs + self.coordinates.index(f"{name} z")]
            motion = self.motion(self.ground)[:3]
            motion[2] += rise
            self.layers[name] = layer.mass, motion
            self.mass += layer.mass * motion.T @ motion
            self.join((rise - below)[None], layer.stiffness, layer.damping)
            below = rise

    def tie_viscera(self) -> None:
        """Join neighbours of the visceral column by rods, each along the line through both."""
        for upper, lower, stiffness, damping in self.person.column:
            line = self.pose(upper).translation - self.pose(lower).translation
            along = line / np.linalg.norm(line)
            stretch = along @ (self.jacobian(upper) - self.jacobian(lower))[:3]
            self.join(stretch[None], stiffness, damping)

    def lean_on(self, back: RigidBack | FoamBack, recline: float) -> None:
        """Set the backrest against the mean motion of its vertebrae, beside the seat's."""
        mean, link = rest_on(back, recline, self.pose(back.at).translation)
        points = {body: self.pose(body).translation for body in mean.of}
        motions = {body: self.jacobian(body) for body in mean.of}
        motion, carried = lean(mean, points, motions, self.seat(), self.motion("backrest"))
        self.carried["backrest"] = carried
        self.held.append(motion[list(link.rigid)])
        at = link.sprung
        self.join(motion[at], link.stiffness[at], link.damping[at])

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
                self.carried[name] = carry(pivot)
                motion -= carry(place.translation) @ self.motion(self.ground)
                motion -= carry(place.translation - pivot) @ self.motion(name)
            seen = np.vstack([goal.T @ motion[:3], goal.T @ motion[3:]])
            # Of the angles sin(phi) n of the task: their rate, where some are free and not zero.
            apart = goal.T @ place.rotation
            seen[3:] = (np.trace(apart) * np.eye(3) - apart) @ seen[3:] / 2
            rows = [COMPONENTS.index(component) for component in task.components]
            self.held.append(seen[rows])

    def free(self) -> tuple[Array, npt.NDArray[np.intp]]:
        """T (p + n, p + k) that meets all that is held, and which k coordinates stay.

        Raises:
            PostureIKError: more is held than can move.
        """
        p, size = self.inputs, len(self.mass)
        rows = np.vstack([np.zeros((0, size)), *self.held])
        count = len(rows)
        if not count:
            return np.eye(size), np.arange(size - p)
        light = 1.0 / np.sqrt(np.diag(self.mass)[p:])
        triangle, order = qr(rows[:, p:] * light, mode="r", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        if count > size - p or pivots[-1] < 1e-9 * pivots[0]:
            raise PostureIKError(
                "vibration: the grips and the rigid backrest hold more than can move; let a grip "
                "or a component of it go, or take a backrest of foam."
            )
        dependent = p + np.sort(order[:count])
        free = np.delete(np.arange(size), dependent)
        transform = np.zeros((size, size - count))
        transform[free, np.arange(len(free))] = 1.0
        transform[dependent] = -np.linalg.solve(rows[:, dependent], rows[:, free])
        return transform, free[p:] - p


def _gripped(posture: Posture) -> Sequence[str]:
    hands = [task for task in posture.problem.task if isinstance(task, Hand)]
    return [f"lever_{hand.lever}" for hand in hands if hand.lever is not None]
