"""What the rules ask of a mesh file: its box, its volume, what is wrong with its surface, its outermost points.

They are kept by what is in each file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.support.cache import Key, ObjectCache, cache_folder, code_digest
from robodyn.support.floats import Floats
from robodyn.support.input_file import read_input
from robodyn.support.threads import in_threads

_NOT_FINITE = "coordinates must be finite"
_LARGEST = 400_000
"""Triangles up to which the shells of a closed surface are told from each other."""
_LARGEST_OPEN = 50_000
"""Triangles up to which the gaps of an open surface are looked at: a quarter of a second."""
_SHARD = 1 << 20
"""Bytes kept in each of 256 folders: a few thousand meshes, listed in no time."""


@dataclass(frozen=True, slots=True)
class MeshFacts:
    """One file, before any scale of the URDF.

    Attributes:
        problem, remedy: why it cannot be read, and what to do; the rest is then meaningless.
        finite: whether that is for another reason than a coordinate that is not finite.
        lo, hi: corners of its box [m].
        volume: signed integral [m^3]; meaningless unless closed.
        centre: of that volume [m]; second: xx, xy, xz, yy, yz, zz of its second moments about the centre, by the volume
            [m^2]; zeros where there is no volume.
        closed: whether the surface has no boundary; mixed: whether it has one by the winding of its faces alone.
        inverted: shells wound inwards without being a cavity in another; overlapping: whether two shells share volume.
        one_sided: faces that no turning makes agree with their neighbours, as on a Moebius strip.
        mended: gaps of an open surface that `robodyn inertia` fills; None where there are too many triangles to tell.
        left: gaps that are too large for that; missing: the share of the surface of the open parts that they are.
        doubt: why the file may hold another mesh than was read.
        digest: of the file's content; empty where nothing is kept by it.
    """

    problem: str | None = None
    remedy: str = ""
    finite: bool = True
    triangles: int = 0
    lo: tuple[float, ...] = (0.0, 0.0, 0.0)
    hi: tuple[float, ...] = (0.0, 0.0, 0.0)
    volume: float = 0.0
    centre: tuple[float, ...] = (0.0,) * 3
    second: tuple[float, ...] = (0.0,) * 6
    closed: bool = False
    mixed: bool = False
    inverted: int = 0
    overlapping: bool = False
    one_sided: int = 0
    mended: int | None = None
    left: int = 0
    missing: float = 0.0
    doubt: str = ""
    digest: str = ""

    def dumps(self) -> bytes:
        return json.dumps(asdict(self)).encode()

    @classmethod
    def loads(cls, data: bytes) -> MeshFacts | None:
        """Return what `dumps` wrote; None of anything else."""
        try:
            values: dict[str, Any] = json.loads(data)
            return cls(**{**values, **{name: tuple(values[name]) for name in ("lo", "hi", "centre", "second")}})
        except (ValueError, TypeError, KeyError):
            return None


def mesh_facts(path: Path) -> MeshFacts:
    """Return the facts of a file: of a closed surface those of its shells, of an open one those of its gaps."""
    from robodyn.solids.mesh.closed import is_one_shell
    from robodyn.solids.mesh.holes import gaps
    from robodyn.solids.mesh.indexed import merged
    from robodyn.solids.mesh.inside import shell_faults
    from robodyn.solids.mesh.integrals import measure
    from robodyn.solids.mesh.read.load import load_triangles
    from robodyn.solids.mesh.shells import wound

    try:
        triangles = load_triangles(path)
        integrals, edges = measure(triangles)
        inverted, overlapping, one_sided, open_by = 0, False, 0, None
        if edges.mixed and triangles.count <= _LARGEST:
            one_sided = wound(merged(triangles.array()))[0].twisted
        elif edges.closed and triangles.count <= _LARGEST:
            alone = is_one_shell(triangles)
            inverted, overlapping = (int(integrals.volume < 0), False) if alone else shell_faults(triangles)
        elif not edges.closed and triangles.count <= _LARGEST_OPEN:
            open_by = gaps(triangles)
            one_sided = open_by.one_sided
    except MeshError as error:
        remedy = "export it again" if error.remedy is None or "--" in error.remedy else error.remedy
        return MeshFacts(error.what, remedy, error.remedy != _NOT_FINITE)
    scale, centre, second = triangles.scale, np.zeros(3), np.zeros(6)
    if integrals.volume:
        with np.errstate(all="ignore"):
            offset = integrals.first / integrals.volume
            spread = integrals.S / integrals.volume - np.outer(offset, offset)
        if np.isfinite(integrals.reference + offset).all() and np.isfinite(spread).all():
            centre, second = integrals.reference + offset, spread[np.triu_indices(3)]
    return MeshFacts(
        triangles=integrals.count,
        lo=tuple((integrals.lo * scale).tolist()),
        hi=tuple((integrals.hi * scale).tolist()),
        volume=integrals.volume * scale**3,
        centre=tuple((centre * scale).tolist()),
        second=tuple((second * scale**2).tolist()),
        closed=edges.closed,
        mixed=edges.mixed,
        inverted=inverted,
        overlapping=overlapping,
        one_sided=one_sided,
        mended=None if open_by is None else open_by.mended,
        left=0 if open_by is None else open_by.left,
        missing=0.0 if open_by is None else open_by.missing,
        doubt="; ".join(triangles.warnings),
    )


@cache
def maker() -> str:
    """A digest of the modules that facts come from: with any change of them, facts are found anew."""
    checks = Path(__file__).parent
    own, solids = code_digest(checks), code_digest(checks.parents[1] / "solids")
    return f"{own} {solids}" if own and solids else ""


class Shelf:
    """Where something about the content of a mesh is kept: nowhere if robodyn is installed without its sources, by
    which versions are told apart."""

    def __init__(self, digest: str, what: str) -> None:
        folder = cache_folder() if digest and maker() else None
        self._store = ObjectCache(None if folder is None else folder / "meshes" / digest[:2], _SHARD)
        self._key = Key(f"{digest} {what}", maker())

    def get(self) -> bytes | None:
        return self._store.get(self._key)

    def put(self, data: bytes) -> None:
        self._store.put(self._key, data)


def facts_of(paths: Iterable[Path]) -> dict[Path, MeshFacts]:
    """The facts of each file; those of known content are not computed again, the others in threads."""
    wanted = list(dict.fromkeys(paths))
    return dict(zip(wanted, in_threads(_of_content, wanted), strict=True))


def _of_content(path: Path) -> MeshFacts:
    digest = ""
    if cache_folder() is not None and path.suffix.lower() != ".gltf":  # a .gltf has part of its data in other files
        with suppress(OSError):
            digest = hashlib.sha256(read_input(path)).hexdigest()
    shelf = Shelf(digest, path.suffix.lower())
    known = MeshFacts.loads(shelf.get() or b"")
    if known is not None:
        return known
    facts = replace(mesh_facts(path), digest=digest)
    shelf.put(facts.dumps())
    return facts


def spread_out(count: int) -> Floats:
    """(count, 3) directions that are spread evenly: points of a spiral around the sphere (Fibonacci)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(turn), across * np.sin(turn), z), axis=1)


