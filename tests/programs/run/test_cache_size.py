"""What is removed from the cache, and what never is."""

from __future__ import annotations

import os
import time

import pytest
from helpers.kept_files import CONTENT, KEY, OTHER, files, the_file

from robodyn.support.cache import FORGOTTEN, Key, ObjectCache


@pytest.mark.parametrize(("age", "left"), [(0.5 * FORGOTTEN, True), (2.0 * FORGOTTEN, False)])
def test_files_never_finished_are_removed_once_nobody_can_be_at_work_on_them(tmp_path, age, left):
    objects = ObjectCache(tmp_path)
    objects.put(KEY, CONTENT)
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


def test_file_larger_than_all_that_may_be_kept(tmp_path):
    objects = ObjectCache(tmp_path, largest=1000)
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None
    assert not files(tmp_path)


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


def test_what_cannot_be_removed_keeps_nothing_else(tmp_path):
    _put_an_hour_apart(tmp_path, KEYS)
    oldest, newest = (pick(files(tmp_path), key=lambda path: path.stat().st_mtime) for pick in (min, max))
    newest.unlink()
    newest.mkdir()
    ObjectCache(tmp_path, largest=0).put(KEY, CONTENT)
    assert not oldest.exists()
