"""`robodyn export`: the dynamics of a robot as source code for other programs."""

from __future__ import annotations

import click

from robodyn.cli.files import check_names, robot_in_scene
from robodyn.cli.options import PATH, SCENE, Call, Output, option, takes
from robodyn.cli.screen import show, show_file
from robodyn.equations.export.export import TARGETS, export


@click.command("export", short_help="Write the dynamics as C, CasADi, JAX, PyTorch or NumPy.")
@click.argument("urdf", type=PATH)
@takes(
    option("--to", "C99, or the library of a Python module.", list(TARGETS), required=True),
    option(
        "--what WHAT,...",
        "torques (default), mass_matrix, bias, coriolis, forward, derivatives, forward_derivatives, regressor.",
        default="torques",
    ),
    option("--out FILE", "Default standard output.", Output("source code")),
    SCENE,
)
def command(call: Call, urdf: str, to: str, what: str) -> None:
    """Write functions that compute the dynamics of a robot, a scene folded in, without robodyn: one C99 file, or a
    Python module for CasADi, JAX, PyTorch or NumPy, which these differentiate, map and compile by their own means.
    Its head says units, the order of joints and what derivatives are by. No library is needed to write.
    A file named - is standard input.

    \b
    Examples:
      robodyn export robots/puma560.urdf --to c --what torques,mass_matrix,bias,forward --out puma560.c
      robodyn export robots/two_link_planar.urdf --to casadi --what forward --out arm.py
      robodyn export robots/puma.urdf --scene robots/puma_payload.toml --to jax --what derivatives,regressor > puma.py
    """
    check_names()
    model, scene = robot_in_scene(call, urdf)
    text = export(model, to, what, scene=scene, out=call.out)
    if call.out is None:
        show_file(text)
    else:
        show(f"written: {call.out}, {max(1, len(text) // 1000)} kB\n")
