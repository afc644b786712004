"""Files of a batch agree, and what is printed is the same, whatever the processor, the threads of BLAS, and the worker.

Accelerations that are derived of positions divide their rounding by the squared time between samples, 1e-6 here.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from helpers.batch_runs import listing
from helpers.command_line import run, spawn
from helpers.other_robots import other_paths

from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.trajectory.write import open_writer

try:
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
except ImportError:  # NumPy 1
    from numpy.core._multiarray_umath import __cpu_dispatch__, __cpu_features__

ROBOT = """<robot name="skew">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0.03 -0.01" rpy="0.3 -0.2 0.5"/><mass value="2"/>
    <inertia ixx="0.011" ixy="0.001" ixz="0.002" iyy="0.02" iyz="-0.001" izz="0.023"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.1 0 0.02" rpy="0.7 0.1 -1.5"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0.002" ixz="0" iyy="0.013" iyz="0.001" izz="0.012"/></inertial></link>
  <link name="tool"><inertial><origin xyz="0 0.01 0.04"/><mass value="0.3"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="5e-4"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.4" rpy="0.1 0.2 0.3"/><axis xyz="0.1 1 0.3"/>
    <limit effort="50" velocity="9" lower="-3" upper="3"/><dynamics damping="0.3" friction="0.1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/>
    <origin xyz="0.4 0.01 0" rpy="-0.4 0.6 1.1"/><axis xyz="-0.2 0.7 0.4"/><limit effort="50" velocity="9"/></joint>
  <joint name="mount" type="fixed"><parent link="fore"/><child link="tool"/>
    <origin xyz="0.2 0 0.05" rpy="0.2 1.3 -0.3"/></joint>
</robot>
"""
SCENE = """gravity = [0.3, -2, -9]
[friction]
elbow = { viscous = 0.1, coulomb = [0.7, -0.6], stribeck = 0.9, stribeck_velocity = 0.05 }
[motor]
shoulder = { gear = 50, inertia = 2e-5, efficiency = 0.9, continuous = 1, peak = 3, max_speed = 500, gear_average = 40 }
[[payload]]
link = "tool"
mass = 1.5
com = [0.02, -0.01, 0.1]
[[wrench]]
link = "tool"
point = [0, 0.05, 0]
frame = "base"
force = [1, 2, -15]
"""
OPTIONS = ("--scene", "scene.toml", "--reactions", "--sizing", "--momentum")

HERE = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
"""Kinds of instructions that NumPy has code for and this processor has."""
WIDE = [name for name in HERE if name.startswith(("AVX512", "X86_V4"))]
AVX2 = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": " ".join(WIDE)}
SSE = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": " ".join(HERE)}
KINDS = {
    "one thread of BLAS": {"OPENBLAS_NUM_THREADS": "1"},
    "two threads of BLAS": {"OPENBLAS_NUM_THREADS": "2"},
    "AVX2": {**AVX2, "ROBODYN_CPU": "x86-64-v3"},
    "SSE": {**SSE, "ROBODYN_CPU": "x86-64-v3", "OPENBLAS_NUM_THREADS": "1"},
}
X86 = compiler_problem() is None and "X86" in "".join(__cpu_features__)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Positions alone: from encoders, clean, and at uneven times; as text, Parquet and NPZ."""
    monkeypatch.chdir(tmp_path)
    for name in ("OPENBLAS_CORETYPE", "OPENBLAS_NUM_THREADS", "NPY_DISABLE_CPU_FEATURES", "ROBODYN_CPU"):
        monkeypatch.delenv(name, raising=False)
    Path("skew.urdf").write_text(ROBOT)
    Path("scene.toml").write_text(SCENE)
    Path("runs").mkdir()
    rng = np.random.default_rng(11)
    even = np.arange(3000) / 1000
    uneven = (np.arange(1500) + rng.uniform(-0.3, 0.3, 1500)) / 500
    step = 2 * np.pi / 2**17
    for name, t, grid in (
        ("encoder.csv", even, step),
        ("clean.npz", even, 0.0),
        ("uneven.parquet", uneven, 0.0),
        ("both.csv", uneven, step),
    ):
        shoulder = 0.8 * np.sin(2.1 * t) + 0.3 * np.cos(5.3 * t)
        elbow = (4.0 * t + 0.5 * np.sin(4.7 * t) + np.pi) % (2 * np.pi) - np.pi
        if grid:
            shoulder = grid * np.rint(shoulder / grid)
        with open_writer(Path("runs") / name, ["q_shoulder", "q_elbow"]) as writer:
            writer.write(t, np.stack((shoulder, elbow), axis=1))


