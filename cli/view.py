"""`robodyn view`: a robot in the browser, moved by sliders or along a motion."""

from __future__ import annotations

import click

from robodyn.cli.files import ROBOT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.options import AT, BASE_HELD, PATH, READING, REPORT_OUT, SCENE, Call, option, refuse_where, takes
from robodyn.cli.screen import show, write_report
from robodyn.support.extras import need


@click.command("view", short_help="Show a robot in 3-D in the browser: with sliders, or along a motion.")
@click.argument("urdf", type=PATH)
@click.argument("trajectory", type=PATH, required=False)
@takes(
    AT,
    SCENE,
    BASE_HELD,
    READING,
    option("--report FILE", "Write the page there, .html, and open nothing.", REPORT_OUT),
)
def command(call: Call, urdf: str, trajectory: str | None) -> None:
    """Show a robot in 3-D in the browser. Its joints have sliders; along a trajectory it is the page of
    robodyn torques, which plays it. The page is one file that needs no network; its name is printed.
    A file named - is standard input; a trajectory then is CSV.

    \b
    Examples:
      robodyn view robots/puma560.urdf --at 0,0.8,-0.3,0,0.5,0
      robodyn view robots/puma560.urdf robots/puma560_sweep.csv --report puma.html
    """
    check_names()
    refuse_where(
        (call.report is not None and not call.pictured, "--report of view is an .html file"),
        (trajectory is not None and call.at is not None, "--at is for a robot without a trajectory"),
        (trajectory is None and call.reading_given, f"{call.reading_given} goes with a trajectory"),
    )
    need("HTML reports", "jinja2", "uplot-python")
    expect(ROBOT, urdf)
    model, scene = robot_in_scene(call, urdf, loops=True, contacts=True)
    from robodyn.report.torques_page import view_page

    if trajectory is None:
        document = view_page(model, None, scene, call.at)
    else:
        from robodyn.trajectory.read import read_motion

        expect(TABLE, trajectory)
        with read_motion(trajectory, model, scene, **call.reading) as motion:
            document = view_page(model, motion, scene, None)
    if call.report is not None:
        show(write_report(call.report, document).lstrip())
        return
    import webbrowser
    from pathlib import Path
    from tempfile import mkdtemp

    path = Path(mkdtemp(prefix="robodyn_")) / "view.html"
    written = write_report(str(path), document).lstrip()
    opened = webbrowser.open(path.as_uri())
    show(written + ("" if opened else "no browser was found here: open this file in one\n"))
