"""What shells complete beyond commands, options and files: methods, codes of rules, links and joints of the robot."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

import click

from robodyn.cli.options import ROBOT_SUFFIXES
from robodyn.support.input_file import read_input

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

LONGEST = 1 << 24
"""Bytes of a description that are searched for names."""
ENDS = {
    **dict.fromkeys(("method", "what", "asked", "select", "ignore", "link", "frame"), ""),
    **dict.fromkeys(("payloads", "at", "qd", "qdd", "hold"), "="),
}
"""What follows each name, by the parameters that take names."""


def add_completions(command: click.Command) -> None:
    """Let shells complete the values of a command's options and arguments that take names."""
    for param in command.params:
        if param.name in ENDS:
            setattr(param, "shell_complete", partial(_completed, param.name))  # noqa: B010


def _completed(parameter: str, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
    """Return the names that begin like what stands behind the last comma, in any case."""
    from click.shell_completion import CompletionItem

    before, comma, last = incomplete.rpartition(",")
    begun = (name for name in _names(parameter, ctx) if name.casefold().startswith(last.casefold()))
    return [CompletionItem(f"{before}{comma}{name}{ENDS[parameter]}") for name in begun]


def _names(parameter: str, ctx: click.Context) -> Iterable[str]:
    if parameter == "method":
        from robodyn.simulation.methods import METHODS

        return [method.name for method in METHODS]
    if parameter == "what":
        from robodyn.equations.export import export

        return export.WORDS
    if parameter in ("asked", "select", "ignore"):
        from robodyn.checks.catalogue import RULES, WORDS

        if parameter == "asked":
            return [name for rule in RULES for name in (rule.code, rule.name)]
        return [*(WORDS if parameter == "select" else ()), *(rule.code for rule in RULES)]
    element = "link" if parameter in ("link", "frame", "payloads") else "joint"
    given = [*ctx.args, ctx.params.get("urdf"), *(ctx.params.get("files") or ())]
    robots = [name for name in given if isinstance(name, str) and name.endswith(ROBOT_SUFFIXES)]
    try:
        text = read_input(robots[0] if robots else "", LONGEST).decode("utf-8", "replace")
    except (OSError, ValueError):
        return []
    return dict.fromkeys(re.findall(rf"<{element}\s[^>]*?\bname\s*=\s*[\"']([^\"'${{}}]+)[\"']", text))
