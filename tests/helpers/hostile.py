"""Hostile files, the commands that read each kind, and mutants of good ones."""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from helpers.command_line import Outcome, run

HOSTILE = Path(__file__).parents[1] / "data" / "hostile"
_DESCRIPTION = [
    ("check", "X", "--select", "ALL", "--format", "github"),
    ("info", "X"),
    ("inertia", "X"),
    ("torques", "X", "arm.csv", "--hold", "rest", "--ignore-extra"),
    ("fbd", "X"),
    ("linearize", "X"),
    ("export", "X", "--to", "c"),
]
_TABLE = [
    ("torques", "arm.urdf", "X"),
    ("torques", "arm.urdf", "X", "--hold", "rest", "--ignore-extra", "--measured"),
    ("check", "arm.urdf", "--trajectory", "X"),
    ("fbd", "arm.urdf", "--traj", "X", "--time", "0"),
]
_TOML = [
    ("torques", "arm.urdf", "arm.csv", "--scene", "X"),
    ("simulate", "arm.urdf", "--scene", "X", "--duration", "0.01"),
    ("check", "arm.urdf", "--config", "X"),
    ("torques", "arm.urdf", "arm.csv", "--map", "X"),
]
_MESH = [("inertia", "X"), ("check", "with_mesh.urdf", "--select", "ALL"), ("inertia", "with_mesh.urdf")]
_JSON = [("check", "arm.urdf", "--baseline", "X"), ("torques", "arm.urdf", "arm.csv", "--scene", "covariance_x.toml")]
CALLS: dict[str, Sequence[tuple[str, ...]]] = {
    **dict.fromkeys((".urdf", ".xacro"), _DESCRIPTION),
    **dict.fromkeys((".csv", ".npz", ".parquet", ".yaml", ".mcap", ".db3", ".bag"), _TABLE),
    **dict.fromkeys((".stl", ".obj", ".ply", ".off", ".dae", ".glb", ".gltf", ".3mf"), _MESH),
    ".json": [*_TABLE, *_JSON],
    ".toml": _TOML,
    ".srdf": [("check", "arm.urdf", "--select", "ALL"), ("check", "X")],
}
"""By suffix, what reads such a file, X."""
_LONGEST = 120
"""Seconds after which a command is said not to end."""


class Waits(BaseException):
    """A command does not end; no error, which a command would tell as its own."""


@contextmanager
def _hurried() -> Iterator[None]:
    def late(*_: object) -> None:
        raise Waits

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(_LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def outcomes(name: str) -> Iterator[tuple[tuple[str, ...], Outcome]]:
    """Yield the calls that read a file of the current folder, and how they end."""
    suffix = os.path.splitext(name)[1]
    mesh = f'<mesh filename="{name}"/>'
    text = Path("arm.urdf").read_text()
    Path("with_mesh.urdf").write_text(
        text.replace('<link name="base"/>', f'<link name="base"><visual><geometry>{mesh}</geometry></visual></link>')
    )
    Path("covariance_x.toml").write_text(f'[uncertainty]\ncovariance = "{name}"\n')
    if suffix == ".srdf":
        shutil.copy(name, "arm.srdf")
    for call in CALLS[suffix]:
        words = tuple(name if word == "X" else word for word in call)
        with _hurried():
            yield words, run(*words)


def fault(outcome: Outcome) -> str:
    """Return what is wrong with how a command ended; empty if nothing is."""
    if outcome.status not in (0, 1, 2):
        return f"status {outcome.status}"
    lines = [line for line in outcome.err.splitlines() if line.startswith("error: ")]
    for word in ("internal error", "Traceback", "out of memory"):
        if word in outcome.err or (word != "out of memory" and word in outcome.out):
            return f"{word}: {outcome.err.strip()[-300:]}"
    if re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", outcome.err + outcome.out):
        return "it drives a terminal"
    if outcome.status == 2 and len(lines) != 1:
        return f"{len(lines)} lines of error: {outcome.err[:300]}"
    return ""


_TOKENS = [
    *(
        b"nan",
        b"inf",
        b"-1e999",
        b"1e400",
        b"0",
        b"-1",
        b"null",
        b"true",
        b"~",
        b"[]",
        b"{}",
        b"''",
        b'""',
        b"&x",
        b"*x",
    ),
    *(
        b"9" * 400,
        b"1_0",
        b"0x1",
        b"12:30:45",
        b"2001-12-14",
        b"\xff",
        b"\0",
        b"\r",
        b"\n",
        b",",
        b"<",
        b">",
        b"&",
        b"%",
    ),
    *("é".encode(), "\u202e".encode(), "\x9b".encode(), b"_-", b"../", b"a." * 40, b"/dev/zero", b"${", b"-->"),
]
_WORD = re.compile(rb"[\w.+-]+")


def mutant(data: bytes, draw: random.Random) -> bytes:
    """Return a file with one to four changes: bytes, tokens, lines, or an end that is missing."""
    for _ in range(draw.randint(1, 4)):
        place = draw.randrange(len(data) + 1)
        kind = draw.randrange(7)
        if kind == 0:
            data = data[:place] + bytes([draw.randrange(256)]) + data[place + 1 :]
        elif kind == 1:
            data = data[:place] + draw.choice(_TOKENS) + data[place:]
        elif kind == 2 and (words := list(_WORD.finditer(data))):
            word = draw.choice(words)
            data = data[: word.start()] + draw.choice(_TOKENS) + data[word.end() :]
        elif kind == 3:
            data = data[:place]
        elif kind == 4:
            data = data[:place] + data[place + draw.randint(1, 20) :]
        elif kind == 5:
            lines = data.split(b"\n")
            number = draw.randrange(len(lines))
            lines[number:number] = [draw.choice(lines)] * draw.randint(1, 3)
            data = b"\n".join(lines)
        elif kind == 6 and (words := list(_WORD.finditer(data))):
            one, other = sorted((draw.choice(words), draw.choice(words)), key=lambda word: word.start())
            if one.end() <= other.start():
                data = b"".join(
                    (data[: one.start()], other[0], data[one.end() : other.start()], one[0], data[other.end() :])
                )
    return data
