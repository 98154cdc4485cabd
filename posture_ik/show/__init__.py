"""What people see: report, 3D page, summary."""

from posture_ik.show.report import write_report
from posture_ik.show.view import serve_view, write_view

__all__ = ["serve_view", "write_report", "write_view"]
