"""The decoder of Parquet files, which runs in a process of its own.

On some damaged files polars ends the process (it asks for more memory than there is) or prints a backtrace. Neither
may happen to the program, so `read_parquet` talks to this module through pipes: a request is one line of JSON, an
answer one line of JSON, followed by the values if there are any.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray


def serve(path: str) -> None:
    """Answer requests on standard input until it ends."""
    import polars as pl

    scan = pl.scan_parquet(path, glob=False)
    for line in sys.stdin:
        try:
            _answer(*_handle(scan, json.loads(line)))
        except (Exception, pl.exceptions.PanicException) as error:
            _answer({"error": str(error).strip().partition("\n")[0]})


def _handle(scan: Any, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    import polars as pl

    if not request:
        schema = scan.collect_schema()
        types = [None if kind.is_numeric() else str(kind) for kind in schema.values()]
        return {"names": list(schema), "types": types, "rows": scan.select(pl.len()).collect().item()}, b""
    part = scan.slice(request["start"], request["rows"]).select(pl.col(request["names"]).cast(pl.Float64)).collect()
    values: NDArray[np.float64] = np.asarray(part.to_numpy(), dtype=np.float64)
    return {"rows": len(values)}, values.T.tobytes()


def _answer(head: dict[str, Any], values: bytes = b"") -> None:
    sys.stdout.buffer.write(json.dumps({**head, "bytes": len(values)}).encode() + b"\n" + values)
    sys.stdout.buffer.flush()
