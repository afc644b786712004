"""A corpus of crashers and bombs, through every command that reads them; rooms try what is random.

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
    ("envelope", "X"),
    ("export", "X", "--to", "c"),
    ("convert", "X", "--to", "mjcf", "--out", os.devnull),
    ("convert", "X", "--to", "urdf", "--out", os.devnull),
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
NAMES = sorted(path.name for path in HOSTILE.iterdir() if path.is_file())


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


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROBODYN_CACHE", "0")


def test_every_suffix_has_its_commands() -> None:
    assert len(NAMES) >= 60
    assert {os.path.splitext(name)[1] for name in NAMES} <= CALLS.keys()


@pytest.mark.parametrize("most", [1, pytest.param(None, marks=pytest.mark.slow)], ids=["first", "all"])
@pytest.mark.parametrize("name", NAMES)
def test_the_corpus(name: str, most: int | None) -> None:
    """By the first command that reads it, and by all."""
    Path(name).write_bytes((HOSTILE / name).read_bytes())
    before = {*os.listdir(), "with_mesh.urdf", "covariance_x.toml", "arm.srdf"}
    for call, outcome in outcomes(name, most):
        assert not fault(outcome), call
    assert before >= {*os.listdir()}
    assert "executed" not in os.listdir()


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 8))])
def test_damaged_files_that_no_room_damages(seed: int) -> None:
    """Bags, settings, baselines and SRDF: bytes changed or missing, long tokens, an end cut off."""
    log = [(k, joint_state(ROS2, 10**9 * (k + 1), ["shoulder", "elbow"], {"position": [0.1 * k, 0]})) for k in range(6)]
    (bag,) = write_bag(Path("bag"), {"/joint_states": log}, "mcap").glob("*.mcap")
    (base,) = write_bag(Path("base"), {"/joint_states": log}).glob("*.db3")
    run("check", "arm.urdf", "--baseline", "base.json", "--write-baseline", "--select", "ALL")
    good = {
        "x.mcap": bag.read_bytes(),
        "x.db3": base.read_bytes(),
        "x.json": Path("base.json").read_bytes(),
        "x.toml": b'[tool.robodyn.check]\nselect = ["RD2"]\nignore = ["RD5"]\n[tool.robodyn.check.thresholds]\n',
        "x.srdf": b'<robot name="arm"><group name="g"><joint name="elbow"/></group><virtual_joint name="v"/></robot>',
    }
    draw = random.Random(seed)
    for name, data in good.items():
        for _ in range(2):
            place = draw.randrange(len(data))
            ends = (b"", b"9" * 400 + data[place:], draw.randbytes(3) + data[place + 3 :], data[place + 20 :])
            Path(name).write_bytes(data[:place] + draw.choice(ends))
            for call, outcome in outcomes(name, 2):
                assert not fault(outcome), (call, Path(name).read_bytes()[:3000])
