"""The command `robodyn`: finds the subcommand, prints errors as one line."""

from __future__ import annotations

import os
import sys
from importlib import import_module

import click

from robodyn.errors import RobodynError

COMMANDS = ("torques",)


class Commands(click.Group):
    """Subcommands, each imported only when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command: click.Command = import_module(f"robodyn.cli.{name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS:
            ctx.fail(f"there is no command {args[0]!r} (commands: {', '.join(COMMANDS)})")
        return super().resolve_command(ctx, args)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="robodyn")
def robodyn() -> None:
    """Robot dynamics from URDF descriptions."""


def main() -> None:
    """Run the command line.

    Exit status: 0 fine, 1 findings or limits exceeded, 2 the input or the call is wrong, 130 interrupted.
    """
    try:
        status = robodyn.main(standalone_mode=False)
    except click.ClickException as error:
        fail(f"{error.format_message().rstrip('.')} (try: robodyn --help)")
    except (RobodynError, MemoryError) as error:
        fail(str(error) or "out of memory")
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        fail(f"{error.filename or 'standard output'}: {error.strerror or error}")
    except (KeyboardInterrupt, click.Abort):
        sys.exit(130)
    sys.exit(status if isinstance(status, int) else 0)


def fail(message: str) -> None:
    """Print one line of error and exit with status 2."""
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(2)
