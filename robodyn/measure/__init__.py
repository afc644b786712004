"""What accuracy costs (accuracy/), how fast executors are (speed/), what is installed (doctor)."""
