"""Names as TOML writes them."""

from __future__ import annotations

import re

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_key(name: str) -> str:
    """Return a name as a key."""
    return name if _BARE.fullmatch(name) else toml_string(name)


def toml_string(text: str) -> str:
    """Return a text as a string."""
    escaped = re.sub(r'["\\\x00-\x1f\x7f-\x9f\u2028\u2029]', lambda found: f"\\u{ord(found[0]):04x}", text)
    return f'"{escaped}"'
