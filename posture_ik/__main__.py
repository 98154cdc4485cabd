"""`python -m posture_ik` is `posture-ik`."""

from posture_ik.cli import main

main()
