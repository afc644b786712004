"""What is asked for: limits along a motion, verdicts of programs, the earlier version."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from robodyn.checks.context import TARGETS
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.imported import INSTALLABLE, verdict_of
from robodyn.checks.importers import FACTS, Verdict, named
from robodyn.checks.rule import MODEL, NOTE, TREE, WARNING, Context, Fault, Faults, rule
from robodyn.errors import InputError
from robodyn.robot.urdf.sources import EXPANDED, is_xacro
from robodyn.robot.urdf.view import JointView, LinkView, Subject

if TYPE_CHECKING:
    from robodyn.robot.model import Model


@rule(
    "RD802",
    WARNING,
    MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="9"/>'),
    bad=('lower="-2" upper="2"', 'lower="-0.5" upper="0.5"'),
)
def limits_along_motion(context: Context) -> Faults:
    """The limits hold along the given motion.

    With --trajectory FILE: the torques of inverse dynamics, speeds and positions along the motion, against effort,
    velocity, lower and upper. It is what robodyn torques --fail-on-limits says, among the other findings. The examples
    are held against a motion that swings the arm by 1 rad."""
    if context.asked.trajectory is None:
        return
    from robodyn.loads.torques import torques
    from robodyn.trajectory.read import read_motion

    with read_motion(context.asked.trajectory, context.model, **context.asked.reading) as motion:
        result = torques(context.model, motion)
    for caveat in motion.caveats:
        what = f"limits along {context.asked.trajectory} hold only {caveat.kind}: {caveat.text}"
        yield Fault(context.view.root.span, what, "say which unit it is", subject=None)
    for excess in result.exceeded:
        joint = context.view.joint[excess.joint]
        assert joint.limit is not None, "a limit is exceeded"
        name: str = excess.quantity
        if name == "position":
            name = "lower" if excess.value < excess.limit else "upper"
        what = f"the motion of {context.asked.trajectory} reaches {excess.quantity} {excess.value:.4g} "
        what += f"{excess.unit}, beyond the limit {excess.limit:g}"
        remedy = "slow the motion down or raise the limit; robodyn torques says when"
        yield Fault(getattr(joint.limit, name).span, what, remedy, excess.value, excess.limit)


_TOOL = a_link("tool") + a_joint("yaw", "cross", "tool")

_KNOWN = "\n".join(f"{fact.target} {fact.verdict.name.lower()}: it {fact.does} [{fact.source}]." for fact in FACTS)


@rule(
    "RD901",
    NOTE,
    TREE,
    explanation=f"""For each program asked for ({", ".join(TARGETS)}) its verdict: loads, alters, or rejects and why. A
