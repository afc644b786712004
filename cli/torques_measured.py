"""`robodyn torques --measured`: the torques of a log against those computed."""

from __future__ import annotations

from functools import partial

from robodyn.cli.files import ROBOT, TABLE, check_names, expect, robot_in_scene
from robodyn.cli.reading_options import reading
from robodyn.cli.reports import answer, get_ready
from robodyn.identification.faults.compare import compare
from robodyn.report.measured import measured_json, measured_page, measured_sections


def run_measured(urdf: str, log: str, cutoff: float | None) -> None:
    """Show what explains the difference of measured and computed torques.

    Args:
        cutoff: of the filter [Hz]; None: by the noise.
    """
    check_names()
    expect(ROBOT, urdf)
    expect(TABLE, log)
    get_ready()
    model, scene = robot_in_scene(urdf)
    found = compare(model, log, scene, cutoff=cutoff, **reading())
    answer(measured_sections(found), partial(measured_page, found), json=lambda: measured_json(found))
