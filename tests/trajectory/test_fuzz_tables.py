"""Damaged and random tables and messages: one clear line or a motion, and the two CSV readers agree."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from helpers.command_line import run, write_arm
from helpers.whole_tables import read_trajectory
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import TrajectoryError
from robodyn.robot.load import load
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.formats.messages import yaml_documents
from robodyn.trajectory.read import read_motion

SIGNALS = Signals((Signal("a", "continuous"), Signal("b", "length")))
FREE = Signals((Signal("base", "floating"),))
TRICKY = [b"\n", b",", b"\r", b"\r\n\r\n", b"_", b"nan", b"1e999", b'"', b"\xff\xff\xff\x7f", b"\0", b" ", b";", b"-"]

edits = st.lists(
    st.tuples(
        st.sampled_from(["set", "cut", "insert", "end"]),
        st.integers(0, 1 << 16),
        st.one_of(st.binary(min_size=1, max_size=6), st.sampled_from(TRICKY)),
    ),
    min_size=1,
    max_size=4,
)


@cache
def table(suffix: str) -> bytes:
    time = np.arange(40) / 100
    columns = {"time": time, "q_a": np.sin(time), "q_b": np.cos(time)}
    stream = io.BytesIO()
    if suffix == "npz":
        np.savez(stream, **columns)
    elif suffix == "parquet":
        pl.DataFrame(columns).write_parquet(stream)
    else:
        pl.DataFrame(columns).write_csv(stream)
    return stream.getvalue()


def damage(data: bytes, changes: list[tuple[str, int, bytes]]) -> bytes:
    for kind, place, part in changes:
        i = place % max(1, len(data))
        if kind == "end":
            data = data[:i]
        else:
            skipped = {"set": len(part), "cut": 3 * len(part), "insert": 0}[kind]
            data = data[:i] + (b"" if kind == "cut" else part) + data[i + skipped :]
    return data


def outcome(path: Path, signals: Signals = SIGNALS) -> str | bytes:
    try:
        result = read_trajectory(path, signals)
    except TrajectoryError as error:
        return str(error)
    assert np.isfinite(result.qdd).all()
    return result.q.tobytes()


@given(edits, st.binary(max_size=200))
def test_damaged_csv_and_random_bytes(tmp_path: Path, changes: list[tuple[str, int, bytes]], data: bytes) -> None:
    check_both(tmp_path, damage(table("csv"), changes), SIGNALS)
    check_both(tmp_path, data, SIGNALS)


cells = st.one_of(
    st.floats().map(repr),
    st.integers(-9, 9).map(str),
    st.sampled_from(["", " ", "1_0", "0x1", "+1", "1e5", " 2", "3 ", "\t4", "nan", "x", '"5"', "1e400", ".5", "5."]),
)


@given(
    st.sampled_from(
        ["time,q_a,q_b", "time;q_a;q_b", "time\tq_a\tq_b", "time q_a q_b", "t,base_x,base_qw", "t,base_wz"]
    ),
    st.lists(st.tuples(st.floats(0, 1e-3), st.lists(cells, min_size=1, max_size=3)), max_size=8),
    st.sampled_from(["\n", "\r\n", "\n\n"]),
)
def test_random_tables(tmp_path: Path, header: str, rows: list[tuple[float, list[str]]], end: str) -> None:
    mark = next(mark for mark in ",;\t " if mark in header)
    lines = [mark.join([repr(i + jitter), *cells]) for i, (jitter, cells) in enumerate(rows)]
    check_both(tmp_path, end.join([header, *lines]).encode(), FREE if "base" in header else SIGNALS)


def check_both(folder: Path, data: bytes, signals: Signals) -> None:
    path = folder / "t.csv"
    path.write_bytes(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robodyn.trajectory.formats.csv_table.LARGE", 1 << 60)
        plain = outcome(path, signals)
        patch.setattr("robodyn.trajectory.formats.csv_table.LARGE", -1)
        assert outcome(path, signals) == plain


@given(edits)
def test_damaged_npz_and_parquet(tmp_path: Path, changes: list[tuple[str, int, bytes]]) -> None:
    (tmp_path / "t.npz").write_bytes(damage(table("npz"), changes))
    outcome(tmp_path / "t.npz")
    data = table("parquet")
    (tmp_path / "t.parquet").write_bytes(data[:4] + damage(data[4:-8], changes) + data[-8:])
    outcome(tmp_path / "t.parquet")


NAMES = ["shoulder", "elbow"]


def _message(k: int, **parts: Any) -> dict[str, Any]:
    return {"header": {"stamp": {"sec": k, "nanosec": 5}, "frame_id": ""}, **parts}


VALUES = {"interface_names": ["position", "velocity"], "values": [0.1, 0.2]}
KINDS: dict[str, Any] = {
    "states": [_message(k, name=NAMES, position=[0.1 * k, 0.2], velocity=[0.1, 0.0], effort=[1, 2]) for k in range(8)],
    "dynamic": [_message(k, joint_names=NAMES, interface_values=[VALUES, VALUES]) for k in range(8)],
    "plan": {
        "joint_names": NAMES,
        "points": [{"positions": [0.1 * k, 0.2], "time_from_start": {"sec": k}} for k in range(8)],
    },
}
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


@pytest.mark.parametrize("every", [12, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS)
def test_anything_anywhere(kind: str, every: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second message has it at some places, beginning at another for each."""
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    model, path = load("arm.urdf"), Path("x.json")
    first = len(list(_places(KINDS[kind][0]))) if kind != "plan" else 0
    places = len(list(_places(KINDS[kind])))
    for turn, odd in enumerate(ODD):
        for number in range(first + turn % every, min(first + 24, places), every):
            document = json.loads(json.dumps(KINDS[kind]))
            holder, key = list(_places(document))[number]
            holder[key] = odd
            path.write_text(json.dumps(document))
            error = ""
            try:
                with read_motion(path, model) as reader:
                    assert list(reader.blocks())
            except TrajectoryError as caught:
                error = str(caught)
            assert not error or (error.startswith("x.") and "\n" not in error), error


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
