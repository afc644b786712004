"""The text of the driver in LLVM IR, with places for what depends on the type of numbers; see `driver`."""

from __future__ import annotations

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
  %far_block = mul i64 %size, %sample_stride
  %distance = select i1 %stays, i64 {ahead}, i64 %far_block
  %wanted = getelementptr i8, ptr %block, i64 %distance
  %dense = icmp eq i64 %sample_stride, {bytes}
  %in_rows = mul i64 %size, {bytes}
  %apart = select i1 %dense, i64 %column_stride, i64 %in_rows
  %streams = icmp ne i64 %stream, 0
  %streaming = and i1 %streams, %result
  %past_caches = select i1 %stays, i1 false, i1 %streaming
  %some = icmp sgt i64 %columns, 0
  br i1 %some, label %loop, label %done
loop:
  %c = phi i64 [ 0, %entry ], [ %next, %more ]
{home}
  %down = mul i64 %place, %pitch
  %near = getelementptr i8, ptr %work, i64 %down
  %chosen = select i1 %stays, ptr %column, ptr %near
  store ptr %chosen, ptr %entry_place
  %on = mul i64 %c, %apart
  %later = getelementptr i8, ptr %wanted, i64 %on
  %called = select i1 %past_caches, ptr %chosen, ptr %later
  %second_place = getelementptr ptr, ptr %entry_place, i64 1
  store ptr %called, ptr %second_place
  br i1 %leave, label %more, label %copy
copy:
  call void @read(ptr %column, i64 %sample_stride, ptr %near, i64 %count)
  br label %more
more:
  %next = add i64 %c, 1
  %again = icmp slt i64 %next, %columns
  br i1 %again, label %loop, label %done
done:
  %end = add i64 %row, %columns
  ret i64 %end
}}

define internal void @deliver(ptr %array, i64 %row, ptr %table, i64 %start, i64 %count) #0 {{
entry:
{array}
{block}
  br label %loop
loop:
  %c = phi i64 [ 0, %entry ], [ %next, %more ]
{home}
  %near = load ptr, ptr %entry_place
  %there = icmp eq ptr %near, %column
  br i1 %there, label %more, label %copy
copy:
  call void @write(ptr %column, i64 %sample_stride, ptr %near, i64 %count, i64 %stream)
  br label %more
more:
  %next = add i64 %c, 1
  %again = icmp slt i64 %next, %columns
  br i1 %again, label %loop, label %done
done:
  ret void
}}

define internal void @run(ptr %kernel, ptr %arrays, i64 %count, ptr %table, ptr %work, i64 %pitch, ptr %flags,
    ptr %flagged, ptr %taken, i64 %share, i64 %stop, i64 %size) #0 {{
entry:
  %last = sub i64 %count, 1
  %last_at = mul i64 %last, {array_bytes}
  %result = getelementptr i8, ptr %arrays, i64 %last_at
  br label %take
take:
  %first = atomicrmw add ptr %taken, i64 %share monotonic, align 8
  %stop0 = add i64 %first, %share
  %until = call i64 @llvm.smin.i64(i64 %stop0, i64 %stop)
  %work_left = icmp slt i64 %first, %stop
  br i1 %work_left, label %shared, label %done
shared:
  br label %block
block:
  %start = phi i64 [ %first, %shared ], [ %end, %used ]
  %any = phi i64 [ 0, %shared ], [ %total, %used ]
  %left = sub i64 %until, %start
  %filled = call i64 @llvm.smin.i64(i64 %left, i64 %size)
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
  %byte = udiv i64 %start, 8
  %marks = getelementptr i8, ptr %flags, i64 %byte
  %some = call i64 %kernel(ptr %table, ptr %marks, i64 %groups)
  %total = or i64 %any, %some
  call void @deliver(ptr %result, i64 %row, ptr %table, i64 %start, i64 %filled)
  br label %used
used:
  %end = add i64 %start, %size
  %again = icmp slt i64 %end, %until
  br i1 %again, label %block, label %finished
finished:
  %was_flagged = atomicrmw or ptr %flagged, i64 %total monotonic, align 8
  br label %take
done:
  ret void
}}

define i64 @share(ptr %job, i64 %me) #0 {{
entry:
{job}
  %known = icmp slt i64 %me, %parts
  br i1 %known, label %begin, label %done
begin:
  %room_at = mul i64 %me, %room_bytes
  %table = getelementptr i8, ptr %rooms, i64 %room_at
  %work = getelementptr i8, ptr %table, i64 %table_bytes
  %taken = getelementptr i64, ptr %common, i64 1
  br label %part
part:
  %k = phi i64 [ 0, %begin ], [ %k1, %part ]
  %turn = add i64 %me, %k
  %this = urem i64 %turn, %parts
  %next = add i64 %this, 1
  %end = mul i64 %next, %each
  %stop = call i64 @llvm.smin.i64(i64 %end, i64 %samples)
  %taken_here = getelementptr i64, ptr %taken, i64 %this
  call void @run(ptr %kernel, ptr %arrays, i64 %count, ptr %table, ptr %work, i64 %pitch, ptr %flags, ptr %common,
    ptr %taken_here, i64 %step, i64 %stop, i64 %size)
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %parts
  br i1 %more, label %part, label %done
done:
  ret i64 0
}}
declare i64 @llvm.smin.i64(i64, i64)
attributes #0 = {{ nounwind "prefer-vector-width"="512" "min-legal-vector-width"="512" }}
!0 = !{{i32 1}}
"""

BLOCK = """\
  %skip = mul i64 %start, %sample_stride
  %block = getelementptr i8, ptr %address, i64 %skip"""
"""Where the block that begins with sample `%start` lies in an array."""

HOME = """\
  %home_at = getelementptr i64, ptr %homes, i64 %c
  %home = load i64, ptr %home_at
  %place = add i64 %row, %home
  %entry_place = getelementptr [2 x ptr], ptr %table, i64 %place
  %far = mul i64 %c, %column_stride
  %column = getelementptr i8, ptr %block, i64 %far"""
"""Column `%c` of a block, and where the table says at what address the kernel works on it."""
