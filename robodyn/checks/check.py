"""`robodyn check`: rules in, findings out. The map of the room, step by step:

1. Which files: `sources` finds them in folders and patterns, and the descriptions that a mesh or an SRDF belongs to.
2. How each is checked: `sources` reads the settings of its project, `catalogue` has the rules and which are selected.
3. One file (`check_one`): read as far as it can be, of xacro its expansion (`located` leads back to the macros), into a
   `context`, which derives what rules ask for (its tree, `srdf`, `meshes/`, `bodies/`, `mirror`) once.
4. The rules (`run_rules`): `rule` says what one is; those of a family are a file in `rules/`. `waivers` allow findings.
5. What is shown (`select_findings`): of two rules that tell of one defect one, places of one cause together (`groups`).
6. What may follow: `fixes` are made and proven, `groups` knows findings of before, `rules/asked` an earlier version.
"""

from __future__ import annotations

import os
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING
from warnings import warn

from robodyn.checks.catalogue import BY_CODE, CODES, is_selected, rules_for
from robodyn.checks.context import STANDARD, STDIN, Context, Options
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.groups import across_files, across_robots, deduplicate, grouped, kind_of, places
from robodyn.checks.rule import HERE, Fault, Finding, Rule, Severity, excerpt, subject_of
from robodyn.checks.rules.text import unused_waiver, without_use
from robodyn.checks.sources import Config, defined_beside, files_of, find_config, read_config, worth_processes
from robodyn.checks.waivers import waived, waivers
from robodyn.errors import InputError, NoRobotError, RobodynWarning
from robodyn.robot.urdf.document import Document, Element, SourcePositions, read, read_document
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import EXPANDED, OTHER_FORMATS, is_xacro, read_source, root_tag
from robodyn.robot.urdf.view import Subject
from robodyn.support.input_file import read_input
from robodyn.support.wording import count, listed, listed_paths

if TYPE_CHECKING:
    from robodyn.robot.urdf.xacro import Expansion

__all__ = ["STANDARD", "Options"]
Source = str | os.PathLike[str] | bytes
_OF_ANY_FORMAT = (
    *("RD111", "RD112", "RD113", "RD201", "RD204", "RD205", "RD206", "RD207", "RD208", "RD209", "RD21", "RD3", "RD4"),
    *("RD503", "RD507", "RD509", "RD512", "RD515", "RD516", "RD517"),
    *("RD601", "RD602", "RD604", "RD605", "RD606", "RD608", "RD609", "RD61", "RD8"),
)
"""Codes of the rules that ask about the robot: not about the text of a URDF, nor about links without mass, which stand
between several joints of a body."""
_OWN = ".msh"  # meshes of MuJoCo's own, which nothing else reads
_MOST_HUNG_ON = 16  # links of others that a part may hang on


def check(
    sources: Source | Sequence[Source],
    options: Options = STANDARD,
    *,
    select: Sequence[str] = (),
    ignore: Sequence[str] = (),
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
    config: str | os.PathLike[str] | None = None,
) -> tuple[Finding, ...]:
    """Return the findings in one or several descriptions, in the order of the files and of their text: one for each
    cause in a file, with its `places`, also those in other files of which the same is said.

        for finding in robodyn.check("robot.urdf", ignore=["RD110"]):
            print(finding.line, finding.code, finding.message)

    They are those of the command `robodyn check`: the settings of a project hold for its files, and xacro files are
    expanded first.

    Args:
        sources: paths of URDF or xacro files, folders (every .urdf below them) or patterns (`robots/*.urdf`), or bytes,
            for which the settings of the current folder hold.
        options: which rules run, and against what; the arguments below are added to them.
        select, ignore: codes of rules (RD207) or their beginnings (RD2), to run and not to run. Without `select` it is
            DEFAULT: errors, and what is likely a defect; ALL is everything.
        package_paths: packages, or folders of packages, that are looked at first for meshes and what xacro includes.
        xacro_args: values of the arguments of xacro files; defaults hold for the others.
        trust_xacro: let xacro files that are named run any Python, read any file and all of the environment; not those
            of folders and patterns.
        config: a file whose settings hold for all, in place of robodyn.toml or pyproject.toml above each.

    Raises:
        InputError: a file cannot be read, nothing matches a pattern, there is no such rule, or settings are wrong."""
    given = replace(
        options,
        select=(*options.select, *map(str.upper, select)),
        ignore=(*options.ignore, *map(str.upper, ignore)),
        package_path=(*options.package_path, *(os.fspath(path) for path in package_paths)),
        xacro_args=(*options.xacro_args, *(xacro_args or {}).items()),
        trust_xacro=options.trust_xacro or trust_xacro,
    )
    files = [sources] if isinstance(sources, (str, bytes, os.PathLike)) else sources
    checked = check_tasks(tasks_for(files, given, None if config is None else os.fspath(config)))
    if checked.unread:
        raise checked.unread[0].error
    return checked.findings


