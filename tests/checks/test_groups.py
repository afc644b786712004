"""One finding for each cause in a file, with its places; two rules that speak of one defect are one finding."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, INERTIA, arm

from robodyn.checks.catalogue import BY_CODE, CODES, RULES
from robodyn.checks.check import STANDARD, Options, Task, check_one, check_tasks, fix_task, found_in, tasks_for
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.examples import inertia as entries
from robodyn.checks.groups import (
    compared,
    deduplicate,
    file_by_file,
    fingerprints,
    grouped,
    kind_of,
    places,
    write_baseline,
)
from robodyn.checks.rule import Severity
from robodyn.report import document
from robodyn.report.check import check_json, check_sections, further

ONE = arm(shoulder="0 2 0")
TWO = arm(shoulder="0 2 0", elbow="0 3 0")
SHAPE = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'


def shown(text: str, *select: str) -> tuple[tuple[str, int], ...]:
    found = found_in(text.encode(), Options(select or ("RD2", "RD3", "RD5")))
    return tuple((finding.code, len(finding.places)) for finding in found.shown)


def shaped(upper: str) -> str:
    """The arm with a box for its upper link, around its centre of mass."""
    box = SHAPE.replace("<visual>", '<visual><origin xyz="0.2 0 0"/>')
    return arm(upper=upper).replace('<link name="upper">', f'<link name="upper">{box}')


@pytest.mark.parametrize(
    ("what", "kind"),
    [
        ("there is no link 'link_2' in the robot", "there is no link # in the robot"),
        ("the robot's own weight is that of 'arm's end'", "the robot's own weight is that of #"),
        ("the mesh 'a.stl' is not there (and 12 more places)", "the mesh # is not there"),
        ("it moves 'a', 'b' and has 1, 2.5, -3 kg", "it moves # and has # kg"),
        ("mujoco refuses 'a', 'b' and 4 more", "mujoco refuses #"),
        ("the scale 1 -1 1 mirrors the mesh (and 3 more of this mesh)", "the scale # # # mirrors the mesh"),
    ],
)
def test_kind_is_the_sentence_without_names_and_numbers(what: str, kind: str) -> None:
    assert kind_of(what) == kind


def test_the_same_slip_in_one_file_is_one_finding_with_its_places() -> None:
    (finding,) = found_in(TWO.encode(), Options(("RD5",))).shown
    assert [place.subject and place.subject.name for place in finding.places] == ["shoulder", "elbow"]
    assert [place.measured for place in finding.places] == [2.0, 3.0]
    assert finding.line == finding.places[0].line < finding.others[0].line
    assert all(place.others == () for place in finding.places)


def test_rules_severities_and_causes_are_kept_apart() -> None:
    mixed = arm(shoulder="0 0 0", elbow="0 2 0")
    assert shown(mixed, "RD5") == (("RD501", 1), ("RD502", 1))
    placeholders = arm(upper=IDENTITY, fore=IDENTITY.replace('"1"', '"0.1"'))
    assert shown(placeholders, "RD208") == (("RD208", 1), ("RD208", 1))


def test_equal_findings_of_several_files_are_one_with_the_places_of_all(tmp_path: Path) -> None:
    """But those of another link are not; programs have them file by file."""
    for name, text in (("a", TWO), ("b", TWO), ("c", ONE), ("d", arm(shoulder="0 0 0"))):
        (tmp_path / f"{name}.urdf").write_text(text)
    checked = check_tasks(tasks_for([str(tmp_path)], Options(("RD5",))))
    places_in = [[(Path(place.file).stem, place.line) for place in one.places] for one in checked.findings]
    ab, c, d = places_in
    assert [file for file, _ in ab] == ["a", "a", "b", "b"]
    assert ([file for file, _ in c], [file for file, _ in d]) == (["c"], ["d"])
    assert [Path(one.file).stem for one in file_by_file(checked.findings)] == ["a", "b", "c", "d"]
    assert re.search(r"\n  in: '[^']*b.urdf'\n", document.text(check_sections(checked)))
    (first, *_) = json.loads(check_json(checked))["findings"]
    assert [Path(place["file"]).stem for place in first["places"]] == ["a", "a", "b", "b"]


def test_places_are_what_was_grouped() -> None:
    for rule in RULES[1::4]:
        single = check_one(rule.bad.encode())
        assert places(grouped(single)) == single


def test_rules_explain_rules_that_exist_and_no_two_each_other() -> None:
    for code, rule in BY_CODE.items():
        assert not [other for other in rule.explains if other not in CODES or code in BY_CODE[other].explains]


def test_the_less_severe_of_two_that_are_one_defect_becomes_the_cause() -> None:
    (finding,) = found_in(shaped(IDENTITY).encode(), Options(("RD208", "RD301"))).shown
    assert (finding.code, finding.severity) == ("RD301", Severity.ERROR)
    assert finding.cause == "the inertia looks like a placeholder: the identity matrix, 1 kg m^2 three times (RD208)"

    negative = shaped(INERTIA.replace('"0.01"', '"-40"'))
    both = [one.code for one in check_one(negative.encode(), Options(("RD206", "RD301")))]
    assert both.count("RD206") == 1
    assert [code for code, _ in shown(negative, "RD206", "RD301")] == ["RD206"]

    # the defect of another link is its own
    single = check_one(shaped(IDENTITY).replace(INERTIA, IDENTITY).encode(), Options(("RD208", "RD301")))
    left = deduplicate(single, BY_CODE)
    assert [(one.code, one.subject and one.subject.name) for one in left] == [("RD301", "upper"), ("RD208", "fore")]


def test_a_waiver_allows_the_place_that_it_is_about() -> None:
    waiver = "<!-- robodyn: allow RD502 as it was published -->"
    waived = TWO.replace('<axis xyz="0 2 0"/>', f'{waiver}\n    <axis xyz="0 2 0"/>')
    (finding,) = found_in(waived.encode(), Options(("RD5", "RD0"))).shown
    assert [place.subject and place.subject.name for place in finding.places] == ["elbow"]


def test_every_place_is_fixed(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(TWO)
    fixed = fix_task(Task(str(path), STANDARD))
    assert len(fixed.made) == 2
    assert fixed.after.decode() == arm(shoulder="0.0 1.0 0.0", elbow="0.0 1.0 0.0")


def test_one_more_place_is_new_alone_and_leaves_the_name_of_the_finding(tmp_path: Path) -> None:
    before, after = (found_in(text.encode(), Options(("RD5",)), "arm.urdf").shown for text in (ONE, TWO))
    path = str(tmp_path / "known.json")
    assert write_baseline(before, path) == 1
    new, known, gone = compared(after, path)
    assert (known, gone) == (1, 0)
    assert [place.subject and place.subject.name for one in new for place in one.places] == ["elbow"]
    assert list(fingerprints(before)) == list(fingerprints(after))
    write_baseline(after, path)
    assert compared(before, path)[2] == 1


def test_what_a_cause_may_be_makes_no_finding_of_its_own() -> None:
    """Allegro's fingers had three with "one of these" and one without, of one rule."""
    single = check_one(TWO.encode(), Options(("RD502",)), "arm.urdf")
    sure, unsure, other = "the axes are permuted (RD312)", "one of these: a; b", "it may be that a"
    for causes, expected in (((None, unsure), 1), ((other, unsure), 1), ((None, sure), 2), ((unsure, sure), 2)):
        given = [replace(one, cause=cause) for one, cause in zip(single, causes, strict=True)]
        found = grouped(given)
        assert len(found) == expected
        assert len(set(fingerprints(found))) == expected
        assert [one.cause for one in places(found)] == list(causes)
    (line,) = further(
        grouped([replace(one, cause=cause) for one, cause in zip(single, (None, unsure), strict=True)])[0]
    )
    assert line.endswith(f"; {unsure}"), "another surmise is said at its place"
    assert unsure not in "".join(further(grouped([replace(one, cause=unsure, kind="") for one in single])[0]))


def test_shapes_that_do_not_fit_the_mass_are_one_finding() -> None:
    """RD301 and RD302 hold against the very shapes of which RD304 says that they are not the link's."""
    for centre, moments, beside in (("0 0 0.6", "4", "RD302"), ("0 0 0.12", "4", "RD301"), ("0 0 0.12", "40", "RD301")):
        text = a_shaped_link(mass="90", centre=centre, inertia=entries(f"{moments} 0 0 {moments} 0 {moments}")).encode()
        options = Options(("RD301", "RD302", "RD304"))
        assert {one.code for one in check_one(text, options)} == {"RD304", beside}
        (finding,) = found_in(text, options).shown
        assert finding.severity is Severity.ERROR or finding.code == "RD304"
        assert (finding.cause or "").endswith("denser than solid steel (RD304)") == (finding.code != "RD304")
