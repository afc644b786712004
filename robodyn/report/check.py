"""`check`: findings with the lines of the source, in words, as a page and as JSON; fixes; documentation of rules.

`info`: a description at a glance: counts and mass, the tree, meshes, findings, and what to run next.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from math import sqrt
from pathlib import PurePath
from textwrap import indent, wrap
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from robodyn.checks.rule import Severity
from robodyn.report import document as doc
from robodyn.report.table import axis_text, number, point_text, printable
from robodyn.robot.urdf.parts import Limit
from robodyn.support.wording import count, listed_paths, relative_path, shown

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.checks.fixes import Fixed
    from robodyn.checks.overview import Branch, Overview
    from robodyn.checks.rule import Excerpt, Finding, Rule
    from robodyn.robot.model import Model


LEVELS: dict[Severity, doc.Level] = {Severity.ERROR: "bad", Severity.WARNING: "doubtful", Severity.NOTE: "neutral"}
UNFIT = "not fit for use as it is"
_NAMED = 8
_PLACES, _PLACES_SAID = 40, 10
"""Further places that are listed: by name alone, and with a sentence each."""
_WIDTH = 100
_WEIGHT = {
    Severity.ERROR: "error: the check fails",
    Severity.WARNING: "warning: the check fails with --strict",
    Severity.NOTE: "note: the check does not fail",
}
_UNITS = {"prismatic": ("m", "N", "m/s")}
_ANGULAR = ("rad", "N m", "rad/s")
_MOST_MISSING = 5
_DEEPEST = 40


def check_line(checked: Checked) -> str:
    """Return how many findings there are of each kind, at how many places, and whether the description is unfit."""
    if not checked.files and not checked.unread:
        return "nothing, as it comes from no file"
    counts = ", ".join(count(checked.count(severity), severity.value) for severity in LEVELS)
    places = sum(len(finding.places) for finding in checked.findings)
    at = f" at {places} places" if places > len(checked.findings) else ""
    said = f"{counts}{at}{'' if checked.fit else f': {UNFIT}'}" if checked.findings else "nothing found"
    return f"{said}; {count(len(checked.unread), 'file')} could not be read" if checked.unread else said


def checked_lines(checked: Checked) -> list[str]:
    """Return what is not shown, if anything, and at the end how many files were checked and what was found."""
    line = f"{count(len(checked.files), 'file')} checked: {check_line(checked)}"
    return [f"not shown: {hidden_line(checked)}", line] if checked.hidden else [line]


def hidden_line(checked: Checked) -> str:
    """Return how many findings are not shown, and what shows them."""
    rules = len({finding.code for finding in checked.hidden})
    return f"{count(len(checked.hidden), 'minor finding')} of {count(rules, 'rule')} (--select ALL)"


def check_data(checked: Checked) -> dict[str, Any]:
    """Return the same for JSON."""
    return {**{f"{severity.value}s": checked.count(severity) for severity in LEVELS}, "fit": checked.fit}


def check_verdict(checked: Checked) -> doc.Verdict:
    """Return whether the descriptions can be used, and the first errors, each with its place."""
    errors, warnings, notes = (checked.count(severity) for severity in LEVELS)
    if errors:
        level, headline = LEVELS[Severity.ERROR], f"{count(errors, 'error')}: {UNFIT}"
    elif checked.unread:
        level, headline = "bad", f"{count(len(checked.unread), 'file')} could not be read"
    elif warnings:
        level, headline = LEVELS[Severity.WARNING], f"No errors, {count(warnings, 'warning')}"
    else:
        more = f", {count(notes, 'note')}" if notes else ""
        level, headline = "good", f"No errors and no warnings{more}"
    worst = [finding for finding in checked.findings if finding.severity is Severity.ERROR]
    lines = [f"{finding.file}, line {finding.line}: {finding.message}." for finding in worst[:_NAMED]]
    rest = len(worst) - len(lines)
    lines += [f"{count(rest, 'more error')}: robodyn check lists all."] if rest else []
    return doc.Verdict(level, headline, (*lines, *(f"{each.file}: {each.why}." for each in checked.unread)))


def further(finding: Finding) -> list[str]:
    """Return lines with the further places of a finding in its file: in a row where they are alike, else each with its
    sentence, and with what its cause may be where that is another."""
    others = [other for other in finding.others if other.file == finding.file]
    alike = all((other.what, other.cause) == (finding.what, finding.cause) for other in others)
    most = _PLACES if alike else _PLACES_SAID
    shown, more = others[:most], len(others) - most
    rest = [f"{count(more, 'more place')}"] if more > 0 else []
    if alike:
        row = ", ".join([*map(place_words, shown), *rest])
        return wrap(row, _WIDTH, break_long_words=False, break_on_hyphens=False)
    causes = ["" if other.cause in (None, finding.cause) else f"; {other.cause}" for other in shown]
    said = [f"{place_words(other)}: {other.what}{cause}" for other, cause in zip(shown, causes, strict=True)]
    return [*said, *rest]


def place_words(finding: Finding) -> str:
    """`31:12 link 'arm'`"""
    at = f"{finding.line}:{finding.column}"
    return at if finding.subject is None else f"{at} {finding.subject.words}"


def short_sections(checked: Checked) -> Iterator[doc.Section]:
    """Yield for each file its rules, the most severe first, and the places of each; at the end how many there are."""
    order = list(LEVELS)
    files: dict[str, list[Finding]] = {}
    for finding in checked.findings:
        files.setdefault(finding.file, []).append(finding)
    for file, found in files.items():
        ranked = sorted(found, key=lambda one: (order.index(one.severity), one.code))
        lines = [relative_path(file)]
        for head, same in groupby(ranked, key=lambda one: f"{one.severity.value} {one.code} {one.name}"):
            lines.append(f"  {head}")
            for one in same:
                lines.append(f"    {one.line}:{one.column}: {one.message}")
                others = [other for other in one.others if other.file == one.file]
                if others:
                    more = len(others) - _PLACES_SAID
                    rest = [count(more, "more place")] if more > 0 else []
                    lines.append(f"      also {', '.join([*map(place_words, others[:_PLACES_SAID]), *rest])}")
                lines += [f"      in: {line}" for line in _below(one).get("in", ())]
        yield doc.paragraphs(lines)
    yield doc.paragraphs(checked_lines(checked))


def check_sections(checked: Checked) -> Iterator[doc.Section]:
    """Yield every finding, and at the end how many there are in how many files."""
    for finding in checked.findings:
        place = f"{finding.file}:{finding.line}:{finding.column}"
        kind = f"{finding.severity.value} {finding.code} {finding.name}"
        lines = [f"{place}: {kind}: {finding.message}", *marked(finding.line, finding.excerpt)]
        for label, said in _below(finding).items():
            lines += [f"  {' ' * (len(label) + 2) if k else f'{label}: '}{line}" for k, line in enumerate(said)]
        yield doc.paragraphs(lines)
    yield doc.paragraphs(checked_lines(checked))


def _below(finding: Finding) -> dict[str, list[str]]:
    """Return what stands below a finding: the robots that include its file and the other files that have it, its cause,
    further places, what to do."""
    files = dict.fromkeys([*finding.robots, *(other.file for other in finding.others)])
    files.pop(finding.file, None)
    fix = finding.fix and f"{finding.fix.what} ({'safe' if finding.fix.safe else 'unsafe'})"
    found = {"in": [listed_paths(files)] if files else [], "cause": [finding.cause] if finding.cause else []}
    found |= {"also": further(finding), "do": [finding.remedy], "fix": [fix] if fix else []}
    return {label: lines for label, lines in found.items() if lines}


def marked(line: int, excerpt: Excerpt) -> list[str]:
    """Return the line and the caret below; what a terminal would break is escaped before it is counted."""
    if not excerpt.text:
        return []
    before, within = excerpt.text[: excerpt.start], excerpt.text[excerpt.start : excerpt.start + excerpt.length]
    margin = f"  {line} | "
    gap = " " * (len(margin) - 2)
    return [margin + excerpt.text, f"{gap}| {' ' * len(printable(before))}{'^' * max(len(printable(within)), 1)}"]


def check_page(checked: Checked, models: Mapping[str, Model] = MappingProxyType({})) -> doc.Document:
    """Return whether the descriptions can be used, the robots of files that load, every finding with its line by file
    and severity, and what the rules that speak ask for."""
    from robodyn.checks.catalogue import BY_CODE

    verdict = check_verdict(checked)
    fixes = sum(finding.fix is not None and finding.fix.safe for finding in checked.findings)
    correct = f"robodyn check --fix corrects {fixes} of the findings and leaves the dynamics as they are."
    hidden = [f"Not shown: {hidden_line(checked)}."] if checked.hidden else []
    reasons = (*verdict.reasons, *([correct] if fixes else []), *hidden)
    blocks: list[doc.Block] = [replace(verdict, reasons=reasons)]
    if len(checked.files) == 1:
        blocks += [block for file, model in models.items() for block in _drawn(checked, file, model)]
    counts = {severity: checked.count(severity) for severity in LEVELS if checked.count(severity)}
    if len(counts) > 1:
        blocks.append(doc.Levels(tuple((LEVELS[each], count(many, each.value)) for each, many in counts.items())))
    for file in dict.fromkeys(finding.file for finding in checked.findings):
        blocks.append(doc.Heading(printable(file)))
        if file in models and len(checked.files) > 1:
            blocks += _drawn(checked, file, models[file])
        for severity in counts:
            found = [one for one in checked.findings if one.file == file and one.severity is severity]
            codes, caption = tuple(one.code for one in found), count(len(found), severity.value)
            blocks += [doc.Findings(tuple(map(_item, found)), caption, codes)] if found else []
    if checked.findings:
        tables = [
            block for section in statistics_sections(checked) for block in section if isinstance(block, doc.Table)
        ]
        tables[0] = replace(tables[0], caption="How often each rule speaks")
        rules = [BY_CODE[code] for code in sorted({finding.code for finding in checked.findings}) if code in BY_CODE]
        said = [(one.code, f"{one.code} {one.name}: {one.summary}", " ".join(one.explanation.split())) for one in rules]
        blocks += [doc.Heading("Rules"), *tables, doc.Folded(tuple(said))]
        blocks.append(doc.Paragraph("robodyn rule CODE shows an example of what a rule finds."))
    blocks += doc.data_blocks([("findings.json", check_json(checked))], "robodyn check --format json prints it")
    title = PurePath(checked.files[0]).name if len(checked.files) == 1 else "Robot descriptions"
    return doc.Document(
        title, f"Check of robot descriptions: {count(len(checked.files), 'file')} checked", tuple(blocks)
    )


def _drawn(checked: Checked, file: str, model: Model) -> Iterator[doc.Block]:
    """Yield the robot of a file; the links with errors and warnings, or joints with such, are lit."""
    from robodyn.report import stage
    from robodyn.robot.kinematics import configuration, nearest_to_zero

    numbers, lit, said = stage.bodies_of(model), dict[str, str](), dict[str, list[str]]()
    for severity, level in LEVELS.items():
        for one in (place for finding in checked.findings for place in finding.places):
            of = numbers.get((one.subject.kind, one.subject.name)) if one.subject else None
            if one.severity is severity and of is not None and file in (one.checked, *one.robots):
                said.setdefault(model.bodies[of].name, []).append(f"{severity.value} {one.code}, {one.message}")
                lit.setdefault(model.bodies[of].name, level)
    lit = {name: level for name, level in lit.items() if level != "neutral"}
    words = {name: "; ".join(lines) for name, lines in said.items()}
    at = stage.pose(model, configuration(model, nearest_to_zero(model)).tolist())
    shown = stage.robot(model, [at], lit=lit, words=words)
    named = {"bad": "errors in red", "doubtful": "warnings in yellow-brown"}
    marked = [f"links with {each}" for level, each in named.items() if level in lit.values()]
    alt = "; ".join(f"{name}: {words[name]}" for name in lit)
    yield stage.stage(f"{model.name}: {', '.join(marked) or 'no link with errors or warnings'}", [shown], alt=alt)


def _item(finding: Finding) -> tuple[doc.Level, str, tuple[tuple[str, bool], ...]]:
    title = f"Line {finding.line}: {finding.message}"
    lines = [("\n".join(marked(finding.line, finding.excerpt)), True)] if finding.excerpt.text else []
    told = {label: "; ".join(said).replace(",; ", ", ") for label, said in _below(finding).items()}  # of wrapped rows
    lines += [(f"{label.capitalize()}: {said}.", False) for label, said in told.items()]
    return LEVELS[finding.severity], title, tuple(lines)


def check_diff(fixed: Fixed) -> str:
    """Return the unified diff of one file, empty if nothing changes. Lines end with LF; a CR is part of its line."""
    from difflib import unified_diff

    before, after = (
        re.findall(r"[^\n]*\n|[^\n]+", data.decode("utf-8", "surrogateescape")) for data in (fixed.before, fixed.after)
    )
    name = printable(fixed.file)
    lines = unified_diff(before, after, name, name)
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)


def fix_lines(files: Iterable[Fixed], did: str) -> list[str]:
    """Return a line for each fix that was made, `did` it being said how, and for each that was not, with the reason."""
    lines = []
    for fixed in files:
        told = [(did, one.finding, one.fix, one.effect) for one in fixed.made]
        told += [("not fixed", one.finding, one.fix, one.why) for one in fixed.refused]
        for how, finding, fix, why in told:
            subject = f", {finding.subject.kind} {finding.subject.name}" if finding.subject else ""
            place = f"{finding.file}:{finding.line}: {finding.code}{subject}"
            lines.append(printable(f"{how}: {place}: {fix.what} ({why})"))
    return lines


def rules_sections(rules: Sequence[Rule]) -> Iterator[doc.Section]:
    """Yield what each rule asks for, why, and an example of both."""
    for rule in rules:
        off = "" if rule.in_default else f"; shown with --select {rule.code}"
        yield [doc.Paragraph(f"{rule.code} {rule.name} ({_WEIGHT[rule.severity]}{off})")]
        for text in (rule.summary, rule.explanation):
            yield doc.paragraphs(wrap(" ".join(text.split()), _WIDTH))
        for title, example in (("bad:", rule.bad), ("good:", rule.good)):
            yield doc.paragraphs([title, *indent(example, "    ").splitlines()])


def statistics_sections(checked: Checked) -> Iterator[doc.Section]:
    """Yield a table of rules, the most frequent first: findings, places, files, and how many places have safe and other
    fixes; and one of what is not shown."""
    if not checked.findings:
        yield [doc.Paragraph("no findings")]
    hidden = "Not shown, since they are minor; --select ALL shows them"
    for caption, findings in (("", checked.findings), (hidden, checked.hidden)):
        if findings:
            places = [(finding.code, place) for finding in findings for place in finding.places]
            counts, at = Counter(finding.code for finding in findings), Counter(code for code, _ in places)
            files = Counter(code for code, _ in {(code, place.file) for code, place in places})
            fixes = Counter((code, place.fix.safe) for code, place in places if place.fix)
            names = {finding.code: f"{finding.code} {finding.name}" for finding in findings}
            figures = {
                code: (counts[code], at[code], files[code], fixes[code, True], fixes[code, False]) for code in counts
            }
            order = sorted(counts, key=lambda code: (-counts[code], code))
            rows = [[names[code], *(str(figure or "-") for figure in figures[code])] for code in order]
            yield [doc.Table(caption, ("rule", "findings", "places", "files", "safe fixes", "unsafe fixes"), rows)]


def check_json(checked: Checked) -> str:
    """Return {"findings", "unread", "summary"}; places count from 1, edits are byte offsets of the file."""
    subject, bounds, fix = "subject[kind name] message", "measured? bound?", "fix[what safe edits]"
    places = f"places[file line column {subject} {bounds} {fix}]"
    keys = f"file line column code name severity {subject} remedy {bounds} cause {fix} {places} robots"
    return doc.written(
        {
            "findings": [doc.select(finding, keys) for finding in checked.findings],
            "unread": [doc.select(each, "file error:why") for each in checked.unread],
            "summary": {"files": len(checked.files), **check_data(checked), "hidden": len(checked.hidden)},
        }
    )


def overview_sections(found: Overview) -> Iterator[doc.Section]:
    """Yield counts and mass, the tree as a table, then meshes, findings and what to run next."""
    branches, merged, kinds = found.branches, found.types.get("fixed", 0), found.types.items()
    joints = ", ".join(f"{amount} {kind}" for kind, amount in kinds)
    lines = [f"{found.file}: robot {shown(found.name)}", f"links: {len(branches)}, {found.massive} with mass"]
    lines.append(f"joints: {sum(found.types.values())}{joints and f' ({joints})'}")
    freedoms = f"degrees of freedom: {found.freedoms}"
    if found.base_freedoms:
        freedoms += f", {found.base_freedoms} of them the base's"
    if merged:
        freedoms += f"; {count(merged, 'fixed joint is', 'fixed joints are')} merged"
    if found.mimics:
        freedoms += f"; {count(found.mimics, 'joint mimics another', 'joints mimic others')}"
    if found.loops:
        freedoms += f"; of the open tree, which {count(found.loops, 'constraint closes', 'constraints close')}"
    centre = ""
    if found.com is not None:
        values = ", ".join(f"{name} {value:.6g}" for name, value in found.moved.items())
        where = "where every joint is zero" + (f" or at its limit nearest to zero: {values}" if values else "")
        point = point_text(found.com, max(map(abs, found.com)))
        centre = f", centre of mass {point} m in the frame of {shown(found.base)}, {where}"
    mass = f"mass: {number(found.mass)} kg{centre}"
    yield doc.paragraphs([*lines, freedoms, mass, *(f"note: {note}" for note in found.notes)])
    yield [tree_table(branches)]
    references, files = found.meshes
    missing = len(found.missing)
    state = f"{missing} not found:" if missing else "all found"
    lines = [f"meshes: {references} in {count(files, 'file')}, {state}" if references else "meshes: none"]
    for link, geometry in found.missing[:_MOST_MISSING]:
        lines.append(f"  {geometry.filename} (link {shown(link)}, line {geometry.line})")
    lines += [f"  and {missing - _MOST_MISSING} more"] if missing > _MOST_MISSING else []
    yield doc.paragraphs([*lines, f"check: {check_line(found.checked)}"])
    if found.next:
        yield doc.paragraphs(["next:", *(f"  {command}" for command in found.next)])


def tree_table(branches: Sequence[Branch], caption: str = "") -> doc.Table:
    """Return links with the joints that carry them."""
    step = 2 if max(branch.depth for branch in branches) <= _DEEPEST // 2 else 1
    rows = [_row(branch, min(branch.depth * step, _DEEPEST)) for branch in branches]
    head = ["link", "mass [kg]", "joint", "type", "axis", "lower", "upper", "effort", "velocity", "mimics"]
    kept = [k for k in range(len(head)) if k < 2 or any(row[k] for row in rows)]
    return doc.Table(caption, [head[k] for k in kept], [[row[k] for k in kept] for row in rows])


def _row(branch: Branch, indent: int) -> list[str]:
    """Return a link's row; - where a limit is to be expected but not given."""
    mass, joint = "" if branch.mass is None else number(branch.mass), branch.joint
    row = [" " * indent + branch.name, mass]
    if joint is None:
        return [*row, *[""] * 8]
    axis, mimic = "", ""
    if joint.type not in ("fixed", "floating"):
        largest = max(map(abs, joint.axis))
        norm = largest * sqrt(sum((x / largest) ** 2 for x in joint.axis))
        direction = [x / norm for x in joint.axis]
        along = sum(map(bool, direction)) <= 1  # a letter stands for an axis of the joint's frame
        axis = axis_text(direction) if along else f"({', '.join(f'{value:.4g}' for value in direction)})"
    if joint.mimic is not None:
        factor, offset = joint.mimic.multiplier, joint.mimic.offset
        mimic = joint.mimic.joint + ("" if factor == 1 else f" * {factor:.6g}")
        mimic += f" {'+' if offset > 0 else '-'} {abs(offset):.6g}" if offset else ""
    limits = [""] * 4
    if joint.type in ("revolute", "prismatic", "continuous"):
        length, effort, speed = _UNITS.get(joint.type, _ANGULAR)
        limit = joint.limit or Limit()
        units = {"lower": "", "upper": f" {length}", "effort": f" {effort}", "velocity": f" {speed}"}
        values = ((getattr(limit, name), unit) for name, unit in units.items())
        limits = ["-" if value is None else number(value) + unit for value, unit in values]
        if joint.type == "continuous":
            limits[:2] = "", ""
    return [*row, joint.name, joint.type, axis, *limits, mimic]


