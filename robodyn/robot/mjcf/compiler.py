"""What MuJoCo's compiler makes of a file: numbers of the compiled model, names and lines.

1. `_check_files` reads the file and all that it includes, and refuses what lies outside of its folder.
2. `compiled` starts a process of its own, in which nothing is printed or logged and time and memory end.
3. `serve` compiles there, and answers with the arrays that `read` needs.
"""

from __future__ import annotations

import json
import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.document import Element, read_document
from robodyn.robot.urdf.sources import as_utf8, root_tag
from robodyn.support.extras import need
from robodyn.support.input_file import read_input
from robodyn.support.wording import shown

PATIENCE = 60.0
"""Seconds that the compiler may take."""
_MEMORY = 8 << 30
"""Bytes that its process may take."""
_MOST_FILES, _MOST_BODIES = 256, 20_000
_LINE = re.compile(r"\bline (\d+)")
_LONGEST = 300
_WITH_FILES = ("include", "model")
"""Elements whose files are read as descriptions."""
ARRAYS = (
    *("body_parentid", "body_weldid", "body_pos", "body_quat", "body_mass", "body_inertia", "body_ipos", "body_iquat"),
    *("body_jntadr", "body_jntnum", "body_gravcomp", "body_mocapid"),
    *("jnt_type", "jnt_pos", "jnt_axis", "jnt_range", "jnt_limited", "jnt_stiffness", "jnt_qposadr", "jnt_dofadr"),
    *("jnt_actfrclimited", "jnt_actfrcrange", "qpos0", "qpos_spring"),
    *("dof_armature", "dof_damping", "dof_frictionloss"),
    *("geom_bodyid", "geom_type", "geom_pos", "geom_quat", "geom_size", "geom_dataid", "geom_contype"),
    *("geom_conaffinity", "geom_group", "geom_fluid", "mesh_pos", "mesh_quat", "mesh_scale"),
    *("site_bodyid", "site_pos", "site_quat", "eq_type", "eq_obj1id", "eq_obj2id", "eq_objtype", "eq_active0"),
    *("eq_data", "actuator_trntype", "actuator_trnid", "actuator_gear", "actuator_gaintype", "actuator_biastype"),
    *("actuator_dyntype", "actuator_gainprm", "actuator_forcelimited", "actuator_forcerange"),
    *("actuator_ctrllimited", "actuator_ctrlrange", "actuator_outadr", "actuator_ctrladr", "actuator_armature"),
    *("actuator_damping", "actuator_plugin", "jnt_stiffnesspoly", "dof_dampingpoly"),
)
"""Of the compiled model, by MuJoCo's names."""
COUNTS = ("npair", "nflex", "nskin", "nplugin", "ntendon", "nmocap")
NAMED = ("body", "joint", "equality", "actuator", "mesh")


