"""A motion read in many blocks gives what it gives in one, in memory that does not grow with its length."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from helpers.command_line import ARM, HEADER, ROBOTS

from robodyn.loads.torques import torques
from robodyn.report.torques import torques_json
from robodyn.robot.load import load
from robodyn.scene.read import load_scene
from robodyn.scene.scene import DEFAULT
from robodyn.trajectory.read import open_trajectory, signals

CASES = [
    ("scara", "scara_pick_and_place", None, 100),
    ("puma", "puma_encoder", None, 100),
    ("gripper", "gripper_pick", "gripper", 7),
    ("puma", "puma_polish", "puma_polish", 30),
    ("puma560", "puma560_sweep", "puma560_sizing", 7),
]
"""Robot, table, scene, and rows of a block."""
BY_BLOCK = ("quadrature_error", "samples", "first_law", "second_law", "power", "largest_force", "largest_moment")
"""Keys of the checks that depend on which samples stand together."""
SHORT, LONG = 20_000, 320_000
BLOCK_ROWS = 8192
MEGABYTE = 1 << 20


def computed(urdf: Path, table: Path, scene_file: Path | None, block_rows: int) -> tuple[Any, np.ndarray]:
    """The document without what depends on blocks, and the torques with all reactions."""
    scene = load_scene(scene_file) if scene_file else DEFAULT
    model = load(urdf, moving_base=scene.moving_base)
    blocks: list[np.ndarray] = []
    with open_trajectory(table, signals(model), extra=scene.columns, block_rows=block_rows) as reader:
        keep = [lambda time, columns: blocks.append(np.column_stack((time, columns)))]
        result = torques(model, reader, scene, reactions=True, executor="numpy", sinks=keep)
    assert len(blocks) >= -(-result.samples // block_rows)
    document = json.loads(torques_json(result))
    document["checks"] = {name: value for name, value in document["checks"].items() if name not in BY_BLOCK}
    for name in ("quadrature_error", "largest_residual"):
        document["checks"]["energy_balance"].pop(name)
    return document, np.concatenate(blocks)


def flat(value: Any, path: str = "") -> dict[str, Any]:
    """Every leaf of a document by its path."""
    if isinstance(value, (dict, list)):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        return {key: leaf for name, part in items for key, leaf in flat(part, f"{path}/{name}").items()}
    return {path: value}


@pytest.mark.parametrize(
    ("robot", "table", "scene", "block_rows"),
    [pytest.param(*case, id=case[1], marks=[pytest.mark.slow] * (case[3] < 30)) for case in CASES],
)
def test_many_blocks_are_as_one(robot: str, table: str, scene: str | None, block_rows: int) -> None:
    files = ROBOTS / f"{robot}.urdf", ROBOTS / f"{table}.csv", ROBOTS / f"{scene}.toml" if scene else None
    (one, whole), (many, parts) = computed(*files, 1 << 16), computed(*files, block_rows)
    derived = bool(one["derivatives"])
    tolerance = 1e-8 if derived else 1e-13
    largest = np.abs(whole[:, 1:]).max()
    np.testing.assert_array_equal(parts[:, 0], whole[:, 0])
    assert np.abs(parts - whole).max() <= tolerance * largest
    expected, found = flat(one), flat(many)
    assert list(found) == list(expected)
    scale = max(abs(x) for x in expected.values() if isinstance(x, float))
    for path, value in expected.items():
        if isinstance(value, float):
            assert abs(found[path] - value) <= tolerance * scale, path
        else:
            assert found[path] == value, path


def write_motion(path: Path, rows: int) -> None:
    """The arm's motion with full digits, through polars."""
    t = pl.int_range(rows, eager=True) / 1000.0
    columns = dict.fromkeys(HEADER.strip().split(","), (t * 0.1).sin())
    pl.DataFrame({**columns, "time": t}).write_csv(path)


def peak_resident(folder: Path, rows: int) -> int:
    """Bytes of resident memory at the most of `robodyn torques arm.urdf arm.csv --out tau.csv`, in small blocks."""
    write_motion(folder / "arm.csv", rows)
    code = (
        "from robodyn.trajectory.read import open_trajectory; "
        f"open_trajectory.__kwdefaults__['block_rows'] = {BLOCK_ROWS}; from robodyn.cli.main import main; main()"
    )
    call = [sys.executable, "-c", code, "torques", "arm.urdf", "arm.csv", "--out", "tau.csv"]
    with subprocess.Popen(call, cwd=folder, stdout=subprocess.DEVNULL) as child:
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0
    assert sum(1 for _ in (folder / "tau.csv").open()) == rows + 1
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the system does not tell the memory of a process")
def test_many_times_the_rows_in_the_same_memory(tmp_path: Path) -> None:
    """300 000 rows of 7 columns more are 17 MB as numbers and 40 MB as text."""
    (tmp_path / "arm.urdf").write_text(ARM)
    short, long = (peak_resident(tmp_path, rows) for rows in (SHORT, LONG))
    assert long - short <= 20 * MEGABYTE
