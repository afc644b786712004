"""What `robodyn equations --form dae` prints."""

from __future__ import annotations

from typing import Any

from robodyn.cli.screen import page
from robodyn.equations.dae.dae import dae
from robodyn.report.json_dae import dae_json
from robodyn.report.latex_dae import dae_latex
from robodyn.report.text_dae import dae_text
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def dae_report(model: Model, scene: Scene, at: Any, qd: Any, tau: Any, output: str) -> str:
    """The report in the form that is asked for."""
    found = dae(model, scene, at, qd or (), tau or ())
    if output == "text":
        return dae_text(found, page())
    return {"json": dae_json, "latex": dae_latex}[output](found)
