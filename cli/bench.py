"""`robodyn bench`: how fast the dynamics of a robot are computed on this machine."""

from __future__ import annotations

import sys

import click

from robodyn.cli.call import FORMAT, PATH, SCENE, Call, refuse, takes
from robodyn.cli.files import STANDARD_INPUT, check_names, robot_in_scene
from robodyn.cli.reports import answer
from robodyn.measure.speed.run import bench
from robodyn.report.accuracy import bench_json, bench_sections


@click.command("bench", short_help="Measure how fast each executor is on a robot.")
@click.argument("urdf", type=PATH)
@takes(
    SCENE,
    click.option("--samples", type=click.IntRange(min=1), default=100_000, metavar="N", help="Default 100000."),
    click.option("--threads", type=click.IntRange(min=1), metavar="N", help="Beside one; default all."),
    click.option("--peers", is_flag=True, help="Measure Pinocchio, MuJoCo and Drake too, where they are installed."),
    FORMAT,
)
def command(call: Call, urdf: str, samples: int, threads: int | None, peers: bool) -> None:
    """Measure the time of the inverse dynamics by every executor, and the cost of every effect.
    A file named - is standard input.

    \b
    Example:
      robodyn bench robots/puma560.urdf --scene robots/puma560_motors.toml --peers
    """
    if peers and urdf == STANDARD_INPUT:
        refuse("--peers reads the description again: name its file")
    check_names()
    model, scene = robot_in_scene(call, urdf)
    try:
        result = bench(model, scene, samples=samples, threads=threads, peers=peers, watch=_watch)
    finally:
        _watch("")
    answer(call, bench_sections(result), json=lambda: bench_json(result))


def _watch(what: str) -> None:
    """Show on a terminal what is measured; an empty text takes the line away."""
    if sys.stderr is not None and sys.stderr.isatty():
        print(f"\r\x1b[K{what and 'measuring: '}{what}", end="", file=sys.stderr, flush=True)
