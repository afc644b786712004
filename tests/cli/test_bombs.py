"""Small files that ask for much are refused with one line, within a minute of processor and 500 MB."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.bombs import FEWER, MOST, TABLES, TOML, WAIVERS, Bounded, Command, bounded_commands, write_bomb
from helpers.command_line import write_arm
from helpers.sampled import sampled

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs limits of the system")
COUNTED = {"values.yaml", "documents.yaml", "records.mcap", "lines.csv", "publishers.json", "values.json"}
"""What is refused only after much of it is counted: by default beyond fewer, some under `slow` beyond the usual."""
USES = [(name, use) for use in ("scene", "settings", "map") for name in TOML]
OFTEN = [pytest.param(*each, marks=[pytest.mark.slow] * (each[1] != "scene" and each[0] != "keys")) for each in USES]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path) -> None:
    write_arm(tmp_path)


@pytest.fixture(scope="module")
def bounded() -> Iterator[Command]:
    with bounded_commands() as run:
        yield run


def refused(outcome: Bounded, name: str) -> None:
    assert outcome.status == 2, outcome
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.startswith(f"error: {name}"), outcome.err
    assert "out of memory" not in outcome.err
    assert outcome.memory < MOST, f"{outcome.memory >> 20} MB: {outcome.err}"


@pytest.mark.parametrize("name", sampled(TABLES, 4))
def test_tables(name: str, tmp_path: Path, bounded: Command) -> None:
    write_bomb(tmp_path / name)
    refused(bounded("torques", "arm.urdf", name, cwd=tmp_path, limits=FEWER if name in COUNTED else ""), name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["values.json", "values.yaml", "lines.csv"])
def test_tables_beyond_the_usual_limits(name: str, tmp_path: Path, bounded: Command) -> None:
    write_bomb(tmp_path / name)
    refused(bounded("torques", "arm.urdf", name, cwd=tmp_path), name)


@pytest.mark.parametrize(("name", "use"), sampled(OFTEN, 3))
def test_scenes_and_settings(name: str, use: str, tmp_path: Path, bounded: Command) -> None:
    (tmp_path / ("robodyn.toml" if use == "settings" else "x.toml")).write_bytes(TOML[name])
    if use == "settings":
        refused(bounded("check", "arm.urdf", cwd=tmp_path), "")
    else:
        said = {"scene": "x.toml", "map": "invalid value for '--map'"}[use]
        refused(bounded("torques", "arm.urdf", "arm.csv", f"--{use}", "x.toml", cwd=tmp_path), said)


def test_settings_of_others(tmp_path: Path, bounded: Command) -> None:
    """A pyproject.toml that does not name us is none of our business."""
    (tmp_path / "pyproject.toml").write_bytes(TOML["keys"])
    assert bounded("check", "arm.urdf", cwd=tmp_path).status == 0


@pytest.mark.slow
def test_waivers_on_one_line(tmp_path: Path, bounded: Command) -> None:
    """Time grows with their number, not with its square."""
    (tmp_path / "r.urdf").write_text(WAIVERS)
    outcome = bounded("check", "r.urdf", cwd=tmp_path)
    assert outcome.status == 0, outcome.err[:500]
    assert outcome.memory < MOST
