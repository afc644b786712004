"""The files of meshes: where they are, why they are not there, in which unit, and what the rules ask of them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from math import dist
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from robodyn.checks.context import STDIN, Context
from robodyn.checks.rule import Edit, Fault, Fix, Severity
from robodyn.errors import MeshError
from robodyn.robot.urdf.document import Span, unexpanded
from robodyn.robot.urdf.sources import package_of
from robodyn.robot.urdf.view import GeometryView, LinkView, value_span
from robodyn.support.cache import Key, ObjectCache, cache_folder, code_digest
from robodyn.support.floats import Floats
from robodyn.support.input_file import read_input
from robodyn.support.threads import in_threads
from robodyn.support.wording import count, shown_path

_NOT_FINITE = "coordinates must be finite"
_LARGEST = 400_000  # triangles up to which the shells of a closed surface are told from each other
_LARGEST_OPEN = 50_000  # triangles up to which the gaps of an open surface are looked at: a quarter of a second
_BLOCK = 2700  # triangles whose corners are looked at together
_SHARD = 1 << 20  # bytes kept in each of 256 folders: a few thousand meshes, listed in no time
_LONGEST, _SHORTEST = 20.0, 1e-3
"""Metres beyond which no part of a robot is; and, for such ones, of its sizes over the reach of the robot's joints."""
_TIMES, _MINUTE = 20.0, 100.0
_TWIN = (300.0, 3000.0)  # ratio of a link's meshes that a factor of 1000 between them explains
_UNEVEN = (900.0, 1100.0)
_KILOMETRES = 900.0  # a scale in all axes that no file asks for: of 86 published robots none has more than 1
_FLAT = 1e-2


@dataclass(frozen=True, slots=True)
class MeshFacts:
    """One file, before any scale of the URDF."""

    problem: str | None = None  # why it cannot be read; the rest is then meaningless
    remedy: str = ""
    finite: bool = True  # whether that is for another reason than a coordinate that is not finite
    triangles: int = 0
    lo: tuple[float, ...] = (0.0, 0.0, 0.0)  # corners of its box [m]
    hi: tuple[float, ...] = (0.0, 0.0, 0.0)
    volume: float = 0.0  # signed integral [m^3]; meaningless unless closed
    centre: tuple[float, ...] = (0.0,) * 3  # of that volume [m]; zeros where there is none, as of the next
    second: tuple[float, ...] = (0.0,) * 6  # moments about the centre, by the volume, xx xy xz yy yz zz [m^2]
    closed: bool = False  # whether the surface has no boundary
    mixed: bool = False  # whether it has one by the winding of its faces alone
    inverted: int = 0  # shells wound inwards without being a cavity in another
    overlapping: bool = False  # whether two shells share volume
    one_sided: int = 0  # faces that no turning makes agree with their neighbours, as on a Moebius strip
    mended: int | None = None  # gaps that `robodyn inertia` fills; None where there are too many triangles to tell
    left: int = 0  # gaps that are too large for that
    missing: float = 0.0  # the share of the surface of the open parts that they are
    doubt: str = ""  # why the file may hold another mesh than was read
    digest: str = ""  # of the file's content; empty where nothing is kept by it


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


def shelf(digest: str, what: str) -> tuple[ObjectCache, Key]:
    """Where something about a mesh is kept: nowhere without the sources of robodyn, which tell versions apart."""
    folder = cache_folder() if digest and maker() else None
    store = ObjectCache(None if folder is None else folder / "meshes" / digest[:2], _SHARD)
    return store, Key(f"{digest} {what}", maker())


def facts_of(paths: Iterable[Path]) -> dict[Path, MeshFacts]:
    """The facts of each file; those of known content are not computed again, the others in threads."""
    wanted = list(dict.fromkeys(paths))
    return dict(zip(wanted, in_threads(_of_content, wanted), strict=True))


def _of_content(path: Path) -> MeshFacts:
    digest = ""
    if cache_folder() is not None and path.suffix.lower() != ".gltf":  # a .gltf has part of its data in other files
        with suppress(OSError):
            digest = hashlib.sha256(read_input(path)).hexdigest()
    store, key = shelf(digest, path.suffix.lower())
    with suppress(ValueError, TypeError, KeyError):  # it is not there, or damaged
        values: dict[str, Any] = json.loads(store.get(key) or b"")
        return MeshFacts(**{**values, **{name: tuple(values[name]) for name in ("lo", "hi", "centre", "second")}})
    facts = replace(mesh_facts(path), digest=digest)
    store.put(key, json.dumps(asdict(facts)).encode())
    return facts


