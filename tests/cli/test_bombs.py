"""Small files that ask for much are refused with one line, within a minute of processor and 500 MB."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.bombs import MOST, TABLES, TOML, WAIVERS, Bounded, bounded
from helpers.command_line import write_arm

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs limits of the system")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path) -> None:
    write_arm(tmp_path)


def refused(outcome: Bounded, name: str) -> None:
    assert outcome.status == 2, outcome
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.startswith(f"error: {name}"), outcome.err
    assert "out of memory" not in outcome.err
    assert outcome.memory < MOST, f"{outcome.memory >> 20} MB: {outcome.err}"


@pytest.mark.parametrize("name", TABLES)
def test_tables(name: str, tmp_path: Path) -> None:
    TABLES[name](tmp_path / name)
    outcome = bounded("torques", "arm.urdf", name, cwd=tmp_path)
    refused(outcome, name)


@pytest.mark.parametrize("name", TOML)
def test_scenes_and_settings(name: str, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_bytes(TOML[name])
    refused(bounded("torques", "arm.urdf", "arm.csv", "--scene", "x.toml", cwd=tmp_path), "x.toml")
    (tmp_path / "robodyn.toml").write_bytes(TOML[name])
    refused(bounded("check", "arm.urdf", cwd=tmp_path), "")
    (tmp_path / "robodyn.toml").unlink()
    refused(bounded("torques", "arm.urdf", "arm.csv", "--map", "x.toml", cwd=tmp_path), "invalid value for '--map'")


def test_settings_of_others(tmp_path: Path) -> None:
    """A pyproject.toml that does not name us is none of our business."""
    (tmp_path / "pyproject.toml").write_bytes(TOML["keys"])
    assert bounded("check", "arm.urdf", cwd=tmp_path).status == 0


@pytest.mark.parametrize("command", ["check", "info"])
def test_waivers_on_one_line(command: str, tmp_path: Path) -> None:
    """Time grows with their number, not with its square."""
    (tmp_path / "r.urdf").write_text(WAIVERS)
    outcome = bounded(command, "r.urdf", cwd=tmp_path)
    assert outcome.status == 0, outcome.err[:500]
    assert outcome.memory < MOST
