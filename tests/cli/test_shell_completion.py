"""Shells complete commands, options and files."""

from __future__ import annotations

import shutil

import pytest
from helpers.command_line import run


@pytest.mark.parametrize(
    ("shell", "part"),
    [("bash", "complete -o nosort -F _robodyn_completion"), ("zsh", "#compdef robodyn"), ("fish", "complete ")],
)
def test_script(shell: str, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if shell == "bash" and shutil.which("bash") is None:
        pytest.skip("click asks bash for its version")
    monkeypatch.setenv("_ROBODYN_COMPLETE", f"{shell}_source")
    outcome = run()
    assert (outcome.status, outcome.err) == (0, "")
    assert part in outcome.out


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("robodyn in", ["plain,inertia", "plain,info"]),
        ("robodyn info --f", ["plain,--format"]),
        ("robodyn info rob", ["file,rob"]),
        ("robodyn torques robot.urdf mot", ["file,mot"]),
        ("robodyn simulate robot.urdf --scene sc", ["file,sc"]),
        ("robodyn inertia a.stl par", ["file,par"]),
        ("robodyn check --package-path mod", ["dir,mod"]),
        ("robodyn zebra --f", []),
    ],
)
def test_words(words: str, completed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_ROBODYN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    outcome = run()
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.split() == completed
