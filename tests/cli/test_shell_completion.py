"""Shells complete commands, options and files."""

from __future__ import annotations

import shutil

import pytest
from helpers.command_line import ROBOTS, shown


@pytest.mark.parametrize(
    ("shell", "part"),
    [("bash", "complete -o nosort -F _robodyn_completion"), ("zsh", "#compdef robodyn"), ("fish", "complete ")],
)
def test_script(shell: str, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if shell == "bash" and shutil.which("bash") is None:
        pytest.skip("click asks bash for its version")
    monkeypatch.setenv("_ROBODYN_COMPLETE", f"{shell}_source")
    text = shown()
    assert part in text


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("robodyn in", ["plain,inertia", "plain,info"]),
        ("robodyn check --package-path mod", ["dir,mod"]),
        ("robodyn zebra --f", []),
        ("robodyn linearize robots/puma.urdf --eq", ["plain,--equilibrium"]),
        ("robodyn export robots/puma.urdf --to ca", ["plain,casadi"]),
    ],
)
def test_words(words: str, completed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROBOTS.parent)
    monkeypatch.setenv("_ROBODYN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    text = shown()
    assert text.split() == completed
