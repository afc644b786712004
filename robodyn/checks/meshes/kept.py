"""What was found about meshes is kept between runs: by what is in each file, and together for all files of a robot.

The latter is found by the files' sizes and times, without reading them: they are as they were.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path

from robodyn.checks.meshes.facts import MeshFacts, mesh_facts
from robodyn.support.cache import Key, ObjectCache, cache_folder, code_digest
from robodyn.support.input_file import read_input
from robodyn.support.threads import in_threads

_SHARD = 1 << 20
"""Bytes kept in each of 256 folders: a few thousand meshes, listed in no time."""
_ELSEWHERE = (".gltf",)
"""Types that hold part of their data in other files."""
_YOUNG = 3_000_000_000
"""Nanoseconds: a file that was changed since may be changed again without its time telling so."""


@cache
def maker() -> str:
    """Return a digest of the modules that facts come from: with any change of them, facts are found anew."""
    checks = Path(__file__).parent
    own, solids = code_digest(checks), code_digest(checks.parents[1] / "solids")
    return f"{own} {solids}" if own and solids else ""


class Shelf:
    """Where something about the content of a mesh, or of several, is kept.

    Nothing is kept where robodyn is installed without its sources, by which versions are told apart.
    """

    def __init__(self, digest: str, what: str) -> None:
        """
        Args:
            digest: of the content; what: it is that is kept.
        """
        folder = cache_folder() if digest and maker() else None
        self._store = ObjectCache(None if folder is None else folder / "meshes" / digest[:2], _SHARD)
        self._key = Key(f"{digest} {what}", maker())

    def get(self) -> bytes | None:
        """Return what is kept, or None."""
        return self._store.get(self._key)

    def put(self, data: bytes) -> None:
        """Keep it."""
        self._store.put(self._key, data)


def facts_of(paths: Iterable[Path]) -> dict[Path, MeshFacts]:
    """Return the facts of each file; those of known content are not computed again, the others in threads."""
    wanted = list(dict.fromkeys(paths))
    if not wanted:
        return {}
    before = _as_they_are(wanted)
    shelf = Shelf(before, "together")
    lines = (shelf.get() or b"").split(b"\n")
    found = [MeshFacts.loads(line) for line in lines] if len(lines) == len(wanted) else []
    known = [facts for facts in found if facts is not None]
    if len(known) < len(wanted):
        known = in_threads(_of_content, wanted)
        if before and before == _as_they_are(wanted):
            shelf.put(b"\n".join(facts.dumps() for facts in known))
    return dict(zip(wanted, known, strict=True))


def _as_they_are(paths: Sequence[Path]) -> str:
    """Return a digest of the places, sizes and times of files; empty where these do not tell whether they change."""
    if cache_folder() is None or any(path.suffix.lower() in _ELSEWHERE for path in paths):
        return ""
    try:
        states = [path.stat() for path in paths]
    except OSError:
        return ""
    times = [(state.st_mtime_ns, state.st_ctime_ns) for state in states]
    if max(map(max, times)) > time.time_ns() - _YOUNG:
        return ""
    files = zip(paths, times, states, strict=True)
    lines = [f"{path} {each} {state.st_dev} {state.st_ino} {state.st_size}" for path, each, state in files]
    return hashlib.sha256("\n".join(lines).encode(errors="surrogateescape")).hexdigest()


def _of_content(path: Path) -> MeshFacts:
    digest = "" if cache_folder() is None or path.suffix.lower() in _ELSEWHERE else _digest_of(path)
    shelf = Shelf(digest, path.suffix.lower())
    data = shelf.get()
    known = None if data is None else MeshFacts.loads(data)
    if known is not None:
        return known
    facts = replace(mesh_facts(path), digest=digest)
    shelf.put(facts.dumps())
    return facts


def _digest_of(path: Path) -> str:
    """Return the digest of a file's content, computed once for a file that does not change; empty if it cannot be
    read."""
    try:
        status = path.stat()
        return _digest(path, status.st_mtime_ns, status.st_size)
    except OSError:
        return ""


@lru_cache(maxsize=4096)
def _digest(path: Path, changed: int, size: int) -> str:
    return hashlib.sha256(read_input(path)).hexdigest()
