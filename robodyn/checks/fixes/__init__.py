"""Fixes of files, and the proof that they leave the dynamics alone."""
