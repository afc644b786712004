"""What is kept in the user's cache folder: written whole or not at all, where, how much, by several at once."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import platformdirs
import pytest
from helpers.processes import environment, python

from robodyn.support.cache import FORGOTTEN, MARK, Key, ObjectCache, cache_folder

KEY, OTHER = Key("a program", "a machine"), Key("another program", "a machine")
CONTENT = bytes(range(256)) * 20
posix = pytest.mark.skipif(os.name == "nt", reason="owners, permissions, links and pipes are those of POSIX")


def files(folder):
    return sorted(path for path in Path(folder).rglob("*") if path.is_file())


def the_file(folder):
    (path,) = files(folder)
    return path


@pytest.fixture
def objects(tmp_path):
    """A cache that holds one thing."""
    kept = ObjectCache(tmp_path)
    assert kept.get(KEY) is None
    kept.put(KEY, CONTENT)
    assert kept.get(KEY) == CONTENT
    return kept


def put_again(objects):
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == CONTENT


@pytest.mark.parametrize("part", Key._fields)
def test_every_part_of_the_key_counts(objects, part):
    assert objects.get(KEY._replace(**{part: "something else"})) is None


def test_only_this_user_reads_what_is_kept(objects, tmp_path):
    path = the_file(tmp_path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def _flip(place):
    return lambda data: data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]


DAMAGE = {
    "empty": lambda data: b"",
    "head alone": lambda data: data[: len(MARK) + 32],
    "bit of the digest": _flip(len(MARK) + 7),
    "last bit of the body": _flip(-1 + len(MARK) + 32 + len(CONTENT)),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_ignored_and_written_again(objects, tmp_path, damage):
    path = the_file(tmp_path)
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    put_again(objects)


REPLACEMENTS = {
    "a folder": Path.mkdir,
    "a link to itself": lambda path: path.symlink_to(path.name),
    "a pipe": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
}


@posix
@pytest.mark.parametrize("replacement", REPLACEMENTS)
def test_what_is_no_file_is_ignored(objects, tmp_path, replacement):
    path = the_file(tmp_path)
    path.unlink()
    REPLACEMENTS[replacement](path)
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == (None if replacement == "a folder" else CONTENT)
    assert not list(tmp_path.rglob("*.part"))


@posix
@pytest.mark.parametrize("mode", [0o602, 0o620])
def test_what_others_may_write_to_is_ignored(objects, tmp_path, mode):
    the_file(tmp_path).chmod(mode)
    put_again(objects)
    before = the_file(tmp_path).read_bytes()
    the_file(tmp_path).parent.chmod(mode | 0o100)
    assert objects.get(KEY) is None
    objects.put(KEY, b"new")
    assert the_file(tmp_path).read_bytes() == before


@posix
def test_folders_of_others_are_ignored(objects, tmp_path, monkeypatch):
    before = the_file(tmp_path).read_bytes()
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    assert objects.get(KEY) is None
    objects.put(KEY, b"new")
    assert the_file(tmp_path).read_bytes() == before


@posix
@pytest.mark.parametrize("inside", [True, False])
def test_without_owners_only_the_users_own_folder_is_trusted(tmp_path, monkeypatch, inside):
    """As under Windows, where anybody may have written to a folder elsewhere; a link into it is elsewhere too."""
    home, shared = tmp_path / "home", tmp_path / "shared"
    home.mkdir()
    shared.mkdir()
    (home / "link").symlink_to(shared)
    for folder in (shared, home / "kept"):
        ObjectCache(folder).put(KEY, CONTENT)
    monkeypatch.delattr(os, "getuid")
    monkeypatch.setattr(Path, "home", lambda: home)
    for folder in [home / "kept"] if inside else [shared, home / "link"]:
        assert ObjectCache(folder).get(KEY) == (CONTENT if inside else None)
        ObjectCache(folder).put(KEY, b"new")
        assert ObjectCache(folder).get(KEY) == (b"new" if inside else None)
    assert the_file(shared).read_bytes().endswith(CONTENT)


@pytest.mark.parametrize("named", ["0", ""])
def test_cache_that_is_switched_off(monkeypatch, named, tmp_path):
    monkeypatch.setenv("ROBODYN_CACHE", named)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() is None
    objects = ObjectCache(cache_folder())
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None
    assert not list(tmp_path.iterdir())


def test_folder_that_the_user_names(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for named, folder in ((str(tmp_path), tmp_path), ("~/here", tmp_path / "here"), ("kept", Path("kept"))):
        monkeypatch.setenv("ROBODYN_CACHE", named)
        assert cache_folder().absolute() == folder.absolute() or (named[0] == "~" and os.name == "nt")


@pytest.mark.skipif(sys.platform != "linux", reason="the XDG folders are those of Linux")
def test_folder_of_the_user(monkeypatch, tmp_path):
    monkeypatch.delenv("ROBODYN_CACHE")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert cache_folder() == tmp_path / "home" / ".cache" / "robodyn"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "robodyn"
    ObjectCache(cache_folder()).put(KEY, CONTENT)
    assert ObjectCache(tmp_path / "xdg" / "robodyn").get(KEY) == CONTENT


def _refuses(*_, **__):
    raise RuntimeError("could not determine the home directory")


@pytest.mark.parametrize("answer", [_refuses, lambda *_, **__: "~/.cache/robodyn"])
def test_user_without_a_home_keeps_nothing(monkeypatch, answer):
    monkeypatch.delenv("ROBODYN_CACHE")
    monkeypatch.setattr(platformdirs, "user_cache_dir", answer)
    assert cache_folder() is None


@posix
@pytest.mark.parametrize("folder", [Path(__file__), Path(__file__) / "below", Path("x" * 300), Path("/proc/robodyn")])
def test_folder_that_cannot_be(folder):
    objects = ObjectCache(folder)
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None


@pytest.mark.parametrize(("age", "left"), [(0.5 * FORGOTTEN, True), (2.0 * FORGOTTEN, False)])
def test_files_never_finished_are_removed_once_nobody_can_be_at_work_on_them(objects, tmp_path, age, left):
    part = the_file(tmp_path).with_name(f"{the_file(tmp_path).name}.0a1b.part")
    part.write_bytes(b"half")
    os.utime(part, (time.time() - age,) * 2)
    objects.put(OTHER, CONTENT)
    assert part.exists() == left
    assert objects.get(KEY) == CONTENT


def _put_an_hour_apart(folder, keys):
    for k, key in enumerate(keys):
        ObjectCache(folder).put(key, CONTENT)
        newest = max(files(folder), key=lambda path: path.stat().st_mtime)
        os.utime(newest, (1e9 + 3600 * k,) * 2)


KEYS = [Key(f"program {k}", "a machine") for k in range(6)]


def test_files_used_longest_ago_go_first(tmp_path):
    _put_an_hour_apart(tmp_path, KEYS)
    size = files(tmp_path)[0].stat().st_size
    objects = ObjectCache(tmp_path, largest=4 * size)
    assert objects.get(KEYS[1]) == CONTENT  # used just now
    objects.put(KEY, CONTENT)
    assert [objects.get(key) is not None for key in KEYS] == [False, True, False, False, True, True]
    assert objects.get(KEY) == CONTENT


def test_files_of_the_user_are_never_removed(tmp_path):
    """Whatever folder the user names, and whatever else lies there."""
    objects = ObjectCache(tmp_path, largest=0)
    objects.put(KEY, CONTENT)
    mine = [tmp_path / "thesis.tex", tmp_path / "objects" / "thesis.part", tmp_path / "objects" / ("a" * 65)]
    for path in mine:
        path.write_bytes(CONTENT)
        os.utime(path, (1e9, 1e9))
    (tmp_path / "objects" / "folder").mkdir()
    objects.put(KEY, CONTENT)
    assert [path for path in mine if path.exists()] == mine


BUILDER = """
import hashlib
import numpy as np
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.program import trace
x = np.linspace(-3.0, 3.0, 1000)[:, None]
run = CompiledBlocks(trace(lambda tape: [tape.input("x", 0).sin() * 0.3 + 1.7]), {"x": 1})
print(hashlib.sha256(run({"x": x}, len(x)).tobytes()).hexdigest())
"""


def test_many_processes_at_once(tmp_path):
    pytest.importorskip("llvmlite")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": environment(ROBODYN_CACHE=tmp_path)}
    children = [subprocess.Popen([sys.executable, "-c", BUILDER], text=True, **pipes) for _ in range(3)]
    ends = [(*child.communicate(), child.returncode) for child in children]
    assert set(ends) == {(ends[0][0], "", 0)}
    assert len(ends[0][0]) == 65
    assert len(files(tmp_path)) == 2, "the program, and what drives it"


def test_nothing_is_lost_or_said_where_nothing_can_be_kept(tmp_path):
    """No home, or a disk that is full: no file grows beyond 100 bytes."""
    pytest.importorskip("llvmlite")
    homeless = python(BUILDER, ROBODYN_CACHE=None, XDG_CACHE_HOME=None, HOME="/proc")
    assert (len(homeless.stdout), homeless.stderr) == (65, "")
    if os.name != "nt":
        small = "import resource, sys; sys.dont_write_bytecode = True; "
        small += "resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))"
        done = python(small + BUILDER, ROBODYN_CACHE=tmp_path)
        assert (done.stdout, done.stderr) == (homeless.stdout, "")
        assert not files(tmp_path)


@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_full_disk_or_interruption_leaves_what_was_there(objects, tmp_path, monkeypatch, failure):
    def failing(*_):
        raise failure

    monkeypatch.setattr(os, "replace", failing)
    if isinstance(failure, OSError):
        objects.put(KEY, b"new")
    else:
        with pytest.raises(KeyboardInterrupt):
            objects.put(KEY, b"new")
    assert objects.get(KEY) == CONTENT
    assert len(files(tmp_path)) == 1
