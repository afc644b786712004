"""xacro files that would run code, read what is none of their business, or never end: one line each, no more."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from robodyn.errors import InputError
from robodyn.robot.urdf import xacro
from robodyn.robot.urdf.sources import VARIABLES
from robodyn.robot.urdf.xacro import expanded

HOSTILE = Path(__file__).parents[2] / "data" / "hostile" / "xacro"
HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
REFUSED = {
    "shell": (3, "a lambda"),
    "format": (4, "a format with a dot"),
    "eval": (3, "'__class__'"),
    "vars": (3, "the function vars()"),
    "environment": (3, "the variable 'TOKEN' of the environment"),
    "optional_environment": (3, "the variable 'TOKEN' of the environment"),
    "secret": (3, "reading '/etc/hostname', outside"),
    "up": (3, "etc/hostname', outside"),
    "hidden": (3, "reading '.git/config', below a name that begins with a dot,"),
    "include": (3, "reading '/etc/hostname', outside"),
    "pattern": (3, "reading '/etc', outside"),
    "package_etc": (3, "taking '/etc', without a package.xml, for the package 'etc'"),
    "power": (3, "a power of more than 4096 bits"),
    "text": (None, "a text of more than 1000000 characters"),
    "macros": (None, "an expansion of more than"),
    "itself": (3, "reading more than 1000 files"),
    "aliases": (3, "a value of more than 100000 items"),
    "units": (3, "'__class__'"),
}
"""Line and reason of what is refused."""
FAILED = {
    "package_up": "the package '..' is not found",
    "endless": "it is nested too deeply",
    "deep": "it is nested too deeply",
    "object": "could not determine a constructor for the tag",
    "entities": "amplification",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The files in a package of their own, a secret in the environment and another beside; no canary at the end."""
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("TOKEN", "opensesame")
    monkeypatch.setattr(xacro, "PATIENCE", 120.0)  # so that a slow machine finds the other bounds first
    package = tmp_path / "work" / "arm"
    shutil.copytree(HOSTILE, package)
    (package / "package.xml").write_text("<package><name>arm</name></package>")
    (package / ".git").mkdir()
    (package / ".git" / "config").write_text("token: opensesame\n")
    (tmp_path / "secret.yaml").write_text("token: opensesame\n")
    monkeypatch.chdir(package)
    yield package
    assert not list(tmp_path.rglob("canary"))


def refusal(path: Path | str, **how: object) -> str:
    with pytest.raises(InputError) as error:
        expanded(str(path), **how)  # type: ignore[arg-type]
    assert "opensesame" not in str(error.value)
    assert "\n" not in str(error.value)
    return str(error.value)


def written(folder: Path, body: str, name: str = "own.xacro") -> Path:
    (folder / name).write_text(f"{HEAD}\n{body}\n</robot>\n")
    return folder / name


