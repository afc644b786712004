"""The options of `robodyn check`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import click

from robodyn.cli.files import STANDARD_INPUT
from robodyn.cli.options import DESCRIPTION, PATH, lookup
from robodyn.robot.urdf.sources import is_xacro


class Codes(click.ParamType):  # type: ignore[type-arg,unused-ignore]
    """Codes of rules, or their beginnings, between commas."""

    name = "codes"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        codes = [code.strip() for code in str(value).split(",")]
        return tuple(code.upper() if code[:2].upper() == "RD" else code for code in codes)


class Programs(Codes):
    """Names of programs, between commas."""

    name = "names"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        return tuple(code.lower() for code in super().convert(value, param, ctx))


CODES, PROGRAMS = Codes(), Programs()
FORMATS = ("text", "json", "sarif", "junit", "github")
_OPTIONS = (
    click.option("--select", type=CODES, metavar="CODES", help="Rules to run: RD207,RD5; default all."),
    click.option("--ignore", type=CODES, metavar="CODES", help="Rules not to run."),
    click.option("--strict", is_flag=True, help="Exit with 1 on warnings, too."),
    click.option("--format", "form", type=click.Choice(FORMATS), default="text", help="Default text."),
    click.option("--statistics", is_flag=True, help="Count findings by rule in place of listing them."),
    DESCRIPTION,
    click.option("--target", "targets", type=PROGRAMS, metavar="NAMES", help="What mujoco, drake, gz, kdl, isaac do."),
    click.option("--against", metavar="REF", help="Compare the dynamics with the file's version at a git revision."),
    click.option("--trajectory", type=PATH, metavar="FILE", help="Hold the limits against the loads along a motion."),
    click.option(
        "--config", type=PATH, metavar="FILE", help="Settings, in place of robodyn.toml or pyproject.toml above a file."
    ),
    click.option("--baseline", type=PATH, metavar="FILE", help="Pass over the findings that this file has."),
    click.option("--write-baseline", is_flag=True, help="Write today's findings to the file of --baseline."),
    click.option("--fix", is_flag=True, help="Edit the files where an edit is right and leaves the dynamics alone."),
    click.option("--unsafe-fixes", is_flag=True, help="With --fix or --diff: edits that change the dynamics, too."),
    click.option("--diff", is_flag=True, help="Print what --fix would change, and change nothing."),
)


def OPTIONS(command: Callable[..., Any]) -> Callable[..., Any]:
    """All of them, in this order."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def check_flags(flags: dict[str, Any], urdfs: Sequence[str]) -> None:
    """Raise if options do not go together."""
    stdin, plain = STANDARD_INPUT in urdfs, not any(map(is_xacro, urdfs))
    wrong = [
        (plain and lookup()["xacro_args"], "--xacro-arg goes with a file that is xacro (xacro files end in .xacro)"),
        (flags["write_baseline"] and not flags["baseline"], "--write-baseline needs --baseline FILE"),
        (flags["unsafe_fixes"] and not (flags["fix"] or flags["diff"]), "--unsafe-fixes needs --fix or --diff"),
        (flags["fix"] and stdin and not flags["diff"], "--fix cannot edit standard input; --diff shows the edit"),
        (flags["statistics"] and flags["form"] != "text", "--statistics is text; leave --format out"),
    ]
    for is_wrong, what in wrong:
        if is_wrong:
            raise click.UsageError(what, click.get_current_context())
