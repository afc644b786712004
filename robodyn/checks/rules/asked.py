"""What is asked for: limits along a motion, verdicts of programs, the earlier version."""

from __future__ import annotations

import os
from collections.abc import Iterator
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robodyn.checks.context import TARGETS
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.imported import INSTALLABLE, verdict_of
from robodyn.checks.importers import FACTS, Verdict, named
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.errors import InputError
from robodyn.programs.vectors import length
from robodyn.robot.urdf.sources import EXPANDED, is_xacro
from robodyn.robot.urdf.view import JointView, LinkView, Subject
from robodyn.support.floats import first_largest

if TYPE_CHECKING:
    from robodyn.robot.model import Model


@rule(
    "RD802",
    Severity.WARNING,
    Stage.MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="9"/>'),
    bad=('lower="-2" upper="2"', 'lower="-0.5" upper="0.5"'),
)
def limits_along_motion(context: Context) -> Faults:
    """The limits hold along the given motion.

    With --trajectory FILE: the torques of inverse dynamics, speeds and positions along the motion, against effort,
    velocity, lower and upper. It is what robodyn torques --fail-on-limits says, among the other findings. The
    examples are held against a motion that swings the arm by 1 rad.
    """
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
        what = (
            f"the motion of {context.asked.trajectory} reaches {excess.quantity} {excess.value:.4g} "
            f"{excess.unit}, beyond the limit {excess.limit:g}"
        )
        remedy = "slow the motion down or raise the limit; robodyn torques says when"
        yield Fault(getattr(joint.limit, name).span, what, remedy, excess.value, excess.limit)


_TOOL = a_link("tool") + a_joint("yaw", "cross", "tool")

_KNOWN = "\n".join(f"{fact.target} {fact.verdict.name.lower()}: it {fact.does} [{fact.source}]." for fact in FACTS)


@rule(
    "RD901",
    Severity.NOTE,
    Stage.TREE,
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


@rule("RD902", Severity.WARNING, Stage.MODEL, good=arm(), bad=('value="2"', 'value="2.2"'))
def regression(context: Context) -> Faults:
    """The dynamics are those of the earlier version.

    With --against REF, the robot is compared with what git has of the same file at that revision: joints that come,
    go, move or change their order, types, axes, limits and friction; masses, centres of mass and inertias of the
    moving bodies, with everything fixed to them; and the torques of both in random states, in percent of the
    largest. Moving a fixed frame, renaming a fixed joint or splitting a link changes nothing here. Of a xacro file the
    version is expanded with the files that it includes as they were. The examples are two versions of a file: the bad
    one is compared with the good one.
    """
    against = context.asked.against
    if against is None:
        return
    before = model_at(context, against)
    if isinstance(before, str):
        what = f"the dynamics are not compared with {against}: {before}"
        yield Fault(context.view.root.span, what, "nothing to do", subject=None, severity=Severity.NOTE)
        return
    parts: dict[Subject, LinkView | JointView] = {part.subject: part for part in context.view.links}
    parts |= {part.subject: part for part in context.view.joints}
    for subject, what, size in changes(before, context.model):
        at = parts[subject].name_span if subject in parts else context.view.root.span
        measured = size if isfinite(size) else None
        yield Fault(at, f"{what}, against {against}", "see that the change is meant", measured, subject=subject)


SAME = 1e-9
"""Relative differences that are no more are rounding."""
_MESHES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".png", ".jpg", ".STL", ".bag", ".mcap")
"""What descriptions include none of."""
_PLAIN = ("-c", "safe.bareRepository=explicit", "-c", "core.fsmonitor=false")
"""No settings that name programs are taken from a repository that lies among the files of another."""
_STATES = 32
_SEED = 20_26


Change = tuple[Subject, str, float]
"""A link, joint or the robot, what is different in it, and how much."""


