"""The command `robodyn`: finds the subcommand and runs it."""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from io import TextIOWrapper

import click

from robodyn.cli.screen import reported
from robodyn.errors import RobodynWarning
from robodyn.support.wording import alternatives

COMMANDS = (
    *("torques", "retime", "envelope", "size", "simulate", "inertia", "check", "fbd", "equations", "derive"),
    *("linearize", "export", "excite", "identify", "scene", "info", "view", "diff", "convert", "accuracy", "rule"),
    *("doctor", "lsp"),
)


class Commands(click.Group):
    """Subcommands, each imported only when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            if ctx.resilient_parsing:  # a shell completes what is being typed
                return None
            ctx.fail(f"there is no command {name!r}; {alternatives(name, COMMANDS, 'commands')}")
        found: click.Command = import_module(f"robodyn.cli.{name}").command
        return found


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]}, invoke_without_command=True)
@click.version_option(package_name="robodyn", message="robodyn %(version)s")
@click.pass_context
def robodyn(ctx: click.Context) -> None:
    """Robot dynamics from URDF descriptions.

    \b
    Example:
      robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(interrupted: Callable[[], bool] = lambda: False) -> None:
    """Run the command line; `interrupted` tells whether there was an interrupt. Exit status: 0 fine, 1 findings or
    limits exceeded, 2 the input or the call is wrong, 130 interrupted."""
    with reported(interrupted), warnings.catch_warnings():
        for name, status in (("SIGTERM", 143), ("SIGHUP", 129)):  # so that half-written files are removed
            if (number := getattr(signal, name, None)) and signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, lambda *_, status=status: sys.exit(status))
        if not sys.warnoptions:
            warnings.simplefilter("ignore")
            warnings.simplefilter("default", RobodynWarning)
            warnings.showwarning = lambda message, *_, **__: click.echo(f"warning: {message}", err=True)
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")
        status = robodyn.main(prog_name="robodyn", standalone_mode=False)
        sys.exit(status if isinstance(status, int) else 0)
