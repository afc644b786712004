"""Pages made from the program itself: commands from click, rules from the check, functions from their docstrings.

They are written when Sphinx starts, and git ignores them: `write_pages(folder)`.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent
from typing import Any

import click
from markdown_text import escaped
from python_page import python_page

from robodyn.checks.catalogue import RULES
from robodyn.checks.rule import Rule, Severity
from robodyn.cli.main import COMMANDS
from robodyn.cli.main import robodyn as main_command

FAMILIES = {
    "RD0": "Reading",
    "RD1": "Tree and names",
    "RD2": "Masses and inertias",
    "RD3": "Inertias against shapes and their likely causes",
    "RD4": "Left against right",
    "RD5": "Joints",
    "RD6": "Meshes and shapes",
    "RD7": "Names in other sections",
    "RD8": "Loads and limits",
    "RD9": "Other programs, earlier versions",
}


def write_pages(folder: Path) -> None:
    """Write every generated page into the folder of the documentation; what has not changed is left alone."""
    for name, text in pages():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def pages() -> Iterator[tuple[str, str]]:
    """Yield the name and the text of every generated page."""
    yield "reference/commands.md", commands_page()
    yield "reference/python.md", python_page()
    yield "reference/json_keys.md", json_page()
    yield "reference/rules/index.md", rules_page()
    for rule in RULES:
        yield f"reference/rules/{rule.code.lower()}.md", rule_page(rule)


def rules_page() -> str:
    """Return the page that lists the rules by family."""
    default = sum(rule.in_default for rule in RULES)
    lines = [
        "# Rules of the check",
        "",
        f"`robodyn check` has {len(RULES)} rules. `robodyn rule RD207` explains one on the command line, and",
        "`robodyn rule mimic` finds those about a word. How to select, waive and fix findings is in",
        "[Find out whether a description is possible](../../howto/check_descriptions.md).",
        "",
        f"The usual findings of {default} rules are in the default set: errors, and what is likely a defect. Those",
        "of the others are shown where their code, or `ALL`, is selected, or an option asks for them.",
    ]
    for prefix, title in FAMILIES.items():
        family = [rule for rule in RULES if rule.code.startswith(prefix)]
        rows = [
            f"| [{rule.code}]({rule.code.lower()}.md) | {rule.name} | {rule.severity.value} |"
            f" {'yes' if rule.in_default else 'no'} | {escaped(rule.summary)} |"
            for rule in family
        ]
        lines += ["", f"## {prefix}xx: {title}", "", "| code | name | severity | default | rule |"]
        lines += ["| --- | --- | --- | --- | --- |"]
        lines += rows
    entries = [rule.code.lower() for rule in RULES]
    return "\n".join([*lines, "", "```{toctree}", ":hidden:", "", *entries, "```", ""])


def rule_page(rule: Rule) -> str:
    """Return the page of one rule, with its bad and its good example."""
    return f"""# {rule.code} {rule.name}

{escaped(rule.summary)}

Severity: {rule.severity.value}, {_shown(rule)}

{escaped(" ".join(rule.explanation.split()))}

## A description that breaks it

```xml
{rule.bad.strip(chr(10))}
```

## A description that keeps it

```xml
{rule.good.strip(chr(10))}
```
"""


def _shown(rule: Rule) -> str:
    """Return which findings of a rule are shown by default."""
    least = {Severity.ERROR: "errors alone", Severity.WARNING: "errors and warnings", Severity.NOTE: "all"}
    said = f"in the default set: {least[rule.default]}; `--select {rule.code}` shows every finding."
    same = f" A finding of {', '.join(rule.explains)} about the same link or joint is the same defect."
    return said + same * bool(rule.explains)


def commands_page() -> str:
    """Return the page of all commands with their arguments, options and examples."""
    head = [
        "# Commands",
        "",
        "`robodyn COMMAND --help` prints the same. [Exit status and errors](exit_status.md) are those of all commands.",
    ]
    context = click.Context(main_command, info_name="robodyn", **main_command.context_settings)
    for name in COMMANDS:
        command = main_command.get_command(context, name)
        assert command is not None
        head += _command(command, click.Context(command, parent=context, info_name=name), "##")
        if isinstance(command, click.Group):
            for sub in command.list_commands(context):
                inner = command.commands[sub]
                parent = click.Context(command, parent=context, info_name=name)
                head += _command(inner, click.Context(inner, parent=parent, info_name=sub), "###")
    return "\n".join([*head, ""])


def _command(command: click.Command, context: click.Context, level: str) -> list[str]:
    usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
    lines = ["", f"{level} {context.command_path}", "", "```text", usage, "```", "", *_help(command.help or "")]
    rows = [param.get_help_record(context) for param in command.get_params(context)]
    given = [(names.replace("|", r"\|"), text) for names, text in filter(None, rows) if text]
    options = [f"| `{names}` | {escaped(text)} |" for names, text in given]
    return [*lines, "", "| option | meaning |", "| --- | --- |", *options] if options else lines


def _help(text: str) -> Iterator[str]:
    """Yield the lines of a command's help; paragraphs that click leaves as they are become blocks of code."""
    for paragraph in inspect.cleandoc(text).split("\n\n"):
        if paragraph.startswith("\b"):
            first, *rest = paragraph[1:].strip("\n").splitlines()
            yield from (first, "", "```sh", *dedent("\n".join(rest)).splitlines(), "```", "")
        else:
            yield from (escaped(" ".join(paragraph.split())), "")


def json_page() -> str:
    """Return the page that lists the keys of every JSON document, by their schemas."""
    lines = [
        "# JSON keys",
        "",
        "What `--format json` prints, by [the schemas](json.md); `[]` stands for each item of a list, `*` for a name.",
    ]
    for path in sorted((Path(__file__).parent / "reference" / "schemas").glob("*.json")):
        schema = json.loads(path.read_text(encoding="utf-8"))
        rows = [f"| `{key}` | {kind} | {escaped(text)} |" for key, kind, text in _keys(schema, "")]
        lines += ["", f"## {path.name.partition('.')[0]}", "", f"`{schema['title']}`", ""]
        lines += ["| key | type | meaning |", "| --- | --- | --- |", *rows]
    return "\n".join([*lines, ""])


def _keys(schema: dict[str, Any], path: str) -> Iterator[tuple[str, str, str]]:
    """Yield path, type and description of each key of a schema, depth first."""
    for one in schema.get("anyOf", ()):
        yield from _keys(one, path)
    if "items" in schema:
        yield from _keys(schema["items"], f"{path}[]")
    inner = dict(schema.get("properties", {}))
    if isinstance(schema.get("additionalProperties"), dict):
        inner["*"] = schema["additionalProperties"]
    for name, value in inner.items():
        here = f"{path}.{name}" if path else name
        kind = value.get("type", "any")
        yield here, kind if isinstance(kind, str) else " or ".join(kind), value.get("description", "")
        yield from _keys(value, here)
