"""`robodyn simulate`: how a robot moves from where the scene has it begin."""

from __future__ import annotations

from functools import partial

import click

from robodyn.cli import options
from robodyn.cli.files import check_names, check_table, robot_in_scene
from robodyn.cli.options import PATH, POSITIVE, TABLE_OUT, VALUES, Call, option, refuse, takes
from robodyn.cli.screen import answer, write_table
from robodyn.dynamics.initial_state import begun_at
from robodyn.programs.run.runner import EXECUTORS
from robodyn.report.simulation import simulation_json, simulation_page, simulation_sections
from robodyn.simulation.methods import METHODS
from robodyn.simulation.simulate import simulate
from robodyn.simulation.table import read_table
from robodyn.trajectory.write import format_of


@click.command("simulate", short_help="Simulate how a robot moves by itself, driven or pushed.")
@click.argument("urdf", type=PATH)
@takes(
    options.SCENE,
    option("--at Q", "Begin here: joint values in order, or JOINT=Q,...", VALUES),
    option("--traj FILE", "The table whose columns the scene names.", PATH, "table"),
    options.TABLE,
    option("--duration S", "s; default that of the table, else 10.", float),
    option("--step S", "s, of a fixed step; default 0.001, less where stiff.", float),
    option("--rtol R", "Tolerance of a method that chooses its steps.", float),
    option("--method NAME", f"{', '.join(each.name for each in METHODS)}; default rk4."),
    option("--accuracy E", "Choose method and step for this relative error.", POSITIVE),
    option("--out FILE", "Write the motion and its torques: .csv, .parquet or .npz.", TABLE_OUT),
    option("--fail-on-limits", "Exit with 1 if a limit is exceeded, or one ends the motion."),
    options.BASE_HELD,
    option("--explain", "Say why each effect is on or off."),
    option("--executor", "As of torques; default auto.", EXECUTORS, default="auto"),
    options.REPORT,
    options.FORMAT,
)
def command(
    call: Call,
    urdf: str,
    table: str | None,
    duration: float | None,
    step: float | None,
    rtol: float | None,
    method: str | None,
    explain: bool,
) -> int:
    """Simulate a robot from a scene's initial state: gravity, drives, friction, springs, wrenches, a free base, closed
    chains. Drives and wrenches may follow columns of a table (--traj). There is no contact. Joints for which
    neither --at nor the scene says a position begin at 0, or within their limits. A file named - is standard input.

    \b
    Examples:
      robodyn simulate robots/two_link_planar.urdf --scene robots/two_link_planar_swing_down.toml --duration 2
      robodyn simulate robots/two_link_planar.urdf --scene robots/two_link_planar_swing_down.toml --report r.html
      robodyn simulate robots/puma.urdf --at shoulder=-1.5,elbow=1.5 --duration 0.5
    """
    check_names()
    if call.out:
        format_of(call.out)
    model, scene = robot_in_scene(call, urdf, loops=True)
    scene = begun_at(model, scene, call.at or ())
    check_table(call, table, scene)
    if table is None and call.reading_given:
        refuse(f"{call.reading_given} goes with --traj")
    form = {name: call.reading[name] for name in ("columns", "time_unit")}
    rows = None if table is None else read_table(table, scene, **form)
    if call.accuracy is None:
        result = simulate(
            model, scene, duration, step=step, rtol=rtol, method=method, table=rows, executor=call.executor
        )
    else:
        from robodyn.measure.accuracy.simulate_within import simulate_within

        if step or rtol or method:
            refuse("--accuracy chooses method, step and tolerance")
        result = simulate_within(model, scene, duration, call.accuracy, table=rows, executor=call.executor)
    written = write_table(call.out, result.names, result.time, result.columns)
    sections, document = simulation_sections(result, explain), partial(simulation_page, result)
    answer(call, sections, document, written, json=lambda: simulation_json(result))
    return int(call.fail_on_limits and (bool(result.ended) or result.within_limits is False))
