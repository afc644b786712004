"""The LLVM function that feeds a kernel: block after block of samples, from and to arrays of any layout."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.programs.run.llvm.functions import BYTES, SUFFIXES

COPIES = """\
declare {vector} @llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0({pointers}, i32, {mask}, {vector})
declare void @llvm.prefetch.p0(ptr, i32, i32, i32)
declare {vector} @llvm.masked.load.v{lanes}{suffix}.p0(ptr, i32, {mask}, {vector})
declare void @llvm.masked.scatter.v{lanes}{suffix}.v{lanes}p0({vector}, {pointers}, i32, {mask})

define internal void @read(ptr %far, i64 %stride, ptr %near, i64 %count, ptr %later) #0 {{
entry:
  %one = insertelement {integers} poison, i64 %stride, i64 0
  %strides = shufflevector {integers} %one, {integers} poison, <{lanes} x i32> zeroinitializer
  %offsets = mul {integers} %strides, {numbers}
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
{valid}
  %first = mul i64 %i, %stride
  %from = getelementptr i8, ptr %far, i64 %first
  %here = getelementptr {scalar}, ptr %near, i64 %i
  %each = getelementptr i8, ptr %from, {integers} %offsets
  %gathered = call {vector} @llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0({pointers} %each, i32 {bytes},
    {mask} %valid, {vector} zeroinitializer)
  store {vector} %gathered, ptr %here, align {bytes}
  %soon = getelementptr {scalar}, ptr %later, i64 %i
  call void @llvm.prefetch.p0(ptr %soon, i32 0, i32 2, i32 1)
  %next = add i64 %i, {lanes}
  %again = icmp slt i64 %next, %count
  br i1 %again, label %loop, label %done
done:
  ret void
}}

define internal void @write(ptr %far, i64 %stride, ptr %near, i64 %count, i64 %stream, ptr %later) #0 {{
entry:
  %one = insertelement {integers} poison, i64 %stride, i64 0
  %strides = shufflevector {integers} %one, {integers} poison, <{lanes} x i32> zeroinitializer
  %offsets = mul {integers} %strides, {numbers}
  %dense = icmp eq i64 %stride, {bytes}
  %wanted = icmp ne i64 %stream, 0
  %streaming = and i1 %dense, %wanted
  %number = ptrtoint ptr %far to i64
  %past = and i64 %number, 63
  %behind = udiv i64 %past, {bytes}
  %ahead = sub i64 0, %behind
  %begin = select i1 %streaming, i64 %ahead, i64 0
  br label %loop
loop:
  %i = phi i64 [ %begin, %entry ], [ %next, %more ]
  %first = mul i64 %i, %stride
  %to = getelementptr i8, ptr %far, i64 %first
  %here = getelementptr {scalar}, ptr %near, i64 %i
  %next = add i64 %i, {lanes}
  %begun = icmp sge i64 %i, 0
  %inside = icmp sle i64 %next, %count
  %whole = and i1 %begun, %inside
  %plain = and i1 %whole, %dense
  br i1 %plain, label %plain_out, label %scatter
plain_out:
  %results = load {vector}, ptr %here, align {bytes}
  br i1 %streaming, label %stream_out, label %keep
keep:
  store {vector} %results, ptr %to, align {bytes}
  br label %more
stream_out:
  store {vector} %results, ptr %to, align {vector_bytes}, !nontemporal !0
  br label %more
scatter:
{valid}
  %each = getelementptr i8, ptr %to, {integers} %offsets
  %some = call {vector} @llvm.masked.load.v{lanes}{suffix}.p0(ptr %here, i32 {bytes}, {mask} %valid,
    {vector} zeroinitializer)
  call void @llvm.masked.scatter.v{lanes}{suffix}.v{lanes}p0({vector} %some, {pointers} %each, i32 {bytes},
    {mask} %valid)
  %soon = getelementptr {scalar}, ptr %later, i64 %i
  call void @llvm.prefetch.p0(ptr %soon, i32 1, i32 2, i32 1)
  br label %more
more:
  %again = icmp slt i64 %next, %count
  br i1 %again, label %loop, label %done
done:
  ret void
}}

