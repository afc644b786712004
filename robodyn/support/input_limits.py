"""What an input may hold at most: one table for all readers, which one variable of the environment changes.

Inputs are hostile: a few kilobytes can ask for gigabytes or hours. A reader compares what it finds with this table
before it makes room for it, and refuses by `beyond`, which names the limit and how to raise it.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, TypeVar

from robodyn.errors import InputError

VARIABLE = "ROBODYN_LIMITS"
"""`ROBODYN_LIMITS=csv_columns=5000,file_bytes=4e9` changes limits by name; child processes inherit it."""

_Error = TypeVar("_Error", bound=InputError)


@dataclass(frozen=True)
class InputLimits:
    """Each limit, what it counts, and why a reader needs it; all are of one file."""

    file_bytes: int = 1 << 30
    """Bytes of a file that is held in memory whole."""
    stream_bytes: int = 1 << 34
    """Bytes taken from standard input or another pipe, which are copied to a temporary file."""
    nesting: int = 32
    """Depth of lists and tables within each other, in YAML and TOML: parts of a dotted key, too."""
    toml_bytes: int = 1 << 20
    """Bytes of a scene or of settings, in TOML."""
    table_columns: int = 10_000
    """Columns of a table of any format."""
    name_characters: int = 4096
    """Characters in the name of a column."""
    csv_line_bytes: int = 1 << 20
    """Bytes in a line of a table as text, the header among them."""
    message_values: int = 2_000_000
    """Values in JSON, and in messages as text: numbers, names, lists, and the ends of lists in YAML."""
    log_values: int = 30_000_000
    """Cells of the table that messages make: stamps times columns."""
    yaml_metadata_bytes: int = 1 << 18
    """Bytes of the metadata of a bag."""
    bag_chunk_bytes: int = 1 << 26
    """Bytes that come out of one compressed chunk or message of a bag."""
    bag_expansion: int = 100
    """Times the bytes of a bag that come out of all of its chunks, beyond the first 256 MiB."""
    bag_records: int = 4_000_000
    """Records in the chunks of an MCAP file."""
    bag_steps: int = 1_000_000_000
    """Steps of SQLite over a bag that is a database."""
    mesh_nodes: int = 10_000
    """Nodes of a scene of meshes (GLB, glTF, COLLADA), shared ones as often as they are used."""
    mesh_items: int = 3_000
    """Objects of a 3MF, shared ones as often as they are used."""
    mesh_faces: int = 5_000_000
    """Triangles of all geometries of a scene of meshes, shared ones as often as they are used."""
    mesh_depth: int = 200
    """Nodes of a scene of meshes in one another."""
    mesh_unpacked: int = 1 << 27
    """Bytes of all files in an archive of meshes (3MF, ZAE), or that the accessors of a glTF stand for."""
    mesh_shape: int = 2_000_000
    """Triangles of a mesh whose symmetry and facets are asked for: each takes 800 bytes of memory."""
    mesh_nesting: int = 30_000
    """Points of shells of a mesh that are tried for lying in another shell."""
    mesh_overlaps: int = 200_000
    """Pairs of shells with overlapping boxes that are united exactly; more are measured by columns."""


def limits() -> InputLimits:
    """Return the limits that hold now; InputError where the variable of the environment names none, or no number."""
    return _asked_for(os.environ.get(VARIABLE, ""))


def beyond(name: str, what: str, kind: type[_Error], **place: Any) -> _Error:
    """Return the error of an input that is beyond a limit, a field of `InputLimits`: "20000 columns, at most ..."."""
    value = getattr(limits(), name)
    remedy = f"if it is meant, {VARIABLE}={name}=NUMBER allows more"
    return kind(f"{what}, at most {value} are read", remedy=remedy, **place)


@cache
def _asked_for(text: str) -> InputLimits:
    known = {each.name for each in fields(InputLimits)}
    found: dict[str, int] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        name, _, number = map(str.strip, part.partition("="))
        try:
            found[name] = int(float(number))
        except (ValueError, OverflowError):
            raise InputError(f"{VARIABLE}: {part!r:.60} is not NAME=NUMBER", remedy="e.g. file_bytes=4e9") from None
        if name not in known or found[name] < 0:
            what = f"{VARIABLE}: {name!r:.60} is no limit" if name not in known else f"{VARIABLE}: {part!r:.60}"
            raise InputError(what, remedy=f"limits: {', '.join(sorted(known))}; each a number from 0 on")
    return InputLimits(**found)
