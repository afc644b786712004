"""`robodyn convert`: a robot in another format."""

from __future__ import annotations

import os
from contextlib import ExitStack

import click

from robodyn.cli.files import check_names, refuse_foreign, robot_in_scene
from robodyn.cli.options import PATH, SCENE, Call, Output, option, takes
from robodyn.cli.screen import show
from robodyn.support.files import cannot_be_written, whole_file


@click.command("convert", short_help="Write a robot as MJCF or URDF.")
@click.argument("urdf", type=PATH)
@takes(
    option("--to", "The format.", ("mjcf", "urdf"), required=True),
    option("--out FILE", "The file to write.", Output("a converted description"), required=True),
    option("--meshes", "Write meshes that MuJoCo does not read as STL, for FILE.xml into FILE_meshes."),
    SCENE,
)
def command(call: Call, urdf: str, to: str, meshes: bool) -> None:
    """Write a robot in another format with the same dynamics, and list what that format cannot say. Friction, rotors,
    springs, payloads, loops and gravity of a scene go along. A robot that cannot exist is refused, never repaired.
    URDF to URDF is edited: every other byte stays. A file named - is standard input.

    \b
    Examples:
      robodyn convert robots/scara.urdf --to mjcf --out scara.xml
      robodyn convert robot.urdf --scene friction.toml --to mjcf --meshes --out robot.xml
    """
    from robodyn.robot.write.mjcf import write_mjcf
    from robodyn.robot.write.urdf import write_urdf
    from robodyn.scene.described import described

    check_names()
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    assert call.out is not None, "it is required"
    assert model.description is not None, "models of files have one"
    description, lost = described(model.description, scene)
    out = call.out
    written = write_mjcf(description, out, convert_meshes=meshes) if to == "mjcf" else write_urdf(description, out)
    files = {os.path.join(os.path.dirname(out), name): data for name, data in written.files.items()}
    for path in files:
        refuse_foreign(path, "a converted mesh", "write elsewhere")
    with ExitStack() as stack:
        for path, data in files.items():
            with cannot_be_written(path):
                os.makedirs(os.path.dirname(path), exist_ok=True)
            stack.enter_context(whole_file(path)).write(data)
        stack.enter_context(whole_file(out)).write(written.data)
    for each in (*lost, *written.lost):
        show(f"{to.upper()} cannot say {each}\n")
    show(f"written: {out}, {max(1, len(written.data) // 1000)} kB\n")