"""

VALID = """\
  %i_first = insertelement {integers} poison, i64 %i, i64 0
  %i_all = shufflevector {integers} %i_first, {integers} poison, <{lanes} x i32> zeroinitializer
  %places = add {integers} %i_all, {numbers}
  %count_first = insertelement {integers} poison, i64 %count, i64 0
  %counts = shufflevector {integers} %count_first, {integers} poison, <{lanes} x i32> zeroinitializer
  %valid = icmp ult {integers} %places, %counts"""
"""Which of the samples from `%i` on are among the first `%count`; none before 0 is."""


TEXT = """\
define internal i64 @place(ptr %array, i64 %row, ptr %table, ptr %work, i64 %pitch, i64 %start, i64 %count, i64 %size,
    i1 %result) #0 {{
entry:
{array}
{block}
  %partial = urem i64 %count, {lanes}
  %full = icmp eq i64 %partial, 0
  %allowed = icmp ne i64 %direct, 0
  %stays = and i1 %full, %allowed
  %leave = or i1 %stays, %result
  %some = icmp sgt i64 %columns, 0
  br i1 %some, label %loop, label %done
loop:
  %c = phi i64 [ 0, %entry ], [ %next, %more ]
{home}
  %down = mul i64 %place, %pitch
  %near = getelementptr i8, ptr %work, i64 %down
  %chosen = select i1 %stays, ptr %column, ptr %near
  store ptr %chosen, %table[%place]
  br i1 %leave, label %more, label %copy
copy:
  call void @read(ptr %column, i64 %sample_stride, ptr %near, i64 %count, ptr %later)
  br label %more
more:
  %next = add i64 %c, 1
  %again = icmp slt i64 %next, %columns
  br i1 %again, label %loop, label %done
done:
  %end = add i64 %row, %columns
  ret i64 %end
}}

define internal void @deliver(ptr %array, i64 %row, ptr %table, i64 %start, i64 %count, i64 %size) #0 {{
entry:
{array}
{block}
  br label %loop
loop:
  %c = phi i64 [ 0, %entry ], [ %next, %more ]
{home}
  %near = load ptr, %table[%place]
  %there = icmp eq ptr %near, %column
  br i1 %there, label %more, label %copy
copy:
  call void @write(ptr %column, i64 %sample_stride, ptr %near, i64 %count, i64 %stream, ptr %later)
  br label %more
more:
  %next = add i64 %c, 1
  %again = icmp slt i64 %next, %columns
  br i1 %again, label %loop, label %done
done:
  ret void
}}

define i64 @share(ptr %job, i64 %me, i64 %first, i64 %until) #0 {{
entry:
{job}
  %room_at = mul i64 %me, %room_bytes
  %table = getelementptr i8, ptr %rooms, i64 %room_at
  %work = getelementptr i8, ptr %table, i64 %table_bytes
  %last = sub i64 %count, 1
  %last_at = mul i64 %last, {array_bytes}
  %result = getelementptr i8, ptr %arrays, i64 %last_at
  br label %block
block:
  %start = phi i64 [ %first, %entry ], [ %end, %ready ]
  %any = phi i64 [ 0, %entry ], [ %total, %ready ]
  %left = sub i64 %until, %start
  %in_groups = and i64 %left, -{lanes}
  %none = icmp eq i64 %in_groups, 0
  %most = select i1 %none, i64 %left, i64 %in_groups
  %filled = call i64 @llvm.smin.i64(i64 %most, i64 %size)
  br label %array
array:
  %k = phi i64 [ 0, %block ], [ %k1, %array ]
  %row = phi i64 [ 0, %block ], [ %row1, %array ]
  %at = mul i64 %k, {array_bytes}
  %spec = getelementptr i8, ptr %arrays, i64 %at
  %is_result = icmp eq i64 %k, %last
  %row1 = call i64 @place(ptr %spec, i64 %row, ptr %table, ptr %work, i64 %pitch, i64 %start, i64 %filled,
    i64 %size, i1 %is_result)
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %count
  br i1 %more, label %array, label %ready
