"""Forward simulation: integrators, events, stiffness, tables as inputs."""
