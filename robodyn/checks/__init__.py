"""The linter: rules (a function each), what they read, causes, fixes, baselines; `check.py` is the door."""
