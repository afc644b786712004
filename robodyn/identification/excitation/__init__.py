"""Motions that show what a robot's parameters are."""