def tasks_for(sources: Sequence[Source], given: Options = STANDARD, config: str | None = None) -> tuple[Task, ...]:
    """Return the files of the sources, each with its options: those of the call win over those of its project, or are
    added to them (see `Config.of`). The settings of the file `config` hold for all, by default those above each. Of a
    folder that is named xacro files may read every file. InputError where nothing matches a source, there is no such
    rule, or settings are wrong."""
    rules_for(given.select, given.ignore)
    fixed = None if config is None else read_config(config)
    known: dict[str, Config | None] = {}
    named = {os.fspath(source) for source in sources}
    folders = [source for source in named if isinstance(source, str) and os.path.isdir(source)]
    tasks = []
    for file in files_of(sources, given.including):
        options = given if file in named else replace(given, trust_xacro=False)
        above = Path(file).parents if isinstance(file, str) and is_xacro(file) else ()
        within = [folder for folder in folders if Path(folder) in above]
        options = replace(options, package_path=(*options.package_path, *within))
        tasks.append(Task(file, _options(file, options, fixed, known)))
    return tuple(tasks)


def check_description(description: Description, given: Options = STANDARD) -> Checked:
    """Return the findings in a description that was read, with the settings of its project; no file of what came in
    another format than URDF from none."""
    options = _options(description.file.removesuffix(EXPANDED), given, None, {})
    if description.format == "urdf":
        found = found_in(description.data, options, description.file)
    elif os.path.isfile(description.file):
        found = _judged(*as_urdf(description), options)
    else:
        return Checked((), ())
    return Checked((description.file,), found.shown, hidden=found.hidden)


def fix_task(task: Task, unsafe: bool = False) -> Fixed:
    """Return the text of a file with its fixes made (see `fixed`), which is not written; what is no URDF as it is."""
    name = task.name
    _, data = read_source(task.source, name)
    if is_xacro(task.source) or root_tag(data) in OTHER_FORMATS:
        return Fixed(name, data, data)
    return fixed(data, name, lambda text: places(found_in(text, task.options, name).shown), unsafe=unsafe)


def _options(file: str | bytes, given: Options, fixed: Config | None, known: dict[str, Config | None]) -> Options:
    path = STDIN if isinstance(file, bytes) else file
    config = fixed or find_config(os.path.dirname(path), known)
    return given if config is None else config.of(path, given)


@dataclass(frozen=True)
class Unread:
    """A file that could not be checked, and why: without its name, unless another one is at fault."""

    file: str
    error: InputError

    @property
    def why(self) -> str:
        return self.error.sentence if self.error.file in (None, self.file) else str(self.error)


@dataclass(frozen=True)
class Checked:
    """The files that were checked, and what was found, file by file and each in the order of its text; the files that
    could not be read, and the findings that are not selected."""

    files: tuple[str, ...]
    findings: tuple[Finding, ...]
    unread: tuple[Unread, ...] = ()
    hidden: tuple[Finding, ...] = ()

    def count(self, severity: Severity) -> int:
        return sum(finding.severity is severity for finding in self.findings)

    @property
    def fit(self) -> bool:
        return not self.count(Severity.ERROR)

    def of_link(self, name: str) -> Checked:
        subject = Subject("link", name)
        every = (self.findings, self.hidden)
        findings, hidden = (grouped(one for one in places(found) if one.subject == subject) for found in every)
        return replace(self, findings=findings, hidden=hidden)


@dataclass(frozen=True)
class Found:
    """What is shown of the findings in a file, and what is not; and a digest of its elements with their attributes."""

    shown: tuple[Finding, ...]
    hidden: tuple[Finding, ...] = ()
    content: str = ""


@dataclass(frozen=True)
class Task:
    """A file, or the bytes of standard input, and how to check it; its name as findings show it."""

    source: str | bytes
    options: Options

    @property
    def name(self) -> str:
        return STDIN if isinstance(self.source, bytes) else self.source


