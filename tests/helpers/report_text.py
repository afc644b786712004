"""Reports as text for a terminal, as the commands print them."""

from __future__ import annotations

from robodyn.loads.result import Result
from robodyn.report.document import text
from robodyn.report.limits import verdict_section
from robodyn.report.simulation import simulation_sections
from robodyn.report.table import PLAIN, Page
from robodyn.report.torques import torques_sections
from robodyn.simulation.result import Simulation


def torques_text(result: Result, explain: bool = False, page: Page = PLAIN) -> str:
    """Return what `robodyn torques` prints."""
    return text([*torques_sections(result, explain), verdict_section(result)], page)


def simulation_text(result: Simulation) -> str:
    """Return what `robodyn simulate` prints."""
    return text(simulation_sections(result))