def compiled(data: bytes, file: str) -> dict[str, Any]:
    """Return what the compiler makes of a file: the arrays of `ARRAYS`, names and lines by kind, options.

    Raises:
        DescriptionError: it is not XML, includes what it may not, or the compiler refuses it; with the line.
        InputError: MuJoCo is not installed.
    """
    import subprocess
    from tempfile import TemporaryDirectory

    from robodyn.support.children import start_python

    own = os.path.isfile(file) and read_input(file) == data
    root = _check_files(data, file, own)
    need("MJCF files", "mujoco-core", file=file)
    path = os.path.abspath(file)
    question = {"file": path if own else "", "text": as_utf8(data)[0].decode(), "folder": os.path.dirname(path)}
    late = DescriptionError(f"MuJoCo's compiler is not done after {PATIENCE:g} s", remedy="leave parts out", file=file)
    with TemporaryDirectory() as folder:
        child = start_python(f"{__name__}:serve", folder=folder, stderr=subprocess.DEVNULL)
        try:
            said, _ = child.communicate(json.dumps(question).encode(), timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            raise late from None
        finally:
            child.kill()
            child.communicate()
    if child.returncode or not said:
        what = f"MuJoCo's compiler ended with status {child.returncode}"
        raise DescriptionError(what, remedy="is it a file that MuJoCo loads, and is there memory enough?", file=file)
    found: dict[str, Any] = json.loads(said)
    included = next((element for element in root.walk() if element.tag == "include"), None)
    if "problem" in found:
        text = found["problem"].removeprefix("Error: ").removeprefix("XML Error: ")
        place = _LINE.search(text)
        line = int(place[1]) or None if place and included is None else None
        raise DescriptionError(f"MuJoCo refuses it: {text[:_LONGEST]}", remedy="correct it", file=file, line=line)
    if included is not None:  # whose lines are of another file
        here = {(element.tag, element.line, element.get("name") or "") for element in root.walk()}
        for kind, lines in found["lines"].items():
            for k, (name, line) in enumerate(zip(found["names"][kind], lines, strict=True)):
                if not here & {(tag, line, name) for tag in (kind, "freejoint")}:
                    lines[k] = included.line
    return found


def _check_files(data: bytes, file: str, own: bool) -> Element:
    """Return the root element; raise if a file, or one that it includes, is not XML, has entities, or includes files
    from outside its folder.

    The compiler looks for a file in the folder of the model, then in that of the file that names it.
    """
    folder = os.path.dirname(os.path.abspath(file))
    within = os.path.realpath(folder)
    waiting, seen, root = [(data, file, folder)], set[str](), None
    while waiting:
        text, name, here = waiting.pop()
        inner = read_document(text, name, root_tag(text)).root
        root = inner if root is None else root
        for element in inner.walk():
            if element.tag not in _WITH_FILES or not (written := element.get("file")):
                continue
            what, remedy = f"<{element.tag}> of {shown(written)}", "name the description by its file"
            if own:
                places = [os.path.join(each, written) for each in (folder, here)]
                paths = dict.fromkeys(os.path.realpath(place) for place in places if os.path.isfile(place))
                if paths and all(Path(path).is_relative_to(within) for path in paths):
                    for path in paths.keys() - seen:
                        seen.add(path)
                        more = read_input(path)
                        if root_tag(more) != "robot" and more[:2] != b"PK":
                            waiting.append((more, os.path.join(os.path.dirname(file), written), os.path.dirname(path)))
                    if len(seen) <= _MOST_FILES:
                        continue
                    what, remedy = f"{what}: more than {_MOST_FILES} files", "include fewer"
                elif paths:
                    what, remedy = f"{what}, outside of the folder of the description", "move it below that folder"
                else:
                    what, remedy = f"{what}, which is not there", "names are relative to the folder of the description"
            else:
                what = f"{what} in what comes from no file"
            raise DescriptionError(what, remedy=remedy, file=name, line=element.line)
    assert root is not None, "the file itself was read"
    return root


def serve() -> None:
    """Compile what standard input asks for, and answer with JSON on standard output, which nothing else reaches."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    asked = json.loads(sys.stdin.buffer.read())
    try:
        said = _extracted(asked["file"], asked["text"], asked["folder"])
    except Exception as error:
        said = {"problem": " ".join(str(error).split()) or type(error).__name__}
    answers.write(json.dumps(said).encode())
    answers.flush()
    os._exit(0)


def _extracted(file: str, text: str, folder: str) -> dict[str, Any]:
    import mujoco

    spec = mujoco.MjSpec.from_file(file) if file else mujoco.MjSpec.from_string(text)
    if not file:
        spec.modelfiledir = folder
    model = spec.compile()
    if model.nbody > _MOST_BODIES:
        return {"problem": f"it has {model.nbody} bodies, more than {_MOST_BODIES} are not read"}
    found: dict[str, Any] = {key: getattr(model, key).tolist() for key in ARRAYS if hasattr(model, key)}
    found |= {key: int(getattr(model, key)) for key in COUNTS if hasattr(model, key)}
    kinds = {kind: getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}") for kind in NAMED}
    counts = {"body": model.nbody, "joint": model.njnt, "equality": model.neq, "mesh": model.nmesh}
    counts["actuator"] = len(found["actuator_trntype"])
    names = {
        kind: [mujoco.mj_id2name(model, which, k) or "" for k in range(counts[kind])] for kind, which in kinds.items()
    }
    lines = {}
    for kind, elements in (("body", spec.bodies), ("joint", spec.joints)):
        lines[kind] = [1] * counts[kind]
        for element in elements:
            place = _LINE.search(element.info)
            if place and 0 <= element.id < counts[kind] and element.name in ("", names[kind][element.id]):
                lines[kind][element.id] = int(place[1])
    ends = [(start, model.paths.find(b"\0", start)) for start in model.mesh_pathadr.tolist()]
    turned = [bool(any(mesh.refpos) or abs(mesh.refquat[0]) < 1.0) for mesh in spec.meshes]
    flags = [each for name, each in mujoco.mjtDisableBit.__members__.items() if name.startswith("mjDSBL")]
    off = {each.name[7:].lower() for each in flags if model.opt.disableflags & each.value}
    off |= {"equality", "frictionloss", "limit", "contact"} if "constraint" in off else set()
    filters = (mujoco.mjtDyn.mjDYN_NONE, mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT)
    return found | {
        "name": "" if spec.modelname == mujoco.MjSpec().modelname else spec.modelname,
        "names": names,
        "lines": lines,
        "files": ["" if start < 0 else os.fsdecode(model.paths[start:end]) for start, end in ends],
        "turned": turned,
        "off": sorted(off),
        "filters": [int(each.value) for each in filters],
        "option": {key: getattr(model.opt, key).tolist() for key in ("gravity", "wind")}
        | {key: float(getattr(model.opt, key)) for key in ("density", "viscosity")},
        "kinds": {
            name[2:].lower(): int(each.value)
            for kind in (mujoco.mjtJoint, mujoco.mjtGeom, mujoco.mjtEq, mujoco.mjtTrn, mujoco.mjtObj, mujoco.mjtGain)
            for name, each in kind.__members__.items()
        },
    }