def check_tasks(tasks: Sequence[Task], done: Callable[[], None] = lambda: None) -> Checked:
    """Return the findings in all files; many are shared out among processes, one for each core. `done` is called after
    each. One that cannot be read stops no other; one that describes no robot is skipped, with a warning, and so is a
    URDF that is what one of the xacro files expands to."""
    shared_out = worth_processes([task.source for task in tasks])
    if shared_out:
        from robodyn.support.processes import each_in_a_process

        each = each_in_a_process(_outcome, [(task,) for task in tasks])
    else:
        each = map(_outcome, tasks)
    found, unread = list[tuple[str, Found]](), list[Unread]()
    for task, outcome in zip(tasks, each, strict=True):
        if isinstance(outcome, NoRobotError):
            warn(f"{outcome}: skipped", RobodynWarning, stacklevel=2)
        elif isinstance(outcome, InputError):
            unread.append(Unread(task.name, outcome))
        else:
            found.append((task.name, outcome))
        done()
    several = any(is_xacro(name) for name, _ in found)
    expanded = {each.content for name, each in found if is_xacro(name)}
    same = [name for name, each in found if each.content in expanded and not is_xacro(name)]
    if same:
        what = count(len(same), "URDF is what a xacro file expands to", "URDFs are what xacro files expand to")
        warn(f"{what}, and judged there: {listed_paths(same)}", RobodynWarning, stacklevel=2)
    found = [(name, each) for name, each in found if name not in same]
    shown, hidden = ([one for _, each in found for one in getattr(each, kind)] for kind in ("shown", "hidden"))
    together = across_robots if several else across_files
    return Checked(tuple(name for name, _ in found), tuple(together(shown)), tuple(unread), tuple(together(hidden)))


def _outcome(task: Task) -> Found | InputError:
    try:
        return found_in(task.source, task.options)
    except InputError as error:
        return error


def found_in(source: Source, options: Options = STANDARD, name: str | None = None) -> Found:
    """Return one finding for each cause in one file or its bytes, shown or hidden as is selected."""
    return _judged(*_read(source, options, name), options)


def _judged(reading: Document, expansion: Expansion | None, options: Options) -> Found:
    elements = [] if reading.robot is None else reading.root.walk()
    written = [(one.tag, sorted((key, each.value) for key, each in one.attributes.items())) for one in elements]
    content = sha256(repr(written).encode("utf-8", "surrogatepass")).hexdigest()
    return replace(select_findings(_findings(reading, expansion, options), options), content=content)


def select_findings(every: Sequence[Finding], options: Options) -> Found:
    """Return what `check_one` returns, with one finding for each cause, as what is shown and what is not."""
    shown, hidden = list[Finding](), list[Finding]()
    for finding in deduplicate(every, BY_CODE):
        (shown if is_selected(finding, options.select, options.asked) else hidden).append(finding)
    return Found(grouped(shown), grouped(hidden))


def check_one(source: Source, options: Options = STANDARD, name: str | None = None) -> tuple[Finding, ...]:
    """Return every place that the rules find in one file, or in its expansion, in the order of the text."""
    return _findings(*_read(source, options, name), options)


def _read(source: Source, options: Options, name: str | None) -> tuple[Document, Expansion | None]:
    """Return a description as it is read, of xacro its expansion, of other formats their URDF. NoRobotError where that
    has no link and no joint, or hangs on links that another xacro file of the folder or package has."""
    if isinstance(source, bytes) or not is_xacro(source):
        reading = read(source, name)
        if reading.robot is None and root_tag(reading.data) in OTHER_FORMATS:
            from robodyn.robot.load import load_description

            return as_urdf(load_description(source, name, package_paths=options.package_path))
        return reading, None
    from robodyn.robot.urdf.xacro import expanded, no_robot

    path = os.fspath(source)
    expansion = expanded(path, options.package_path, dict(options.xacro_args), options.trust_xacro)
    reading = read(expansion.text, (name or path) + EXPANDED)
    parts = [] if reading.robot is None else reading.root.children
    if reading.robot is not None and not any(part.tag in ("link", "joint") for part in parts):
        raise no_robot(path)
    links = {part.get("name") for part in parts if part.tag == "link"}
    ends = {
        kind: {end.get("link") for part in parts if part.tag == "joint" for end in part.findall(kind)}
        for kind in ("parent", "child")
    }
    hung_on = sorted(filter(None, ends["parent"] - links))
    is_part = 0 < len(hung_on) <= _MOST_HUNG_ON and ends["child"] <= links
    if is_part and (other := defined_beside(path, hung_on)) is not None:
        what = f"it is a part that hangs on {listed(hung_on)} of {os.path.basename(other)}"
        raise NoRobotError(what, remedy="name the file that includes both", file=path)
    return reading, expansion


def as_urdf(description: Description) -> tuple[Document, Expansion]:
    """Return the URDF of a description, and of each element of it what it comes from: the body, link or joint of the
    file. InputError of what is no file, or UTF-16."""
    from robodyn.robot.urdf.xacro import Expansion
    from robodyn.robot.write.urdf import new_urdf

    file = description.file
    if not os.path.isfile(file):
        raise InputError("MJCF and SDF are checked as files", remedy="name the file", file=file)
    source = read_document(description.data, file, root_tag(description.data))
    if source.data != description.data:
        raise InputError("the file is UTF-16 and is not checked", remedy="save it as UTF-8", file=file)
    starts: dict[int, int] = {}
    for element in source.root.walk():
        starts.setdefault(element.line, element.start)
    lines = {("link", link.name): link.line for link in description.links}
    lines |= {("joint", joint.name): joint.line for joint in description.joints}
    readable = tuple(
        replace(link, geometries=tuple(each for each in link.geometries if not (each.filename or "").endswith(_OWN)))
        for link in description.links
    )
    reading = read(new_urdf(replace(description, links=readable), file).encode(), file)
    places = [(0, source.root.start)]
    for part in reading.root.children:
        start = starts.get(lines.get((part.tag, part.get("name") or ""), 0), source.root.start)
        places += [(0, start) for _ in part.walk()]
    return reading, Expansion(reading.data, (file,), tuple(places))


