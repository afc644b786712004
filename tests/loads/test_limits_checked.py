"""Limits that cannot be checked are not "not exceeded": no limits, limits of 0, and numbers that limit nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.batch_runs import write_motion
from helpers.command_line import ARM, motion, run

from robodyn.errors import Caveat
from robodyn.report.limits import exceeded_words, unchecked_words, verdict_on_limits
from robodyn.robot.limits import Excess, coverage
from robodyn.robot.load import load

LIMIT = '<limit effort="50" velocity="5" lower="-3" upper="3"/>'
NO_EFFORT = "2 of 2 joints have no effort limit: not checked (0, which means none, for shoulder, elbow)."
CONTINUOUS = ARM.replace("revolute", "continuous")
WITHOUT = CONTINUOUS.replace(LIMIT, "")


def model(limit: str, text: str = ARM):
    """The arm whose elbow has this limit."""
    head, _, tail = text.rpartition(LIMIT)
    return load(f"{head}{limit}{tail}".encode())


def arm(folder: Path, text: str) -> tuple[str, str]:
    (folder / "arm.urdf").write_text(text)
    (folder / "arm.csv").write_text(motion(10))
    return str(folder / "arm.urdf"), str(folder / "arm.csv")


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (LIMIT, ()),
        ('<limit effort="0" velocity="5" lower="-3" upper="3"/>', ("effort: 0, which means none, for elbow",)),
        ('<limit effort="50" velocity="0" lower="-3" upper="3"/>', ("velocity: 0, which means none, for elbow",)),
        (
            '<limit effort="50" velocity="1e9" lower="-3" upper="3"/>',
            ("velocity: 1e+09, which limits nothing, for elbow",),
        ),
        ('<limit velocity="5" lower="-3" upper="3"/>', ("effort: elbow",)),
        ('<limit effort="50" velocity="5"/>', ("position: elbow",)),
        ("", ("effort: elbow", "velocity: elbow", "position: elbow")),
    ],
)
def test_what_has_no_limit_is_named(limit: str, said: tuple[str, ...]) -> None:
    expected = tuple(
        f"1 of 2 joints have no {kind} limit: not checked ({who})."
        for kind, _, who in (each.partition(": ") for each in said)
    )
    limits = coverage(model(limit).independent)
    assert unchecked_words(limits) == expected
    verdict = verdict_on_limits(2, (), limits)
    assert (verdict.level, verdict.headline) == (
        ("neutral", "No limit is exceeded where there is one") if said else ("good", "No limit is exceeded")
    )


def test_a_continuous_joint_needs_no_limit_of_position() -> None:
    assert not unchecked_words(coverage(load(CONTINUOUS.encode()).independent))


def test_a_doubt_takes_the_green_away_and_goes_with_the_headline() -> None:
    limits = coverage(model(LIMIT).independent)
    caveats = (Caveat("as long as it holds", "It may not hold."), Caveat("as far as it goes", "It may not go."))
    verdict = verdict_on_limits(2, (), limits, caveats)
    assert verdict.headline == "No limit is exceeded as long as it holds, as far as it goes"
    assert (verdict.level, verdict.reasons) == ("doubtful", ("It may not hold.", "It may not go."))
    said = exceeded_words(Excess("elbow", "effort", 60.0, 50.0, "N m", 0.5, 0.1))
    red = verdict_on_limits(2, [("elbow", said)], limits, caveats)
    assert (red.level, red.headline) == ("bad", "1 of 2 joints exceeds its limits")
    assert red.reasons[0] == said
    limit = "120 % of its limit of 50 N m; it is beyond the limit for 0.1 s."
    assert said == f"elbow needs a torque of 60.00 N m at 0.5 s, {limit}"


@pytest.mark.parametrize(
    ("form", "text", "headline", "line"),
    [
        ("text", ARM.replace('effort="50"', 'effort="0"'), "No limit is exceeded where there is one", NO_EFFORT),
        (
            "html",
            WITHOUT,
            "Nothing was checked: the description gives no limits",
            "2 of 2 joints have no velocity limit: not checked (shoulder, elbow).",
        ),
    ],
    ids=["effort 0", "no limits"],
)
def test_headlines_are_neither_red_nor_green(form: str, text: str, headline: str, line: str, tmp_path: Path) -> None:
    page = tmp_path / f"page.{form}"
    more = () if form == "text" else ("--report", str(page))
    outcome = run("torques", *arm(tmp_path, text), "--fail-on-limits", *more)
    assert outcome.status == 0
    shown = outcome.out if form == "text" else page.read_text()
    assert headline in shown
    assert line in shown
    assert "xceed" not in shown.replace(headline, "")
    assert "✅ No limit" not in shown
    assert 'verdict good">\n' not in shown.partition("</h1>")[2].partition("<h2")[0]


def test_json_says_what_was_checked(tmp_path: Path) -> None:
    files = arm(tmp_path, ARM.replace('effort="50"', 'effort="0"', 1))
    found = json.loads(run("torques", *files, "--format", "json").out)
    both = ["shoulder", "elbow"]
    assert found["limits"] == {
        "effort": {"checked": ["elbow"], "unchecked": [{"joint": "shoulder", "given": 0.0}]},
        "velocity": {"checked": both, "unchecked": []},
        "position": {"checked": both, "unchecked": []},
    }
    assert found["within_limits"] is None
    assert found["verdict"]["level"] == "neutral"
    assert found["limits_exceeded"] == []
    assert found["joints"][0]["effort_limit"] is None


@pytest.mark.parametrize(("effort", "within"), [("50", True), ("1", False)])
def test_limits_that_were_checked_are_kept_or_not(effort: str, within: bool, tmp_path: Path) -> None:
    files = arm(tmp_path, ARM.replace('effort="50"', f'effort="{effort}"'))
    outcome = run("torques", *files, "--format", "json", "--fail-on-limits")
    assert (json.loads(outcome.out)["within_limits"], outcome.status) == (within, 1 - within)


def test_batches_say_what_was_not_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(ARM.replace('effort="50"', 'effort="0"'))
    for name in ("one", "two"):
        write_motion(Path(f"runs/{name}.csv"))
    call = ("torques", "arm.urdf", "runs/*.csv", "--out", "results/", "--jobs", "1", "--executor", "numpy")
    call += ("--fail-on-limits",)
    outcome = run(*call)
    assert outcome.status == 0, outcome.err
    assert outcome.out.endswith(f"\n{NO_EFFORT}\nNo limit is exceeded where there is one.\n")
    found = json.loads(run(*call, "--format", "json").out)  # finished before: from the documents
    assert found["finished_before"] == 2
    assert found["within_limits"] is None
    assert [each["within_limits"] for each in found["files"]] == [None, None]
    assert [one["joint"] for one in found["files"][0]["limits"]["effort"]["unchecked"]] == ["shoulder", "elbow"]
