"""What accuracy costs (accuracy/), and what is installed (doctor)."""
