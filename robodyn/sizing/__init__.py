"""The questions around the torque: how fast along a path, which pose is worst, which motor and gear suffice."""