def _findings(reading: Document, expansion: Expansion | None, options: Options) -> tuple[Finding, ...]:
    expanded_to = "" if expansion is None else options.expanded_to
    asked = replace(options.asked, xacro_args=options.xacro_args)
    context = Context(reading, options.thresholds, options.package_path, asked, CODES, expanded_to)
    rules = rules_for(options.select, options.ignore)
    if expansion is not None and not reading.file.endswith(EXPANDED):
        rules = tuple(rule for rule in rules if rule.code.startswith(_OF_ANY_FORMAT))
    findings = run_rules(context, rules)
    return findings if expansion is None else tuple(located(findings, reading, expansion))


def located(findings: Sequence[Finding], reading: Document, expansion: Expansion) -> Iterator[Finding]:
    """Yield the findings in an expanded description, without fixes, at the attributes or start tags that they come
    from, in macros perhaps; at the beginning of the file what cannot be traced back; unchanged what is in another file,
    as an SRDF."""
    described = reading.file.removesuffix(EXPANDED)
    elements = [] if reading.robot is None else list(reading.root.walk())
    elements = elements if len(elements) == len(expansion.places) else []
    starts = [element.start for element in elements]
    source_of = cache(lambda file: Document(file, read_input(file), "utf-8", (), None))
    for finding in findings:
        if finding.file != reading.file:
            yield replace(finding, description=described)
            continue
        k = bisect_right(starts, finding.start) - 1
        number, start = expansion.places[max(k, 0)]
        source, message = source_of(expansion.files[number]), finding.message
        if k < 0:
            at = SourcePositions(source.data, source.encoding).span(0, 0)
            message += f" (line {finding.line} of what `xacro {source.file}` prints)"
        else:
            written = Element("", defaultdict(str), 0, start, SourcePositions(source.data, source.encoding))
            at = written.span
            for name, attribute in elements[k].attributes.items():
                if attribute.span.start <= finding.start <= attribute.span.end and name in written.attributes:
                    whole = finding.start < attribute.value_span.start
                    at = written.attributes[name].span if whole else written.attributes[name].value_span
        where = replace(finding, line=at.line, column=at.column, start=at.start, end=at.end, message=message, fix=None)
        description = None if source.file == described else described
        yield replace(where, file=source.file, excerpt=excerpt(source, at), description=description)


def run_rules(context: Context, rules: Sequence[Rule]) -> tuple[Finding, ...]:
    """Return what these rules find and no waiver of the file allows, in the order of the text."""
    ready = [rule for rule in rules if context.reaches(rule.stage)]
    findings = [_finding(context, rule, fault) for rule in ready for fault in rule.check(context)]
    given = [waiver for waiver in context.once(waivers) if waiver.in_force(context.codes)]
    if given:
        ran = {rule.code for rule in ready}
        findings, unused = waived(context.reading, findings, given)
        if unused_waiver.code in ran:
            faults = (without_use(waiver, code) for waiver, code in unused if code in ran)
            findings += [_finding(context, unused_waiver, fault) for fault in faults]
    return tuple(sorted(findings, key=lambda finding: (finding.start, finding.code)))


def _finding(context: Context, rule: Rule, fault: Fault) -> Finding:
    reading, subject = fault.document or context.reading, fault.subject
    if subject is HERE:
        parts = reading.root.children
        k = bisect_right(parts, fault.at.start, key=lambda part: part.start) - 1
        known = k >= 0 and parts[k].tag in ("link", "joint")
        subject = subject_of(parts[k]) if known else None
    return Finding(
        code=rule.code,
        name=rule.name,
        severity=fault.severity or rule.severity,
        file=reading.file,
        line=fault.at.line,
        column=fault.at.column,
        start=fault.at.start,
        end=fault.at.end,
        subject=subject,
        message=fault.what if subject is None else f"{subject.words}: {fault.what}",
        remedy=fault.remedy,
        measured=fault.measured,
        bound=fault.bound,
        cause=fault.cause,
        fix=fault.fix,
        excerpt=excerpt(reading, fault.at),
        kind=fault.kind or kind_of(fault.what),
        description=None if fault.document is None else context.reading.file,
    )
