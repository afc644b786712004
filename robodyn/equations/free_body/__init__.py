"""Free-body diagrams: what acts on each body, and both of Euler's laws."""
