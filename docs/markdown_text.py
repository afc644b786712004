"""Text for Markdown pages."""

from __future__ import annotations

import re


def escaped(text: str) -> str:
    """Return the text with the signs of Markdown and HTML escaped, except between backticks."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([\\<>*_\[\]|])", r"\\\1", part) for part in parts)