ready:
  %up = add i64 %filled, {lanes_less_one}
  %groups = udiv i64 %up, {lanes}
  %byte = udiv i64 %start, {samples_per_byte}
  %marks = getelementptr i8, ptr %flags, i64 %byte
  %some = call i64 %kernel(ptr %table, ptr %marks, i64 %groups)
  %total = or i64 %any, %some
  call void @deliver(ptr %result, i64 %row, ptr %table, i64 %start, i64 %filled, i64 %size)
  %end = add i64 %start, %filled
  %again = icmp slt i64 %end, %until
  br i1 %again, label %block, label %done
done:
  ret i64 %total
}}
declare i64 @llvm.smin.i64(i64, i64)
attributes #0 = {{ nounwind "prefer-vector-width"="512" "min-legal-vector-width"="512" }}
!0 = !{{i32 1}}
"""

BLOCK = """\
  %skip = mul i64 %start, %sample_stride
  %block = getelementptr i8, ptr %address, i64 %skip
  %in_block = mul i64 %size, %sample_stride
  %next_block = getelementptr i8, ptr %block, i64 %in_block
  %share = mul i64 %size, {bytes}"""
"""Where the block that begins with sample `%start` lies in an array, and the next; and how much of that is called for
with each column."""

HOME = """\
  %home = load i64, %homes[%c]
  %wanted_here = icmp sge i64 %home, 0
  br i1 %wanted_here, label %here, label %more
here:
  %place = add i64 %row, %home
  %far = mul i64 %c, %column_stride
  %column = getelementptr i8, ptr %block, i64 %far
  %shared = mul i64 %c, %share
  %later = getelementptr i8, ptr %next_block, i64 %shared"""
"""Column `%c` of a block, and where the table says at what address the kernel works on it."""


FIELDS = ("address", "homes", "sample_stride", "column_stride", "columns", "direct", "stream")
"""What the driver is told of an array, in 64 bits each.

`homes`: of each column the place among the kernel's, -1 of one that is not touched; strides in bytes; `direct`: 1 where
the kernel may work on contiguous columns themselves; `stream`: 1 where results are copied to contiguous columns past
the caches.
"""
POINTERS = ("kernel", "arrays", "rooms", "flags", "address", "homes")
JOB = ("kernel", "arrays", "rooms", "flags", "count", "room_bytes", "table_bytes", "pitch", "size")
"""What a job is, in 64 bits each, in this order."""


def driver(scalar: str, lanes: int) -> str:
    """Return the LLVM IR of `i64 share(job, me, first, until)`, which thread `me` calls: whether a sample is flagged.

    Runs a kernel of `robodyn.programs.run.llvm.kernel`, at the address `kernel`, over these samples in blocks of
    `size`, a multiple of 16, as `first` is one of `size`. Of the `count` arrays (`FIELDS`), the last is the result.
    Columns are handed to the kernel where they lie if they are contiguous and the block is a whole number of groups, as
    all are but a last one of fewer samples than a group; else they are gathered into rows of the thread's own room,
    `pitch` bytes apart after a table of `table_bytes`, and results are scattered from there; with each column a part of
    the next block is called for, as rows of a block lie together. A result that several columns share is computed once,
    and copied. `scalar` is "double" or "float"; a group has `lanes` samples.
    """
    names = {
        "scalar": scalar,
        "suffix": SUFFIXES[scalar],
        "bytes": BYTES[scalar],
        "vector_bytes": lanes * BYTES[scalar],
        "lanes": lanes,
        "lanes_less_one": lanes - 1,
        "samples_per_byte": min(8, lanes),
        "array_bytes": 8 * len(FIELDS),
        "vector": f"<{lanes} x {scalar}>",
        "integers": f"<{lanes} x i64>",
        "pointers": f"<{lanes} x ptr>",
        "mask": f"<{lanes} x i1>",
        "numbers": f"<{', '.join(f'i64 {k}' for k in range(lanes))}>",
    }
    texts = {"array": _loaded("array", FIELDS), "job": _loaded("job", JOB), "home": HOME}
    return (COPIES + TEXT).format(**names, **texts, block=BLOCK.format(**names), valid=VALID.format(**names))


def _loaded(struct: str, fields: Sequence[str]) -> str:
    return "\n".join(
        f"  %{name} = load {'ptr' if name in POINTERS else 'i64'}, %{struct}[{k}]" for k, name in enumerate(fields)
    )
