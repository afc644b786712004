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
from unittest import mock

import numpy as np
import pytest

from robodyn.errors import InputError
from robodyn.support.files import whole_file, write_whole
from robodyn.trajectory.write import open_writer

STREAM = """
import sys
from robodyn.support.files import write_whole
print("before", flush=True)
write_whole(sys.argv[1], b"whole\\n")
print("after")
"""
KILLED = """
import os, signal, sys
from robodyn.support.files import whole_file
with whole_file(sys.argv[1]) as stream:
    stream.write(b"half")
    stream.flush()
    os.kill(os.getpid(), int(sys.argv[2]))
"""


def write_table(path: str, data: bytes) -> None:
    """A table by way of its writer; its content does not matter here."""
    with open_writer(path, [f"a{len(data)}"]) as writer:
        writer.write(np.arange(3.0), np.ones((3, 1)))


WAYS = pytest.mark.parametrize("write", [write_whole, write_table])
Write = Callable[[str, bytes], None]


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("kept", [0o600, 0o755])
def test_an_old_file_keeps_its_mode(tmp_path: Path, kept: int) -> None:
    """Also under its temporary name, while it is written."""
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    path.chmod(kept)
    with whole_file(str(path)) as stream:
        assert {mode(each) for each in tmp_path.iterdir()} <= {kept, 0o600}
        stream.write(b"two\r\n\x00")
    assert (path.read_bytes(), mode(path)) == (b"two\r\n\x00", kept)


def test_a_new_file_has_the_mode_of_any_other(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_whole(str(tmp_path / "a.csv"), b"new")
    finally:
        os.umask(before)
    assert mode(tmp_path / "a.csv") == 0o640


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
def test_an_old_file_keeps_its_owner(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    os.chown(path, 1234, 5678)
    path.chmod(0o4750)
    write_whole(str(path), b"new")
    found = path.stat()
    assert (found.st_uid, found.st_gid, mode(path)) == (1234, 5678, 0o4750)


@WAYS
def test_a_symbolic_link_is_written_through(tmp_path: Path, write: Write) -> None:
    """Also one that leads to nothing yet."""
    link = tmp_path / "link.csv"
    (tmp_path / "folder").mkdir()
    link.symlink_to(Path("folder", "a.csv"))
    contents = set()
    for data in (b"one", b"second"):
        write(str(link), data)
        assert link.is_symlink()
        assert os.listdir(tmp_path / "folder") == ["a.csv"]
        contents.add(link.read_bytes())
    assert len(contents) == 2


def test_another_hard_link_keeps_the_old_content(tmp_path: Path) -> None:
    """The name gets a file of its own: nobody who reads by the other finds half of it."""
    path, other = tmp_path / "a.csv", tmp_path / "other.csv"
    other.write_bytes(b"old")
    path.hardlink_to(other)
    write_whole(str(path), b"new")
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


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_what_a_killed_process_left_goes_with_the_next_write(tmp_path: Path) -> None:
    """And nothing else: not what another file's writer left, nor what a user named alike."""
    path = tmp_path / "a.csv"
    for name in (path, tmp_path / "b.csv"):
        subprocess.run([sys.executable, "-c", KILLED, str(name), str(int(signal.SIGKILL))], check=False)
    (tmp_path / "a.csv.notes.part").touch()
    assert [Path(name).suffix for name in sorted(os.listdir(tmp_path))] == [".part"] * 3
    write_whole(str(path), b"new")
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
def test_the_part_of_another_process_stays_while_that_writes(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    slow = KILLED.replace("os.kill(os.getpid(), int(sys.argv[2]))", "print('written', flush=True), sys.stdin.read()")
    with subprocess.Popen(
        [sys.executable, "-c", slow, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        write_whole(str(path), b"quick")
        assert len(os.listdir(tmp_path)) == 2
        other.communicate()
    assert other.returncode == 0
    assert path.read_bytes() == b"half"
    assert os.listdir(tmp_path) == ["a.csv"]


def test_where_files_cannot_be_locked_nothing_of_others_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on some file systems of a network; under Windows the system keeps others from removing what is open."""
    fcntl = pytest.importorskip("fcntl")
    part = tmp_path / "a.csv.0a1b2c3d.part"

    def refuse(path: object, *_: object) -> None:
        if path == str(part) or not isinstance(path, str):
            raise PermissionError(13, "The process cannot access the file because it is being used by another process")
        unlink(path)

    unlink = os.unlink
    part.touch()
    with monkeypatch.context() as without_locks:
        without_locks.setattr(fcntl, "flock", refuse)
        write_whole(str(tmp_path / "a.csv"), b"new")
    monkeypatch.setattr("robodyn.support.files._WINDOWS", True)
    monkeypatch.setattr(os, "unlink", refuse)
    write_whole(str(tmp_path / "a.csv"), b"new")
    assert sorted(os.listdir(tmp_path)) == ["a.csv", part.name]


def test_an_owner_that_cannot_be_kept_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"old")
    path.chmod(0o600)
    monkeypatch.setattr(os, "chown", mock.Mock(side_effect=PermissionError(1, "Operation not permitted")))
    write_whole(str(path), b"new")
    assert (mode(path), path.read_bytes()) == (0o600, b"new")


@pytest.mark.parametrize("name", ["none/a.urdf", "", "a\0b", "folder", "loop", "x" * 300])
def test_what_cannot_be_written(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError, match=r"cannot be written: .*nothing was written"):
        write_whole(str(tmp_path / name), b"x")
    assert sorted(os.listdir(tmp_path)) == ["folder", "loop"]


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
    monkeypatch.setattr(os, "replace", mock.Mock(side_effect=problem))
    with pytest.raises(raised, match=words):
        write_whole(str(path), b"two")
    assert path.read_bytes() == b"one"
    assert os.listdir(tmp_path) == ["a.urdf"]
