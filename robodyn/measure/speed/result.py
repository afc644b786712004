"""What `bench` answers: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.loads.result import EffectReport


@dataclass(frozen=True)
class Timing:
    """Seconds of something that ran several times, in turn with what it is compared with.

    Attributes:
        least: the shortest run, which the rest of the machine disturbed least.
        median: of all runs.
        runs: how many.
    """

    least: float
    median: float
    runs: int

    def per(self, amount: int) -> Timing:
        """Return the same for one of an amount."""
        return Timing(self.least / amount, self.median / amount, self.runs)


@dataclass(frozen=True)
class ExecutorBench:
    """How fast an executor computes the torques; times are per sample.

    Attributes:
        dtype: of arrays and arithmetic.
        build: what makes it ready where nothing is cached.
        load: what makes it ready from the cache; None where it has none.
        columnar, row_major: one thread, arrays with contiguous columns or rows.
        columnar_threads, row_major_threads: with all threads; None where it works with one alone.
        difference: the largest from NumPy's torques in double precision, of the largest; None if one overflows.
        bytes: that one sample reads and writes.
        of_copying: bytes per second, columnar by one thread, over those of copying.
    """

    name: str
    dtype: str
    build: Timing
    load: Timing | None
    columnar: Timing
    row_major: Timing
    columnar_threads: Timing | None
    row_major_threads: Timing | None
    difference: float | None
    bytes: int
    of_copying: float


@dataclass(frozen=True)
class CopyBench:
    """Copying memory: what one sample of torques reads and writes, `bytes` in all, by one thread and by all.

    Attributes:
        one, all: per sample; None where all threads are one.
    """

    bytes: int
    one: Timing
    all: Timing | None


@dataclass(frozen=True)
class EffectBench:
    """What an active effect costs: operations, and the time per sample of machine code for all the others.

    Attributes:
        without: columnar, one thread; None where there is no machine code.
    """

    report: EffectReport
    without: Timing | None


@dataclass(frozen=True)
class ProgramBench:
    """A program other than that of the torques.

    Attributes:
        trace: seconds.
        build: of machine code, where nothing is cached; None where there is none.
        samples: that ran, fewer where outputs are many.
        compiled: per sample, columnar, one thread.
    """

    name: str
    operations: int
    outputs: int
    trace: float
    build: Timing | None = None
    samples: int | None = None
    compiled: Timing | None = None


@dataclass(frozen=True)
class PeerBench:
    """The same torques by another library.

    Attributes:
        time: per sample, one thread.
        difference: the largest from robodyn's torques, of the largest of these.
        problem: why there are no numbers; then all others are None.
    """

    name: str
    samples: int | None = None
    time: Timing | None = None
    difference: float | None = None
    problem: str | None = None


@dataclass(frozen=True)
class PeersBench:
    """Other libraries and robodyn in one run, for torques of gravity, inertia and Coriolis forces alone.

    Attributes:
        executor: robodyn's, with one thread; `ours` is its time per sample, columnar.
    """

    operations: int
    executor: str
    ours: Timing
    peers: tuple[PeerBench, ...]


@dataclass(frozen=True)
class Bench:
    """How fast the dynamics of a robot are computed on this machine.

    Attributes:
        joints: degrees of freedom.
        operations, operations_at_rest: per sample, for the torques.
        trace: seconds.
        whole: machine code with all effects, measured in turn with `effects`.
        problem: why there is no machine code; None if there is.
        peers: None where they were not asked for.
    """

    robot: str
    joints: int
    gravity: tuple[float, float, float]
    samples: int
    threads: int
    operations: int
    operations_at_rest: int
    trace: Timing
    executors: tuple[ExecutorBench, ...]
    copying: CopyBench
    whole: Timing | None
    effects: tuple[EffectBench, ...]
    programs: tuple[ProgramBench, ...]
    peers: PeersBench | None
    problem: str | None
