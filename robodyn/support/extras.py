"""The libraries that robodyn uses: what needs each, which extra of robodyn brings it; the error without it."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import NamedTuple

from robodyn.errors import InputError


class Library(NamedTuple):
    """A library by its name for pip and the module to import; what does not work without it; and the extra of robodyn
    that brings it, empty where an installation always has it, or none does."""

    name: str
    module: str
    cost: str
    extra: str = ""

    @property
    def install(self) -> str:
        """What to give to pip."""
        return f'"robodyn[{self.extra}]"' if self.extra else self.name


CORE = (
    Library("numpy", "numpy", "everything"),
    Library("click", "click", "the command line"),
    Library("scipy", "scipy.interpolate", "splines of reference tables and simulation with steps of its own choice"),
    Library("polars", "polars", "reading and writing of large CSV tables"),
    Library("trimesh", "trimesh", "meshes other than STL, OBJ, PLY and OFF"),
    Library("manifold3d", "manifold3d", "union of meshes that overlap"),
    Library("platformdirs", "platformdirs", "the cache of machine code"),
)
"""What an installation always has, and needs."""
COMPILER = Library("llvmlite", "llvmlite.binding", "machine code: long trajectories take ten times longer")
SCENES = Library(
    "yourdfpy", "yourdfpy", "what brings trimesh with the libraries of its readers, such as that of COLLADA"
)
OPTIONAL = (
    Library("uplot-python", "uplot", "plots of HTML reports", "report"),
    Library("jinja2", "jinja2", "HTML reports", "report"),
    Library("pyarrow", "pyarrow", "tables written as Parquet", "parquet"),
    Library("rich", "rich", "progress bars", "progress"),
    Library("mpmath", "mpmath", "reference values with many digits", "exact"),
    Library("sympy", "sympy", "equations in closed form", "symbolic"),
    Library("xacrodoc", "xacrodoc", "xacro files", "xacro"),
    Library("mujoco-core", "mujoco", "MJCF files", "mjcf"),
    Library("clarabel", "clarabel", "contact forces that cost torques or are bounded by them", "conic"),
    Library("pygls", "pygls", "`lsp`, for editors", "lsp"),
    Library("mujoco", "mujoco", "what MuJoCo changes, by `check --target`", "importers"),
    Library("drake", "pydrake", "what Drake changes, by `check --target`", "importers"),
    Library("rosbags", "rosbags", "ROS bags", "ros"),
    Library("pyyaml", "yaml", "messages of ROS as YAML", "ros"),
    Library("distributed", "distributed", "`torques --dask`", "dask"),
    Library("casadi", "casadi", "use of what `export --to casadi` writes", "casadi"),
    Library("jax", "jax", "use of what `export --to jax` writes", "jax"),
    Library("torch", "torch", "use of what `export --to torch` writes", "torch"),
)
"""What extras bring, each imported only by what needs it."""


def available(module: str) -> bool:
    """Whether a module can be found, without importing it."""
    if module in sys.modules:
        return sys.modules[module] is not None
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def need(what: str, *names: str, otherwise: str = "", file: str | None = None) -> None:
    """Raise if a library of an extra is not installed: before long work begins, or where it would be imported.

    Args:
        what: needs the libraries, in the plural; otherwise: what helps without them.
        names: of libraries of `OPTIONAL`, all of one extra.
    """
    missing = [library for library in OPTIONAL if library.name in names and not available(library.module)]
    if missing:
        remedy = f"pip install {missing[0].install}{otherwise and f', or {otherwise}'}"
        raise InputError(f"{what} need {' and '.join(each.name for each in missing)}", remedy=remedy, file=file)
