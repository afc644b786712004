"""What `doctor` found as one JSON document with stable keys."""

from __future__ import annotations

from dataclasses import asdict

from robodyn.measure.doctor import Line, healthy


def doctor_json(lines: tuple[Line, ...]) -> str:
    """{"ok": ..., "lines": [{group, name, found, verdict, remark, figures}]}."""
    import json

    document = {"ok": healthy(lines), "lines": [{**asdict(line), "figures": dict(line.figures)} for line in lines]}
    return json.dumps(document, indent=2, allow_nan=False) + "\n"
