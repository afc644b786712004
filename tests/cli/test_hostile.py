"""A corpus of crashers and bombs, and mutants of good files, through every command that reads them.

Each ends by itself with one line at most, runs nothing that it read, and writes nothing.
"""

from __future__ import annotations

import os
import random
from pathlib import Path

import pytest
from helpers.bags import ROS2, joint_state, write_bag
from helpers.command_line import run, write_arm
from helpers.hostile import CALLS, HOSTILE, fault, mutant, outcomes

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs signals and devices")
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
    Path(name).write_bytes((HOSTILE / name).read_bytes())
    before = {*os.listdir(), "with_mesh.urdf", "covariance_x.toml", "arm.srdf"}
    for call, outcome in outcomes(name):
        assert not fault(outcome), call
    assert before >= {*os.listdir()}
    assert not {"executed"} & {*os.listdir()}


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


def _try(rounds: int, seed: int) -> None:
    draw, seeds = random.Random(seed), _seeds()
    for number in range(rounds):
        for name, data in seeds.items():
            changed = mutant(data, draw)
            Path(name).write_bytes(changed)
            for call, outcome in outcomes(name):
                wrong = fault(outcome)
                assert not wrong, (number, call, wrong, changed[:3000])


def test_some_mutants() -> None:
    _try(1, 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_many_mutants(seed: int) -> None:
    _try(25, 1000 + seed)
