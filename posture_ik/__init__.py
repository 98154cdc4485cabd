"""The posture a seated person takes, what holds it, and what it carries."""

from posture_ik import show
from posture_ik.body import Body, build_body
from posture_ik.errors import InfeasiblePosture, PostureIKError, PostureNotFound
from posture_ik.exchange import (
    read_posture,
    write_mbdyn,
    write_motion,
    write_posture,
    write_trajectory,
    write_urdf,
)
from posture_ik.kinematics import Kinematics
from posture_ik.muscle import Activity, Muscles, Paths, reach, solve_activation
from posture_ik.posture import (
    InfeasibleReach,
    Motion,
    Posture,
    Trajectory,
    move,
    solve_posture,
)
from posture_ik.problem import (
    ActivationBlock,
    Backrest,
    BackrestContact,
    Frame,
    Gaze,
    Hand,
    Head,
    Lever,
    MotionBlock,
    Pelvis,
    PostureBlock,
    Problem,
    Seat,
    Subject,
    TrajectoryBlock,
    load_problem,
)

__all__ = [
    "ActivationBlock",
    "Activity",
    "Backrest",
    "BackrestContact",
    "Body",
    "Frame",
    "Gaze",
    "Hand",
    "Head",
    "InfeasiblePosture",
    "InfeasibleReach",
    "Kinematics",
    "Lever",
    "Motion",
    "MotionBlock",
    "Muscles",
    "Paths",
    "Pelvis",
    "Posture",
    "PostureBlock",
    "PostureIKError",
    "PostureNotFound",
    "Problem",
    "Seat",
    "Subject",
    "Trajectory",
    "TrajectoryBlock",
    "build_body",
    "load_problem",
    "move",
    "reach",
    "read_posture",
    "show",
    "solve_activation",
    "solve_posture",
    "write_mbdyn",
    "write_motion",
    "write_posture",
    "write_trajectory",
    "write_urdf",
]
