"""The page of the public names of the package, from their signatures and docstrings."""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from collections.abc import Iterator, Sequence
from functools import cached_property
from textwrap import dedent
from typing import Any

from markdown_text import escaped

import robodyn

TOPICS = {
    "Read a robot and its surroundings": ("load", "Model", "load_scene", "scene_of", "read_motion", "motion"),
    "Compute": (
        "inverse_dynamics",
        "forward_dynamics",
        "mass_matrix",
        "bias_forces",
        "momenta",
        "forward_kinematics",
        "jacobian",
        "free_bodies",
        "dae",
        "derive",
    ),
    "Differentiate": (
        "inverse_dynamics_derivatives",
        "forward_dynamics_derivatives",
        "inverse_dynamics_derivative_entries",
        "inverse_dynamics_second_derivatives",
        "coriolis_matrix",
        "regressor",
    ),
    "One sample at a time": ("function",),
    "The commands as functions": (
        "torques",
        "size",
        "retime",
        "simulate",
        "rollouts",
        "envelope",
        "linearize",
        "view",
        "export",
        "excite",
        "read_log",
        "identify",
        "mass_properties",
        "check",
    ),
}
"""Names that are in none of these are listed last, as what a scene is made of."""
SECTION = re.compile(r"^(Args|Attributes|Returns|Raises|Accuracy|Yields):\s*", re.MULTILINE)


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
