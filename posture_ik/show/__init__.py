"""What people see: report, 3D page, summary."""

from posture_ik.show.motion_report import write_motion_report
from posture_ik.show.muscle_report import write_activation_report
from posture_ik.show.page import view, write_view
from posture_ik.show.report import write_report
from posture_ik.show.vibration_report import write_vibration_report

__all__ = [
    "view",
    "write_activation_report",
    "write_motion_report",
    "write_report",
    "write_vibration_report",
    "write_view",
]
