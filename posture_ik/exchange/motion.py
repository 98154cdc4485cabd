"""What moves in time, the muscles that hold or drive it, and vibration, as netCDF."""

from __future__ import annotations

from pathlib import Path

from posture_ik.muscle import Activity
from posture_ik.posture import Motion, Trajectory
from posture_ik.vibration import Vibration


def write_motion(motion: Motion, folder: Path) -> None:
    """Write `motion.nc` into an existing folder."""
    motion.to_dataset().to_netcdf(folder / "motion.nc", engine="h5netcdf")


def write_trajectory(trajectory: Trajectory, folder: Path) -> None:
    """Write `trajectory.nc` into an existing folder."""
    trajectory.to_dataset().to_netcdf(folder / "trajectory.nc", engine="h5netcdf")


def write_activation(activity: Activity, folder: Path) -> None:
    """Write `activation.nc` into an existing folder."""
    activity.to_dataset().to_netcdf(folder / "activation.nc", engine="h5netcdf")


def write_vibration(vibration: Vibration, folder: Path) -> None:
    """Write `response.nc` into an existing folder."""
    vibration.to_dataset().to_netcdf(folder / "response.nc", engine="h5netcdf")
