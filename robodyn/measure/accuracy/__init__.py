"""Ladders of methods, from the cheapest to a reference in more digits."""
