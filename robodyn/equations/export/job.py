"""A function to write."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from robodyn.dynamics.function import Kind
from robodyn.dynamics.plan import Plan
from robodyn.programs.program import Program


@dataclass(frozen=True)
class Job:
    """A function to write.

    Attributes:
        kind: what it computes; its short name is that of the function.
        program: its operations.
        widths: its arguments, and how many numbers each has.
        shapes: of its results.
    """

    kind: Kind
    program: Program
    widths: dict[str, int]
    shapes: dict[str, tuple[int, ...]]

    @staticmethod
    def of(kind: Kind, plan: Plan) -> Job:
        """Return the job of a kind."""
        return Job(kind, kind.program(plan), kind.widths(plan), kind.shapes(plan))

    @property
    def name(self) -> str:
        return self.kind.word

    @property
    def sizes(self) -> dict[str, int]:
        """How many numbers each result has."""
        return {name: prod(shape) for name, shape in self.shapes.items()}

    @property
    def meaning(self) -> str:
        return f"{self.kind.meaning}; {self.program.size} operations"
