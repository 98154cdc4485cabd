"""What is asked: who sits, where, what is held, how it moves."""

from posture_ik.problem.blocks import (
    COMPONENTS,
    SPINE,
    Backrest,
    BackrestContact,
    Component,
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
    Task,
    task_label,
)
from posture_ik.problem.load import example_problems, load_problem
from posture_ik.problem.paths import number_at, with_numbers

__all__ = [
    "COMPONENTS",
    "SPINE",
    "Backrest",
    "BackrestContact",
    "Component",
    "Frame",
    "Gaze",
    "Hand",
    "Head",
    "Lever",
    "MotionBlock",
    "Pelvis",
    "PostureBlock",
    "Problem",
    "Seat",
    "Subject",
    "Task",
    "example_problems",
    "load_problem",
    "number_at",
    "task_label",
    "with_numbers",
]
