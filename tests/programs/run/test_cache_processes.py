"""The cache of several processes at once, of processes that are killed, and of disks that are full."""

from __future__ import annotations

import errno
import os
import random
import subprocess
import sys
import time

import pytest
from helpers.kept_files import KEY, files
from helpers.processes import environment, python

from robodyn.support.cache import FORGOTTEN, ObjectCache

WRITER = """
import sys
from pathlib import Path
from robodyn.support.cache import Key, ObjectCache
objects, contents = ObjectCache(Path(sys.argv[1])), [bytes([k]) * 2_000_000 for k in range(4)]
print("ready", flush=True)
while True:
    for content in contents:
        objects.put(Key("a program", "a machine"), content)
"""


@pytest.mark.skipif(os.name == "nt", reason="a file that is open elsewhere is not replaced there")
def test_process_killed_while_it_writes(tmp_path):
    objects = ObjectCache(tmp_path)
    chance = random.Random(5)
    torn = 0
    for _ in range(20):
        child = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE, env=environment()
        )
        with child:
            assert child.stdout.readline() == b"ready\n"
            time.sleep(chance.uniform(0.0, 0.03))
            child.kill()
        whole = [path for path in files(tmp_path) if path.suffix != ".part"]
        content = objects.get(KEY)
        assert content is None if not whole else len(set(content)) == 1 and len(content) == 2_000_000
        torn += len(files(tmp_path)) - len(whole)
    assert torn > 0, "no process was killed while it wrote"
    for path in tmp_path.rglob("*.part"):
        os.utime(path, (time.time() - 2 * FORGOTTEN,) * 2)
    objects.put(KEY, b"new")
    assert not list(tmp_path.rglob("*.part"))


BUILDER = """
import hashlib
import numpy as np
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.program import trace
x = np.linspace(-3.0, 3.0, 1000)[:, None]
run = CompiledBlocks(trace(lambda tape: [tape.input("x", 0).sin() * 0.3 + 1.7]), {"x": 1})
print(hashlib.sha256(run({"x": x}, len(x)).tobytes()).hexdigest())
"""
SMALL_FILES = (
    "import resource, sys; sys.dont_write_bytecode = True; "
    "resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))"
)
"""As on a disk that fills up: no file grows beyond 100 bytes."""


def test_many_processes_at_once(tmp_path):
    pytest.importorskip("llvmlite")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": environment(ROBODYN_CACHE=tmp_path)}
    children = [subprocess.Popen([sys.executable, "-c", BUILDER], text=True, **pipes) for _ in range(8)]
    ends = [(*child.communicate(), child.returncode) for child in children]
    assert set(ends) == {(ends[0][0], "", 0)}
    assert len(ends[0][0]) == 65
    assert len(files(tmp_path)) == 2, "the program, and what drives it"


def test_nothing_is_lost_or_said_where_nothing_can_be_kept(tmp_path):
    pytest.importorskip("llvmlite")
    expected = python(BUILDER, ROBODYN_CACHE=tmp_path / "kept").stdout
    (tmp_path / "file").touch()
    homeless = {"ROBODYN_CACHE": None, "XDG_CACHE_HOME": None, "HOME": "/proc"}
    for changes in ({"ROBODYN_CACHE": 0}, {"ROBODYN_CACHE": tmp_path / "file"}, homeless):
        done = python(BUILDER, **changes)
        assert (done.stdout, done.stderr) == (expected, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "kept"]


@pytest.mark.skipif(os.name == "nt", reason="limits of files are those of POSIX")
def test_nothing_is_lost_or_said_where_the_disk_is_full(tmp_path):
    pytest.importorskip("llvmlite")
    expected = python(BUILDER, ROBODYN_CACHE=tmp_path / "kept").stdout
    done = python(SMALL_FILES + BUILDER, ROBODYN_CACHE=tmp_path / "full")
    assert (done.stdout, done.stderr) == (expected, "")
    assert not files(tmp_path / "full")


def test_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    objects = ObjectCache(tmp_path)
    objects.put(KEY, b"old")

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    objects.put(KEY, b"new")
    assert objects.get(KEY) == b"old"
    assert len(files(tmp_path)) == 1


def test_interrupted_write_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ObjectCache(tmp_path).put(KEY, b"new")
    assert not files(tmp_path)
