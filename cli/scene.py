"""`robodyn scene`: files that say what surrounds a robot."""

from __future__ import annotations

import os

import click

from robodyn.cli.files import robot_source
from robodyn.cli.options import DESCRIPTION, PATH, SCENE_OUT, Call, option, takes
from robodyn.cli.screen import show, show_file
from robodyn.errors import InputError
from robodyn.robot.load import load
from robodyn.scene.template import scene_toml
from robodyn.support.files import write_whole


@click.group("scene", short_help="Begin a file on what surrounds a robot.", invoke_without_command=True)
@click.pass_context
def command(ctx: click.Context) -> None:
    """Begin a TOML file on what surrounds a robot: friction, motors, payloads, wrenches, drives and so on.

    \b
    Example:
      robodyn scene init robots/puma.urdf --out puma.toml
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@command.command("init", short_help="Write a scene for a robot, everything in it off.")
@click.argument("urdf", type=PATH)
@takes(option("--out FILE", "A new file; default standard output.", SCENE_OUT), DESCRIPTION)
def init(call: Call, urdf: str) -> None:
    """Write a scene with the joints and links of a robot, each key explained and switched off.
    As written it changes nothing. A file named - is standard input.

    \b
    Example:
      robodyn scene init robots/puma.urdf --out puma.toml
    """
    if call.out is not None and os.path.lexists(call.out):
        raise InputError("there is a file of this name already", remedy="name another one with --out", file=call.out)
    text = scene_toml(load(robot_source(urdf), **call.lookup))
    if call.out is None:
        show_file(text)
    else:
        write_whole(call.out, text.encode(), remedy="name another file")
        show(f"written: {call.out}; --scene {call.out} takes it\n")
