"""What `bench` and `doctor` found: how fast robodyn is on this machine, and whether it can work here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from itertools import groupby
from statistics import median

from robodyn.measure.doctor import Line, healthy
from robodyn.measure.speed.result import Bench, EffectBench, ExecutorBench, PeerBench, PeersBench, ProgramBench, Timing
from robodyn.report.document import Paragraph, Section, Table, paragraphs
from robodyn.report.table import Columns, by_columns, gravity_text
from robodyn.support.wording import count


def bench_sections(bench: Bench) -> Iterator[Section]:
    """Yield executors, memory, effects, other programs, other libraries, and how steady the times were."""
    what = f"{count(bench.joints, 'joint')}, {count(bench.samples, 'sample')}, {gravity_text(bench.gravity)}"
    operations = f"{bench.operations} operations per sample for the torques, {bench.operations_at_rest} at rest"
    yield paragraphs([f"{bench.robot}: {what}", f"{operations}; traced in {_ms(bench.trace)} ms"])
    yield _executors(bench)
    if bench.effects:
        whole = bench.whole
        title = f", compiled, columnar, one thread: all take {_ns(whole)} ns per sample" if whole else ""
        effects: Columns[EffectBench] = [
            ("effect", lambda each: each.report.name),
            ("operations alone", lambda each: str(each.report.operations)),
            ("saved without", lambda each: str(each.report.saved)),
        ]
        effects += [("time without [ns]", lambda each: _ns(each.without))] if whole else []
        yield [Table(f"Effects{title}", *by_columns(effects, bench.effects))]
    yield [_programs(bench)]
    if bench.peers:
        yield _peers(bench.peers)
    excess = [100 * (each.median / each.least - 1) for each in _timings(bench)]
    medians = f"medians are {median(excess):.0f}% longer as a rule, {max(excess):.0f}% at most"
    yield [Paragraph(f"Times are the shortest of several runs in turn; {medians}.")]


def _executors(bench: Bench) -> Section:
    columns: Columns[ExecutorBench] = [
        ("executor", lambda each: each.name),
        ("build [ms]", lambda each: _ms(each.build)),
        ("from cache [ms]", lambda each: _ms(each.load)),
        ("columnar [ns]", lambda each: _ns(each.columnar)),
        ("row-major [ns]", lambda each: _ns(each.row_major)),
    ]
    if any(each.columnar_threads for each in bench.executors):
        columns += [
            (f"columnar, {bench.threads} threads [ns]", lambda each: _ns(each.columnar_threads)),
            (f"row-major, {bench.threads} threads [ns]", lambda each: _ns(each.row_major_threads)),
        ]
    columns += [("of copying", lambda each: f"{100 * each.of_copying:.0f}%"), ("difference", _difference)]
    copying = bench.copying
    shared = f", {_ns(copying.all)} ns by {bench.threads} threads" if copying.all else ""
    memory = f"{copying.bytes} bytes per sample; copying as many takes {_ns(copying.one)} ns{shared}"
    problem = [f"compiled: {bench.problem}"] if bench.problem else []
    times = Table("Torques, time per sample", *by_columns(columns, bench.executors))
    return [times, *paragraphs([memory, *problem])]


def _difference(each: ExecutorBench) -> str:
    return "" if each.name == "numpy" else "overflows" if each.difference is None else _off(each.difference)


def _programs(bench: Bench) -> Table:
    columns: Columns[ProgramBench] = [
        ("program", lambda each: each.name),
        ("operations", lambda each: str(each.operations)),
        ("outputs", lambda each: str(each.outputs)),
        ("trace [ms]", lambda each: _digits(1e3 * each.trace)),
    ]
    if bench.problem:
        return Table("Other programs", *by_columns(columns, bench.programs))
    columns += [
        ("build [ms]", lambda each: _ms(each.build)),
        ("time per sample [ns]", lambda each: _ns(each.compiled)),
    ]
    return Table("Other programs, compiled, columnar, one thread", *by_columns(columns, bench.programs))


def _peers(bench: PeersBench) -> Section:
    title = (
        f"Other libraries, one thread, gravity, inertia and Coriolis forces alone: robodyn ({bench.executor}) "
        f"takes {_ns(bench.ours)} ns for {bench.operations} operations"
    )
    columns: Columns[tuple[PeerBench, Timing]] = [
        ("library", lambda each: each[0].name),
        ("samples", lambda each: str(each[0].samples)),
        ("time per sample [ns]", lambda each: _ns(each[1])),
        ("ratio", lambda each: _digits(each[1].least / bench.ours.least)),
        ("difference", lambda each: _off(each[0].difference or 0.0)),
    ]
    measured = [(peer, peer.time) for peer in bench.peers if peer.time]
    missing = paragraphs(f"{peer.name} {peer.problem}" for peer in bench.peers if peer.problem)
    return [Table(title, *by_columns(columns, measured)) if measured else Paragraph(title), *missing]


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


def doctor_sections(lines: tuple[Line, ...]) -> Iterator[Section]:
    """Yield a line each with its verdict, group by group, and a sentence on the whole."""
    wide = max(len(line.name) for line in lines)
    for name, group in groupby(lines, key=lambda line: line.group):
        found = [(line, ": ".join(text for text in (line.found, line.remark) if text)) for line in group]
        yield paragraphs(
            [name, *(f"  {each.name:<{wide}}  {each.verdict:<7}  {said}".rstrip() for each, said in found)]
        )
    broken, missing = (
        ", ".join(line.name for line in lines if line.verdict == verdict) for verdict in ("broken", "missing")
    )
    end = "everything that is needed works" if healthy(lines) else f"to be repaired: {broken}"
    yield [Paragraph(f"{end}; missing: {missing}" if missing else end)]
