"""The text of the functions that copy columns to and from a thread's room, in LLVM IR; see `driver`."""

from __future__ import annotations

COPIES = """\
declare {vector} @llvm.masked.load.v{lanes}{suffix}.p0(ptr, i32, {mask}, {vector})
declare void @llvm.masked.store.v{lanes}{suffix}.p0({vector}, ptr, i32, {mask})
declare {vector} @llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0({pointers}, i32, {mask}, {vector})
declare void @llvm.masked.scatter.v{lanes}{suffix}.v{lanes}p0({vector}, {pointers}, i32, {mask})

define internal void @read(ptr %far, i64 %stride, ptr %near, i64 %count) #0 {{
entry:
  %one = insertelement {integers} poison, i64 %stride, i64 0
  %strides = shufflevector {integers} %one, {integers} poison, <{lanes} x i32> zeroinitializer
  %offsets = mul {integers} %strides, {numbers}
  %dense = icmp eq i64 %stride, {bytes}
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %more ]
{valid}
  %first = mul i64 %i, %stride
  %from = getelementptr i8, ptr %far, i64 %first
  %here = getelementptr {scalar}, ptr %near, i64 %i
  br i1 %dense, label %load, label %gather
load:
  %loaded = call {vector} @llvm.masked.load.v{lanes}{suffix}.p0(ptr %from, i32 {bytes}, {mask} %valid,
    {vector} zeroinitializer)
  store {vector} %loaded, ptr %here, align {bytes}
  br label %more
gather:
  %each = getelementptr i8, ptr %from, {integers} %offsets
  %gathered = call {vector} @llvm.masked.gather.v{lanes}{suffix}.v{lanes}p0({pointers} %each, i32 {bytes},
    {mask} %valid, {vector} zeroinitializer)
  store {vector} %gathered, ptr %here, align {bytes}
  br label %more
more:
  %next = add i64 %i, {lanes}
  %again = icmp slt i64 %next, %count
  br i1 %again, label %loop, label %done
done:
  ret void
}}

define internal void @write(ptr %far, i64 %stride, ptr %near, i64 %count, i64 %stream) #0 {{
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
  %results = load {vector}, ptr %here, align {bytes}
  %next = add i64 %i, {lanes}
  %begun = icmp sge i64 %i, 0
  %inside = icmp sle i64 %next, %count
  %whole = and i1 %begun, %inside
  %past_caches = and i1 %whole, %streaming
  br i1 %past_caches, label %stream_out, label %partly
stream_out:
  store {vector} %results, ptr %to, align 64, !nontemporal !0
  br label %more
partly:
{valid}
  br i1 %dense, label %store, label %scatter
store:
  call void @llvm.masked.store.v{lanes}{suffix}.p0({vector} %results, ptr %to, i32 {bytes}, {mask} %valid)
  br label %more
scatter:
  %each = getelementptr i8, ptr %to, {integers} %offsets
  call void @llvm.masked.scatter.v{lanes}{suffix}.v{lanes}p0({vector} %results, {pointers} %each, i32 {bytes},
    {mask} %valid)
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
