"""The text and the JSON of `bench`: every number in its place, and what is not there left out."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, replace

import pytest

from robodyn.dynamics.effects.effect import Verdict
from robodyn.loads.result import EffectReport
from robodyn.measure.speed.result import (
    Bench,
    CopyBench,
    EffectBench,
    ExecutorBench,
    PeerBench,
    PeersBench,
    ProgramBench,
    Timing,
)
from robodyn.report.accuracy import bench_json, bench_sections
from robodyn.report.document import text
from robodyn.report.table import PLAIN, Page


def time(seconds: float, excess: float = 1.1) -> Timing:
    return Timing(seconds, seconds * excess, 5)


NUMPY = ExecutorBench(
    *("numpy", "float64", time(1.5e-3), None, time(215e-9), time(220e-9), None, None),
    *(0.0, 184, 0.0333),
)
COMPILED = ExecutorBench(
    *("compiled", "float64", time(20e-3), time(1.25e-3), time(10.5e-9), time(25.3e-9), time(5.25e-9), time(13e-9)),
    *(3e-16, 184, 0.714),
)
SINGLE = replace(COMPILED, name="compiled float32", dtype="float32", difference=2e-7, bytes=92)
GRAVITY = EffectBench(EffectReport("gravity", Verdict(True, "gravity is on"), 131, 4), time(10.1e-9))
CORIOLIS = EffectBench(EffectReport("coriolis", Verdict(True, "it moves"), 328, 129), time(9.09e-9))
BIAS = ProgramBench("bias forces", 338, 6, 1.8e-3, time(18.3e-3), 1000, time(10.8e-9))
MASS = ProgramBench("mass matrix", 39543, 10201, 0.75, time(2.4), 800, time(20e-6))
PEERS = PeersBench(
    371,
    "compiled",
    time(10e-9),
    (
        PeerBench("Pinocchio 4, rneaInParallel", 1000, time(650e-9), 5e-16),
        PeerBench("Drake, loop", 100, time(15e-6), 0.0),
        PeerBench("MuJoCo", problem="is not installed (pip install mujoco)"),
    ),
)
BENCH = Bench(
    robot="arm",
    joints=6,
    gravity=(0.0, 0.0, -9.81),
    samples=1000,
    threads=2,
    operations=371,
    operations_at_rest=131,
    trace=time(1.3e-3),
    executors=(NUMPY, COMPILED, SINGLE),
    copying=CopyBench(184, time(7.5e-9), time(6e-9, 2.0)),
    whole=time(10.55e-9),
    effects=(GRAVITY, CORIOLIS),
    programs=(BIAS, MASS),
    peers=PEERS,
    problem=None,
)
MISSING = replace(
    BENCH,
    executors=(NUMPY,),
    whole=None,
    effects=(replace(GRAVITY, without=None),),
    programs=(replace(BIAS, build=None, samples=None, compiled=None),),
    peers=None,
    problem="llvmlite is not installed; pip install llvmlite",
)


def section(text: str, title: str) -> list[list[str]]:
    """The lines of the part that begins with this title, cut into cells."""
    part = next(part for part in text.split("\n\n") if part.startswith(title))
    return [re.split(r"  +", line.strip()) for line in part.splitlines()]


def bench_text(bench: Bench, page: Page = PLAIN) -> str:
    return text(bench_sections(bench), page)


def test_head() -> None:
    assert bench_text(BENCH).splitlines()[:2] == [
        "arm: 6 joints, 1000 samples, gravity (0, 0, -9.81) m/s^2",
        "371 operations per sample for the torques, 131 at rest; traced in 1.30 ms",
    ]


def test_executors() -> None:
    _, head, numpy, compiled, single, (memory,) = section(bench_text(BENCH), "Torques, time per sample")
    assert head == [
        *("executor", "build [ms]", "from cache [ms]", "columnar [ns]", "row-major [ns]"),
        *("columnar, 2 threads [ns]", "row-major, 2 threads [ns]", "of copying", "difference"),
    ]
    assert numpy == ["numpy", "1.50", "215", "220", "3%"]
    assert compiled == ["compiled", "20.0", "1.25", "10.5", "25.3", "5.25", "13.0", "71%", "3e-16"]
    assert (single[0], single[-1]) == ("compiled float32", "2e-07")
    assert memory == "184 bytes per sample; copying as many takes 7.50 ns, 6.00 ns by 2 threads"


def test_one_thread() -> None:
    alone = replace(COMPILED, columnar_threads=None, row_major_threads=None, difference=None)
    copying = replace(BENCH.copying, all=None)
    words = bench_text(replace(BENCH, threads=1, executors=(NUMPY, alone), copying=copying))
    _, head, _, compiled, (memory,) = section(words, "Torques, time per sample")
    assert not [title for title in head if "threads" in title]
    assert compiled[-2:] == ["71%", "overflows"]
    assert memory.endswith("copying as many takes 7.50 ns")


def test_effects() -> None:
    (title,), head, gravity, coriolis = section(bench_text(BENCH), "Effects")
    assert title == "Effects, compiled, columnar, one thread: all take 10.6 ns per sample"
    assert head == ["effect", "operations alone", "saved without", "time without [ns]"]
    assert gravity == ["gravity", "131", "4", "10.1"]
    assert coriolis == ["coriolis", "328", "129", "9.09"]


def test_programs() -> None:
    _, head, bias, mass = section(bench_text(BENCH), "Other programs, compiled, columnar, one thread")
    assert head == ["program", "operations", "outputs", "trace [ms]", "build [ms]", "time per sample [ns]"]
    assert bias == ["bias forces", "338", "6", "1.80", "18.3", "10.8"]
    assert mass == ["mass matrix", "39543", "10201", "750", "2400", "20000"]


def test_other_libraries() -> None:
    (title,), head, pinocchio, drake, (missing,) = section(bench_text(BENCH), "Other libraries")
    assert title.endswith("alone: robodyn (compiled) takes 10.0 ns for 371 operations")
    assert head == ["library", "samples", "time per sample [ns]", "ratio", "difference"]
    assert pinocchio == ["Pinocchio 4, rneaInParallel", "1000", "650", "65.0", "5e-16"]
    assert drake == ["Drake, loop", "100", "15000", "1500", "0"]
    assert missing == "MuJoCo is not installed (pip install mujoco)"
    assert "Other libraries" not in bench_text(replace(BENCH, peers=None))


def test_no_other_library() -> None:
    words = bench_text(replace(BENCH, peers=replace(PEERS, peers=PEERS.peers[-1:])))
    assert len(section(words, "Other libraries")) == 2


def test_steadiness_is_of_all_times() -> None:
    assert bench_text(BENCH).splitlines()[-1] == (
        "Times are the shortest of several runs in turn; medians are 10% longer as a rule, 100% at most."
    )


def test_without_machine_code() -> None:
    words = bench_text(MISSING)
    executors = section(words, "Torques, time per sample")
    assert [line[0] for line in executors[2:]] == [
        "numpy",
        "184 bytes per sample; copying as many takes 7.50 ns, 6.00 ns by 2 threads",
        "compiled: llvmlite is not installed; pip install llvmlite",
    ]
    assert section(words, "Effects") == [
        ["Effects"],
        ["effect", "operations alone", "saved without"],
        ["gravity", "131", "4"],
    ]
    assert section(words, "Other programs") == [
        ["Other programs"],
        ["program", "operations", "outputs", "trace [ms]"],
        ["bias forces", "338", "6", "1.80"],
    ]


@pytest.mark.parametrize("bench", [BENCH, MISSING])
@pytest.mark.parametrize("width", [None, 60])
def test_lines_end_and_parts_are_apart(bench: Bench, width: int | None) -> None:
    words = bench_text(bench, Page(width))
    assert words.endswith(".\n")
    assert not re.search(r"\n\n\n| $", words, re.MULTILINE)


def test_a_name_cannot_control_the_terminal() -> None:
    assert "\x1b" not in bench_text(replace(BENCH, robot="arm\x1b[31m"))


def test_json_has_everything_at_full_precision() -> None:
    found = json.loads(bench_json(BENCH))
    assert list(found) == list(asdict(BENCH))
    assert found["trace"] == {"least": 1.3e-3, "median": 1.3e-3 * 1.1, "runs": 5}
    assert found["executors"][1] == asdict(COMPILED)
    assert found["copying"] == asdict(BENCH.copying)
    assert found["programs"] == [asdict(BIAS), asdict(MASS)]
    assert found["peers"] == {**asdict(PEERS), "peers": [asdict(peer) for peer in PEERS.peers]}
    assert found["effects"][0] == {
        "name": "gravity",
        "reason": "gravity is on",
        "operations": 131,
        "operations_saved_without": 4,
        "without": asdict(GRAVITY.without),
    }


def test_json_without_machine_code() -> None:
    found = json.loads(bench_json(MISSING))
    assert found["problem"] == MISSING.problem
    assert found["whole"] is found["peers"] is found["effects"][0]["without"] is None
