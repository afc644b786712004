"""Programs that are repeated, each run from the results of the one before: in machine code, or by NumPy."""

from __future__ import annotations

import struct
from ctypes import addressof, c_int64, c_void_p
from functools import cache
from typing import NamedTuple

import numpy as np

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.support.floats import Floats

ROLLOUT = """\
define internal i64 @apply(ptr %kernel, ptr %from, ptr %to, ptr %table, ptr %flags, i64 %rows, i64 %more, i64 %pitch,
    i64 %groups) nounwind {{
entry:
  %outputs = getelementptr ptr, ptr %table, i64 %rows
  %writes = add i64 %rows, %more
  br label %fill
fill:
  %k = phi i64 [ 0, %entry ], [ %k1, %filled ]
  %away = mul i64 %k, %pitch
  %target = getelementptr i8, ptr %to, i64 %away
  store ptr %target, %outputs[%k]
  %reads = icmp slt i64 %k, %rows
  br i1 %reads, label %read, label %filled
read:
  %source = getelementptr i8, ptr %from, i64 %away
  store ptr %source, %table[%k]
  br label %filled
filled:
  %k1 = add i64 %k, 1
  %again = icmp slt i64 %k1, %writes
  br i1 %again, label %fill, label %call
call:
  %some = call i64 %kernel(ptr %table, ptr %flags, i64 %groups)
  ret i64 %some
}}

define internal double @largest(ptr %row, i64 %count) nounwind {{
entry:
  br label %loop
loop:
  %k = phi i64 [ 0, %entry ], [ %k1, %loop ]
  %best = phi double [ 0.0, %entry ], [ %better, %loop ]
  %place = getelementptr double, ptr %row, i64 %k
  %x = load double, ptr %place
  %less = fcmp olt double %x, %best
  %better = select i1 %less, double %best, double %x
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %count
  br i1 %more, label %loop, label %done
done:
  ret double %better
}}

define i64 @rollout(ptr %sweep, ptr %step, ptr %slots, ptr %spare, ptr %table, ptr %flags, i64 %rows, i64 %pitch,
    i64 %groups, i64 %records, i64 %every, i64 %sweeps, ptr %columns, i64 %extra, ptr %swept) nounwind {{
entry:
  %twice = mul i64 %rows, 2
  %past = add i64 %twice, 1
  %given = getelementptr ptr, ptr %table, i64 %past
  %given_slot = mul i64 %extra, %pitch
  %driven = icmp sgt i64 %extra, 0
  %slot = mul i64 %rows, %pitch
  %spare_slot = add i64 %slot, %pitch
  %steps = mul i64 %records, %every
  %samples = mul i64 %groups, {lanes}
  %implicit = icmp ne ptr %sweep, null
  br label %loop
loop:
  %k = phi i64 [ 0, %entry ], [ %k1, %next ]
  %from = phi ptr [ %slots, %entry ], [ %to, %next ]
  %so_far = phi i64 [ 0, %entry ], [ %in_all, %next ]
  %k1 = add i64 %k, 1
  %whole = urem i64 %k1, %every
  %record = udiv i64 %k1, %every
  %records_on = icmp eq i64 %whole, 0
  %odd = and i64 %k, 1
  %spare_at = mul i64 %odd, %spare_slot
  %spare_to = getelementptr i8, ptr %spare, i64 %spare_at
  %slot_at = mul i64 %record, %slot
  %slot_to = getelementptr i8, ptr %slots, i64 %slot_at
  %to = select i1 %records_on, ptr %slot_to, ptr %spare_to
  %third_at = mul i64 %spare_slot, 2
  %third = getelementptr i8, ptr %spare, i64 %third_at
  %fourth_at = mul i64 %spare_slot, 3
  %fourth = getelementptr i8, ptr %spare, i64 %fourth_at
  %now_at = mul i64 %k, %given_slot
  %now = getelementptr i8, ptr %columns, i64 %now_at
  br i1 %driven, label %give, label %begin
give:
  %j = phi i64 [ 0, %loop ], [ %j1, %give ]
  %j_at = mul i64 %j, %pitch
  %column = getelementptr i8, ptr %now, i64 %j_at
  store ptr %column, %given[%j]
  %j1 = add i64 %j, 1
  %yet = icmp slt i64 %j1, %extra
  br i1 %yet, label %give, label %begin
begin:
  br i1 %implicit, label %iterate, label %end
iterate:
  %s = phi i64 [ 0, %begin ], [ %s1, %judged ]
  %have = phi ptr [ %from, %begin ], [ %want, %judged ]
  %before = phi double [ 0x7FF0000000000000, %begin ], [ %change, %judged ]
  %s_odd = and i64 %s, 1
  %s_even = icmp eq i64 %s_odd, 0
  %want = select i1 %s_even, ptr %third, ptr %fourth
  %lost = call i64 @apply(ptr %sweep, ptr %have, ptr %want, ptr %table, ptr %flags, i64 %rows, i64 1, i64 %pitch,
    i64 %groups)
  %is_lost = icmp ne i64 %lost, 0
  br i1 %is_lost, label %stop, label %judge
judge:
  %s1 = add i64 %s, 1
  %change_row = getelementptr i8, ptr %want, i64 %slot
  %change = call double @largest(ptr %change_row, i64 %samples)
  %small = fcmp ole double %change, {done}
  %near = fcmp ole double %change, {near}
  %grows = fcmp oge double %change, %before
  %stays = and i1 %near, %grows
  %settled = or i1 %small, %stays
  %tired = icmp sge i64 %s1, %sweeps
  br i1 %settled, label %end, label %maybe
maybe:
  br i1 %tired, label %fail, label %judged
judged:
  br label %iterate
end:
  %ready = phi ptr [ %from, %begin ], [ %want, %judge ]
  %took = phi i64 [ 0, %begin ], [ %s1, %judge ]
  %in_all = add i64 %so_far, %took
  %bad = call i64 @apply(ptr %step, ptr %ready, ptr %to, ptr %table, ptr %flags, i64 %rows, i64 0, i64 %pitch,
    i64 %groups)
  %is_bad = icmp ne i64 %bad, 0
  br i1 %is_bad, label %stop, label %next
next:
  %more = icmp slt i64 %k1, %steps
  br i1 %more, label %loop, label %finished
finished:
  store i64 %in_all, ptr %swept
  ret i64 %steps
stop:
  ret i64 %k
fail:
  %failed = sub i64 -1, %k
  ret i64 %failed
}}
"""

