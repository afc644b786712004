"""Files are written whole or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from robodyn.errors import InputError
from robodyn.whole_file import write_whole


def test_new_and_old(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    for data in (b"one", b"two\r\n\x00"):
        write_whole(str(path), data)
        assert path.read_bytes() == data
    assert os.listdir(tmp_path) == ["a.urdf"]


def test_mode_and_links_stay(tmp_path: Path) -> None:
    path, link = tmp_path / "a.urdf", tmp_path / "link.urdf"
    path.write_bytes(b"one")
    path.chmod(0o750)
    link.symlink_to("a.urdf")
    write_whole(str(link), b"two")
    assert link.is_symlink()
    assert path.read_bytes() == b"two"
    assert stat.S_IMODE(path.stat().st_mode) == 0o750


@pytest.mark.parametrize("name", ["none/a.urdf", "", "a\0b", "folder"])
def test_what_cannot_be_written(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match=r"cannot be written: .*nothing was written"):
        write_whole(str(tmp_path / name), b"x")
    assert os.listdir(tmp_path) == ["folder"]


@pytest.mark.parametrize(
    ("problem", "raised", "words"),
    [
        (OSError(28, "No space left on device"), InputError, "no space left on device"),
        (KeyboardInterrupt("stop"), KeyboardInterrupt, "stop"),
    ],
)
def test_a_failure_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, problem: BaseException, raised: type[BaseException], words: str
) -> None:
    path = tmp_path / "a.urdf"
    path.write_bytes(b"one")

    def fails(*_: object) -> None:
        raise problem

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises(raised, match=words):
        write_whole(str(path), b"two")
    assert path.read_bytes() == b"one"
    assert os.listdir(tmp_path) == ["a.urdf"]
