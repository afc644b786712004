"""Files are written whole or not at all, and what they replace keeps its place: mode, owner, links."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from robodyn.errors import InputError
from robodyn.support.files import whole_file, write_whole
from robodyn.trajectory.write import open_writer


def write_table(path: str, data: bytes) -> None:
    """A table by way of its writer; its content does not matter here."""
    with open_writer(path, [f"a{len(data)}"]) as writer:
        writer.write(np.arange(3.0), np.ones((3, 1)))


WAYS = pytest.mark.parametrize("write", [write_whole, write_table])
Write = Callable[[str, bytes], None]


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_new_and_old(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    for data in (b"one", b"two\r\n\x00"):
        write_whole(str(path), data)
        assert path.read_bytes() == data
    assert os.listdir(tmp_path) == ["a.urdf"]


@pytest.mark.parametrize("kept", [0o600, 0o640, 0o755])
@WAYS
def test_an_old_file_keeps_its_mode(tmp_path: Path, write: Write, kept: int) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    path.chmod(kept)
    write(str(path), b"new")
    assert path.read_bytes() != b"old"
    assert mode(path) == kept


def test_what_replaces_a_secret_is_never_open(tmp_path: Path) -> None:
    """Not even under its temporary name, while it is written."""
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    path.chmod(0o600)
    with whole_file(str(path)):
        assert [mode(each) for each in tmp_path.iterdir()] == [0o600, 0o600]


@WAYS
def test_a_new_file_has_the_mode_of_any_other(tmp_path: Path, write: Write) -> None:
    before = os.umask(0o027)
    try:
        write(str(tmp_path / "a.csv"), b"new")
    finally:
        os.umask(before)
    assert mode(tmp_path / "a.csv") == 0o640


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
@WAYS
def test_an_old_file_keeps_its_owner(tmp_path: Path, write: Write) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    os.chown(path, 1234, 5678)
    path.chmod(0o4750)
    write(str(path), b"new")
    found = path.stat()
    assert (found.st_uid, found.st_gid, mode(path)) == (1234, 5678, 0o4750)


@WAYS
def test_an_owner_that_cannot_be_kept_is_no_error(
    tmp_path: Path, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    path.chmod(0o600)

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "chown", refuse)
    write(str(path), b"new")
    assert (mode(path), path.read_bytes() == b"old") == (0o600, False)


@pytest.mark.parametrize("there", [True, False], ids=["whole", "dangling"])
@WAYS
def test_a_symbolic_link_is_written_through(tmp_path: Path, write: Write, there: bool) -> None:
    target, link = tmp_path / "folder" / "a.csv", tmp_path / "link.csv"
    target.parent.mkdir()
    if there:
        target.write_bytes(b"old")
        target.chmod(0o750)
    link.symlink_to(Path("folder", "a.csv"))
    write(str(link), b"new")
    assert link.is_symlink()
    assert target.read_bytes() != b"old"
    assert not there or mode(target) == 0o750
    assert os.listdir(target.parent) == ["a.csv"]


@WAYS
def test_links_in_a_circle(tmp_path: Path, write: Write) -> None:
    for name, other in (("a.csv", "b.csv"), ("b.csv", "a.csv")):
        (tmp_path / name).symlink_to(other)
    with pytest.raises(InputError, match="cannot be written: too many levels of symbolic links"):
        write(str(tmp_path / "a.csv"), b"new")
    assert sorted(os.listdir(tmp_path)) == ["a.csv", "b.csv"]


@WAYS
def test_another_hard_link_keeps_the_old_content(tmp_path: Path, write: Write) -> None:
    """The name gets a file of its own: nobody who reads by the other finds half of it."""
    path, other = tmp_path / "a.csv", tmp_path / "other.csv"
    other.write_bytes(b"old")
    path.hardlink_to(other)
    write(str(path), b"new")
    assert other.read_bytes() == b"old"
    assert path.read_bytes() != b"old"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
@WAYS
def test_a_pipe_is_written_to(tmp_path: Path, write: Write) -> None:
    path, found = tmp_path / "a.csv", []
    os.mkfifo(path)
    reader = Thread(target=lambda: found.append(path.read_bytes()))
    reader.start()
    write(str(path), b"new")
    reader.join()
    assert found[0]
    assert stat.S_ISFIFO(path.stat().st_mode)
    assert os.listdir(tmp_path) == ["a.csv"]


STREAM = """
import sys
from robodyn.support.files import write_whole
print("before", flush=True)
write_whole(sys.argv[1], b"whole\\n")
print("after")
"""


@pytest.mark.skipif(not os.path.exists("/dev/stdout"), reason="the system has no /dev/stdout")
@pytest.mark.parametrize("name", ["/dev/stdout", "link"])
def test_standard_output_is_written_to_in_its_order(tmp_path: Path, name: str) -> None:
    """Also where it goes to a file, which opened by its name would begin anew."""
    (tmp_path / "link").symlink_to("/dev/stdout")
    call = [sys.executable, "-c", STREAM, name]
    piped = subprocess.run(call, stdout=subprocess.PIPE, check=True, cwd=tmp_path).stdout
    with open(tmp_path / "out", "wb") as out:
        subprocess.run(call, stdout=out, check=True, cwd=tmp_path)
    assert piped == (tmp_path / "out").read_bytes() == b"before\nwhole\nafter\n"
    assert sorted(os.listdir(tmp_path)) == ["link", "out"]


KILLED = """
import os, signal, sys
from robodyn.support.files import whole_file
with whole_file(sys.argv[1]) as stream:
    stream.write(b"half")
    stream.flush()
    os.kill(os.getpid(), int(sys.argv[2]))
