"""The LLVM functions by which threads stand by for work and take part in it, without Python in between."""

from __future__ import annotations

LINE = 8
"""Numbers of 64 bits in a line of the cache."""
CALLS, JOB, INSIDE = 0, 1, LINE
"""Where in a team's memory stand: how often it was called, the job that is open, and how many work on it."""
SIZE = 2 * LINE

TEXT = """\
define i64 @stand_by(ptr %team, i64 %me, i64 %known, i64 %looks) #0 {{
entry:
  %job_at = getelementptr i64, ptr %team, i64 {job}
  %inside = getelementptr i64, ptr %team, i64 {inside}
  br label %look
look:
  %seen = phi i64 [ %known, %entry ], [ %seen, %next ], [ %calls, %leave ]
  %k = phi i64 [ 0, %entry ], [ %k1, %next ], [ 0, %leave ]
  %calls = load atomic i64, ptr %team acquire, align 8
  %none = icmp eq i64 %calls, %seen
  br i1 %none, label %next, label %enter
next:
  {pause}
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %looks
  br i1 %more, label %look, label %idle
idle:
  ret i64 %seen
enter:
  %before = atomicrmw add ptr %inside, i64 1 seq_cst, align 8
  %job = load atomic ptr, ptr %job_at seq_cst, align 8
  %over = icmp eq ptr %job, null
  br i1 %over, label %leave, label %work
work:
  %share = load ptr, ptr %job
  %unused = call i64 %share(ptr %job, i64 %me)
  br label %leave
leave:
  %after = atomicrmw sub ptr %inside, i64 1 release, align 8
  br label %look
}}

define i64 @lead(ptr %team, ptr %job, i64 %looks, ptr %rest, i32 %time) #0 {{
entry:
  %job_at = getelementptr i64, ptr %team, i64 {job}
  %inside = getelementptr i64, ptr %team, i64 {inside}
  store atomic ptr %job, ptr %job_at seq_cst, align 8
  %before = atomicrmw add ptr %team, i64 1 seq_cst, align 8
  %share = load ptr, ptr %job
  %unused = call i64 %share(ptr %job, i64 0)
  store atomic ptr null, ptr %job_at seq_cst, align 8
  br label %look
look:
  %k = phi i64 [ 1, %entry ], [ %k1, %wait ], [ 1, %doze ]
  %working = load atomic i64, ptr %inside seq_cst, align 8
  %none = icmp eq i64 %working, 0
  br i1 %none, label %done, label %wait
wait:
  {pause}
  %k1 = add i64 %k, 1
  %more = icmp sle i64 %k1, %looks
  br i1 %more, label %look, label %doze
doze:
  call void %rest(i32 %time)
  br label %look
done:
  ret i64 0
}}
{declared}
attributes #0 = {{ nounwind }}
"""


def team(triple: str) -> str:
    """Return the LLVM IR of `i64 stand_by(team, me, known, looks)` and of `i64 lead(team, job, looks, rest, time)`.

    A job is memory that begins with the address of a function `i64 share(job, me)`, which any number of threads may
    call at once and which returns when nothing is left to begin.

    `stand_by` looks whether the team was called since the `known` calls, takes part if it was and the job is still
    open, and looks on; after so many looks in vain it returns how many calls it has seen. `lead` opens a job, calls the
    team, does what it finds to do, closes the job and waits for those inside: nobody touches the job afterwards, and
    nobody who was late is waited for. It calls `rest(time)` after every so many looks, lest it keeps the core from
    those it waits for.

    Args:
        triple: of the machine, as LLVM writes it.
    """
    x86 = triple.startswith(("x86_64", "i686", "amd64"))
    return TEXT.format(
        job=JOB,
        inside=INSIDE,
        pause="call void @llvm.x86.sse2.pause()" if x86 else 'fence syncscope("singlethread") seq_cst',
        declared="declare void @llvm.x86.sse2.pause()" if x86 else "",
    )
