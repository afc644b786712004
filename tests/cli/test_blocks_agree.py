"""A motion read in many blocks gives what it gives in one, in memory that does not grow with its length."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.sampled import sampled

from robodyn.loads.torques import torques
from robodyn.report.torques_json import torques_json
from robodyn.robot.load import load
from robodyn.scene.read import load_scene
from robodyn.scene.scene import DEFAULT
from robodyn.trajectory.read import open_trajectory, signals

CASES = [
    ("scara", "scara_pick_and_place", None),
    ("puma", "puma_encoder", None),
    ("gripper", "gripper_pick", "gripper"),
    ("puma", "puma_polish", "puma_polish"),
    ("puma560", "puma560_sweep", "puma560_sizing"),
]
BY_BLOCK = ("quadrature_error", "samples", "first_law", "second_law", "power", "largest_force", "largest_moment")
"""Keys of the checks that depend on which samples stand together."""


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


@pytest.mark.parametrize(("robot", "table", "scene"), CASES, ids=[case[1] for case in CASES])
@pytest.mark.parametrize("block_rows", sampled([30, 7, 100]))
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