def spread_out(count: int) -> Floats:
    """(count, 3) directions that are spread evenly: points of a spiral around the sphere (Fibonacci)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(turn), across * np.sin(turn), z), axis=1)


def extremes(path: Path, digest: str) -> Floats | None:
    """Return (k, 3) the points of a mesh that lie farthest in 240 directions, in metres before any scale of the URDF;
    None where it cannot be read. They are kept by the digest of the file's content, unless it is empty. Accuracy: their
    hull lies in the mesh's; of a smooth body of size d it falls short of that by about d / 240."""
    store, key = shelf(digest, f"{path.suffix.lower()} extremes")
    data = store.get(key)
    if data is not None:
        return np.frombuffer(data).reshape(-1, 3)
    from robodyn.solids.mesh.read.load import load_triangles

    directions, farthest = spread_out(240), np.zeros((0, 3))
    try:
        triangles = load_triangles(path)
        for block in triangles.blocks(_BLOCK):
            points = np.concatenate((farthest, np.asarray(block, float).reshape(-1, 3)))
            farthest = points[(points @ directions.T).argmax(axis=0)]
    except MeshError:
        return None
    points = np.unique(farthest * triangles.scale, axis=0)
    store.put(key, points.tobytes())
    return points


State = Literal["there", "there in another case", "not there", "in an unknown package", "on another machine"]


class MeshUse(NamedTuple):
    """A mesh of a link, and where its file is named."""

    link: LinkView
    geometry: GeometryView
    at: Span


@dataclass(frozen=True, slots=True, eq=False)
class MeshName:
    """A file name as it is written, every <mesh> that has it, the path of the file if it is there, and the name as it
    should be written where its case is wrong."""

    uri: str
    uses: tuple[MeshUse, ...]
    state: State
    path: Path | None = None
    found: str | None = None

    def fault(self, what: str, remedy: str, severity: Severity | None = None, fix: Fix | None = None) -> Fault:
        others = f" (and {count(len(self.uses) - 1, 'more place')})" if self.uses[1:] else ""
        sentence = f"the mesh {shown_path(self.uri)} {what}{others}"
        return Fault(self.uses[0].at, sentence, remedy, severity=severity, fix=fix)

    def renamed(self, better: str) -> Fix:
        edits = tuple(Edit(use.at.start, use.at.end, better) for use in self.uses)
        return Fix(f"write {shown_path(better)}", edits, safe=True)


def mesh_uses(context: Context) -> Iterator[MeshUse]:
    for link in context.view.links:
        for geometry in link.geometries:
            if geometry.shape is not None and geometry.tag == "mesh":
                yield MeshUse(link, geometry, value_span(geometry.shape, "filename"))


def mesh_names(context: Context) -> Mapping[str, MeshName]:
    """The names of meshes; those that are empty or not expanded are none."""
    uses: dict[str, list[MeshUse]] = {}
    for use in mesh_uses(context):
        if use.geometry.uri and not unexpanded(use.geometry.uri):
            uses.setdefault(use.geometry.uri, []).append(use)
    meshes = MeshSearch(context)
    return {uri: meshes.find(uri, tuple(found)) for uri, found in uses.items()}


def all_facts(context: Context) -> Mapping[str, MeshFacts]:
    """By name the facts of every mesh whose file is found."""
    names = context.once(mesh_names).values()
    known = facts_of(name.path for name in names if name.path is not None)
    return {name.uri: known[name.path] for name in names if name.path is not None}


def _names(folder: Path) -> frozenset[str]:
    with suppress(OSError, ValueError):
        return frozenset(os.listdir(folder))
    return frozenset()


