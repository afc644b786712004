"""What ROS tools read beside the robot: ros2_control, and the SRDF of MoveIt and Pinocchio."""