AGAIN = ("itself", "vars", "optional_environment", "up", "include", "package_etc", "power", "macros", "units")
"""Of a kind that another one is of, or long."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in AGAIN)) for name in REFUSED])
def test_is_refused_with_its_line(folder: Path, name: str) -> None:
    line, why = REFUSED[name]
    said = refusal(f"{name}.xacro")
    assert said.startswith(f"{name}.xacro:" + ("" if line is None else f"{line}: "))
    assert why in said
    assert "is refused (" in said
    assert said.endswith("--trust-xacro lifts this, and lets the file do whatever Python can)")


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "deep")) for name in FAILED])
def test_fails_with_one_line(folder: Path, name: str) -> None:
    assert {path.stem for path in HOSTILE.glob("*.xacro")} == REFUSED.keys() | FAILED.keys() | {"merges"}
    if name == "entities" and sys.version_info < (3, 11):
        pytest.skip("an older expat, which memory and time bound")
    assert FAILED[name] in refusal(f"{name}.xacro")


@pytest.mark.parametrize("expression", ["${python.repr(f)}", "${'%.30s' % [f]}"])
def test_no_address_comes_out(folder: Path, expression: str) -> None:
    own = written(folder, f'<xacro:property name="f" value="${{xacro.load_yaml}}"/>\n<link name="{expression}"/>')
    assert "the address of a function is refused" in refusal(own.name)


def test_mappings_that_are_merged_stay_small(folder: Path) -> None:
    """Newer versions of PyYAML merge each key once; in older ones there would be 9**9."""
    try:
        text = expanded("merges.xacro").text
    except InputError as error:
        assert "a mapping of more than 10000 items is refused" in str(error)  # noqa: PT017
    else:
        assert len(text) < 2000


def test_the_line_is_that_of_the_macro_in_another_file(folder: Path) -> None:
    written(folder, '<xacro:macro name="m">\n<link name="${().__class__}"/></xacro:macro>', "parts.xacro")
    own = written(folder, '<xacro:include filename="parts.xacro"/>\n<xacro:m/>')
    assert refusal(own.name).startswith("parts.xacro:3: the attribute '__class__'")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes and links")
@pytest.mark.parametrize(
    ("use", "trusted"),
    [('<xacro:include filename="{}"/>', False), ("<link name=\"${{xacro.load_yaml('{}')}}\"/>", True)],
)
def test_pipes_and_devices_are_no_files(folder: Path, use: str, trusted: bool) -> None:
    os.mkfifo("pipe")
    assert "this is no regular file" in refusal(written(folder, use.format("pipe")), trusted=trusted)
    os.symlink("/dev/zero", "zero")
    assert "zero" in refusal(written(folder, use.format("zero")), trusted=trusted)


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_links_lead_nowhere_else(folder: Path) -> None:
    """But to a copy of the package, as those of an installation do."""
    secret = folder.parents[1] / "secret.yaml"
    os.symlink(secret, "link.yaml")
    os.symlink(secret.parent, "around")
    for name in ("link.yaml", "around/secret.yaml"):
        own = written(folder, f"<link name=\"${{xacro.load_yaml('{name}').token}}\"/>")
        assert "outside of the packages that were found" in refusal(own)
    assert b"opensesame" in expanded(str(own), trusted=True).text
    assert b"opensesame" in expanded(str(own), [str(secret.parent)]).text
    copy = folder.parents[1] / "install" / "share" / "arm"
    copy.mkdir(parents=True)
    for name in ("package.xml", "own.xacro", "values.yaml"):
        os.symlink(folder / name, copy / name)
    (folder / "values.yaml").write_text("a: 7\n")
    written(folder, "<link name=\"a${xacro.load_yaml('values.yaml').a}\"/>")
    assert b'name="a7"' in expanded(str(copy / "own.xacro")).text


def test_packages_are_known_by_their_manifest(folder: Path) -> None:
    for name in ("other", "plain"):
        (folder.parent / name).mkdir()
        (folder.parent / name / "values.yaml").write_text("a: 7\n")
    (folder.parent / "other" / "package.xml").write_text("<package><name>other</name></package>")
    use = "<link name=\"a${{xacro.load_yaml('$(find {})/values.yaml').a}}\"/>"
    assert b'name="a7"' in expanded(str(written(folder, use.format("other")))).text
    plain = written(folder, use.format("plain"))
    assert "--package-path DIR" in refusal(plain)
    assert b'name="a7"' in expanded(str(plain), [str(folder.parent)]).text


def test_variables_come_from_arguments_and_those_of_packages(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = written(folder, '<link name="$(env TOKEN) $(optenv TOKEN x)"/>')
    assert "--xacro-arg TOKEN:=VALUE gives it one" in refusal(own)
    assert b'name="7 7"' in expanded(str(own), args={"TOKEN": "7"}).text
    assert b"opensesame opensesame" in expanded(str(own), trusted=True).text
    own = written(folder, '<link name="a$(optenv ROS_PACKAGE_PATH none)"/>')
    assert b'name="anone"' in expanded(str(own)).text
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/opt/ros")
    assert b'name="a/opt/ros"' in expanded(str(own)).text


def test_of_arguments_only_files_are_read(folder: Path) -> None:
    """A prefix may well be a slash."""
    secret = folder.parents[1] / "secret.yaml"
    own = written(folder, f"<xacro:arg name='x' default=''/><link name=\"${{xacro.load_yaml('{secret}').token}}\"/>")
    for other in ("/", str(secret.parent)):
        with pytest.raises(InputError, match="outside of the packages that were found"):
            expanded(str(own), args={"x": other})
    assert b"opensesame" in expanded(str(own), args={"x": str(secret)}).text


SLOW = '<link name="${len([0 for a in range(300) for b in range(300)])}"/>\n'


def test_time_is_bounded(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro, "PATIENCE", 0.5)
    assert "it is not done after 0.5 s" in refusal(written(folder, SLOW * 1000))
    assert "it is not done after 0.5 s" in refusal("power.xacro", trusted=True)


@pytest.mark.parametrize(
    ("body", "trusted"),
    [
        ("""<a b="${'x' * 2**31}"/>""", True),
        pytest.param("""<a b="${'x' * 900_000}"/>""" * 2000, False, marks=pytest.mark.slow),
    ],
    ids=["trusted", "not trusted"],
)
def test_memory_is_bounded(folder: Path, body: str, trusted: bool) -> None:
    assert "it needs more than 1024 MB" in refusal(written(folder, body), trusted=trusted)


CHECK = "from robodyn.robot.urdf.xacro import expanded; import sys; expanded(sys.argv[1], trusted=sys.argv[2] == '1')"


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="looks at processes in /proc")
@pytest.mark.slow
@pytest.mark.parametrize("trusted", [False, True])
def test_no_process_outlives_the_one_that_asked(folder: Path, trusted: bool) -> None:
    """Also one that is in the middle of a number without end, which the bound of its processor time ends."""
    path = Path("power.xacro") if trusted else written(folder, SLOW * 100_000)
    asking = subprocess.Popen([sys.executable, "-c", CHECK, str(path), str(int(trusted))], cwd=folder)
    children = Path(f"/proc/{asking.pid}/task/{asking.pid}/children")
    while not (pids := children.read_text().split()):
        time.sleep(0.01)
    time.sleep(1.0)
    asking.send_signal(signal.SIGKILL)
    asking.wait()
    while any(_runs(int(pid)) for pid in pids):
        time.sleep(0.1)


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


WRONG = [
    "os.system('touch canary')",
    "subprocess.run(['touch', 'canary'])",
    "os.execv('/bin/sh', ['sh', '-c', 'touch canary'])",
    "os.posix_spawn('/bin/sh', ['sh', '-c', 'touch canary'], {})",
    "os.fork()",
    "open('canary', 'w')",
    "os.open('canary', os.O_CREAT | os.O_WRONLY)",
    "os.mkdir('canary')",
    "os.symlink('x', 'canary')",
    "__import__('socket').socket()",
    "__import__('ctypes').CDLL(None)",
    "eval('1')",
    "exec('1')",
]


@pytest.mark.skipif(os.name != "posix", reason="some of these calls are of POSIX")
def test_what_comes_through_an_expression_is_stopped(folder: Path) -> None:
    """Should one ever lead to Python's functions; here they are called in its place."""
    code = f"""
import os, subprocess, sys, socket, ctypes
from robodyn.robot.urdf import xacro_child
wrong = [{", ".join(f"lambda: {call}" for call in WRONG)}]
sys.addaudithook(xacro_child._watch)
for call in wrong:
    try:
        call()
    except xacro_child.RefusedError:
        print("refused")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=folder)
    assert done.stdout == "refused\n" * len(WRONG), done.stderr
