"""Triangular factors of many rows, one for each joint, that grow no larger with the log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.support.floats import Floats


@dataclass
class Triangle:
    """R with R^T R = A^T A of all rows A that were added: by QR updates, whose error is that of QR, not of squares.

    Attributes:
        R: (at most c, c).
        count: rows that were added.
    """

    R: Floats
    count: int = 0

    @classmethod
    def empty(cls, columns: int) -> Triangle:
        return cls(np.zeros((0, columns)))

    def add(self, rows: Floats) -> None:
        """Add rows (k, c)."""
        if len(rows):
            self.R = stacked([self.R, rows])
            self.count += len(rows)


def stacked(parts: list[Floats]) -> Floats:
    """Return the triangular factor of rows (k, c) of which there may be many, one below another."""
    return np.asarray(np.linalg.qr(np.concatenate(parts), mode="r"))
