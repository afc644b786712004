"""The result of `bench` as text for a person."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from statistics import median

from robodyn.measure.speed.result import Bench, ExecutorBench, PeerBench, PeersBench, Timing
from robodyn.report.table import PLAIN, Content, Page, printable
from robodyn.support.wording import count


def bench_text(bench: Bench, page: Page = PLAIN) -> str:
    """Return the report: executors, memory, effects, other programs, other libraries, and how steady the times were."""
    parts = [_head(bench), _executors(bench, page)]
    if bench.effects:
        parts.append(f"Effects{_whole(bench)}\n{page.table(_effects(bench))}")
    parts.append(_programs(bench, page))
    if bench.peers:
        parts.append(_peers(bench.peers, page))
    return "\n".join([*parts, _steadiness(bench)])


def _head(bench: Bench) -> str:
    x, y, z = bench.gravity
    return (
        f"{printable(bench.robot)}: {count(bench.joints, 'joint')}, {count(bench.samples, 'sample')}, "
        f"gravity ({x:g}, {y:g}, {z:g}) m/s^2\n"
        f"{bench.operations} operations per sample for the torques, {bench.operations_at_rest} at rest; "
        f"traced in {_ms(bench.trace)} ms\n"
    )


def _executors(bench: Bench, page: Page) -> str:
    head = ["executor", "build [ms]", "from cache [ms]", "columnar [ns]", "row-major [ns]"]
    threads = any(each.columnar_threads for each in bench.executors)
    if threads:
        head += [f"{layout}, {bench.threads} threads [ns]" for layout in ("columnar", "row-major")]
    head += ["of copying", "difference"]
    table = page.table((head, [_executor(each, threads) for each in bench.executors]))
    copying = bench.copying
    shared = f", {_ns(copying.all)} ns by {bench.threads} threads" if copying.all else ""
    memory = f"{copying.bytes} bytes per sample; copying as many takes {_ns(copying.one)} ns{shared}\n"
    return f"Torques, time per sample\n{table}{memory}" + (f"compiled: {bench.problem}\n" if bench.problem else "")


def _executor(each: ExecutorBench, threads: bool) -> list[str]:
    shared = [_ns(each.columnar_threads), _ns(each.row_major_threads)] if threads else []
    off = "" if each.name == "numpy" else "overflows" if each.difference is None else _off(each.difference)
    times = [_ms(each.build), _ms(each.load), _ns(each.columnar), _ns(each.row_major), *shared]
    return [each.name, *times, f"{100 * each.of_copying:.0f}%", off]


def _whole(bench: Bench) -> str:
    return f", compiled, columnar, one thread: all take {_ns(bench.whole)} ns per sample" if bench.whole else ""


def _effects(bench: Bench) -> Content:
    head = ("effect", "operations alone", "saved without", *(("time without [ns]",) if bench.whole else ()))
    rows = [
        (
            each.report.name,
            str(each.report.operations),
            str(each.report.saved),
            *((_ns(each.without),) if bench.whole else ()),
        )
        for each in bench.effects
    ]
    return head, rows


def _programs(bench: Bench, page: Page) -> str:
    rows = [
        (each.name, str(each.operations), str(each.outputs), _digits(1e3 * each.trace))
        + (() if bench.problem else (_ms(each.build), _ns(each.compiled)))
        for each in bench.programs
    ]
    head = ("program", "operations", "outputs", "trace [ms]") + (
        () if bench.problem else ("build [ms]", "time per sample [ns]")
    )
    title = "Other programs" if bench.problem else "Other programs, compiled, columnar, one thread"
    return f"{title}\n{page.table((head, rows))}"


def _peers(bench: PeersBench, page: Page) -> str:
    title = (
        f"Other libraries, one thread, gravity, inertia and Coriolis forces alone: robodyn ({bench.executor}) "
        f"takes {_ns(bench.ours)} ns for {bench.operations} operations\n"
    )
    head = ("library", "samples", "time per sample [ns]", "ratio", "difference")
    rows = [_peer(peer, bench.ours) for peer in bench.peers if peer.time]
    missing = [f"{peer.name} {printable(peer.problem)}\n" for peer in bench.peers if peer.problem]
    return title + (page.table((head, rows)) if rows else "") + "".join(missing)


def _peer(peer: PeerBench, ours: Timing) -> tuple[str, ...]:
    assert peer.time is not None
    assert peer.difference is not None
    ratio = _digits(peer.time.least / ours.least)
    return peer.name, str(peer.samples), _ns(peer.time), ratio, _off(peer.difference)


def _steadiness(bench: Bench) -> str:
    excess = [100 * (each.median / each.least - 1) for each in _timings(bench)]
    return (
        "Times are the shortest of several runs in turn; "
        f"medians are {median(excess):.0f}% longer as a rule, {max(excess):.0f}% at most.\n"
    )


def _timings(part: object) -> Iterator[Timing]:
    """Yield every time that was measured repeatedly."""
    if isinstance(part, Timing):
        yield part
    elif isinstance(part, tuple):
        for each in part:
            yield from _timings(each)
    elif is_dataclass(part):
        for field in fields(part):
            yield from _timings(getattr(part, field.name))


def _ns(time: Timing | None) -> str:
    return "" if time is None else _digits(1e9 * time.least)


def _ms(time: Timing | None) -> str:
    return "" if time is None else _digits(1e3 * time.least)


def _digits(x: float) -> str:
    """Return a number with three digits, and all those before the point."""
    return f"{x:.0f}" if x >= 99.95 else f"{x:#.3g}"


def _off(difference: float) -> str:
    return f"{difference:.0e}" if difference else "0"
