"""How `robodyn check` is held beside other programs: what counts as naming a planted defect, and where."""

from __future__ import annotations

import pytest
from benchmarks import bench_simcheck
from helpers.example_robots import PATHS
from helpers.judged import NAMED, SILENT, SOMETHING, by_robodyn, of_robots, of_simcheck
from helpers.planted_everywhere import Case, files, real, small
from helpers.simcheck import ABSENT, Said, Verdict
from helpers.simcheck_words import PRECISE

from robodyn.checks.catalogue import BY_CODE

SMALL = tuple(small())
AXIS = next(case for case in SMALL if case.code == "RD501")
KNOWN = Said("kinematics.attached", "warning", "shoulder", "'arm' is 5.0 cm from its parent 'base'")


def judged(*said: Said, case: Case = AXIS) -> str:
    return of_simcheck(case, Verdict((KNOWN,), 0.1), Verdict((KNOWN, *said), 0.1))


def test_a_defect_is_about_its_element_and_its_neighbours() -> None:
    assert AXIS.about == {"shoulder", "base", "arm"}
    mass = next(case for case in SMALL if case.code == "RD201")
    assert mass.about == {"arm", "shoulder", "roll"}
    assert not next(case for case in SMALL if case.code == "RD002").about


def test_words_at_the_place_name_it() -> None:
    words = "joint 'shoulder' has a zero axis"
    assert judged(Said("joints.axis", "error", "shoulder", words)) == NAMED
    assert judged(Said("joints.axis", "info", "", words)) == NAMED
    assert judged(Said("joints.axis", "error", "grip", "joint 'grip' has a zero axis")) == SILENT


def test_other_words_at_the_place_are_something() -> None:
    assert judged(Said("inertia.mass", "warning", "arm", "'arm' weighs 90 kg")) == SOMETHING
    assert judged(Said("inertia.mass", "info", "arm", "'arm' weighs 90 kg")) == SILENT
    assert judged(Said("engine.rest_contacts", "error", "arm|base", "they overlap")) == SOMETHING


def test_another_number_is_nothing_new() -> None:
    assert judged(KNOWN._replace(message="'arm' is 7.5 cm from its parent 'base'")) == SILENT
    assert judged(KNOWN._replace(message="'arm' is far from its parent 'base'")) == SOMETHING


def test_each_rule_with_words_is_one() -> None:
    assert PRECISE.keys() <= BY_CODE.keys()


@pytest.mark.skipif(not PATHS, reason="example-robot-data is not installed")
def test_all_that_is_planted_is_there() -> None:
    found = tuple(real())
    assert len({case.robot for case in found}) >= 15
    assert {"RD111", "RD405", "RD609", "RD702", "RD709"} <= {case.code for case in found}
    assert all(case.before != case.after for case in (*SMALL, *found))
    assert of_robots((*found, *SMALL)) == [*range(len(found), len(found) + len(SMALL))]


def test_robodyn_is_judged_by_its_rule(tmp_path) -> None:
    before, after = files(AXIS, tmp_path)
    assert by_robodyn(AXIS, (before, after)) == NAMED
    assert by_robodyn(AXIS._replace(code="RD502"), (before, after)) == SOMETHING
    assert by_robodyn(AXIS, (before, before)) == SILENT
    assert by_robodyn(AXIS, (after, after)) == SILENT


def test_it_says_that_simcheck_is_missing(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(bench_simcheck, "real", lambda: ())
    monkeypatch.setattr(bench_simcheck, "small", lambda: SMALL[:3])
    monkeypatch.setattr(bench_simcheck, "published", lambda: [])
    monkeypatch.setattr(bench_simcheck, "alarms", lambda paths, engines: "")
    monkeypatch.setattr(bench_simcheck, "timed", lambda paths, turns: "")
    text = bench_simcheck.report(1, 1, 1)
    assert text.startswith(ABSENT)
    assert "| 3 of 3 | robodyn check | 3 | 0 | 0 | 100 % |" in text
    assert "simcheck, static" not in text
