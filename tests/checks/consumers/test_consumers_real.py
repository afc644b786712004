"""Whether MuJoCo and Drake take published robots, but for their meshes, as RD901 says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.peers import mujoco, peer
from pinned_findings import name_of, published

from robodyn.checks.context import Asked
from robodyn.checks.run import Options, check_one

pytestmark = pytest.mark.slow
_WITHOUT = re.compile(r"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
ROBOTS = [path for path in published() if path.name != "ur3.urdf"]


def stripped(path: Path) -> str:
    """A description without its shapes."""
    return _WITHOUT.sub("", path.read_text(encoding="utf-8"))


def said(text: str, target: str) -> bool:
    """Whether RD901 says that a program rejects it."""
    (one,) = check_one(text.encode(), Options(select=("RD901",), asked=Asked(targets=(target,))))
    return one.message.startswith(f"{target} rejects it")


@pytest.mark.parametrize("path", ROBOTS, ids=name_of)
def test_mujoco(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = stripped(path)
    try:
        mujoco.MjModel.from_xml_string(text)
    except ValueError:
        assert said(text, "mujoco")
    else:
        assert not said(text, "mujoco")


@pytest.mark.parametrize("path", ROBOTS, ids=name_of)
def test_drake(path: Path) -> None:
    parsing = peer("pydrake.multibody.parsing")
    plant = peer("pydrake.multibody.plant").MultibodyPlant(0.0)
    text = stripped(path)
    try:
        parsing.Parser(plant).AddModelsFromString(text, "urdf")
        plant.Finalize()
    except RuntimeError:
        assert said(text, "drake")
    else:
        assert not said(text, "drake")
