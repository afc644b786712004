"""Facts of mesh files, several at a time, and kept between runs by what is in the files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from robodyn.checks.mesh_facts import MeshFacts, mesh_facts
from robodyn.support.cache import Key, ObjectCache, cache_folder

MAKER = "mesh facts 2"
"""Another text wherever other facts would come of the same file."""
_SHARD = 1 << 20
"""Bytes kept in each of 256 folders: a few thousand meshes, listed in no time."""
_ELSEWHERE = (".gltf",)
"""Types that hold part of their data in other files."""


def facts_of(paths: Iterable[Path]) -> dict[Path, MeshFacts]:
    """The facts of each file, in threads; those of known content are not computed again."""
    wanted = list(dict.fromkeys(paths))
    if not wanted:
        return {}
    folder = cache_folder()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(wanted, pool.map(lambda path: _kept(path, folder), wanted), strict=True))


def _kept(path: Path, folder: Path | None) -> MeshFacts:
    if folder is None or path.suffix.lower() in _ELSEWHERE:
        return mesh_facts(path)
    try:
        with open(path, "rb") as stream:
            digest = hashlib.sha256(stream.read()).hexdigest()
    except OSError:
        return mesh_facts(path)
    key = Key(f"{digest} {path.suffix.lower()}", MAKER)
    store = ObjectCache(folder / "meshes" / digest[:2], _SHARD)
    data = store.get(key)
    known = None if data is None else MeshFacts.loads(data)
    if known is not None:
        return known
    facts = mesh_facts(path)
    store.put(key, facts.dumps())
    return facts
