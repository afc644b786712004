"""MJCF, MuJoCo's format: its own compiler says what a file means, and that becomes a description."""
