"""A corpus of crashers and bombs, and mutants of good files, through every command that reads them.

Each ends by itself with one line at most, runs nothing that it read, and writes nothing.
"""

from __future__ import annotations

import os
import random
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from helpers.bags import ROS2, joint_state, write_bag
from helpers.command_line import Outcome, run, write_arm
from helpers.hurried import hurried

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs signals and devices")
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


def outcomes(name: str, most: int | None = None) -> Iterator[tuple[tuple[str, ...], Outcome]]:
    """Yield the calls that read a file of the current folder, the first few or all, and how they end."""
    suffix = os.path.splitext(name)[1]
    mesh = f'<mesh filename="{name}"/>'
    text = Path("arm.urdf").read_text()
    Path("with_mesh.urdf").write_text(
        text.replace('<link name="base"/>', f'<link name="base"><visual><geometry>{mesh}</geometry></visual></link>')
    )
    Path("covariance_x.toml").write_text(f'[uncertainty]\ncovariance = "{name}"\n')
    if suffix == ".srdf":
        shutil.copy(name, "arm.srdf")
    for call in CALLS[suffix][:most]:
        words = tuple(name if word == "X" else word for word in call)
        with hurried(120):
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
    *b"nan inf -1e999 1e400 0 -1 null true ~ [] {} '' \"\" &x *x 1_0 0x1 12:30:45 2001-12-14 , < > & %".split(),
    *(b"9" * 400, b"\xff", b"\0", b"\r", b"\n", b"_-", b"../", b"a." * 40, b"/dev/zero", b"${", b"-->"),
    *(text.encode() for text in ("\u00e9", "\u202e", "\x9b")),
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


NAMES = sorted(path.name for path in HOSTILE.iterdir() if path.is_file())


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROBODYN_CACHE", "0")


def test_every_suffix_has_its_commands() -> None:
    assert len(NAMES) >= 60
    assert {os.path.splitext(name)[1] for name in NAMES} <= CALLS.keys()


@pytest.mark.parametrize("name", NAMES)
def test_the_corpus(name: str) -> None:
    """By the first command that reads it."""
    corpus(name, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_corpus_by_all_commands(name: str) -> None:
    corpus(name)


def corpus(name: str, most: int | None = None) -> None:
    Path(name).write_bytes((HOSTILE / name).read_bytes())
    before = {*os.listdir(), "with_mesh.urdf", "covariance_x.toml", "arm.srdf"}
    for call, outcome in outcomes(name, most):
        assert not fault(outcome), call
    assert before >= {*os.listdir()}
    assert "executed" not in os.listdir()


def _seeds() -> dict[str, bytes]:
    """Return a good file of each kind."""
    points = ", ".join(f"{{positions: [{0.1 * k}, 0], time_from_start: {{sec: {k}}}}}" for k in range(6))
    state = "header: {{stamp: {{sec: {k}, nanosec: 0}}}}\nname: [shoulder, elbow]\nposition: [0.{k}, 0.2]\n"
    log = [(k, joint_state(ROS2, 10**9 * (k + 1), ["shoulder", "elbow"], {"position": [0.1 * k, 0]})) for k in range(6)]
    (bag,) = write_bag(Path("bag"), {"/joint_states": log}, "mcap").glob("*.mcap")
    (base,) = write_bag(Path("base"), {"/joint_states": log}).glob("*.db3")
    for suffix in ("npz", "parquet"):
        run("torques", "arm.urdf", "arm.csv", "--out", f"tau.{suffix}")
    run("check", "arm.urdf", "--baseline", "base.json", "--write-baseline", "--select", "ALL")
    scene = "gravity = [0, 0, -9.81]\n[friction]\nelbow = { viscous = 1, coulomb = 0.5 }\n[[payload]]\nlink = 'fore'\n"
    scene += "mass = 2\n[motor.shoulder]\ninertia = 1e-4\ngear = 100\n[initial]\nq = { elbow = 0.1 }\n"
    settings = '[tool.robodyn.check]\nselect = ["RD2"]\nignore = ["RD5"]\n[tool.robodyn.check.thresholds]\n'
    return {
        "x.urdf": Path("arm.urdf").read_bytes(),
        "x.csv": Path("arm.csv").read_bytes(),
        "x.npz": Path("tau.npz").read_bytes(),
        "x.parquet": Path("tau.parquet").read_bytes(),
        "x.mcap": bag.read_bytes(),
        "x.db3": base.read_bytes(),
        "x.yaml": "---\n".join(state.format(k=k) for k in range(6)).encode(),
        "plan.yaml": f"joint_names: [shoulder, elbow]\npoints: [{points}]\n".encode(),
        "x.json": Path("base.json").read_bytes(),
        "scene.toml": scene.encode(),
        "x.toml": settings.encode(),
        "x.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
        "x.off": b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n",
        "x.stl": b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n",
        "x.srdf": b'<robot name="arm"><group name="g"><joint name="elbow"/></group><virtual_joint name="v"/></robot>',
    }  # fmt: skip


def _try(rounds: int, seed: int, most: int | None = None) -> None:
    draw, seeds = random.Random(seed), _seeds()
    for number in range(rounds):
        for name, data in seeds.items():
            changed = mutant(data, draw)
            Path(name).write_bytes(changed)
            for call, outcome in outcomes(name, most):
                wrong = fault(outcome)
                assert not wrong, (number, call, wrong, changed[:3000])


def test_some_mutants() -> None:
    _try(1, 1, 2)


@pytest.mark.slow
def test_many_mutants() -> None:
    _try(10, 1000)
