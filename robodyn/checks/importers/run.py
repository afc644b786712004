"""MuJoCo and Drake themselves, asked whether they take a description."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import NamedTuple

from robodyn.checks.context import Context

INSTALLABLE = {"mujoco": "mujoco", "drake": "drake"}
"""Programs that can be run, by the package to install."""
_PACKAGE = re.compile(rb"(?:package|model)://([^/\"']+)/")
PATIENCE = 60.0
"""s."""


class Answer(NamedTuple):
    """The version of a program, None where it is not installed; and why it refuses a file, None where it does not."""

    version: str | None
    refusal: str | None = None


def answer(context: Context, target: str) -> Answer | None:
    """What a program says of a file; None of programs that cannot be run.

    It reads the file in a process of its own, and is killed after 60 s. A description that is not the file itself, such
    as expanded xacro, is handed over in a temporary folder.
    """
    if target not in INSTALLABLE:
        return None
    import subprocess
    from tempfile import TemporaryDirectory

    from robodyn.support.children import start_python
    from robodyn.support.input_file import read_input

    if (installed := _version(INSTALLABLE[target])) is None:
        return Answer(None)
    names = {name.decode(errors="replace") for name in _PACKAGE.findall(context.reading.data)}
    shares = {name: context.search.share(name) for name in sorted(names)}
    packages = {name: str(share.resolve()) for name, share in shares.items() if share is not None}
    with TemporaryDirectory() as folder:
        file = Path(context.reading.file).resolve()
        if not file.is_file() or read_input(file) != context.reading.data:
            file = Path(folder) / "robot.urdf"
            file.write_bytes(context.reading.data)
        child = start_python(
            f"{__name__}:serve", target, str(file), json.dumps(packages), folder=folder, stderr=subprocess.DEVNULL
        )
        try:
            said, _ = child.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return Answer(installed, f"it is not done after {PATIENCE:g} s")
        finally:
            child.kill()
            child.communicate()
    if child.returncode:
        return Answer(installed, f"its process ended with status {child.returncode}")
    return Answer(installed, json.loads(said.splitlines()[-1]))


def _version(package: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return None


def serve(target: str, file: str, packages: str) -> None:
    """Read a file, and write as the last line of JSON why it is refused; null where it is not."""
    said = None
    try:
        if target == "mujoco":
            import mujoco

            mujoco.MjModel.from_xml_path(file)
        else:
            _in_drake(file, json.loads(packages))
    except Exception as error:
        said = " ".join(str(error).split())
    sys.stdout.write(f"\n{json.dumps(said)}\n")


def _in_drake(file: str, packages: dict[str, str]) -> None:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    parser = Parser(plant)
    for name, folder in packages.items():
        parser.package_map().Add(name, Path(folder))
    parser.AddModels(Path(file))
    plant.Finalize()
    builder.Build().CreateDefaultContext()