def model_at(context: Context, ref: str) -> Model | str:
    """Return the robot of a file at a git revision, of xacro with what it includes there; or why there is none.

    Raises:
        InputError: git is not there, the file is in no repository, or that has no such revision.
    """
    from io import BytesIO
    from tarfile import open as open_archive
    from tempfile import TemporaryDirectory

    from robodyn.robot.load import load
    from robodyn.support.children import run_program

    file = Path(context.reading.file.removesuffix(EXPANDED)).resolve()

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
        given = f"--against takes a revision of git, and {ref!r} is a file" if os.path.exists(ref) else ""
        raise InputError(given or f"git has no revision {ref!r}", remedy=remedy)
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


def changes(before: Model, after: Model) -> Iterator[Change]:
    """Yield what differs in joints, in masses, centres and tensors of links with everything fixed to them, and in the
    torques: of inverse dynamics in 32 random states, the same in every run, of the coordinates that both have, the
    others being at rest, the largest difference in a state over the largest torque there."""
    from robodyn.dynamics.inverse import inverse_dynamics

    robot = Subject("robot", after.name)
    yield from (change for change in (*_joints(before, after), *_bodies(before, after)) if change[2] > SAME)
    common = [name for name in after.rates if name in before.rates]
    if not common or any(joint.kind == "floating" for joint in (*before.independent, *after.independent)):
        return
    rng = np.random.default_rng(_SEED)
    states = [rng.uniform(-2.0, 2.0, (_STATES, len(common))) for _ in range(3)]
    tau = []
    for model in (before, after):
        places = [model.rates.index(name) for name in common]
        given = np.zeros((3, _STATES, model.n))
        given[:, :, places] = states
        tau.append(inverse_dynamics(model, *given, executor="numpy")[:, places])
    difference, largest = np.abs(tau[1] - tau[0]).max(axis=1), np.abs(tau).max(axis=(0, 2))
    relative = difference / np.where(largest > 0.0, largest, 1.0)
    worst = first_largest(relative)
    if (apart := float(relative[worst])) > SAME:
        what = f"torques differ by up to {100 * apart:.3g} % in random states ({difference[worst]:.3g} N m or N)"
        yield robot, what, apart


def _joints(before: Model, after: Model) -> Iterator[Change]:
    robot, (old, new) = (
        Subject("robot", after.name),
        (
            {body.joint.name: body.joint for body in model.bodies if body.joint.kind != "fixed"}
            for model in (before, after)
        ),
    )
    yield from ((robot, f"joint {name!r} is gone", inf) for name in old if name not in new)
    for name, joint in new.items():
        subject = Subject("joint", name)
        if name not in old:
            yield subject, "the joint is new", inf
            continue
        for what in ("kind", "axis", "lower", "upper", "effort", "velocity", "damping", "friction"):
            was, now = (getattr(each, what) for each in (old[name], joint))
            if what == "axis":
                was, now = tuple(was.tolist()), tuple(now.tolist())
            if was != now:
                words = [f"{value:g}" if isinstance(value, float) else str(value) for value in (was, now)]
                yield subject, f"{'type' if what == 'kind' else what} {words[0]} has become {words[1]}", inf
        moved = max(float(np.abs(old[name].R - joint.R).max()), float(np.abs(old[name].p - joint.p).max()))
        yield subject, f"its place has moved by {moved:.3g} (m, or in the rotation)", moved
    if [name for name in before.joint_names if name in new] != [name for name in after.joint_names if name in old]:
        yield robot, "the joints are in another order", inf


def _bodies(before: Model, after: Model) -> Iterator[Change]:
    old = {body.name: body.inertia for body in before.bodies}
    for body in after.bodies:
        if body.name not in old:
            continue
        subject, was, now = Subject("link", body.name), old[body.name], body.inertia
        mass = abs(now.m - was.m) / max(abs(now.m), abs(was.m), 1e-300)
        yield subject, f"mass {was.m:.6g} kg has become {now.m:.6g} kg", mass
        centre = length(now.centre_of_mass - was.centre_of_mass)
        yield subject, f"the centre of mass has moved by {centre:.3g} m", centre
        size = max(float(np.abs(now.I).max()), float(np.abs(was.I).max()), 1e-300)
        tensor = float(np.abs(now.I - was.I).max()) / size
        yield subject, f"the inertia about its origin has changed by {100 * tensor:.3g} %", tensor