DONE, NEAR = 2.0**-106, 2.0**-86
"""Of a sweep's squared relative change: small enough; and small enough to stop when it no longer falls."""
LANES = 8
"""Rollouts worked on at a time."""
COLUMNS = "columns"
"""The source of programs whose values are given for each step."""
SINGLE = 1
"""Lanes for one rollout: a step waits for its divisions and roots, which are quicker one by one."""
SWEEPS = 60
"""At most so many sweeps of an implicit step."""


@cache
def _rollout(lanes: int) -> Function:
    """Return `i64 rollout(...)`, a loop of kernels; its arguments are those of ROLLOUT, in that order.

    `slots` holds `records + 1` states of `rows` columns of doubles, `pitch` bytes from one column to the next; the
    first is given, and each of the others is written `every` steps after the one before it. A step calls `sweep` (if
    not null), at most `sweeps` times, until the last of its outputs is small, then `step`. `columns` holds `extra`
    columns for each step, which both read besides. `spare` has room for four states and a column each, `table` for
    2 rows + 1 + extra pointers; `swept` is told how many sweeps there were, if all steps are done. It returns the
    number of steps done, all of them unless a sample is flagged; or -1 - steps where sweeps do not settle.
    """
    done, near = (f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}" for value in (DONE, NEAR))
    arguments = (*[c_void_p] * 6, *[c_int64] * 6, c_void_p, c_int64, c_void_p)
    return built("rollout", ("rollout", lanes), lambda: ROLLOUT.format(lanes=lanes, done=done, near=near), *arguments)


