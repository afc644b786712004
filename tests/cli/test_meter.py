"""The progress of large meshes: a percentage and the time left on a terminal, nothing elsewhere."""

from __future__ import annotations

import json
import re
import sys

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_samples import binary_stl, box, moved, torus
from helpers.processes import environment
from helpers.terminals import on_terminal

from robodyn.cli.progress import Meter
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh import closed
from robodyn.solids.mesh.read.load import load_triangles


def two(body):
    """A body twice, apart: shells have to be told from each other."""
    return np.concatenate([body, moved(body, (9, 0, 0))])


@pytest.fixture
def files(tmp_path):
    """Two large tori and a box."""
    made = [tmp_path / name for name in ("large.stl", "box.stl", "other.stl")]
    for path, body in zip(made, (torus(2.0, 0.5, 220, 100), box(), torus(2.0, 0.5, 100, 50)), strict=True):
        path.write_bytes(binary_stl(body))
    return made


def test_a_bar_on_a_terminal_alone(files):
    names = [str(path) for path in files]
    code = "from robodyn.cli.main import main; main()"
    call = [sys.executable, "-I", "-c", code, "inertia", *names, "--format", "json"]
    shown, piped = on_terminal(call, stdout=False, stderr=True, **environment())
    plain = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown)
    assert re.search(r"measuring \S+ +\d+% [-0-9]:", plain)
    assert "100% 0:00:00" in plain
    assert json.loads(piped) == json.loads(run("inertia", *names, "--format", "json").out)
    assert on_terminal([*call[:5], names[1]], stdout=False, stderr=True)[0] == ""
    assert on_terminal([*call[:5], names[0]], stdout=True, stderr=False)[1] == ""


@pytest.mark.parametrize("held", [closed.HELD, 20_000])
def test_a_sound_mesh_fills_its_share(monkeypatch, files, held):
    monkeypatch.setattr(closed, "HELD", held)
    meter = Meter([path.stat().st_size for path in files])
    seen = []
    for path in files:
        before = meter.completed
        mass_properties(
            path, on_progress=lambda triangles: (meter.on_progress(triangles), seen.append(meter.completed))
        )
        size, count = path.stat().st_size, load_triangles(path).count
        share = min(0.99 * size, 50 * count) * (1 + closed.readings(count))
        assert meter.completed - before == pytest.approx(share)
        meter.done()
    assert seen == sorted(seen)
    assert meter.completed == meter.total


def test_other_files_come_all_at_once():
    meter = Meter([1000, 3000])
    meter.done()
    assert meter.completed == meter.total / 4


@pytest.mark.parametrize("rows", [7, 100])
def test_every_triangle_is_heard_of_once_a_reading(rows):
    told = []
    mesh = load_triangles(binary_stl(box()), on_progress=told.append)
    for reading in (mesh.records, mesh.blocks):
        told.clear()
        assert len(list(reading(rows))) == len(told)
        assert sum(told) == 12


def test_a_mesh_that_takes_longer_than_foreseen(tmp_path):
    path = tmp_path / "two.stl"
    path.write_bytes(binary_stl(two(torus(2.0, 0.5, 100, 50))))
    meter = Meter([path.stat().st_size, 500])
    late = []
    mass_properties(path, on_progress=lambda triangles: (meter.on_progress(triangles), late.append(meter.overdue)))
    assert late[0] is False
    assert late[-1] is True
    assert late == sorted(late)
    assert meter.completed == 0.99 * path.stat().st_size * (1 + closed.readings(20_000))
    meter.done()
    assert meter.overdue is False


def test_the_bar_of_a_mesh_that_takes_longer_shows_no_percentage(tmp_path):
    path = tmp_path / "two.stl"
    path.write_bytes(binary_stl(two(torus(2.0, 0.5, 300, 100))))
    code = "from robodyn.cli.main import main; main()"
    shown, _ = on_terminal([sys.executable, "-I", "-c", code, "inertia", str(path)], stdout=False, stderr=True)
    frames = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown)
    assert re.search(r"measuring \S+ +\r", frames)
    assert "100% 0:00:00" in frames
