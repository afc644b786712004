"""The model meets the robot: logs, base parameters, calibrated descriptions, exciting motions."""
