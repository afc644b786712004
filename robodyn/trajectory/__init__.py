"""Motions: tables in and out, columns, derivatives from noisy positions and their error bars."""
