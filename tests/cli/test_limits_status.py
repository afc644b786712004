"""Exit status of `--fail-on-limits`."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import ARM, Outcome, motion, run

BOUNDS = {"effort": "50", "velocity": "5", "lower": "-3", "upper": "3"}


def outcome_with(folder: Path, *options: str, **limits: str) -> Outcome:
    """Of the arm whose limits are these."""
    text = ARM
    for name, value in limits.items():
        text = text.replace(f'{name}="{BOUNDS[name]}"', f'{name}="{value}"')
    (folder / "arm.urdf").write_text(text)
    (folder / "arm.csv").write_text(motion(10))
    return run("torques", str(folder / "arm.urdf"), str(folder / "arm.csv"), *options)


def test_within_limits(tmp_path: Path) -> None:
    outcome = outcome_with(tmp_path, "--fail-on-limits")
    assert outcome.status == 0
    assert "\nNo limit is exceeded.\n" in outcome.out


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"effort": "3"}, "effort"),
        ({"velocity": "0.15"}, "velocity"),
        ({"upper": "0.01"}, "position"),
        ({"lower": "0.001"}, "position"),
    ],
)
@pytest.mark.parametrize("form", ["text", "json"])
def test_beyond_a_limit(limits: dict[str, str], said: str, form: str, tmp_path: Path) -> None:
    outcome = outcome_with(tmp_path, "--fail-on-limits", "--format", form, "--out", str(tmp_path / "tau.csv"), **limits)
    assert (outcome.status, outcome.err) == (1, "")
    assert said in outcome.out.partition("LIMITS EXCEEDED" if form == "text" else '"limits_exceeded"')[2]
    assert (tmp_path / "tau.csv").exists()


def test_limits_do_not_fail_unless_asked(tmp_path: Path) -> None:
    outcome = outcome_with(tmp_path, effort="3")
    assert outcome.status == 0
    assert "\nLIMITS EXCEEDED by 1 of 2 joints\n" in outcome.out


def test_at_a_limit_is_within_it(tmp_path: Path) -> None:
    assert outcome_with(tmp_path, "--fail-on-limits", velocity="0.2").status == 0
