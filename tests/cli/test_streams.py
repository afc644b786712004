"""Standard streams: `-`, pipes that break, streams that are closed, full disks, interrupts, terminals."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import ARM, ROBOTS, command, motion, refused, run, spawn, write_arm
from helpers.processes import on_terminal
from helpers.sampled import sampled

SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))
ESCAPE = "\x1b"
LIMITED = (
    "import os, resource as r, sys; r.setrlimit(r.RLIMIT_FSIZE, (20_000, 20_000)); "
    "os.environ['PYTHONDONTWRITEBYTECODE'] = '1'; os.execvp(sys.argv[1], sys.argv[1:])"
)
"""Runs a command whose files may have fewer bytes than its table takes."""
INTERRUPTS = {
    "while standard input is copied": "import tempfile; tempfile.TemporaryFile = stop",
    "between blocks": "from contextlib import nullcontext; from robodyn.cli import progress\n"
    "progress.watched = lambda _: nullcontext(stop)",
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    for name in ("NO_COLOR", "FORCE_COLOR", "TERM", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def test_each_file_may_be_standard_input() -> None:
    Path("calm.toml").write_text("gravity = [0, 0, -1.62]")
    call = ("torques", "arm.urdf", "arm.csv", "--scene", "calm.toml")
    expected = run(*call)
    assert expected.status == 0
    for file in ("arm.urdf", "arm.csv", "calm.toml"):
        piped = [("-" if word == file else word) for word in call]
        assert run(*piped, stdin=Path(file).read_bytes()) == expected


@pytest.mark.parametrize(
    ("stream", "status", "line"),
    [("stdin", 2, "error: <stdin>: standard input is closed"), pytest.param("stdout", 0, "", marks=pytest.mark.slow)],
)
def test_closed_stream(stream: str, status: int, line: str) -> None:
    mark = {"stdin": "<&-", "stdout": ">&-"}[stream]
    urdf = "-" if stream == "stdin" else "arm.urdf"
    call = ["sh", "-c", f'"$@" {mark}', "sh", *command("torques", urdf, "arm.csv")]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (status, "")
    assert done.stderr.startswith(line)
    assert len(done.stderr.splitlines()) == bool(line)


@pytest.mark.parametrize(
    "options",
    [pytest.param(("--format", "json"), marks=pytest.mark.slow), ("--fail-on-limits", "--gravity", "0,0,-9000")],
)
def test_a_reader_that_goes_away_is_no_error(options: tuple[str, ...]) -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(command("torques", *SCARA, *options), stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (int("--fail-on-limits" in options), b"")


def test_a_full_disk_leaves_what_was_there() -> None:
    Path("arm.csv").write_text(motion(2000))
    Path("tau.csv").write_text("time,older\n")
    limited = [sys.executable, "-c", LIMITED, *command("torques", "arm.urdf", "arm.csv", "--out", "tau.csv")]
    done = subprocess.run(limited, capture_output=True, check=False, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("error: tau.csv: cannot be written: file too large")
    assert Path("tau.csv").read_text() == "time,older\n"
    assert sorted(path.name for path in Path().iterdir()) == ["arm.csv", "arm.urdf", "tau.csv"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no device that is always full")
def test_a_full_device() -> None:
    for out in ("full.csv", "full.parquet", "full.npz"):
        os.symlink("/dev/full", out)
        refused(run("torques", "arm.urdf", "arm.csv", "--out", out), f"{out}: cannot be written: no space left")
    with open("/dev/full", "wb") as full:
        call = command("torques", "arm.urdf", "arm.csv")
        done = subprocess.run(call, stdout=full, stderr=subprocess.PIPE, check=False, text=True)
    assert (done.returncode, done.stderr) == (2, "error: standard output: no space left on device\n")


@pytest.mark.parametrize("when", sampled(INTERRUPTS))
def test_interrupt(when: str) -> None:
    code = (
        "import os, signal, time\n"
        "stop = lambda *_: (os.kill(os.getpid(), signal.SIGINT), time.sleep(60))\n"
        f"{INTERRUPTS[when]}\nfrom robodyn.cli.main import main; main()"
    )
    call = [sys.executable, "-c", code, "torques", "arm.urdf", "-", "--out", "tau.csv"]
    done = subprocess.run(call, input=motion(10).encode(), capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.strip()) == (130, b"", b"")
    assert sorted(path.name for path in Path().iterdir()) == ["arm.csv", "arm.urdf"]


def test_bold_headers_on_a_terminal() -> None:
    shown, _ = on_terminal(command("torques", *SCARA), stdout=True, stderr=False)
    assert f"\n{ESCAPE}[1mjoint " in shown
    plain = shown.replace(f"{ESCAPE}[1m", "").replace(f"{ESCAPE}[0m", "")
    assert plain == run("torques", *SCARA).out


@pytest.mark.slow
def test_plain_text_where_the_terminal_wants_it_and_tables_that_fit() -> None:
    shown, _ = on_terminal(command("torques", *SCARA), stdout=True, stderr=False, TERM="dumb")
    assert shown == run("torques", *SCARA).out
    shown, _ = on_terminal(command("torques", *SCARA), stdout=True, stderr=False, columns=80, NO_COLOR="1")
    tables = shown.partition("Self-checks")[0].splitlines()
    assert max(map(len, tables)) <= 80
    assert sum(line.startswith("joint") for line in tables) == 3


def with_bar() -> list[str]:
    """The command with a progress bar for files of any length."""
    code = "import robodyn.cli.progress as p; p.LONG = 0; from robodyn.cli.main import main; main()"
    return [sys.executable, "-c", code, "torques", *SCARA, "--format", "json"]


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal_and_never_on_standard_output() -> None:
    shown, piped = on_terminal(with_bar(), stdout=False, stderr=True)
    assert "reading" in shown
    assert piped == run("torques", *SCARA, "--format", "json").out


@pytest.mark.slow
def test_no_progress_without_a_terminal_nor_for_a_short_file() -> None:
    done = subprocess.run(with_bar(), capture_output=True, check=True)
    assert done.stderr == b""
    shown, _ = on_terminal(command("torques", *SCARA), stdout=False, stderr=True)
    assert shown == ""


def test_progress_of_many_robots(tmp_path: Path) -> None:
    files = [f"{k}.urdf" for k in range(12)]
    for file in files:
        Path(file).write_text(ARM)
    shown, piped = on_terminal(command("check", "--format", "json", *files), stdout=False, stderr=True)
    assert all(f"{k}/12" in shown for k in range(13))
    assert "0:00:00" in shown
    assert piped == run("check", "--format", "json", *files).out


@pytest.mark.slow
def test_progress_of_few_robots_and_of_fixing() -> None:
    files = [f"{k}.urdf" for k in range(12)]
    for file in files:
        Path(file).write_text(ARM)
    assert on_terminal(command("check", *files[:9]), stdout=False, stderr=True)[0] == ""
    shown, _ = on_terminal(command("check", "--fix", *files), stdout=False, stderr=True)
    assert "fixing" in shown


def test_names_that_the_terminal_cannot_show() -> None:
    Path("arm.urdf").write_text(ARM.replace('name="arm"', 'name="\u8155&#155;31m"'), encoding="utf-8")
    outcome = spawn("torques", "arm.urdf", "arm.csv", PYTHONIOENCODING="latin-1", PYTHONUTF8="0")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("\\u8155\\x9b31m: 2 joints")


@pytest.mark.parametrize("call", [("scene", "init"), pytest.param(("export", "--to", "numpy"), marks=pytest.mark.slow)])
def test_files_are_utf_8_whatever_the_locale(call: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ARM.replace("elbow", "códo"), encoding="utf-8")
    spawned = spawn(*call, "arm.urdf", cwd=tmp_path, PYTHONIOENCODING="latin-1")
    assert spawned.out == run(*call, str(tmp_path / "arm.urdf")).out
    assert "códo" in spawned.out
