"""The text of `call` in LLVM IR, with `$` before the numbers that depend on this Python; see `python_call`."""

from __future__ import annotations

TEXT = """\
define internal ptr @memory(ptr %o, ptr %table, i32 %dimensions, ptr %shape, i32 %flags) #0 {
entry:
  %type_at = getelementptr i8, ptr %o, i64 $TYPE
  %type = load ptr, ptr %type_at
  %array_type_at = getelementptr i64, ptr %table, i64 $array_type
  %array_type = load ptr, ptr %array_type_at
  %is_array = icmp eq ptr %type, %array_type
  br i1 %is_array, label %array, label %other
array:
  %dtype_at = getelementptr i8, ptr %o, i64 $DTYPE
  %dtype = load ptr, ptr %dtype_at
  %double_at = getelementptr i64, ptr %table, i64 $dtype
  %double = load ptr, ptr %double_at
  %is_double = icmp eq ptr %dtype, %double
  %flags_at = getelementptr i8, ptr %o, i64 $FLAGS
  %given_flags = load i32, ptr %flags_at
  %common = and i32 %given_flags, %flags
  %plain = icmp eq i32 %common, %flags
  %dimensions_at = getelementptr i8, ptr %o, i64 $DIMENSIONS
  %given_dimensions = load i32, ptr %dimensions_at
  %as_many = icmp eq i32 %given_dimensions, %dimensions
  %fits = and i1 %is_double, %plain
  %fits_all = and i1 %fits, %as_many
  br i1 %fits_all, label %sizes, label %other
sizes:
  %shape_at = getelementptr i8, ptr %o, i64 $SHAPE
  %given_shape = load ptr, ptr %shape_at
  br label %size
size:
  %k = phi i32 [ 0, %sizes ], [ %k1, %next ]
  %given_at = getelementptr i64, ptr %given_shape, i32 %k
  %given = load i64, ptr %given_at
  %wanted_at = getelementptr i64, ptr %shape, i32 %k
  %wanted = load i64, ptr %wanted_at
  %same = icmp eq i64 %given, %wanted
  br i1 %same, label %next, label %other
next:
  %k1 = add i32 %k, 1
  %more = icmp slt i32 %k1, %dimensions
  br i1 %more, label %size, label %found
found:
  %data_at = getelementptr i8, ptr %o, i64 $DATA
  %data = load ptr, ptr %data_at
  ret ptr %data
other:
  ret ptr null
}

define ptr @call(ptr %self, ptr %given, i64 %count, ptr %names) #0 {
entry:
  %arrays = alloca [$ARRAYS x ptr]
  %table_at = getelementptr i8, ptr %self, i64 $DATA
  %table = load ptr, ptr %table_at
  %count_at = getelementptr i64, ptr %table, i64 $count
  %wanted = load i64, ptr %count_at
  %as_many = icmp eq i64 %count, %wanted
  br i1 %as_many, label %each, label %otherwise
each:
  %k = phi i64 [ 0, %entry ], [ %k1, %got ]
  %one_at = getelementptr ptr, ptr %given, i64 %k
  %one = load ptr, ptr %one_at
  %place = add i64 %k, $WIDTHS
  %width_at = getelementptr i64, ptr %table, i64 %place
  %memory = call ptr @memory(ptr %one, ptr %table, i32 1, ptr %width_at, i32 $ALIGNED_ROWS)
  %none = icmp eq ptr %memory, null
  br i1 %none, label %otherwise, label %got
got:
  %array_at = getelementptr ptr, ptr %arrays, i64 %k
  store ptr %memory, ptr %array_at
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %count
  br i1 %more, label %each, label %target
target:
  %to_at = getelementptr ptr, ptr %arrays, i64 %count
  %dimensions_at = getelementptr i64, ptr %table, i64 $dimensions
  %dimensions_64 = load i64, ptr %dimensions_at
  %dimensions = trunc i64 %dimensions_64 to i32
  %shape = getelementptr i64, ptr %table, i64 $shape
  %keep_at = getelementptr i64, ptr %table, i64 $keep
  %keep = load ptr, ptr %keep_at
  %unnamed = icmp eq ptr %names, null
  br i1 %unnamed, label %new, label %named
named:
  %length_at = getelementptr i8, ptr %names, i64 $DATA
  %length = load i64, ptr %length_at
  %single = icmp eq i64 %length, 1
  br i1 %single, label %name, label %otherwise
name:
  %name_at = getelementptr i8, ptr %names, i64 $DIMENSIONS
  %word = load ptr, ptr %name_at
  %out_at = getelementptr i64, ptr %table, i64 $out
  %out = load ptr, ptr %out_at
  %is_out = icmp eq ptr %word, %out
  br i1 %is_out, label %old, label %otherwise
old:
  %old_at = getelementptr ptr, ptr %given, i64 %count
  %old_array = load ptr, ptr %old_at
  %old_memory = call ptr @memory(ptr %old_array, ptr %table, i32 %dimensions, ptr %shape, i32 $WRITEABLE_ROWS)
  %unfit = icmp eq ptr %old_memory, null
  br i1 %unfit, label %otherwise, label %kept
kept:
  call void %keep(ptr %old_array)
  br label %run
new:
  %dtype_at = getelementptr i64, ptr %table, i64 $dtype
  %dtype = load ptr, ptr %dtype_at
  call void %keep(ptr %dtype)
  %empty_at = getelementptr i64, ptr %table, i64 $empty
  %empty = load ptr, ptr %empty_at
  %new_array = call ptr %empty(i32 %dimensions, ptr %shape, ptr %dtype, i32 0)
  %failed = icmp eq ptr %new_array, null
  br i1 %failed, label %nothing, label %made
made:
  %new_memory_at = getelementptr i8, ptr %new_array, i64 $DATA
  %new_memory = load ptr, ptr %new_memory_at
  br label %run
run:
  %result = phi ptr [ %old_array, %kept ], [ %new_array, %made ]
  %result_memory = phi ptr [ %old_memory, %kept ], [ %new_memory, %made ]
  store ptr %result_memory, ptr %to_at
  %kernel = load ptr, ptr %table
  %flag = call i64 %kernel(ptr %arrays)
  %fine = icmp eq i64 %flag, 0
  br i1 %fine, label %done, label %flagged
flagged:
  %drop_at = getelementptr i64, ptr %table, i64 $drop
  %drop = load ptr, ptr %drop_at
  call void %drop(ptr %result)
  br label %otherwise
otherwise:
  %slow_at = getelementptr i64, ptr %table, i64 $otherwise
  %slow = load ptr, ptr %slow_at
  %vectorcall_at = getelementptr i64, ptr %table, i64 $vectorcall
  %vectorcall = load ptr, ptr %vectorcall_at
  %answer = call ptr %vectorcall(ptr %slow, ptr %given, i64 %count, ptr %names)
  ret ptr %answer
done:
  ret ptr %result
nothing:
  ret ptr null
}
attributes #0 = { nounwind }
"""