def files(out: str, executor: str, *more: str, **environment: str) -> dict[str, bytes]:
    """What a batch in a process of its own, in this environment, writes."""
    how = ("--out", f"{out}/", "--executor", executor, *(more or ("--jobs", "1")))
    done = spawn("torques", "skew.urdf", "runs/*", *OPTIONS, *how, **environment)
    assert (done.status, done.err) == (0, "")
    found = listing(Path(out))
    assert len(found) == 8
    return found


def agree(found: dict[str, bytes], expected: dict[str, bytes]) -> bool:
    """Whether files have the same words, and numbers within 1e-9 of the largest of their column, their own or 0.1."""
    return found.keys() == expected.keys() and all(_same(name, found[name], expected[name]) for name in expected)


def _same(name: str, found: bytes, expected: bytes) -> bool:
    if name.endswith(".json"):
        pairs = [list(_leaves(json.loads(data))) for data in (found, expected)]
        words = [[(key, each) for key, each in part if not isinstance(each, float)] for part in pairs]
        numbers = [np.array([each for _, each in part if isinstance(each, float)]) for part in pairs]
        sizes = np.maximum(np.abs(numbers[1]), 0.1)
        return words[0] == words[1] and bool((np.abs(numbers[0] - numbers[1]) <= 1e-9 * sizes).all())
    ours, theirs = (_columns(name, data) for data in (found, expected))
    sizes = [max(np.abs(column).max(), 1e-3) for column in theirs.values()]
    off = [np.abs(ours[key] - column).max() for key, column in theirs.items()]
    return list(ours) == list(theirs) and all(np.array(off) <= 1e-9 * np.array(sizes))


def _leaves(part: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of a document, but the sizes of files."""
    if isinstance(part, dict):
        for name, each in part.items():
            yield from _leaves(each, f"{key}.{name}") if name not in ("bytes", "checks") else ()
    elif isinstance(part, list):
        for each in part:
            yield from _leaves(each, key)
    else:
        yield key, part


def _columns(name: str, data: bytes) -> dict[str, np.ndarray]:
    if name.endswith(".npz"):
        return dict(np.load(io.BytesIO(data)))
    table = pl.read_parquet(io.BytesIO(data)) if name.endswith(".parquet") else pl.read_csv(io.BytesIO(data))
    return {column.name: column.to_numpy() for column in table}


def test_an_old_processor_prints_the_same_and_writes_what_agrees() -> None:
    """One joint by local polynomials, one by the spline; the many ways to go are among the slow tests."""
    how = ("torques", "skew.urdf", "runs/encoder.csv", *OPTIONS, "--executor", "numpy", "--out", "tau.npz")
    found = []
    for form in ("text", "json"):
        here = run(*how, "--format", form)
        written = Path("tau.npz").read_bytes()
        there = spawn(*how, "--format", form, **SSE, OPENBLAS_NUM_THREADS="1")
        assert (here.status, here.err) == (there.status, there.err) == (0, "")
        assert agree({"tau.npz": Path("tau.npz").read_bytes()}, {"tau.npz": written})
        found.append((here.out, there.out))
    assert found[0][0] == found[0][1]
    assert agree(*({"tau.json": text.encode()} for text in found[1]))
    derived = [joint["acceleration"] for joint in json.loads(found[1][0])["derivatives"]]
    assert ["Savitzky" in text for text in derived] == [True, False]


@pytest.mark.slow
@pytest.mark.skipif(not X86, reason="these are kinds of x86-64")
@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_every_kind_of_processor_writes_the_same(executor: str) -> None:
    expected = files("here", executor)
    for number, (kind, environment) in enumerate(KINDS.items()):
        assert agree(files(f"there{number}", executor, **environment), expected), kind


PROGRAMS = """
import sys
from hashlib import blake2b
from robodyn import load
from robodyn.dynamics.plan import plan
from robodyn.scene.scene import DEFAULT
from robodyn.dynamics.balance import laws
for path in sys.argv[1:]:
    a_plan = plan(load(path), DEFAULT)
    print(path, *(blake2b(repr(p).encode(), digest_size=8).hexdigest() for p in (a_plan.wrenches(True), laws(a_plan))))
"""


@pytest.mark.slow
def test_programs_of_real_robots_are_the_same() -> None:
    """The constants that recursions multiply and add up before the first sample."""

    def programs(**environment: str) -> str:
        call = [sys.executable, "-c", PROGRAMS, *map(str, other_paths()[::5])]
        return subprocess.run(
            call, capture_output=True, text=True, check=True, env={**os.environ, **environment}
        ).stdout

    assert programs(**SSE) == programs() != ""
