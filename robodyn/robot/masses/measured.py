"""Mesh files as parts, several at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from robodyn.errors import RobodynError
from robodyn.robot.urdf.parts import Vector
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh_mass import Part, mass_properties
from robodyn.support.threads import in_threads

MeshFile = tuple[Path, Vector]
"""A file, and the scale to read it with."""

Outcome = Part | RobodynError
Tick = Callable[[], object]
Watch = Callable[[Sequence[Path]], AbstractContextManager[Tick]]
"""What makes, for files that are going to be read, a function to call after each of them."""


class How(TypedDict, total=False):
    """Options of `mass_properties` that hold for every mesh."""

    exact: bool
    repair: bool
    strict: bool
    cavities: bool


def unwatched(files: Sequence[Path]) -> AbstractContextManager[Tick]:
    """Do nothing: no progress callback."""
    return nullcontext(lambda: None)


@dataclass(frozen=True)
class Reading:
    """How meshes are read.

    Attributes:
        how: see `mass_properties`.
        workers: threads; by default one per processor.
        watch: is told of the files, and of each that is done.
    """

    how: How
    workers: int | None = None
    watch: Watch = unwatched

    def parts(self, files: Iterable[MeshFile]) -> dict[MeshFile, Outcome]:
        """Return the part that each mesh is at the density 1000 kg/m^3, or why it is none; each is read once.

        Two threads on two processors gain 5 % at most, as most of the time is Python's own: reading DAE, and repairs.
        Two processes, each of which has to import what it needs, gain 1.5 times for TALOS's 38 meshes (3.5 s), and lose
        5 and 30 % for Romeo's 24 and TIAGo's 30 (1.2 s), though their files are of the same size: not enough to choose.
        """
        wanted = list(dict.fromkeys(files))
        with self.watch([path for path, _ in wanted]) as tick:

            def measure(file: MeshFile) -> Outcome:
                try:
                    triangles = load_triangles(file[0])
                    return mass_properties(triangles, scale=file[1], symmetry=False, tessellation=False, **self.how)
                except RobodynError as error:
                    return error
                finally:
                    tick()

            return dict(zip(wanted, in_threads(measure, wanted, self.workers), strict=True))
