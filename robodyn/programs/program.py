"""Straight-line programs: what is left of a recursion once it has been traced."""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Any, TypeVar

from robodyn.programs.scalar import CONSTANT, INPUT, Tape, Traced

T = TypeVar("T")


@dataclass(frozen=True)
class Program:
    """A list of operations, each on the results of earlier ones.

    Attributes:
        operations: (op, a, b) with a, b positions in this list; (INPUT, source, column) and (CONSTANT, value, None)
            stand among them. Every operation is needed by some output, and none is written twice.
        outputs: the position of each output.
    """

    operations: tuple[tuple[str, Any, Any], ...]
    outputs: tuple[int, ...]

    @cached_property
    def counts(self) -> dict[str, int]:
        """How many operations of each kind one sample costs; inputs and constants cost none."""
        return dict(Counter(op for op, _, _ in self.operations if op is not INPUT and op is not CONSTANT))

    @property
    def size(self) -> int:
        return sum(self.counts.values())

    @cached_property
    def distinct(self) -> Program:
        """The same program with each output once."""
        return replace(self, outputs=tuple(dict.fromkeys(self.outputs)))

    @cached_property
    def homes(self) -> tuple[int, ...]:
        """Of each output, its place among the outputs of `distinct`."""
        place = {position: k for k, position in enumerate(self.distinct.outputs)}
        return tuple(place[position] for position in self.outputs)

    @property
    def inputs(self) -> set[tuple[str, int]]:
        """The (source, column) pairs that the outputs depend on."""
        return {(a, b) for op, a, b in self.operations if op is INPUT}

    def rows(self, widths: Mapping[str, int], first: int = 0) -> dict[str, int]:
        """Return the first row of each source that is read, by names, from `first` on, and at "" what comes last."""
        found = {}
        for source in sorted({source for source, _ in self.inputs}):
            found[source], first = first, first + widths[source]
        return {**found, "": first}

    def evaluated(
        self,
        column: Callable[[str, int], Any],
        number: Callable[[float], Any],
        functions: Mapping[str, Callable[..., Any]],
    ) -> list[Any]:
        """Return the outputs in any arithmetic: what inputs (source, column), constants and operations are in it."""
        values: list[Any] = []
        for op, a, b in self.operations:
            if op is INPUT:
                values.append(column(a, b))
            elif op is CONSTANT:
                values.append(number(a))
            elif b is None:
                values.append(functions[op](values[a]))
            else:
                values.append(functions[op](values[a], values[b]))
        return [values[k] for k in self.outputs]


def trace(function: Callable[[Tape], Iterable[Any]], first: Sequence[int] = ()) -> Program:
    """Return the program that computes the scalars which `function` returns when given inputs of a new tape.

    Only operations that some output needs are kept (dead-code pruning). One output is finished before the next is begun
    and so is each operand, so that few values are alive at a time.

    Args:
        first: outputs to finish first, in this order; for torques from the tips of a tree to its base, one branch after
            another, this leaves a third of the values alive at a time that any order across branches does.
    """
    collecting = gc.isenabled()
    gc.disable()  # a trace makes no garbage, and looking for it takes a quarter of its time
    try:
        tape = Tape()
        outputs = [x if isinstance(x, Traced) else tape.constant(x) for x in function(tape)]
        place: list[Any] = [None] * len(tape.nodes)
        operations: list[tuple[str, Any, Any]] = []
        waiting = [*reversed(outputs), *(outputs[i] for i in reversed(first))]
        while waiting:
            node = waiting.pop()
            while place[node.serial] is None:
                op, a, b = node.op, node.a, node.b
                if op is not INPUT and op is not CONSTANT:
                    if place[a.serial] is None or (b is not None and place[b.serial] is None):
                        waiting.append(node)
                        node = a if place[a.serial] is None else b
                        continue
                    a, b = place[a.serial], b and place[b.serial]
                place[node.serial] = len(operations)
                operations.append((op, a, b))
        tape.nodes.clear()  # operations are in no circle then and go away with what holds them
        return Program(tuple(operations), tuple(place[node.serial] for node in outputs))
    finally:
        if collecting:
            gc.enable()


def traced(outputs: Callable[[T, Tape], Iterable[Any]]) -> Callable[[T], Program]:
    """Return what traces these outputs for an argument: a decorator of functions of it and a tape."""

    @wraps(outputs)
    def program(given: T) -> Program:
        return trace(lambda tape: outputs(given, tape))

    return program
