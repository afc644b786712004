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
        of_units: whether it is about the units of a table, so that its numbers can hardly be what they are taken for.
    """

    clause: str
    said: str
    of_units: bool = False
