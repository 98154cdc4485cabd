"""The muscles of the arms: their data, paths and forces, and who pulls how hard."""