class MeshSearch:
    """How names are looked up; folders are listed once."""

    def __init__(self, context: Context) -> None:
        self._bytes = context.reading.file == STDIN
        self._search = context.search
        self._names = cache(_names)

    def find(self, uri: str, uses: tuple[MeshUse, ...]) -> MeshName:
        path = self._search.find(uri)
        scheme, separator, _ = uri.partition("://")
        for root, prefix, rest in self._roots(uri):
            name = self._true_name(root, rest)
            if name is not None and name != rest and (path is None or path == root / rest):
                return MeshName(uri, uses, "there in another case", root / name, prefix + name)
            if path == root / rest:
                break
        if path is not None:
            return MeshName(uri, uses, "there", path)
        if separator and scheme not in ("file", "package", "model"):
            return MeshName(uri, uses, "on another machine")
        return MeshName(uri, uses, "not there" if self._known(uri) else "in an unknown package")

    def _roots(self, uri: str) -> Iterator[tuple[Path, str, str]]:
        """Yield folders that exist, what of the name stands for them, and the path in them."""
        package = package_of(uri)
        if package is not None and package[0]:
            rest = package[1]
            for root in dict.fromkeys(self._search.packages(package[0])):
                if root.is_dir():
                    yield root, uri[: len(uri) - len(rest)], rest
        elif "://" not in uri and not os.path.isabs(uri):
            yield from ((folder, "", uri) for folder in self._search.folders)

    def _known(self, uri: str) -> bool:
        """Whether it is known where the file ought to be."""
        package = package_of(uri)
        if package is None:
            return not (self._bytes and not os.path.isabs(uri) and "://" not in uri)
        return not package[0] or any(True for _ in self._roots(uri)) or self._search.knows_packages

    def _true_name(self, root: Path, rest: str) -> str | None:
        """The path in a folder as its folders spell it, if it is there in any case."""
        parts = []
        for part in rest.split("/"):
            names, alike = self._names(root), [part]
            if part not in ("", ".", "..") and part not in names:
                alike = [name for name in names if name.casefold() == part.casefold()]
            if len(alike) != 1:
                return None
            root = root / alike[0]
            parts += alike
        return "/".join(parts)


class UnitSlip(NamedTuple):
    """A mesh as it is used: its longest side [m], or its scale if the file is unknown, its factor, and how that
    shows."""

    name: MeshName
    longest: float
    factor: float
    how: str


def mesh_slips(context: Context) -> Mapping[GeometryView, UnitSlip]:
    """The uses of meshes that are 1000 times too large or too small."""
    around = reach(context)
    found: dict[GeometryView, UnitSlip] = {}

    @cache
    def twin(link: LinkView, kind: str) -> float | None:
        """The longest side of the meshes of a link that are of another kind, collision or visual."""
        return max((side for one in link.geometries if one.kind != kind for side in _sides(one, context)), default=None)

    for name in context.once(mesh_names).values():
        for use in name.uses:
            sides = _sides(use.geometry, context)
            sizes = sorted(map(abs, use.geometry.scale.or_default(1.0, 1.0, 1.0) or (1.0,)))
            if not sides:
                if sizes[0] >= _KILOMETRES:
                    how = f"a scale of {sizes[0]:g} is for a file in kilometres"
                    found[use.geometry] = UnitSlip(name, sizes[0], 1e3, how)
                continue
            if sides[2] > _LONGEST and sides[0] <= _FLAT * sides[1]:
                continue  # a floor, or what stands on one
            mistaken = _mistaken(sides[2], twin(use.link, use.geometry.kind), around)
            if mistaken is None and sizes[0] > 0 and _UNEVEN[0] <= sizes[-1] / sizes[0] <= _UNEVEN[1]:
                mistaken = sizes[-1] / sizes[0], "its scale differs by a factor of 1000 between axes"
            if mistaken is not None:
                found[use.geometry] = UnitSlip(name, sides[2], *mistaken)
    return found


def _sides(geometry: GeometryView, context: Context) -> list[float]:
    """The sides of the box of a mesh, scaled, ascending [m]; none where it is not known."""
    known = context.once(all_facts).get(geometry.uri)
    scale = geometry.scale.or_default(1.0, 1.0, 1.0)
    if known is None or known.problem is not None or scale is None or not all(scale):
        return []
    return sorted(abs(factor) * (hi - lo) for factor, lo, hi in zip(scale, known.lo, known.hi, strict=True))


def _mistaken(side: float, twin: float | None, reach: float) -> tuple[float, str] | None:
    if side > _LONGEST and side > _TIMES * reach:
        return 1e3, f"it is {side:.4g} m long"
    if side < _SHORTEST and reach > _MINUTE * side:
        return 1e-3, f"it is {1e3 * side:.3g} mm long in a robot whose joints are up to {reach:.3g} m apart"
    if twin is None or not twin > 0:
        return None
    ratio = side / twin
    too_large = 0 < _TIMES * reach < max(side, twin)
    if _TWIN[0] <= ratio <= _TWIN[1] and too_large:
        return 1e3, f"it is {ratio:.0f} times as large as the link's other mesh"
    if _TWIN[0] <= 1 / ratio <= _TWIN[1] and not too_large:
        return 1e-3, f"it is {1 / ratio:.0f} times smaller than the link's other mesh"
    return None


def reach(context: Context) -> float:
    """The largest distance between the origins of neighbouring links [m]; 0 where there is none."""
    offsets = (joint.origin.xyz.or_default(0.0, 0.0, 0.0) for joint in context.view.joints)
    return max((dist(xyz, (0.0, 0.0, 0.0)) for xyz in offsets if xyz is not None), default=0.0)
