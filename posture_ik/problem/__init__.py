"""What is asked: who sits, where, what is held, how it moves."""

from posture_ik.problem.blocks import (
    Cushion,
    FoamBack,
    LawBack,
    Layer,
    Lever,
    Problem,
    RigidBack,
    Seat,
)
from posture_ik.problem.load import example_problems, load_problem
from posture_ik.problem.paths import number_at, with_numbers
from posture_ik.problem.stages import ActivationBlock, MotionBlock, PostureBlock, TrajectoryBlock
from posture_ik.problem.subject import Measured, Subject, sample_people
from posture_ik.problem.tasks import (
    COMPONENTS,
    SPINE,
    Backrest,
    BackrestContact,
    Component,
    Frame,
    Gaze,
    Hand,
    Head,
    Pelvis,
    Task,
    task_label,
)
from posture_ik.problem.vibration import FrequencyBlock, VibrationBlock

__all__ = [
    "COMPONENTS",
    "SPINE",
    "ActivationBlock",
    "Backrest",
    "BackrestContact",
    "Component",
    "Cushion",
    "FoamBack",
    "Frame",
    "FrequencyBlock",
    "Gaze",
    "Hand",
    "Head",
    "LawBack",
    "Layer",
    "Lever",
    "Measured",
    "MotionBlock",
    "Pelvis",
    "PostureBlock",
    "Problem",
    "RigidBack",
    "Seat",
    "Subject",
    "Task",
    "TrajectoryBlock",
    "VibrationBlock",
    "example_problems",
    "load_problem",
    "number_at",
    "sample_people",
    "task_label",
    "with_numbers",
]
