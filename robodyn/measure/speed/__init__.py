"""Executors timed beside other libraries in one run."""
