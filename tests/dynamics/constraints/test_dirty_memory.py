"""Closed chains of two and three samples: whatever stood in memory before, torques are those of virtual work."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.dirty_memory import soil
from helpers.driven_chains import MIDDLE, SCENES, moving
from helpers.processes import python

import robodyn

TESTS = Path(__file__).parents[2]
FREED = "255"
"""What glibc fills freed memory with: every number in it is not a number."""


def check(name: str, samples: int, seed: int) -> None:
    """Compare the drives of a chain with virtual work."""
    chain = moving(name, samples, seed)
    tau = robodyn.inverse_dynamics(chain.model, *chain.state, scene=chain.scene)
    np.testing.assert_allclose(tau, chain.torques, rtol=0, atol=1e-13 * np.abs(chain.torques).max())


@pytest.mark.parametrize("samples", [2, 3])
@pytest.mark.parametrize("name", MIDDLE)
def test_what_stood_in_memory_is_in_no_torque(name, samples, monkeypatch):
    soil(monkeypatch)
    for seed in range(5):
        check(name, samples, seed)


def cut(name: str, samples: int, folder: Path) -> Path:
    """Write some rows of a table of robots/ that are not its first."""
    head, *rows = (ROBOTS / f"{SCENES[name]}.csv").read_text().splitlines()
    path = folder / f"{name}_{samples}.csv"
    path.write_text("\n".join([head, *rows[57 : 57 + samples]]) + "\n")
    return path


def peaks(tables: dict[str, list[str]]) -> dict[str, list[float]]:
    """Return what `torques` finds along tables of each chain."""
    found = {}
    for name, paths in tables.items():
        model, scene = robodyn.load(ROBOTS / f"{name}.urdf"), robodyn.load_scene(ROBOTS / f"{SCENES[name]}.toml")
        for path in paths:
            found[path] = [joint.peak for joint in robodyn.torques(model, path, scene=scene).joints]
    return found


def test_tables_of_few_samples_in_a_child_whose_memory_is_filled(tmp_path, monkeypatch):
    """Malloc's own debugging fills what the child frees; what it prints is what this process finds."""
    tables = {name: [str(cut(name, samples, tmp_path)) for samples in (2, 3)] for name in SCENES}
    code = f"""
import sys, json
sys.path[:0] = [{str(TESTS)!r}, {str(Path(__file__).parent)!r}]
from test_dirty_memory import MIDDLE, check, peaks
for name in MIDDLE:
    for samples in (2, 3):
        for seed in range(5):
            check(name, samples, seed)
print(json.dumps(peaks(json.loads(sys.stdin.read()))))
"""
    done = python(code, json.dumps(tables), MALLOC_PERTURB_=FREED)
    soil(monkeypatch)
    assert json.loads(done.stdout) == peaks(tables)
    assert all(np.isfinite(values).all() for values in json.loads(done.stdout).values())
