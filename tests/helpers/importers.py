"""MuJoCo and Drake reading descriptions, each file in a process of its own: some files end the process."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from helpers.peers import peer
from robodyn.robot.urdf.sources import Search

_READERS = {
    "mujoco": """
import mujoco
def read(file, packages):
    mujoco.MjModel.from_xml_path(file)
""",
    "drake": """
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
def read(file, packages):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    parser = Parser(plant)
    for name, folder in packages.items():
        parser.package_map().Add(name, folder)
    parser.AddModels(file)
    plant.Finalize()
    builder.Build().CreateDefaultContext()
""",
}
_RUN = """
import json, os, sys
answers = os.dup(1)
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
os.dup2(1, 2)
for file, packages in json.load(sys.stdin):
    inlet, outlet = os.pipe()
    child = os.fork()
    if not child:
        answer = {}
        try:
            read(file, packages)
        except Exception as error:
            answer = {"refused": str(error)}
        os.write(outlet, json.dumps(answer).encode())
        os._exit(0)
    os.close(outlet)
    with os.fdopen(inlet, "rb") as stream:
        text = stream.read()
    _, status = os.waitpid(child, 0)
    if status:
        text = json.dumps({"refused": f"the process ended with {status}"}).encode()
    os.write(answers, text + b"\\n")
"""
_PACKAGE = re.compile(r"(?:package|model)://([^/\"']+)/")


@dataclass(frozen=True)
class Answer:
    """What a program makes of a file: why it refuses it, if it does."""

    refused: str | None = None


def answers(target: str, files: Sequence[Path], search: Sequence[Path] = ()) -> list[Answer]:
    """Return what a program makes of files; `search`: the files beside which their packages are."""
    peer({"mujoco": "mujoco", "drake": "pydrake"}[target])
    if sys.platform == "win32":
        pytest.skip("files are read in forked processes")
    asked = [(str(file.resolve()), packages(beside)) for file, beside in zip(files, search or files, strict=True)]
    code = _READERS[target] + _RUN
    with TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", code],
            input=json.dumps(asked),
            capture_output=True,
            text=True,
            check=True,
            cwd=folder,
        )
    return [Answer(**json.loads(line)) for line in done.stdout.splitlines()]


def packages(file: Path) -> dict[str, str]:
    """Return the folders of the packages that a file names."""
    names = set(_PACKAGE.findall(file.read_text(encoding="utf-8", errors="replace")))
    search = Search(str(file), ())
    found = {name: next((root for root in search.packages(name) if root.is_dir()), None) for name in names}
    return {name: str(root) for name, root in found.items() if root is not None}
