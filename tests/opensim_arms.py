"""Both arms and their 50 muscles in OpenSim: its forces, and its static optimisation.

OpenSim brings a CasADi of its own that cannot share a process with ours, so what imports it runs
in the process of the fixture `opensim`. There only this file is loaded: it must not import
posture_ik, and what goes to and fro are the arrays of `Arms`.

At one posture an arm is its joints, bodies and loads, and of each muscle the length and moment
arms; so a path whose length is linear in the angles stands for ours exactly. Each law takes the
tendon as rigid, as ours do.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: The law that `de_groote` states, and the one most models use.
DE_GROOTE, MILLARD = "DeGrooteFregly2016Muscle", "Millard2012EquilibriumMuscle"
#: A joint's reserve costs as much as a muscle at full activation when it gives this, N m.
RESERVE = 0.003
#: Mass (kg) and inertia (kg m²) added to all: Simbody refuses two massless bodies in a row.
_NEXT_TO_NOTHING = 1e-9


class Joint(NamedTuple):
    """A hinge: its frame in that of the joint `parent`, or in the world (-1), and its body."""

    name: str
    parent: int
    rotation: np.ndarray
    origin: np.ndarray
    axis: np.ndarray
    angle: float
    mass: float
    centre: np.ndarray
    inertia: np.ndarray


class Arms(NamedTuple):
    """Both arms at a posture; muscles by columns: peak force, lengths, pennation, as in Muscles."""

    joints: list[Joint]
    gravity: np.ndarray
    loads: list[tuple[int, np.ndarray, np.ndarray]]  # joint, point in its frame, force in the world
    names: tuple[str, ...]
    muscles: np.ndarray  # (50, 4)
    length: np.ndarray  # (50,)
    jacobian: np.ndarray  # (50, 14)


def arms_of(activity: Any) -> Arms:
    """The arms of the first instant of an Activity; in our own process."""
    import pinocchio as pin

    model, q = activity.shown.body.model, activity.q[0]
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    ids = [model.getJointId(dof) for dof in activity.paths.dofs]
    joints = []
    for i in ids:
        parent, place, inertia = model.parents[i], model.jointPlacements[i], model.inertias[i]
        if parent not in ids:
            place = data.oMi[parent] * place
        joints.append(
            Joint(
                model.names[i],
                ids.index(parent) if parent in ids else -1,
                place.rotation.copy(),
                place.translation.copy(),
                pin.getJointJacobian(model, data, i, pin.LOCAL)[3:, model.idx_vs[i]].copy(),
                q[model.idx_qs[i]],
                inertia.mass,
                inertia.lever.copy(),
                inertia.inertia.copy(),
            )
        )
    loads = []
    for side, force in zip("rl", activity.hand_force[0], strict=True):
        grip = model.frames[model.getFrameId(f"grip_{side}")]
        loads.append((ids.index(grip.parentJoint), grip.placement.translation.copy(), force))
    its = activity.muscles
    table = (its.peak_force, its.optimal_length, its.slack_length, its.pennation)
    length, jacobian = activity.paths.evaluate(q)
    gravity = model.gravity.linear.copy()
    return Arms(joints, gravity, loads, its.names, np.column_stack(table), length, jacobian)


def forces(
    arms: Arms, speeds: np.ndarray, activation: np.ndarray, law: str = DE_GROOTE
) -> tuple[np.ndarray, np.ndarray]:
    """Active and passive force of each muscle along its path, (50,) each, N."""
    model = _build(arms, law)
    state = model.initSystem()
    for joint, speed in zip(arms.joints, speeds, strict=True):
        model.getCoordinateSet().get(joint.name).setSpeedValue(state, float(speed))
    muscles = [model.getMuscles().get(name) for name in arms.names]
    for muscle, level in zip(muscles, activation, strict=True):
        muscle.setActivation(state, float(level))
    model.realizeDynamics(state)
    return (
        np.array([muscle.getActiveFiberForceAlongTendon(state) for muscle in muscles]),
        np.array([muscle.getPassiveFiberForceAlongTendon(state) for muscle in muscles]),
    )


#: What `prepare` leaves for `follow`.
_prepared: list[Any] = []


def prepare(
    arms: Arms,
    passive: np.ndarray,
    *,
    strength: np.ndarray | None = None,
    law: str = DE_GROOTE,
    tolerance: float = 1e-4,
) -> None:
    """State the static optimisation of holding still; `tolerance` is by default OpenSim's.

    The tool leaves out passive forces (opensim-core #3910), so their torques (14,), N m, come in
    from outside. What a muscle gives at full activation the tool takes along the fibres, not the
    path (#4390); with `strength` (50,), N, it is given.
    """
    import opensim as osim

    model = _build(arms, law, strength)
    for joint, torque in zip(arms.joints, passive, strict=True):
        given = osim.ExpressionBasedCoordinateForce(joint.name, repr(float(torque)))
        given.setName(f"passive_{joint.name}")
        model.addForce(given)
        reserve = osim.CoordinateActuator(joint.name)
        reserve.setName(f"reserve_{joint.name}")
        reserve.setOptimalForce(RESERVE)
        model.addForce(reserve)
    state = model.initSystem()
    motion, labels = osim.Storage(), osim.ArrayStr()
    labels.append("time")
    for joint in arms.joints:
        for what in ("value", "speed"):
            labels.append(f"/jointset/{joint.name}_hinge/{joint.name}/{what}")
    motion.setColumnLabels(labels)
    still = _array([x for joint in arms.joints for x in (joint.angle, 0.0)])
    for time in np.linspace(0.0, 10.0, 11):
        motion.append(float(time), still)
    tool = osim.StaticOptimization(model)
    tool.setStatesStore(motion)
    tool.setActivationExponent(2.0)
    tool.setUseMusclePhysiology(strength is None)
    tool.setConvergenceCriterion(tolerance)
    tool.setMaxIterations(1000)
    tool.begin(state)
    _prepared[:] = [tool, state, model, motion]  # the tool points at the last two


def follow(steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Optimise so many instants; activations (50,) and reserves (14,), N m, of the last."""
    tool, state, *_ = _prepared
    for k in range(steps):
        state.setTime(5.0 * (k + 1) / steps)
        tool.step(state, k + 1)
    found = tool.getActivationStorage()
    labels, last = found.getColumnLabels(), found.getLastStateVector().getData()
    values = {labels.get(i + 1): last.get(i) for i in range(last.getSize())}
    reserves = [x for name, x in values.items() if name.startswith("reserve_")]
    others = [x for name, x in values.items() if not name.startswith("reserve_")]
    return np.array(others), RESERVE * np.array(reserves)


def _build(arms: Arms, law: str, strength: np.ndarray | None = None) -> Any:
    import opensim as osim

    osim.Logger.setLevelString("Error")
    model = osim.Model()
    model.setGravity(_vector(arms.gravity))
    bodies: list[Any] = []
    for joint in arms.joints:
        inertia = joint.inertia + _NEXT_TO_NOTHING * np.eye(3)
        upper = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        body = osim.Body(
            f"{joint.name}_body",
            joint.mass + _NEXT_TO_NOTHING,
            _vector(joint.centre),
            osim.Inertia(*map(float, upper)),
        )
        hinge = osim.PinJoint(
            f"{joint.name}_hinge",
            model.getGround() if joint.parent < 0 else bodies[joint.parent],
            _vector(joint.origin),
            _turned(joint.axis, joint.rotation),
            body,
            osim.Vec3(0.0),
            _turned(joint.axis, np.eye(3)),
        )
        hinge.updCoordinate().setName(joint.name)
        hinge.updCoordinate().setDefaultValue(float(joint.angle))
        model.addBody(body)
        model.addJoint(hinge)
        bodies.append(body)
    _add_muscles(model, arms, law, strength)
    for i, point, force in arms.loads:
        load = osim.PrescribedForce(f"load_{i}", bodies[i])
        values = [osim.Constant(float(x)) for x in (*force, *point)]
        load.setForceFunctions(*values[:3])
        load.setPointFunctions(*values[3:])
        for value in values:
            value.thisown = False  # the load deletes them
        load.setForceIsInGlobalFrame(True)
        load.setPointIsInGlobalFrame(False)
        model.addForce(load)
    model.finalizeConnections()
    return model


def _add_muscles(model: Any, arms: Arms, law: str, strength: np.ndarray | None) -> None:
    import opensim as osim

    at_zero = arms.length - arms.jacobian @ [joint.angle for joint in arms.joints]
    for i, name in enumerate(arms.names):
        peak, optimal, slack, pennation = map(float, arms.muscles[i])
        path = osim.FunctionBasedPath()
        passed = np.flatnonzero(arms.jacobian[i])
        for j in passed:
            joint = arms.joints[j].name
            path.appendCoordinatePath(f"/jointset/{joint}_hinge/{joint}")
        path.setLengthFunction(osim.LinearFunction(_array([*arms.jacobian[i, passed], at_zero[i]])))
        muscle = getattr(osim, law)()
        muscle.setName(name)
        muscle.set_path(path)
        muscle.setMaxIsometricForce(peak if strength is None else float(strength[i]))
        muscle.setOptimalFiberLength(optimal)
        muscle.setTendonSlackLength(slack)
        muscle.setPennationAngleAtOptimalFiberLength(pennation)
        muscle.set_ignore_tendon_compliance(True)
        muscle.set_ignore_activation_dynamics(True)
        if law == MILLARD:
            muscle.setMinimumActivation(0.0)
            muscle.setFiberDamping(0.0)
        muscle.setMinControl(0.0)
        model.addForce(muscle)


def _turned(axis: np.ndarray, rotation: np.ndarray) -> Any:
    """Angles of a frame whose z lies along a hinge's axis, seen from a frame turned back."""
    import opensim as osim

    x, z = np.roll(axis, 1), axis
    frame = osim.Rotation()
    frame.setRotationFromTwoAxes(
        osim.UnitVec3(_vector(rotation @ z)),
        osim.CoordinateAxis(2),
        _vector(rotation @ x),
        osim.CoordinateAxis(0),
    )
    return frame.convertRotationToBodyFixedXYZ()


def _vector(values: Any) -> Any:
    import opensim as osim

    return osim.Vec3(*map(float, values))


def _array(values: Any) -> Any:
    import opensim as osim

    array = osim.ArrayDouble()
    for value in values:
        array.append(float(value))
    return array
