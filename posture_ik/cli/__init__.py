"""The command line: `posture-ik`."""

# Each module adds its commands to the application as it is read, in the order `--help` lists them.
from posture_ik.cli import stages, studies  # noqa: F401
from posture_ik.cli.terminal import main

__all__ = ["main"]
