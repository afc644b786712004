"""Where things are kept, and what happens where nothing can be."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import platformdirs
import pytest
from helpers.kept_files import CONTENT, KEY, OTHER, posix

from robodyn.support.cache import ObjectCache, cache_folder

not_as_root = pytest.mark.skipif(os.name == "nt" or os.getuid() == 0, reason="permissions do not bind this user")


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
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    assert cache_folder() == tmp_path
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("ROBODYN_CACHE", "~/here")
    assert cache_folder() == tmp_path / "here" or os.name == "nt"


def test_relative_folder_is_one_of_the_working_directory(monkeypatch, tmp_path):
    monkeypatch.setenv("ROBODYN_CACHE", "kept")
    monkeypatch.chdir(tmp_path)
    ObjectCache(cache_folder()).put(KEY, CONTENT)
    assert ObjectCache(tmp_path / "kept").get(KEY) == CONTENT


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


@pytest.mark.parametrize("answer", [_refuses, lambda *_, **__: "~/.cache/robodyn", lambda *_, **__: "relative"])
def test_user_without_a_home_keeps_nothing(monkeypatch, answer):
    monkeypatch.delenv("ROBODYN_CACHE")
    monkeypatch.setattr(platformdirs, "user_cache_dir", answer)
    assert cache_folder() is None


NOWHERE = {
    "a file": lambda folder: Path(__file__),
    "below a file": lambda folder: Path(__file__) / "below",
    "name too long": lambda folder: folder / ("x" * 300),
    "a link to itself": lambda folder: _loop(folder / "loop"),
    "where nobody may write": lambda folder: Path("/proc/robodyn"),
}


def _loop(path):
    path.symlink_to(path)
    return path


@posix
@pytest.mark.parametrize("place", NOWHERE)
def test_folder_that_cannot_be(place, tmp_path):
    objects = ObjectCache(NOWHERE[place](tmp_path))
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None


@not_as_root
def test_folder_that_is_read_only(tmp_path):
    tmp_path.chmod(0o500)
    objects = ObjectCache(tmp_path)
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None
    tmp_path.chmod(0o700)
    objects.put(KEY, CONTENT)
    (tmp_path / "objects").chmod(0o500)
    objects.put(OTHER, CONTENT)
    assert objects.get(KEY) == CONTENT
    assert objects.get(OTHER) is None


@not_as_root
def test_folder_that_may_not_be_entered(tmp_path):
    tmp_path.chmod(0)
    objects = ObjectCache(tmp_path)
    objects.put(KEY, CONTENT)
    assert objects.get(KEY) is None
    tmp_path.chmod(0o700)
