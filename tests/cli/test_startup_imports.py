"""What the command imports: start-up is most of the time of a small job."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from helpers.command_line import ROBOTS

HEAVY = (
    *("polars", "pyarrow", "scipy", "rich", "llvmlite", "yourdfpy", "trimesh"),
    *("sympy", "matplotlib", "pandas", "numpy.ma"),
)
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))
OURS = 107
"""Modules of robodyn that one job may import. Most are small, 0.2 ms each from cached bytecode."""
MESH_OURS = 45
"""As many for one mesh."""
BEYOND = 40
"""Modules that are neither ours nor come with `import numpy, click`: expat, csv, threads, json, dataclasses."""


def imported(code: str, *arguments: str) -> set[str]:
    """The modules that are loaded after some code, in an interpreter of its own."""
    show = "import sys, json, atexit; atexit.register(lambda: print(json.dumps(sorted(sys.modules)), file=sys.stderr))"
    call = [sys.executable, "-I", "-c", f"{show}\n{code}", *arguments]
    done = subprocess.run(call, capture_output=True, check=True, text=True)
    return set(json.loads(done.stderr))


@pytest.fixture(scope="module")
def modules(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    out = tmp_path_factory.mktemp("out") / "tau.csv"
    call = ("torques", *SCARA, "--out", str(out))
    found = imported("from robodyn.cli.main import main; main()", *call)
    assert out.exists()
    return found


@pytest.mark.parametrize("name", HEAVY)
def test_no_heavy_import_for_a_small_table(name: str, modules: set[str]) -> None:
    assert name not in modules


def test_number_of_imports(modules: set[str]) -> None:
    before = imported("import numpy, click")
    ours = {name for name in modules if name.partition(".")[0] == "robodyn"}
    assert len(ours) <= OURS, sorted(ours)
    assert len(modules - before - ours) <= BEYOND, sorted(modules - before - ours)


def test_nothing_of_error_bars_where_nothing_is_uncertain(modules: set[str]) -> None:
    assert [name for name in modules if "uncertain" in name or "varia" in name or "covariance" in name] == []


@pytest.mark.parametrize("call", [("--help",), ("--version",)])
def test_group_imports_commands_only_when_it_lists_them(call: tuple[str, ...]) -> None:
    loaded = imported("from robodyn.cli.main import main; main()", *call)
    assert not loaded & {"polars", "scipy", "rich"}
    assert ("robodyn.cli.torques" in loaded) == (call == ("--help",))


def test_version_needs_no_numpy() -> None:
    assert "numpy" not in imported("from robodyn.cli.main import main; main()", "--version")


def inertia_imports(*options: str) -> set[str]:
    """The modules that one mesh takes."""
    return imported(
        "from robodyn.cli.main import main; main()", "inertia", str(ROBOTS / "meshes" / "hub.stl"), *options
    )


def test_a_mesh_imports_what_it_is_asked() -> None:
    asked = inertia_imports()
    plain = inertia_imports("--no-symmetry", "--no-tessellation")
    assert not asked & set(HEAVY)
    assert {name.rpartition(".")[2] for name in asked - plain} >= {"symmetry", "tessellation", "columns"}
    ours = {name for name in plain if name.partition(".")[0] == "robodyn"}
    assert not ours & {
        "robodyn.solids.mesh.symmetry_search",
        "robodyn.solids.mesh.repair",
        "robodyn.programs.run.runner",
        "robodyn.robot.model",
    }
    assert len(ours) <= MESH_OURS, sorted(ours)
