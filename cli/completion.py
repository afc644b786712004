"""What shells complete beyond commands, options and files: methods, codes of rules, links and joints of the robot."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, TypeGuard

import click

from robodyn.support.input_file import read_input

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

Names = Callable[[click.Context], Iterable[str]]
LONGEST = 1 << 24
"""Bytes of a description that are searched for names."""


def add_completions(command: click.Command) -> None:
    """Let shells complete the values of a command's options and arguments, as `COMPLETED` has them by name."""
    for param in command.params:
        if param.name in COMPLETED:
            setattr(param, "shell_complete", partial(_completed, *COMPLETED[param.name]))  # noqa: B010


def _completed(names: Names, end: str, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
    """Return the names that begin like what stands behind the last comma, in any case, each followed by `end`."""
    from click.shell_completion import CompletionItem

    before, comma, last = incomplete.rpartition(",")
    begun = (name for name in names(ctx) if name.casefold().startswith(last.casefold()))
    return [CompletionItem(f"{before}{comma}{name}{end}") for name in begun]


def _methods(ctx: click.Context) -> Iterable[str]:
    from robodyn.simulation.methods import METHODS

    return [method.name for method in METHODS]


def _functions(ctx: click.Context) -> Iterable[str]:
    from robodyn.equations.export.export import WORDS

    return WORDS


def _codes(ctx: click.Context) -> Iterable[str]:
    from robodyn.checks.catalogue import RULES

    return [rule.code for rule in RULES]


def _codes_and_names(ctx: click.Context) -> Iterable[str]:
    from robodyn.checks.catalogue import RULES

    return [name for rule in RULES for name in (rule.code, rule.name)]


def _selected(ctx: click.Context) -> Iterable[str]:
    from robodyn.checks.catalogue import WORDS

    return [*WORDS, *_codes(ctx)]


def _is_description(name: object) -> TypeGuard[str]:
    return isinstance(name, str) and name.endswith((".urdf", ".xacro"))


def _named(element: str, ctx: click.Context) -> Iterable[str]:
    """Return the names of the links or joints in the description that the command line has so far."""
    given = [*ctx.args, ctx.params.get("urdf"), *(ctx.params.get("files") or ())]
    try:
        text = read_input(next(filter(_is_description, given), ""), LONGEST).decode("utf-8", "replace")
    except (OSError, ValueError):
        return []
    found = re.findall(rf"<{element}\s[^>]*?\bname\s*=\s*[\"']([^\"'${{}}]+)[\"']", text)
    return dict.fromkeys(found)


LINKS, JOINTS = partial(_named, "link"), partial(_named, "joint")
COMPLETED: dict[str | None, tuple[Names, str]] = {
    "method": (_methods, ""),
    "what": (_functions, ""),
    "asked": (_codes_and_names, ""),
    "select": (_selected, ""),
    "ignore": (_codes, ""),
    "link": (LINKS, ""),
    "frame": (LINKS, ""),
    "payloads": (LINKS, "="),
    "at": (JOINTS, "="),
    "qd": (JOINTS, "="),
    "qdd": (JOINTS, "="),
    "hold": (JOINTS, "="),
}
"""By the name of an option or argument: the names that it takes, and what follows each."""