rejection by a program that is asked for is an error, all else a remark. {" and ".join(INSTALLABLE)} are run where they
are installed (extra `importers`), in a process of their own, and their version is given, and why they refuse the file,
or what they hold otherwise: masses, centres, inertias, limits, links fused or dropped, shapes left out. What others do,
and these where they are not installed, is looked up in a table of what holds for all versions. Without being asked
nothing is run, and only what the table knows {" and ".join(INSTALLABLE)} to reject is reported where no other rule
tells of the same link or joint why. Of meshes RD601 and RD607 tell. The table:
{_KNOWN}""",
    good=arm(more=a_link("cross") + a_joint("pitch", "upper", "cross") + _TOOL),
    bad=arm(more=a_link("cross", "") + a_joint("pitch", "upper", "cross") + _TOOL),
)
def consumer_verdict(context: Context) -> Faults:
    """The programs that a description is meant for take it as it is."""
    for target in context.asked.targets:
        yield verdict_of(context, target)
    alone = {*map(named, context.view.links), *map(named, context.view.joints)}
    for fact in () if context.asked.targets else FACTS:
        if fact.target in INSTALLABLE and fact.verdict is Verdict.REJECTS:
            does = f"{fact.target} rejects it: it {fact.does}"
            for at, one in fact.find(context):
                yield Fault(at, does if one in alone else f"{does} ({one})", f"known from {fact.source}", kind=does)


@rule("RD902", WARNING, MODEL, good=arm(), bad=('value="2"', 'value="2.2"'))
def regression(context: Context) -> Faults:
    """The dynamics are those of the earlier version.

    With --against REF, the robot is compared with what git has of the same file at that revision, with --against FILE
    with another description, as `robodyn diff` does: the tree, joints, masses, what acts on joints, and the torques of
    both. Moving a fixed frame, renaming a fixed joint or splitting a link changes nothing here. Of a xacro file the
    version is expanded with the files that it includes as they were. The bad example is compared with the good one."""
    against = context.asked.against
    if against is None:
        return
    before = model_at(context, against)
    if isinstance(before, str):
        what = f"the dynamics are not compared with {against}: {before}"
        yield Fault(context.view.root.span, what, "nothing to do", subject=None, severity=NOTE)
        return
    parts: dict[Subject, LinkView | JointView] = {part.subject: part for part in context.view.links}
    parts |= {part.subject: part for part in context.view.joints}
    from robodyn.comparison.compare import compare

    found = compare(before, context.model)
    for one in found.differences:
        subject = Subject(one.subject, one.name)
        at = parts[subject].name_span if subject in parts else context.view.root.span
        cause = f" ({one.cause.replace('in B', 'here').replace('in A', f'in {against}')})" if one.cause else ""
        what = f"{one.kind} {one.says[0]} in {against}, {one.says[1]} here{cause}"
        yield Fault(at, what, "see that the change is meant", one.size, subject=subject)
    worst = found.worst
    if worst is not None and worst.worst > 0.0 and found.differences:
        what = f"torques differ, most of all that of {worst.joint} by {worst.worst:.3g} {worst.unit}"
        what += f" ({100.0 * worst.share:.3g} % of its {'limit' if worst.limit else 'largest'}), against {against}"
        yield Fault(context.view.root.span, what, "see that the change is meant", worst.worst, subject=None)


_MESHES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".png", ".jpg", ".STL", ".bag", ".mcap")
"""What descriptions include none of."""
_PLAIN = ("-c", "safe.bareRepository=explicit", "-c", "core.fsmonitor=false")
"""No settings that name programs are taken from a repository that lies among the files of another."""


def model_at(context: Context, ref: str) -> Model | str:
    """Return the robot of a file at a git revision, of xacro with what it includes there, or of another file; or why
    there is none. InputError without git, a repository that the file is in, or such a revision."""
    from io import BytesIO
    from tarfile import open as open_archive
    from tempfile import TemporaryDirectory

    from robodyn.robot.load import load
    from robodyn.support.children import run_program

    file = Path(context.reading.file.removesuffix(EXPANDED)).resolve()
    if os.path.isfile(ref):
        return load(ref, package_paths=context.package_path, xacro_args=dict(context.asked.xacro_args))

    def git(*words: str, folder: Path = file.parent) -> bytes | None:
        try:
            run = run_program("git", *_PLAIN, *words, folder=str(folder), GIT_NO_LAZY_FETCH="1", LC_ALL="C")
        except OSError as error:
            raise InputError(f"git cannot be run: {error}", remedy="install git, or leave --against out") from None
        return None if run.returncode else run.stdout

    top = git("rev-parse", "--show-toplevel")
    if top is None:
        raise InputError(f"{file.name} is in no git repository, which has its versions", remedy="leave --against out")
    if git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{ref}^{{tree}}") is None:
        remedy = f"give one such as HEAD~1 or main, with which {file.name} itself is compared: git log lists them"
        raise InputError(f"git has no revision {ref!r}", remedy=remedy)
    root = Path(os.fsdecode(top).rstrip("\r\n")).resolve()
    place = file.relative_to(root)
    wanted = [f":(literal){place.as_posix()}"]
    if is_xacro(str(file)):
        wanted = [f":(exclude)*{suffix}" for suffix in _MESHES]
    archive = git("archive", "--format=tar", ref, *wanted, folder=root)
    with TemporaryDirectory() as folder:
        then = Path(folder).resolve()
        if archive:
            with open_archive(fileobj=BytesIO(archive)) as members:
                for member in members:
                    to = (then / member.name).resolve()
                    if member.isfile() and to.is_relative_to(then) and (data := members.extractfile(member)):
                        to.parent.mkdir(parents=True, exist_ok=True)
                        to.write_bytes(data.read())
        if not (then / place).is_file():
            return "the file is not there"
        paths = [Path(each).resolve() for each in context.package_path]
        paths = [then / each.relative_to(root) if each.is_relative_to(root) else each for each in paths]
        try:
            return load(then / place, package_paths=paths, xacro_args=dict(context.asked.xacro_args))
        except InputError as error:
            return f"its version cannot be read: {error.what}"
