"""What gravity asks of each joint, and the inertia that each joint feels."""
