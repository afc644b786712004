"""What makes an answer doubtful, so that no verdict over it is green."""

from __future__ import annotations

from dataclasses import dataclass

TOO_FEW = "by torques that are not trusted (too few samples)"
"""The clause of what is derived from too few samples."""


@dataclass(frozen=True)
class Doubt:
    """Why "No limit is exceeded" alone would mislead.

    Attributes:
        clause: how that headline goes on, such as "as long as the base is held (assumed)".
        said: the warning in full, with the numbers and how to say otherwise; it is among the warnings too.
    """

    clause: str
    said: str


@dataclass(frozen=True)
class WrongUnits(Doubt):
    """Why the numbers of a table can hardly be in the units that they are taken in."""