class Done(NamedTuple):
    """How many steps a run has done, whether it is not sweeps that failed, and how many these were, if it is done."""

    steps: int
    settled: bool
    sweeps: int = 0


class CompiledSteps:
    """The programs of a step, repeated in machine code on some rollouts at a time."""

    def __init__(
        self, source: str, width: int, step: Program, sweep: Program | None, lanes: int, columns: int = 0
    ) -> None:
        """`source`: of both programs, with `width` columns; `step`: of as many outputs; `sweep`: with one more, its
        change; `columns`: of COLUMNS, the other source, which the programs find anew at each step. ImportError, OSError
        or RuntimeError where llvmlite is not there, or does not compile them."""

        def made(program: Program) -> Function:
            rows = {**program.rows({source: width, COLUMNS: columns}), source: 0, "": width, COLUMNS: 2 * width + 1}
            content = "repeated", program.operations, program.outputs, width, lanes
            return built("kernel", content, lambda: kernel(program, rows, "double", lanes, calls=False))

        self.width, self.lanes, self.columns = width, lanes, columns
        self._step, self._sweep, self._run = made(step), None if sweep is None else made(sweep), _rollout(lanes)

    def __call__(self, slots: Floats, every: int, columns: Floats | None = None) -> Done:
        """Fill the slots (records + 1, width, rollouts) from the first on, `every` steps from one record to the next.
        They are contiguous, of a multiple of `lanes` rollouts; columns (steps, columns) are given to all of these."""
        records, width, samples = len(slots) - 1, *slots.shape[1:]
        spare = np.empty((4, width + 1, samples))
        table, flags = np.empty(2 * width + 1 + self.columns, np.int64), np.zeros(samples, np.uint8)
        given = np.empty(0) if columns is None else np.repeat(columns[:, :, None], samples, axis=2)
        kernels = 0 if self._sweep is None else self._sweep.address, self._step.address
        places = (array.ctypes.data for array in (slots, spare, table, flags))
        swept = c_int64(0)
        sizes = width, 8 * samples, samples // self.lanes, records, every, SWEEPS
        done = self._run(*kernels, *places, *sizes, given.ctypes.data, self.columns, addressof(swept))
        return Done(done, True, swept.value) if done >= 0 else Done(-1 - done, False)


class NumpySteps:
    """The same by NumPy, one call per operation and step."""

    def __init__(self, source: str, width: int, step: Program, sweep: Program | None, columns: int = 0) -> None:
        self.source, self.width, self.lanes, self.columns = source, width, 1, columns
        widths = {source: width, COLUMNS: columns}
        self._step = NumpyBlocks(step, widths)
        self._sweep = None if sweep is None else NumpyBlocks(sweep, widths)

    def __call__(self, slots: Floats, every: int, columns: Floats | None = None) -> Done:
        state, sweeps = slots[0].T, 0
        for k in range(every * (len(slots) - 1)):
            now = np.empty((len(state), 0)) if columns is None else np.repeat(columns[k : k + 1], len(state), axis=0)
            before = np.inf
            for count in range(1, SWEEPS + 1):
                if self._sweep is None:
                    break
                swept = self._sweep({self.source: state, COLUMNS: now}, len(state))
                state, change = np.asarray(swept[:, :-1], dtype=float), float(swept[:, -1].max())
                if change <= DONE or (change <= NEAR and change >= before):
                    sweeps += count
                    break
                if count == SWEEPS:
                    return Done(k, False)
                before = change
            state = np.asarray(self._step({self.source: state, COLUMNS: now}, len(state)), dtype=float)
            if not np.isfinite(state).all():
                return Done(k, True)
            if (k + 1) % every == 0:
                slots[(k + 1) // every] = state.T
        return Done(every * (len(slots) - 1), True, sweeps)
