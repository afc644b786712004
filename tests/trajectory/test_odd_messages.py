"""Messages as text whose fields are anything but what belongs there: one line, the message and what it has."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import run, write_arm

from robodyn.errors import TrajectoryError
from robodyn.trajectory.readers.messages import yaml_documents

NAMES = ["shoulder", "elbow"]


def _states() -> list[dict[str, Any]]:
    return [
        {
            "header": {"stamp": {"sec": k, "nanosec": 5}, "frame_id": ""},
            "name": NAMES,
            "position": [0.1 * k, 0.2],
            "velocity": [0.1, 0.0],
            "effort": [1.0, 2.0],
        }
        for k in range(8)
    ]


def _dynamic() -> list[dict[str, Any]]:
    values = {"interface_names": ["position", "velocity"], "values": [0.1, 0.2]}
    both = {"joint_names": NAMES, "interface_values": [values, values]}
    return [{"header": {"stamp": {"sec": k, "nanosec": 0}}, **both} for k in range(8)]


def _plan() -> dict[str, Any]:
    points = [{"positions": [0.1 * k, 0.2], "velocities": [0.1, 0.1], "time_from_start": {"sec": k}} for k in range(8)]
    return {"joint_names": NAMES, "points": points}


KINDS = {"states": _states, "dynamic": _dynamic, "plan": _plan}
ODD: list[Any] = [
    *(None, "text", "", True, 0, -1, 5, 1e400, -1e400, float("nan"), 10**400, [], {}, [None], ["a"], [True], [[]]),
    *([[1.0, 2.0]], {"a": 1}, [{"a": 1}], "2001-12-14", "12:30:45", "1_000", "0x10", "é", [1e400, 0.0], [10**400, 0]),
    *({"sec": None}, {"sec": "x"}, {"sec": 1e300}, {"sec": [1]}, {"sec": {}}, {"sec": 1e400, "nanosec": 0}, [0.1] * 3),
]


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every place in a document: the list or mapping, and the key."""
    keys = range(len(value)) if isinstance(value, list) else list(value) if isinstance(value, dict) else ()
    for key in keys:
        yield value, key
        yield from _places(value[key])


def _count(kind: str) -> int:
    return sum(1 for _ in _places(KINDS[kind]()))


def _yaml(value: Any) -> str:
    """Write YAML in one line, texts without quotes."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_yaml(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return {None: "null", True: "true", "": '""'}.get(value, str(value)) if value.__hash__ else str(value)


@pytest.mark.parametrize("every", [6, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("odd", ODD, ids=lambda odd: repr(odd)[:20])
def test_anything_anywhere(kind: str, odd: Any, every: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second message has it at every sixth place, beginning at another for each, in either form in turn."""
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    turn = list(map(id, ODD)).index(id(odd))
    first = len(list(_places(KINDS[kind]()[0]))) if kind != "plan" else 0
    for number in range(first + turn % every, min(first + 24, _count(kind)), every):
        form = ("json", "yaml")[(number // every + turn) % 2]
        path = Path(f"x.{form}")
        document = deepcopy(KINDS[kind]())
        holder, key = list(_places(document))[number]
        holder[key] = deepcopy(odd)
        path.write_text(json.dumps(document) if form == "json" else _yaml(document))
        outcome = run("torques", "arm.urdf", str(path))
        assert outcome.status in (0, 2), (key, path.read_text())
        assert "internal error" not in outcome.err, (key, outcome.err)
        if outcome.status:
            assert outcome.err.startswith("error: x."), outcome.err
            assert outcome.err.count("\n") == 1, outcome.err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("position: [0.1, null]", "message 1: position has 'None', which is no number"),
        ("position: [0.1, 2001-12-14]", "message 1: position has '2001-12-14', which is no number"),
        ("position: [0.1, 12:30:45]", "message 1: position has '12:30:45', which is no number"),
        ("position: [0.1, {a: 1}]", "which is no number"),
        ("position: 0.1", "message 1: position is '0.1', not a list"),
        ("position: [0, 0], header: {stamp: {sec: .inf}}", "message 1: the stamp is inf s"),
    ],
)
def test_what_is_said(text: str, words: str, tmp_path: Path) -> None:
    write_arm(tmp_path)
    path = tmp_path / "x.yaml"
    path.write_text("{name: [shoulder, elbow], " + text + "}\n")
    outcome = run("torques", str(tmp_path / "arm.urdf"), str(path))
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert words in outcome.err, outcome.err


YAML = {
    **{"1": 1, "-0.5e-3": -0.5e-3, "1e-05": 1e-05, "1.": 1.0, ".inf": float("inf"), "-.Inf": float("-inf")},
    **{"~": None, "'5'": "5", "!!str 5": "5", "[1, [2, {a: b}]]": [1, [2, {"a": "b"}]]},
    **{text: text for text in ("yes", "12:30", "2001-12-14", "1_000", "0x10")},
}


def test_values_of_yaml() -> None:
    assert yaml_documents("".join(f"- {text}\n" for text in YAML).encode(), "f") == [[*YAML.values()]]


def test_documents_of_yaml() -> None:
    assert yaml_documents(b"--- 1\n---\n--- [a]\n...\n", "f") == [1, None, ["a"]]
    assert yaml_documents(b"", "f") == []
    with pytest.raises(TrajectoryError, match=r"f:2: is not YAML"):
        yaml_documents(b"a: [\n}", "f")
    with pytest.raises(TrajectoryError, match=r"f:2: \*x stands for another part"):
        yaml_documents(b"a: &x 1\nb: *x\n", "f")
    with pytest.raises(TrajectoryError, match=r"f:1: nested too deeply, at most 32"):
        yaml_documents(b"[" * 40 + b"]" * 40, "f")
    with pytest.raises(TrajectoryError, match=r"a key is no text"):
        yaml_documents(b"{[1]: 2}", "f")
