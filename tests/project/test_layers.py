"""Imports go one way, and heavy modules wait until they are needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ORDER = [
    ("errors",),
    ("support",),
    ("programs",),
    ("solids",),
    ("robot",),
    ("scene",),
    ("dynamics", "trajectory"),
    ("equations", "identification", "loads", "simulation"),
    ("comparison", "sizing"),
    ("checks", "measure"),
    ("report",),
    ("cli",),
    ("__main__",),
]
"""Each layer imports from those above it, and its parts not from each other."""
HEAVY = {
    *("scipy", "polars", "pyarrow", "rich", "yourdfpy", "trimesh", "sympy", "mpmath", "llvmlite", "distributed"),
    *("matplotlib", "jinja2", "casadi", "jax", "torch", "clarabel"),
}
LAYER = {area: k for k, areas in enumerate(ORDER) for area in areas}
SCARA = str(ROOT / "robots" / "scara.urdf")
TORQUES = f"import robodyn; m = robodyn.load({SCARA!r}); robodyn.inverse_dynamics(m, [.1] * 3, [.2] * 3, [.3] * 3)"


def _paths():
    """(name, path) of every module of the package, `cli/` being robodyn.cli."""
    for base, package in ((ROOT / "robodyn", "robodyn"), (ROOT / "cli", "robodyn.cli")):
        for path in sorted(base.rglob("*.py")):
            parts = [part for part in path.relative_to(base).with_suffix("").parts if part != "__init__"]
            yield ".".join((package, *parts)), path


MODULES = dict(_paths())
_tree = cache(lambda name: ast.parse(MODULES[name].read_text()))
FOLDERS = {name.rpartition(".")[0] for name in MODULES}


def _imported(node):
    if isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports are absolute"
        within = [f"{node.module}.{alias.name}" for alias in node.names]
        return [name if name in MODULES else node.module for name in within]
    return [alias.name for alias in node.names]


def _folder(module):
    return module if module in FOLDERS else module.rpartition(".")[0]


def _area(module):
    return module.split(".")[1] if "." in module else None


def test_every_folder_is_installed():
    """The list in pyproject.toml is by hand, as `cli/` is installed as robodyn.cli."""
    text = (ROOT / "pyproject.toml").read_text()
    listed = set(ast.literal_eval(text.partition("\npackages = ")[2].partition("]")[0] + "]"))
    folders = {name for name in FOLDERS if name} | {"robodyn"}
    assert listed == folders


def test_every_module_has_its_layer_and_imports_go_one_way():
    assert {_area(name) for name in MODULES} - {None} == set(LAYER)
    backwards = [
        f"{name} imports {other}"
        for name in filter(_area, MODULES)
        for other in _imports(name)
        if other.startswith("robodyn.") and _area(other) != _area(name) and LAYER[_area(other)] >= LAYER[_area(name)]
    ]
    assert not backwards


def _statements(tree, at_import=False):
    """All statements, or those that run at import: not the bodies of functions and of `if TYPE_CHECKING`."""
    waiting = list(tree.body)
    while waiting:
        node = waiting.pop()
        if at_import and isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        if at_import and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        for field in ("body", "orelse", "finalbody", "handlers", "cases"):
            waiting.extend(getattr(node, field, ()))


@cache
def _imports(name, at_import=False):
    nodes = _statements(_tree(name), at_import)
    return set(chain.from_iterable(_imported(node) for node in nodes if isinstance(node, (ast.Import, ast.ImportFrom))))


def test_no_file_needs_itself():
    """There is no circle of imports, those within functions and for types alone included."""
    graph = {name: _imports(name) & MODULES.keys() - {"robodyn"} for name in MODULES}
    assert set(TopologicalSorter(graph).static_order()) >= graph.keys() - {"robodyn"}


def test_no_folder_needs_itself():
    """Nor is there a circle of folders, but for one and those within it."""
    graph = {folder: set() for folder in FOLDERS}
    for name in MODULES:
        here = _folder(name)
        for there in map(_folder, _imports(name) & MODULES.keys() - {"robodyn"}):
            if name != "robodyn" and not f"{here}.".startswith(f"{there}.") and not f"{there}.".startswith(f"{here}."):
                graph[here].add(there)
    assert set(TopologicalSorter(graph).static_order()) >= graph.keys()


def test_heavy_modules_wait():
    at_import = {name: {other.split(".")[0] for other in _imports(name, at_import=True)} for name in MODULES}
    assert {name: others & HEAVY for name, others in at_import.items() if others & HEAVY} == {}


def _loaded(code):
    command = f"{code}; import sys; print(*sorted({{name.partition('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-I", "-c", command], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.split())


def test_a_fresh_process_loads_no_heavy_module():
    assert not _loaded(f"{TORQUES}; import robodyn.cli.main") & HEAVY
    assert "numpy" not in _loaded("import robodyn")


def test_a_check_loads_nothing_that_only_others_need():
    """No client for HTTP (which JUnit's escapes bring), no processes, no metadata, no integrals over meshes."""
    check = f"from robodyn.cli.check import command; command([{SCARA!r}], standalone_mode=False)"
    meshes = "import sys; print(*(name for name in sys.modules if name.startswith('robodyn.solids.mesh.')))"
    assert not _loaded(f"{check}; {meshes}") & {"http", "ssl", "subprocess", "zipfile", "robodyn.solids.mesh.integrals"}


def test_names_of_the_package_are_there():
    import robodyn

    for name in robodyn.__all__:
        assert getattr(robodyn, name) is not None
    assert set(robodyn.__all__) <= set(dir(robodyn))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        robodyn.nothing  # noqa: B018
