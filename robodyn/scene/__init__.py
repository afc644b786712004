"""What surrounds a robot: the scene as data, its file, and whether it fits the robot."""
