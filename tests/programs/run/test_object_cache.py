"""What is kept in the user's cache folder: written whole or not at all, and ignored unless it is intact and his own."""

from __future__ import annotations

import os
import random
import shutil
import stat
from pathlib import Path

import pytest
from helpers.kept_files import CONTENT, KEY, OTHER, files, posix, the_file

from robodyn.support.cache import MARK, Key, ObjectCache, in_profile

as_root = pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root gives files away")


@pytest.fixture
def objects(tmp_path):
    return ObjectCache(tmp_path)


def test_round_trip(objects):
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    objects.put(OTHER, b"")
    assert objects.get(KEY) == CONTENT
    assert objects.get(OTHER) == b""


@pytest.mark.parametrize("part", Key._fields)
def test_every_part_of_the_key_counts(objects, part):
    objects.put(KEY, CONTENT)
    assert objects.get(KEY._replace(**{part: "something else"})) is None


def test_only_this_user_reads_what_is_kept(objects, tmp_path):
    objects.put(KEY, CONTENT)
    path = the_file(tmp_path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def _flip(place):
    def flipped(data):
        return data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]

    return flipped


DAMAGE = {
    "empty": lambda data: b"",
    "garbage": lambda data: random.Random(1).randbytes(len(data)),
    "half": lambda data: data[: len(data) // 2],
    "last byte lost": lambda data: data[:-1],
    "a byte more": lambda data: data + b"\0",
    "head alone": lambda data: data[: len(MARK) + 32],
    "bit of the mark": _flip(0),
    "bit of the digest": _flip(len(MARK) + 7),
    "first bit of the body": _flip(len(MARK) + 32),
    "last bit of the body": _flip(-1 + len(MARK) + 32 + len(CONTENT)),
    "twice": lambda data: data + data,
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_ignored_and_written_again(objects, tmp_path, damage):
    objects.put(KEY, CONTENT)
    path = the_file(tmp_path)
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == CONTENT


def test_file_of_another_key_is_ignored_and_written_again(objects, tmp_path):
    objects.put(KEY, CONTENT)
    mine = the_file(tmp_path)
    objects.put(OTHER, CONTENT[:100])
    (others,) = set(files(tmp_path)) - {mine}
    shutil.copy(others, mine)
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == CONTENT


REPLACEMENTS = {
    "a folder": Path.mkdir,
    "a dangling link": lambda path: path.symlink_to("nowhere"),
    "a link to itself": lambda path: path.symlink_to(path.name),
    "a pipe": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
}


@posix
@pytest.mark.parametrize("replacement", REPLACEMENTS)
def test_what_is_no_file_is_ignored(objects, tmp_path, replacement):
    objects.put(KEY, CONTENT)
    path = the_file(tmp_path)
    path.unlink()
    REPLACEMENTS[replacement](path)
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == (None if replacement == "a folder" else CONTENT)
    assert not list(tmp_path.rglob("*.part"))


@posix
def test_pipe_that_somebody_holds_open_is_not_waited_for(objects, tmp_path):
    objects.put(KEY, CONTENT)
    path = the_file(tmp_path)
    path.unlink()
    os.mkfifo(path, 0o600)
    other_end = os.open(path, os.O_RDWR)
    assert objects.get(KEY) is None
    os.close(other_end)


@posix
@pytest.mark.parametrize("mode", [0o602, 0o620, 0o666])
def test_files_that_others_may_write_to_are_ignored(objects, tmp_path, mode):
    objects.put(KEY, CONTENT)
    the_file(tmp_path).chmod(mode)
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == CONTENT


@posix
@pytest.mark.parametrize("mode", [0o702, 0o720, 0o777, 0o1777])
def test_folders_that_others_may_write_to_are_ignored(objects, tmp_path, mode):
    objects.put(KEY, CONTENT)
    the_file(tmp_path).parent.chmod(mode)
    before = the_file(tmp_path).read_bytes()
    assert objects.get(KEY) is None
    objects.put(KEY, b"new")
    assert the_file(tmp_path).read_bytes() == before


@posix
def test_what_belongs_to_another_user_is_ignored(objects, tmp_path, monkeypatch):
    objects.put(KEY, CONTENT)
    before = the_file(tmp_path).read_bytes()
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    assert objects.get(KEY) is None
    objects.put(KEY, b"new")
    assert the_file(tmp_path).read_bytes() == before


@as_root
def test_file_of_another_user_is_ignored_and_written_again(objects, tmp_path):
    objects.put(KEY, CONTENT)
    os.chown(the_file(tmp_path), 4321, -1)
    assert objects.get(KEY) is None
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) == CONTENT


@posix
def test_loose_umask_and_open_parents_keep_nothing_from_working(tmp_path):
    tmp_path.chmod(0o777)
    mask = os.umask(0)
    try:
        ObjectCache(tmp_path / "deep" / "deeper").put(KEY, CONTENT)
    finally:
        os.umask(mask)
    assert ObjectCache(tmp_path / "deep" / "deeper").get(KEY) == CONTENT


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


def test_without_a_home_nothing_is_trusted(tmp_path, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", homeless)
    assert not in_profile(tmp_path)
