"""The 25 muscles of an arm, and how they lie: the moment arms of MuJoCo's rendering of it."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TOOL = Path(__file__).resolve().parents[1] / "tools" / "extract_arm.py"

#: Peak force N, optimal fibre length m, tendon slack length m, pennation deg: Holzbaur et al. 2005
#: and Saul et al. 2014.
TABLE = {
    "DELT1": (1218.9, 0.0976, 0.0930, 22),
    "DELT2": (1103.5, 0.1078, 0.1095, 15),
    "DELT3": (201.6, 0.1367, 0.0380, 18),
    "SUPSP": (499.2, 0.0682, 0.0395, 7),
    "INFSP": (1075.8, 0.0755, 0.0308, 19),
    "SUBSC": (1306.9, 0.0873, 0.0330, 20),
    "TMIN": (269.5, 0.0741, 0.0713, 24),
    "TMAJ": (144.0, 0.1624, 0.0200, 16),
    "PECM1": (444.3, 0.1442, 0.0028, 17),
    "LAT1": (290.5, 0.2540, 0.1200, 25),
    "CORB": (208.2, 0.0932, 0.0970, 27),
    "TRIlong": (771.8, 0.1340, 0.1430, 12),
    "TRIlat": (717.5, 0.1138, 0.0980, 9),
    "TRImed": (717.5, 0.1138, 0.0908, 9),
    "BIClong": (525.1, 0.1157, 0.2723, 0),
    "BICshort": (316.8, 0.1321, 0.1923, 0),
    "BRA": (1177.4, 0.0858, 0.0535, 0),
    "BRD": (276.0, 0.1726, 0.1330, 0),
    "SUP": (379.6, 0.0330, 0.0280, 0),
    "PT": (557.2, 0.0492, 0.0980, 10),
    "ECRL": (337.3, 0.0810, 0.2440, 0),
    "ECRB": (252.5, 0.0585, 0.2223, 9),
    "ECU": (192.9, 0.0622, 0.2285, 4),
    "FCR": (407.9, 0.0628, 0.2440, 3),
    "FCU": (479.8, 0.0509, 0.2650, 12),
}
JOINTS = (
    *("shoulder_plane", "shoulder_elevation", "shoulder_rotation", "elbow_flexion"),
    *("pronation", "wrist_deviation", "wrist_flexion"),
)
#: Ranges while piloting, deg, of myo-sim's angles.
RANGES = np.radians([(0, 80), (10, 60), (-50, 80), (10, 125), (-80, 80), (-10, 20), (-60, 60)])


@dataclass(frozen=True)
class Table:
    names: tuple[str, ...]
    peak_force: np.ndarray
    optimal_length: np.ndarray
    slack_length: np.ndarray
    pennation: np.ndarray
    fastest: np.ndarray


class Arm:
    """myo-sim's right arm: path lengths (25,), dl/dq (25, 7), hand Jacobian (3, 7) at 7 angles."""

    def __init__(self) -> None:
        import mujoco

        spec = importlib.util.spec_from_file_location("extract_arm", TOOL)
        tool = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(tool)
        self.mujoco = mujoco
        self.model, self.state = tool.build()
        hinges = [theirs for theirs, *_ in tool.JOINTS.values()]
        names = ("elv_angle_r", "shoulder_elv_r", "shoulder_rot_r", *hinges)
        self.angles = [self.model.joint(name) for name in names]
        # the humerus turns out of its plane of elevation, then back
        self.back = self.model.joint("shoulder1_r2_r")
        actuators = [self.model.actuator(name) for name in TABLE]
        self.tendons = np.array([actuator.trnid[0] for actuator in actuators])
        self.hand = self.model.body("lunate_r").id

    def __call__(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        model, state = self.model, self.state
        for joint, angle in zip(self.angles, q, strict=True):
            state.qpos[joint.qposadr[0]] = angle
        state.qpos[self.back.qposadr[0]] = -q[0]
        self.mujoco.mj_fwdPosition(model, state)
        dense = np.zeros((model.ntendon, model.nv))
        for i in range(model.ntendon):
            part = slice(model.ten_J_rowadr[i], model.ten_J_rowadr[i] + model.ten_J_rownnz[i])
            dense[i, model.ten_J_colind[part]] = state.ten_J[part]
        position, rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        self.mujoco.mj_jacBody(model, state, position, rotation, self.hand)
        return (
            state.ten_length[self.tendons].copy(),
            self.columns(dense[self.tendons]),
            self.columns(position),
        )

    def columns(self, matrix: np.ndarray) -> np.ndarray:
        columns = matrix[:, [joint.dofadr[0] for joint in self.angles]]
        columns[:, 0] -= matrix[:, self.back.dofadr[0]]
        return columns