def overview_json(found: Overview) -> str:
    """Return a description at a glance; links and joints stand depth first."""
    counts = doc.select(
        found,
        "links links_with_mass:massive joints joints_by_type:types mimic_joints:mimics loops merged_fixed_joints "
        "degrees_of_freedom:freedoms base_degrees_of_freedom:base_freedoms",
        links=len(found.branches),
        joints=sum(found.types.values()),
        merged_fixed_joints=found.types.get("fixed", 0),
    )
    limits = " ".join(f"{name}:limit.{name}" for name in ("lower", "upper", "effort", "velocity"))
    keys, joints = f"name line type parent child axis {limits} mimic[joint multiplier offset]", []
    for joint in (branch.joint for branch in found.branches if branch.joint):
        joints.append(doc.select(joint, keys, axis=None if joint.type in ("fixed", "floating") else joint.axis))
    missing = [{"link": link, **doc.select(each, "kind filename line")} for link, each in found.missing]
    return doc.written(
        doc.select(
            found,
            "robot:name file counts mass? com com_frame:base at at_zero links:branches[name line depth mass "
            "joint:joint.name] joints meshes check notes next",
            counts=counts,
            at_zero=not found.moved,
            joints=joints,
            meshes={"references": found.meshes[0], "files": found.meshes[1], "missing": missing},
            check=check_data(found.checked),
        )
    )
