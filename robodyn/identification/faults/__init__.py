"""Faults of logs and of models that measured torques tell."""
