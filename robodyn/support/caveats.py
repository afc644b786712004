"""Caveats: what makes an answer doubtful, so that no verdict over it is green."""

from __future__ import annotations

from dataclasses import dataclass, field

TOO_FEW = "by torques that are not trusted (too few samples)"
"""The kind of caveat about what is derived from too few samples."""


@dataclass(frozen=True)
class Caveat:
    """Why "No limit is exceeded" alone would mislead.

    Attributes:
        kind: how that headline goes on, such as "as long as the base is held (assumed)".
        text: the warning in full, with the numbers and how to say otherwise; it is among the warnings too.
    """

    kind: str = field(metadata={"json": "clause"})
    text: str = field(metadata={"json": "said"})


@dataclass(frozen=True)
class WrongUnits(Caveat):
    """Why the numbers of a table can hardly be in the units that they are taken in."""