_DIRECTIONS, _PART = spread_out(240), 8192
"""And the points that are looked at together."""


def extremes(path: Path, digest: str) -> Floats | None:
    """Return (k, 3) the points of a mesh that lie farthest in 240 directions, in metres before any scale of the URDF;
    None where it cannot be read. They are kept by the digest of the file's content, unless it is empty.

    Accuracy: their hull lies in the mesh's; of a smooth body of size d it falls short of that by about d / 240.
    """
    shelf = Shelf(digest, f"{path.suffix.lower()} extremes")
    data = shelf.get()
    if data is not None:
        return np.frombuffer(data).reshape(-1, 3)
    from robodyn.solids.mesh.read.load import load_triangles

    best, farthest = np.zeros((len(_DIRECTIONS), 3)), np.full(len(_DIRECTIONS), -np.inf)
    try:
        triangles = load_triangles(path)
        for block in triangles.blocks():
            points = np.asarray(block, float).reshape(-1, 3)
            for part in np.split(points, range(_PART, len(points), _PART)):
                reach = part @ _DIRECTIONS.T
                most = reach.argmax(axis=0)
                reach = reach[most, np.arange(len(_DIRECTIONS))]
                best[reach > farthest] = part[most[reach > farthest]]
                farthest = np.maximum(reach, farthest)
    except MeshError:
        return None
    points = np.unique(best * triangles.scale, axis=0)
    shelf.put(points.tobytes())
    return points
