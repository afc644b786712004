"""How fast the dynamics of a robot are computed here: by each executor, effect by effect, and by other libraries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from robodyn.dynamics.balance import energy, laws
from robodyn.dynamics.mass import mass_runner
from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.loads.figures import effect_reports
from robodyn.measure.speed.executors import Work, compile_anew, executor_benches, random_sources
from robodyn.measure.speed.peers import compared
from robodyn.measure.speed.result import Bench, EffectBench, ProgramBench, Timing
from robodyn.measure.timing import repeated, taking_turns
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.llvm.machine import compiler
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.threads import cores

LARGEST_RESULT = 64 << 20
"""Bytes that the outputs of a program may take; fewer samples run where they would be more."""


@np.errstate(all="ignore")
def bench(
    model: Model,
    scene: Scene = DEFAULT,
    *,
    samples: int = 100_000,
    threads: int | None = None,
    peers: bool = False,
    watch: Callable[[str], None] = lambda what: None,
) -> Bench:
    """How fast the inverse dynamics of a robot in a scene are computed on this machine, and what the effects cost.

    Times are those of random samples in arrays that are ready, with an array to write to. What is compared takes turns;
    the shortest run counts and the median is there beside it.

    Args:
        threads: of the rows with all threads; None is all cores.
        peers: measure Pinocchio, MuJoCo and Drake too, where they are installed; reads `model.file` again.
        watch: told what is measured next.

    Raises:
        InputError: nothing of the robot can move, the scene does not fit it, or a torque overflows.
    """
    check_moves(model)
    a_plan = plan(model, scene)
    program = a_plan.torques()
    work = Work(program, runner_of(program, a_plan).widths, random_sources(model, scene, samples), samples)
    workers = cores(threads)
    watch("executors")
    trace = repeated(a_plan.torques)
    executors, copying = executor_benches(work, workers)
    watch("effects")
    whole, effects = _effects(a_plan, work)
    return Bench(
        robot=model.name,
        joints=model.n,
        gravity=scene.gravity,
        samples=samples,
        threads=workers,
        operations=work.program.size,
        operations_at_rest=_resting(a_plan, ("qd", "qdd")).torques().size,
        trace=trace,
        executors=executors,
        copying=copying,
        whole=whole,
        effects=effects,
        programs=_programs(a_plan, work, watch),
        peers=compared(model, scene.gravity, work.sources, samples, watch) if peers else None,
        problem=compiler().problem,
    )


def _resting(a_plan: Plan, sources: tuple[str, ...]) -> Plan:
    """Return the plan of motions in which these are zero."""
    model = a_plan.model
    return plan(model, a_plan.scene, frozenset((source, i) for source in sources for i in range(model.n)))


def _effects(a_plan: Plan, work: Work) -> tuple[Timing | None, tuple[EffectBench, ...]]:
    """Time per sample with all active effects, and what each of them costs."""
    active = [report for report in effect_reports(a_plan, explain=True) if report.verdict.active]
    if compiler().problem:
        return None, tuple(EffectBench(report, None) for report in active)
    programs = {effect.name: a_plan.without(effect) for effect in a_plan.effects}
    runs = {name: CompiledBlocks(program, work.widths) for name, program in {**programs, "": work.program}.items()}
    acts = {name: _run(run, work.sources, work.samples) for name, run in runs.items()}
    times = {name: timing.per(work.samples) for name, timing in taking_turns(acts).items()}
    return times[""], tuple(EffectBench(report, times[report.name]) for report in active)


def _programs(a_plan: Plan, work: Work, watch: Callable[[str], None]) -> tuple[ProgramBench, ...]:
    makers: dict[str, Callable[[], Program]] = {
        "torques and joint wrenches": partial(a_plan.wrenches, True),
        "bias forces": _resting(a_plan, ("qdd",)).torques,
        "mass matrix": lambda: mass_runner(a_plan.model, a_plan.scene).program,
        "energy and losses": partial(energy, a_plan),
        "momentum laws": partial(laws, a_plan),
    }
    found: list[ProgramBench] = []
    acts: dict[str, Callable[[], object]] = {}
    for name, make in makers.items():
        watch(name)
        start = perf_counter()
        program = make()
        one = ProgramBench(name, program.size, len(program.outputs), perf_counter() - start)
        if not compiler().problem:
            samples = max(1, min(work.samples, LARGEST_RESULT // (8 * max(len(program.outputs), 1))))
            one = replace(one, build=repeated(partial(compile_anew, program, work.widths)), samples=samples)
            acts[name] = _run(CompiledBlocks(program, work.widths), work.sources, samples)
        found.append(one)
    watch("programs")
    times = taking_turns(acts)
    return tuple(replace(one, compiled=times[one.name].per(one.samples)) if one.samples else one for one in found)


def _run(compiled: CompiledBlocks, sources: Mapping[str, Floats], samples: int) -> Callable[[], object]:
    """Return a run by one thread on the first samples, with columns contiguous."""
    out = np.empty((samples, len(compiled.program.outputs)), order="F")
    return partial(compiled, {name: values[:samples] for name, values in sources.items()}, samples, out)
