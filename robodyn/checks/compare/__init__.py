"""Findings and dynamics against those of before: baselines and earlier versions."""
