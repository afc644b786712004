"""Pages made from the program itself: commands from click, rules from the check, functions from their docstrings.

They are written when Sphinx starts, and git ignores them: `write_pages(folder)`.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
import sys
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from textwrap import dedent
from typing import Any

import click

import robodyn
from robodyn.checks.catalogue import RULES
from robodyn.checks.rule import Rule
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
TOPICS = {
    "Read a robot and its surroundings": ("load", "Model", "load_scene", "read_motion", "motion"),
    "Compute": ("inverse_dynamics", "forward_dynamics", "mass_matrix", "bias_forces", "momenta", "free_bodies", "dae"),
    "The commands as functions": ("torques", "simulate", "rollouts", "mass_properties", "check"),
}
"""Names that are in none of these are listed last, as what a scene is made of."""
SECTION = re.compile(r"^(Args|Attributes|Returns|Raises|Accuracy|Yields):\s*", re.MULTILINE)


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


def escaped(text: str) -> str:
    """Return the text with the signs of Markdown and HTML escaped, except between backticks."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([\\<>*_\[\]|])", r"\\\1", part) for part in parts)


def rules_page() -> str:
    """Return the page that lists the rules by family."""
    lines = [
        "# Rules of the check",
        "",
        f"`robodyn check` has {len(RULES)} rules. `robodyn rule RD207` explains one on the command line, and",
        "`robodyn rule mimic` finds those about a word. How to select, waive and fix findings is in",
        "[Find out whether a description is possible](../../howto/check_descriptions.md).",
    ]
    for prefix, title in FAMILIES.items():
        family = [rule for rule in RULES if rule.code.startswith(prefix)]
        rows = [
            f"| [{rule.code}]({rule.code.lower()}.md) | {rule.name} | {rule.severity.value} | {escaped(rule.summary)} |"
            for rule in family
        ]
        lines += ["", f"## {prefix}xx: {title}", "", "| code | name | severity | rule |", "| --- | --- | --- | --- |"]
        lines += rows
    entries = [rule.code.lower() for rule in RULES]
    return "\n".join([*lines, "", "```{toctree}", ":hidden:", "", *entries, "```", ""])


def rule_page(rule: Rule) -> str:
    """Return the page of one rule, with its bad and its good example."""
    return f"""# {rule.code} {rule.name}

{escaped(rule.summary)}

Severity: {rule.severity.value}

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


def commands_page() -> str:
    """Return the page of all commands with their arguments, options and examples."""
    head = [
        "# Commands",
        "",
        "`robodyn COMMAND --help` prints the same. [Exit status and errors](exit_status.md) are those of all commands.",
    ]
    context = click.Context(main_command, info_name="robodyn")
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


def python_page() -> str:
    """Return the page of the public names of the package."""
    known = {name for names in TOPICS.values() for name in names}
    others = sorted(name for name in robodyn.__all__ if name not in known)
    lines = [
        "# Python API",
        "",
        "These names are public: `import robodyn`, then `robodyn.load` and so on. Paths deeper in the package may",
        "change with any version. [Use it from Python](../howto/python.md) shows them at work.",
    ]
    for topic, names in (*TOPICS.items(), ("What a scene is made of, and errors", others)):
        lines += ["", f"## {topic}"]
        for name in names:
            lines += ["", *_entry(name)]
    return "\n".join([*lines, ""])


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


def _entry(name: str) -> Iterator[str]:
    found = getattr(robodyn, name)
    yield f"### {name}"
    yield ""
    if inspect.isfunction(found):
        yield from ("```python", *_signature(name, inspect.signature(found)), "```", "")
    elif dataclasses.is_dataclass(found):
        fields = ", ".join(field.name for field in dataclasses.fields(found) if field.init)
        yield from ("```python", *_wrapped(f"{name}({fields})"), "```", "")
    yield from _docstring(inspect.getdoc(found) or "")
    if inspect.isclass(found):
        yield from _members(found)
    elif inspect.isclass(result := _result(found)):
        yield f"**What it returns, a `{result.__name__}`:** {escaped(_first(result))}"
        yield ""
        yield from _docstring((inspect.getdoc(result) or "").partition("\n\n")[2])
        yield from _members(result)


def _result(function: Any) -> Any:
    """Return the class of what a function returns, where it is one of the package without a public name."""
    name = function.__annotations__.get("return")
    if not isinstance(name, str) or name in robodyn.__all__:
        return None
    found = getattr(sys.modules[function.__module__], name, None)
    return found if getattr(found, "__module__", "").startswith("robodyn") else None


def _first(found: object) -> str:
    """Return the first paragraph of a docstring."""
    return " ".join((inspect.getdoc(found) or "").split("\n\n")[0].split())


def _members(found: type) -> Iterator[str]:
    """Yield the properties and methods of a class that have a docstring, as items of a list."""
    members = [(name, member) for name, member in vars(found).items() if not name.startswith("_")]
    described = [
        (f"{name}()" if inspect.isfunction(member) else name, _first(member))
        for name, member in members
        if inspect.isfunction(member) or isinstance(member, (property, cached_property))
    ]
    if described:
        yield from ("**Properties and methods**", "")
        yield from (f"- `{name}`: {escaped(text)}" for name, text in described if text)
        yield ""


def _signature(name: str, signature: inspect.Signature) -> Sequence[str]:
    """Return a call with the names and the defaults of the arguments, without their types."""
    bare = [
        parameter.replace(annotation=inspect.Parameter.empty, default=_named(parameter.default))
        for parameter in signature.parameters.values()
    ]
    return _wrapped(f"robodyn.{name}{signature.replace(parameters=bare, return_annotation=inspect.Signature.empty)}")


class _Name:
    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return self.name


def _named(default: object) -> object:
    """Return the default so that it is shown as it would be written."""
    if default is inspect.Parameter.empty:
        return default
    if isinstance(default, type):
        return _Name(f"np.{default.__name__}" if default.__module__ == "numpy" else default.__name__)
    if type(default).__module__.startswith("robodyn"):
        return _Name(f"robodyn.{type(default).__name__}()")
    return default


def _wrapped(call: str, width: int = 100) -> list[str]:
    lines, indent = [""], " " * (call.index("(") + 1)
    for part in re.split(r"(?<=, )", call):
        if len(lines[-1]) + len(part) > width:
            lines[-1] = lines[-1].rstrip()
            lines.append(indent)
        lines[-1] += part
    return lines


def _docstring(text: str) -> Iterator[str]:
    """Yield a docstring with Google's sections as Markdown."""
    body, *sections = SECTION.split(text)
    yield from _paragraphs(body)
    for title, content in zip(sections[::2], sections[1::2], strict=True):
        yield f"**{title}**"
        yield ""
        if title in ("Args", "Attributes", "Raises"):
            yield from _items(content)
        else:
            yield from _paragraphs(dedent(" " * 4 + content) if "\n    " in content else content)
        yield ""


def _paragraphs(text: str) -> Iterator[str]:
    """Yield paragraphs, those that are indented as blocks of code."""
    for paragraph in re.split(r"\n\s*\n", text.strip("\n")):
        if paragraph.startswith("    "):
            yield from ("```text", *dedent(paragraph).splitlines(), "```", "")
        elif paragraph.strip():
            yield from (escaped(" ".join(paragraph.split())), "")


def _items(content: str) -> Iterator[str]:
    """Yield `name: what it is` as items of a list."""
    for item in re.split(r"\n(?! )", dedent("    " + content.strip("\n")).strip()):
        names, colon, meaning = " ".join(item.split()).partition(": ")
        yield f"- `{names}`: {escaped(meaning)}" if colon else f"- {escaped(names)}"
