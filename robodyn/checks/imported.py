"""What MuJoCo and Drake, where they are installed, make of a description: each file is read in a process of its own.

What they print stays there, and so does their end. What they hold of links, joints and shapes comes back and is
compared with what the description says; see `verdict_of`.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from html import escape
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from robodyn.checks.bodies.masses import inertia_together, principal_moments
from robodyn.checks.context import Context
from robodyn.checks.importers import FACTS, Found, Verdict, named
from robodyn.checks.meshes.files import mesh_names
from robodyn.checks.rule import Fault, Severity
from robodyn.robot.masses.mistakes import UPPER
from robodyn.robot.urdf.edits import Edit, edited
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import JointView, LinkView

INSTALLABLE = "mujoco", "drake"  # programs that can be run: targets, and the packages to install
_PACKAGE = re.compile(rb"(?:package|model)://([^/\"']+)/")
PATIENCE = 60.0  # s
Held = Mapping[str, Any]
"""What a program holds. `bodies`: by name mass [kg], centre of mass [m] and moments about it in the frame of the link
(xx, xy, xz, yy, yz, zz) [kg m^2]; `joints`: by name `limits` and `friction`; `free`: bodies that float; `coupled`: the
joints that mimic others, of MuJoCo; `shapes`: how many of each kind."""
_CHANGED = 1e-6  # relative, or m, from which a number is another one
_FUSED, _DROPPED, _WORLD = "fuses {} with what carries them", "drops {}", "makes {} a part of the world, without mass"
_MOST = 3
_LONGEST = 300
_SAYS = {Verdict.LOADS: "loads it as it is", Verdict.ALTERS: "loads it with changes", Verdict.REJECTS: "rejects it"}
_LISTED = 12
EXTRA = "importers"


def answer(context: Context, target: str) -> tuple[str | None, str | None, Held | None]:
    """The version of an installable program, None where it is not installed; why it refuses a file, None where it does
    not; what it holds of it, of a refused one without its shapes: read in a process of its own, which is killed after
    60 s. A description that is not the file itself, such as expanded xacro, is handed over in a temporary folder, with
    the paths of the meshes that its own lead to."""
    import subprocess
    from importlib.metadata import PackageNotFoundError, version
    from tempfile import TemporaryDirectory

    from robodyn.support.children import start_python
    from robodyn.support.input_file import read_input

    try:
        installed = version(target)
    except PackageNotFoundError:
        return None, None, None
    data = context.reading.data
    names = {name.decode(errors="replace") for name in _PACKAGE.findall(data)}
    shares = {name: context.search.share(name) for name in sorted(names)}
    packages = {name: str(share.resolve()) for name, share in shares.items() if share is not None}
    with TemporaryDirectory() as folder:
        file = Path(context.reading.file).resolve()
        if not file.is_file() or read_input(file) != data:
            file = Path(folder) / "robot.urdf"
            edits = [
                Edit(use.at.start, use.at.end, escape(str(one.path.resolve())))
                for one in context.once(mesh_names).values()
                for use in one.uses
                if one.path is not None and "://" not in one.uri
            ]
            file.write_bytes(edited(data, edits, context.reading.encoding))
        arguments = target, str(file), json.dumps(packages)
        child = start_python(f"{__name__}:serve", *arguments, folder=folder, stderr=subprocess.DEVNULL)
        try:
            said, _ = child.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return installed, f"it is not done after {PATIENCE:g} s", None
        finally:
            child.kill()
            child.communicate()
        if not said:
            return installed, f"its process ended with status {child.returncode}", None
        refused, held = json.loads(said)
        if refused is None and held is None:  # it is there and cannot be imported
            return None, None, None
        return installed, refused and refused.replace(f"{folder}{os.sep}", ""), held


def serve(target: str, file: str, packages: str) -> None:
    """Read a file, and write in JSON why it is refused, and what is held of it; what is printed goes nowhere."""
    from xml.etree import ElementTree

    out, refused, held = os.dup(1), None, None
    os.dup2(2, 1)

    def read(path: str) -> Any:
        return _in_mujoco(path) if target == "mujoco" else _in_drake(path, json.loads(packages))

    try:
        held = read(file)
    except ImportError:
        pass
    except (Exception, SystemExit) as error:  # the latter is how Drake ends a process
        refused = " ".join(str(error).split())
        with suppress(Exception, SystemExit):
            tree = ElementTree.parse(file)
            for link in tree.iter("link"):
                for shape in (*link.findall("visual"), *link.findall("collision")):
                    link.remove(shape)
            tree.write("without_shapes.urdf", "utf-8")
            held = {**read("without_shapes.urdf"), "shapes": {}}
    with os.fdopen(out, "w") as stream:
        json.dump([refused, held], stream)
    os._exit(0)


def _in_mujoco(file: str) -> Any:
    import mujoco

    model = mujoco.MjModel.from_xml_path(file)
    bodies, joints = {}, {}
    for k in range(1, model.nbody):
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, model.body_iquat[k])
        tensor = R.reshape(3, 3) * model.body_inertia[k] @ R.reshape(3, 3).T
        bodies[model.body(k).name] = [model.body_mass[k], *model.body_ipos[k], *tensor[UPPER]]
    for k in range(model.njnt):
        limits = model.jnt_range[k].tolist() if model.jnt_limited[k] else [-inf, inf]
        joints[model.joint(k).name] = {"limits": limits, "friction": model.dof_frictionloss[model.jnt_dofadr[k]]}
    tied = model.eq_type == mujoco.mjtEq.mjEQ_JOINT
    seen = int((model.geom_contype == 0).sum())
    return {
        "bodies": bodies,
        "joints": joints,
        "free": [model.body(model.jnt_bodyid[k]).name for k in range(model.njnt) if model.jnt_type[k] == 0],
        "coupled": [model.joint(k).name for k in model.eq_obj1id[tied].tolist()],
        "shapes": {"visual": seen, "collision": model.ngeom - seen},
    }


def _in_drake(file: str, packages: Mapping[str, str]) -> Any:
    from pydrake.geometry import Role
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, 1e-3)
    parser = Parser(plant)
    for name, folder in packages.items():
        parser.package_map().Add(name, Path(folder))
    (robot,) = parser.AddModels(Path(file))
    plant.Finalize()
    builder.Build().CreateDefaultContext()
    bodies, joints = {}, {}
    for body in map(plant.get_body, plant.GetBodyIndices(robot)):
        inertia, centre = body.default_spatial_inertia(), body.default_com()
        at_centre = inertia.Shift(centre).CalcRotationalInertia().CopyToFullMatrix3()
        bodies[body.name()] = [body.default_mass(), *centre, *at_centre[UPPER]]
    for joint in map(plant.get_joint, plant.GetJointIndices(robot)):
        limits = [joint.position_lower_limits(), joint.position_upper_limits()]
        joints[joint.name()] = {"limits": [end[0] for end in limits] if joint.num_positions() == 1 else None}
    shapes = scene.model_inspector()
    return {
        "bodies": bodies,
        "joints": joints,
        "free": [plant.get_body(k).name() for k in plant.GetFloatingBaseBodies()],
        "shapes": {
            "visual": shapes.NumGeometriesWithRole(Role.kIllustration),
            "collision": plant.num_collision_geometries(),
        },
    }


def differences(context: Context, held: Held) -> Iterator[tuple[Found, str]]:
    """Yield what a program holds otherwise than the description says: where, and what."""
    bodies, found = held["bodies"], dict[str, list[Found]]()
    carrier: dict[str, str | None] = {}
    parts: dict[str, list[LinkView]] = {}
    for link in context.tree.links:
        joint = context.tree.above.get(link.name)
        above = None if joint is None or joint.moves else carrier[joint.parent]
        carrier[link.name] = by = link.name if link.name in bodies else above
        if by is not None:
            parts.setdefault(by, []).append(link)
        if by != link.name and (by or link.mass or (joint is not None and joint.moves)):
            told = _FUSED if by else _WORLD if joint is None or not joint.moves else _DROPPED
            found.setdefault(told, []).append((link.element.span, named(link)))
    for name, links in parts.items():
        if change := _changed(context, links, bodies[name]):
            yield (links[0].element.span, named(links[0])), change
    for name in (name for name in held["free"] if name in context.view.link):
        found.setdefault("lets {} float", []).append((context.view.link[name].element.span, f"link '{name}'"))
    for joint in context.view.joints:
        for told in _of_joint(joint, held):
            found.setdefault(told, []).append((joint.element.span, named(joint)))
    for kind, amount in held["shapes"].items():
        of = [link for link in context.view.links for one in link.geometries if one.kind == kind]
        if amount < len(of):
            yield (of[0].element.span, ""), f"it leaves out {len(of) - amount} of {len(of)} <{kind}>"
    for told, places in found.items():
        yield places[0], f"it {told.format(listed_places(places))}"


def listed_places(places: Sequence[Found]) -> str:
    more = f" and {len(places) - _MOST} more" if len(places) > _MOST else ""
    return ", ".join(each for _, each in places[:_MOST]) + more


def _of_joint(joint: JointView, held: Held) -> Iterator[str]:
    known = held["joints"].get(joint.name)
    if known is None:
        if joint.type in WITH_RANGE or joint.type == "continuous":
            yield _DROPPED
        return
    if joint.limit is not None and joint.type in WITH_RANGE:
        ends = [end.value for end in (joint.limit.lower, joint.limit.upper) if end.value is not None]
        if ends[1:] and not np.allclose(known["limits"], ends, rtol=_CHANGED, atol=_CHANGED):
            yield "ignores the limits of {}" if known["limits"] == [-inf, inf] else "sets other limits to {}"
    if joint.friction.value and not known.get("friction"):
        yield "ignores the friction of {}"
    if joint.mimic is not None and "coupled" in held:
        yield "makes <mimic> of {} a soft constraint" if joint.name in held["coupled"] else "ignores <mimic> of {}"


def _changed(context: Context, links: Sequence[LinkView], held: Sequence[float]) -> str | None:
    """How the mass, the centre or the moments of links that are one body differ."""
    whole, mass = inertia_together(context, links), sum(link.mass or 0.0 for link in links)
    of = named(links[0])
    if not np.isclose(held[0], mass, rtol=_CHANGED, atol=0.0):
        return f"it gives {of} {held[0]:.4g} kg, not {mass:.4g} kg"
    if whole is None or not mass:
        return None
    moved = float(np.linalg.norm(np.subtract(held[1:4], whole.centre_of_mass)))
    if moved > _CHANGED:
        return f"it moves the centre of mass of {of} by {moved:.3g} m"
    tensor, given = np.array(held[4:]), whole.about_centre[UPPER]
    if not np.allclose(tensor, given, rtol=0.0, atol=_CHANGED * max(np.abs(tensor).max(), np.abs(given).max())):
        moments = (", ".join(f"{x:.4g}" for x in principal_moments(tuple(one.tolist()))) for one in (tensor, given))
        return "it gives {} principal moments of {} kg m^2, not {}".format(of, *moments)
    return None


def verdict_of(context: Context, target: str) -> Fault:
    """What a program makes of a file. From stage TREE on. Of an installed one it is what it refuses or changes; of
    others the facts with the worst verdict that the table has, and that hold for all versions."""
    version, refused, held = answer(context, target) if target in INSTALLABLE else (None, None, None)
    reasons, places, known = list[str](), list[Found](), list[str]()
    verdict = Verdict.LOADS if refused is None else Verdict.REJECTS
    if refused is not None:
        reasons.append(f'it says "{refused[:_LONGEST]}"')
    if version is None or refused is not None:
        facts = [fact for fact in FACTS if fact.target == target]
        counted = [(fact, found) for fact in facts if (found := list(fact.find(context)))]
        verdict = max(verdict, *(fact.verdict for fact, _ in counted), Verdict.LOADS)
        shown = [(fact, found) for fact, found in counted if fact.verdict is verdict]
        reasons += [f"it {fact.does} ({listed_places(found)})" for fact, found in shown]
        places = [found[0] for _, found in shown]
        known = [f"known from {'; '.join(dict.fromkeys(fact.source for fact, _ in shown))}"] if shown else []
    if held is not None:
        changed = [*differences(context, held)]
        verdict = max(verdict, Verdict.ALTERS if changed else Verdict.LOADS)
        more = [f"{len(changed) - _LISTED} more changes"] if len(changed) > _LISTED else []
        said = [*(what for _, what in changed[:_LISTED]), *more]
        reasons += said if refused is None else [f"without its shapes {each}" for each in said[:1]] + said[1:]
        places += [at for at, _ in changed]
    what = f"{target} {_SAYS[verdict]}" + (f": {'; '.join(reasons)}" if reasons else "")
    if target in INSTALLABLE:
        absent = f'not run, since it is not installed (pip install "robodyn[{EXTRA}]")'
        known.insert(0, f"run in version {version}" if version else absent)
    at = places[0][0] if places else context.view.root.span
    severity = Severity.ERROR if verdict is Verdict.REJECTS else Severity.NOTE
    return Fault(at, what, "; ".join(known) or "nothing to do", subject=None, severity=severity)
