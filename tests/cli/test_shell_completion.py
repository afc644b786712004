"""Shells complete commands, options and files."""

from __future__ import annotations

import shutil

import pytest
from helpers.command_line import ROBOTS, shown

from robodyn.checks.catalogue import CODES

RD21 = [f"plain,{code}" for code in CODES if code.startswith("RD21")]


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
        ("robodyn info rob", ["file,rob"]),
        ("robodyn simulate robot.urdf --scene sc", ["file,sc"]),
        ("robodyn check --package-path mod", ["dir,mod"]),
        ("robodyn zebra --f", []),
        ("robodyn simulate robots/puma.urdf --method ga", ["plain,gauss2", "plain,gauss4", "plain,gauss6"]),
        ("robodyn export robots/puma.urdf --what bias,fo", ["plain,bias,forward", "plain,bias,forward_derivatives"]),
        ("robodyn rule RD21", RD21),
        ("robodyn rule zero-", ["plain,zero-tensor", "plain,zero-axis"]),
        ("robodyn check robots/puma.urdf --select a", ["plain,ALL"]),
        ("robodyn check robots/puma.urdf --select RD207,RD90", ["plain,RD207,RD901", "plain,RD207,RD902"]),
        ("robodyn torques robots/puma.urdf motion.csv --frame fore", ["plain,forearm"]),
        ("robodyn fbd robots/puma.urdf --at waist=0.1,el", ["plain,waist=0.1,elbow="]),
        ("robodyn inertia robots/meshed_arm.urdf --link fore", ["plain,forearm"]),
        ("robodyn torques none.urdf motion.csv --frame fore", []),
    ],
)
def test_words(words: str, completed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROBOTS.parent)
    monkeypatch.setenv("_ROBODYN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    text = shown()
    assert text.split() == completed