"""


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@WAYS
def test_what_a_killed_process_left_goes_with_the_next_write(tmp_path: Path, write: Write) -> None:
    """And nothing else: not what another file's writer left, nor what a user named alike."""
    path = tmp_path / "a.csv"
    for name in (path, tmp_path / "b.csv"):
        subprocess.run([sys.executable, "-c", KILLED, str(name), str(int(signal.SIGKILL))], check=False)
    (tmp_path / "a.csv.notes.part").touch()
    assert [Path(name).suffix for name in sorted(os.listdir(tmp_path))] == [".part"] * 3
    write(str(path), b"new")
    left = sorted(os.listdir(tmp_path))
    assert left[:2] == ["a.csv", "a.csv.notes.part"]
    assert [name.partition(".csv.")[0] for name in left[2:]] == ["b"]


BATCH = """
import os, signal, sys
from unittest import mock
from robodyn.cli.main import main
from robodyn.support.files import whole_file
def killed(*_, **__):
    with whole_file("a.csv") as stream:
        stream.write(b"half")
        stream.flush()
        os.kill(os.getpid(), int(sys.argv[1]))
with mock.patch("robodyn.cli.main.robodyn.main", killed):
    main()
"""


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_process_that_is_asked_to_end_leaves_nothing(tmp_path: Path, number: signal.Signals) -> None:
    """A terminal that is closed asks so, too."""
    done = subprocess.run([sys.executable, "-c", BATCH, str(int(number))], cwd=tmp_path, check=False)
    assert done.returncode == 128 + number
    assert not os.listdir(tmp_path)


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@WAYS
def test_the_part_of_another_process_stays_while_that_writes(tmp_path: Path, write: Write) -> None:
    path = tmp_path / "a.csv"
    slow = KILLED.replace("os.kill(os.getpid(), int(sys.argv[2]))", "print('written', flush=True), sys.stdin.read()")
    with subprocess.Popen(
        [sys.executable, "-c", slow, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        write(str(path), b"quick")
        assert len(os.listdir(tmp_path)) == 2
        other.communicate()
    assert other.returncode == 0
    assert path.read_bytes() == b"half"
    assert os.listdir(tmp_path) == ["a.csv"]


@WAYS
def test_two_that_write_the_same_file_do_not_disturb_each_other(tmp_path: Path, write: Write) -> None:
    """Who is still writing loses nothing to the other; the last to end has its way."""
    path = tmp_path / "a.csv"
    with whole_file(str(path)) as stream:
        stream.write(b"slow")
        stream.flush()
        write(str(path), b"quick")
        assert len(os.listdir(tmp_path)) == 2
        write(str(path), b"quick")
    assert path.read_bytes() == b"slow"
    assert os.listdir(tmp_path) == ["a.csv"]


def test_under_windows_a_file_that_is_open_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """There are no locks; the system keeps others from removing it."""
    monkeypatch.setattr("robodyn.support.files._WINDOWS", True)
    parts = [tmp_path / f"a.csv.{number}a1b2c3d.part" for number in (0, 1)]
    for part in parts:
        part.touch()
    unlink = os.unlink

    def refuse(path: str) -> None:
        if path == str(parts[1]):
            raise PermissionError(13, "The process cannot access the file because it is being used by another process")
        unlink(path)

    monkeypatch.setattr(os, "unlink", refuse)
    write_whole(str(tmp_path / "a.csv"), b"new")
    assert sorted(os.listdir(tmp_path)) == ["a.csv", parts[1].name]


def test_where_files_cannot_be_locked_nothing_of_others_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on some file systems of a network."""
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(fcntl, "flock", refuse)
    part = tmp_path / "a.csv.0a1b2c3d.part"
    part.touch()
    write_whole(str(tmp_path / "a.csv"), b"new")
    assert sorted(os.listdir(tmp_path)) == ["a.csv", part.name]


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
