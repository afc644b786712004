"""Times that others published, with the hardware that they name, to stand beside those of `benchmarks.compare`."""

from __future__ import annotations

from typing import NamedTuple


class Published(NamedTuple):
    """What was measured by whom on what, and microseconds of one state by robot and algorithm."""

    program: str
    source: str
    address: str
    hardware: str
    times: dict[str, dict[str, float]]


_ADDRESS = "github.com/robot-acceleration/GRiDBenchmarks"
_PAPER = "Plancher et al., GRiD: GPU-Accelerated Rigid Body Dynamics with Analytical Gradients, ICRA 2022"

PUBLISHED = (
    Published(
        "Pinocchio 3, preview",
        _PAPER,
        _ADDRESS,
        "Intel Core i7-10700K, 3.8 GHz",
        {
            "iiwa": {"RNEA": 0.2, "ABA": 0.9, "dRNEA": 1.4, "dABA": 2.5},
            "HyQ": {"RNEA": 0.3, "ABA": 1.2, "dRNEA": 2.1, "dABA": 3.8},
            "atlas": {"RNEA": 1.1, "ABA": 5.3, "dRNEA": 10.0, "dABA": 22.7},
        },
    ),
    Published(
        "GRiD",
        _PAPER,
        _ADDRESS,
        "NVIDIA GeForce RTX 3080, 1.44 GHz",
        {
            "iiwa": {"RNEA": 3.0, "ABA": 7.7, "dRNEA": 6.3, "dABA": 12.9},
            "HyQ": {"RNEA": 3.2, "ABA": 6.9, "dRNEA": 5.8, "dABA": 11.0},
            "atlas": {"RNEA": 8.0, "ABA": 22.4, "dRNEA": 19.5, "dABA": 42.1},
        },
    ),
    Published(
        "RigidBodyDynamics.jl",
        "documentation of RigidBodyDynamics.jl, medians with Julia 1.1.0",
        "github.com/JuliaRobotics/RigidBodyDynamics.jl/blob/master/docs/src/benchmarks.md",
        "Intel Core i7-6950X, 3.0 GHz",
        {"atlas": {"RNEA": 5.727, "CRBA": 5.795, "ABA": 18.862}},
    ),
)
"""One state a call; atlas is a file `atlas.urdf`, if given. Forward dynamics of the first two multiplies by M^-1."""
