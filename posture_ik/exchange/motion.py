"""A motion in time as netCDF."""

from __future__ import annotations

from pathlib import Path

from posture_ik.posture import Motion


def write_motion(motion: Motion, folder: Path) -> None:
    """Write `motion.nc` into an existing folder."""
    motion.to_dataset().to_netcdf(folder / "motion.nc", engine="h5netcdf")
