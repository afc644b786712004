"""Robot dynamics from URDF descriptions."""
