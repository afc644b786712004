"""`robodyn diff`: whether two descriptions are of one robot, and what differs."""

from __future__ import annotations

import click

from robodyn.cli.files import ROBOT, check_names, expect, robot_source
from robodyn.cli.options import DESCRIPTION, PATH, POSITIVE, REPORT, Call, option, takes
from robodyn.cli.screen import answer
from robodyn.comparison.compare import compare
from robodyn.report.comparison import comparison_json, comparison_page, comparison_sections, findings

FORMS = ("text", "json", "junit", "github")


@click.command("diff", short_help="Compare two descriptions of one robot, and say what differs in torque and why.")
@click.argument("a", type=PATH)
@click.argument("b", type=PATH)
@takes(
    option("--tolerance NM", "N m or N: what changes no torque by more is no difference.", POSITIVE),
    DESCRIPTION,
    REPORT,
    option(
        "--format", "Form of the report; default text.", ("text", "json", "junit", "github"), "form", default="text"
    ),
)
def command(call: Call, a: str, b: str, tolerance: float | None) -> int:
    """Compare two descriptions of one robot, in any formats that are read: bodies are matched, then their joints,
    masses and what acts on joints; and for each joint the worst difference of torque over poses and motions within the
    limits, with the pose, the link that is guilty, and why. Exit status 1 if they differ. - is standard input.

    \b
    Examples:
      robodyn diff robots/puma560.urdf robots/puma.urdf
      robodyn diff robots/scara.urdf robots/scara.urdf --tolerance 0.01 --format json
    """
    from robodyn.robot.load import load

    check_names()
    for each in (a, b):
        expect(ROBOT, each)
    one, other = (load(robot_source(each), **call.lookup) for each in (a, b))
    found = compare(one, other, tolerance=tolerance)
    from robodyn.checks.check import Checked
    from robodyn.report.renderers.findings import check_github, check_junit

    answer(
        call,
        comparison_sections(found),
        lambda pictures: comparison_page(found, pictures),
        json=lambda: comparison_json(found),
        junit=lambda: check_junit(Checked((b,), findings(found))),
        github=lambda: check_github(findings(found)),
    )
    return int(not found.equal)
