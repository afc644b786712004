"""Robot dynamics from URDF descriptions: torques, reactions and sizing along a motion.

    model = robodyn.load("robot.urdf")
    tau = robodyn.inverse_dynamics(model, q, qd, qdd)

Names are imported when they are first used, so that `import robodyn` costs nothing.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robodyn.checks.check import check as check
    from robodyn.comparison.compare import compare as compare
    from robodyn.dynamics.constraints.solve import constraint_forces as constraint_forces
    from robodyn.dynamics.derivatives import forward_dynamics_derivatives as forward_dynamics_derivatives
    from robodyn.dynamics.derivatives import (
        inverse_dynamics_derivative_entries as inverse_dynamics_derivative_entries,
    )
    from robodyn.dynamics.derivatives import inverse_dynamics_derivatives as inverse_dynamics_derivatives
    from robodyn.dynamics.derivatives import (
        inverse_dynamics_second_derivatives as inverse_dynamics_second_derivatives,
    )
    from robodyn.dynamics.forward import forward_dynamics as forward_dynamics
    from robodyn.dynamics.function import function as function
    from robodyn.dynamics.inverse import bias_forces as bias_forces
    from robodyn.dynamics.inverse import coriolis_matrix as coriolis_matrix
    from robodyn.dynamics.inverse import inverse_dynamics as inverse_dynamics
    from robodyn.dynamics.inverse import mass_matrix as mass_matrix
    from robodyn.dynamics.momenta import centre_of_mass as centre_of_mass
    from robodyn.dynamics.momenta import forward_kinematics as forward_kinematics
    from robodyn.dynamics.momenta import jacobian as jacobian
    from robodyn.dynamics.momenta import momenta as momenta
    from robodyn.dynamics.regressor import regressor as regressor
    from robodyn.equations.dae.dae import dae as dae
    from robodyn.equations.derive import derive as derive
    from robodyn.equations.export.export import export as export
    from robodyn.equations.free_body.bodies import free_bodies as free_bodies
    from robodyn.equations.linearized.linearize import linearize as linearize
    from robodyn.errors import RobodynError as RobodynError
    from robodyn.identification.excitation.excite import excite as excite
    from robodyn.identification.identify import identify as identify
    from robodyn.identification.log.log import read_log as read_log
    from robodyn.loads.torques import torques as torques
    from robodyn.report.torques_page import view as view
    from robodyn.robot.load import load as load
    from robodyn.robot.model import Model as Model
    from robodyn.scene.fit import scene_of as scene_of
    from robodyn.scene.read import load_scene as load_scene
    from robodyn.scene.scene import Contact as Contact
    from robodyn.scene.scene import ContactCost as ContactCost
    from robodyn.scene.scene import CoupledMotor as CoupledMotor
    from robodyn.scene.scene import Drive as Drive
    from robodyn.scene.scene import ExternalWrench as ExternalWrench
    from robodyn.scene.scene import Friction as Friction
    from robodyn.scene.scene import GearLife as GearLife
    from robodyn.scene.scene import Immersed as Immersed
    from robodyn.scene.scene import Loop as Loop
    from robodyn.scene.scene import Motor as Motor
    from robodyn.scene.scene import Payload as Payload
    from robodyn.scene.scene import Rotor as Rotor
    from robodyn.scene.scene import Scene as Scene
    from robodyn.scene.scene import Spring as Spring
    from robodyn.scene.scene import Thermal as Thermal
    from robodyn.scene.uncertainty import Covariance as Covariance
    from robodyn.scene.uncertainty import Deviation as Deviation
    from robodyn.scene.uncertainty import LinkUncertainty as LinkUncertainty
    from robodyn.scene.uncertainty import Uncertainty as Uncertainty
    from robodyn.simulation.rollouts import rollouts as rollouts
    from robodyn.simulation.simulate import simulate as simulate
    from robodyn.sizing.catalogue import size as size
    from robodyn.sizing.envelope import envelope as envelope
    from robodyn.sizing.retime import retime as retime
    from robodyn.solids.mass_properties import mass_properties as mass_properties
    from robodyn.trajectory.read import motion as motion
    from robodyn.trajectory.read import read_motion as read_motion

if not os.path.isdir(os.path.join(os.path.dirname(__file__), "cli")):
    __path__.append(os.path.dirname(os.path.dirname(__file__)))  # of a checkout, where `cli/` stands beside this folder

_HOMES = {
    "checks.check": ("check",),
    "comparison.compare": ("compare",),
    "dynamics.constraints.solve": ("constraint_forces",),
    "dynamics.derivatives": (
        "forward_dynamics_derivatives",
        "inverse_dynamics_derivative_entries",
        "inverse_dynamics_derivatives",
        "inverse_dynamics_second_derivatives",
    ),
    "dynamics.forward": ("forward_dynamics",),
    "dynamics.function": ("function",),
    "dynamics.inverse": ("bias_forces", "coriolis_matrix", "inverse_dynamics", "mass_matrix"),
    "dynamics.momenta": ("centre_of_mass", "forward_kinematics", "jacobian", "momenta"),
    "dynamics.regressor": ("regressor",),
    "equations.dae.dae": ("dae",),
    "equations.derive": ("derive",),
    "equations.export.export": ("export",),
    "equations.free_body.bodies": ("free_bodies",),
    "equations.linearized.linearize": ("linearize",),
    "errors": ("RobodynError",),
    "identification.excitation.excite": ("excite",),
    "identification.identify": ("identify",),
    "identification.log.log": ("read_log",),
    "loads.torques": ("torques",),
    "report.torques_page": ("view",),
    "robot.load": ("load",),
    "robot.model": ("Model",),
    "scene.fit": ("scene_of",),
    "scene.read": ("load_scene",),
    "scene.scene": (
        *("Contact", "ContactCost", "CoupledMotor", "Drive", "ExternalWrench", "Friction", "Immersed", "Loop", "Motor"),
        *("GearLife", "Payload", "Rotor", "Scene", "Spring", "Thermal"),
    ),
    "scene.uncertainty": ("Covariance", "Deviation", "LinkUncertainty", "Uncertainty"),
    "simulation.rollouts": ("rollouts",),
    "simulation.simulate": ("simulate",),
    "sizing.catalogue": ("size",),
    "sizing.retime": ("retime",),
    "sizing.envelope": ("envelope",),
    "solids.mass_properties": ("mass_properties",),
    "trajectory.read": ("motion", "read_motion"),
}
__all__ = [name for names in _HOMES.values() for name in names]


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            found = globals()[name] = getattr(import_module(f"robodyn.{home}"), name)
            return found
    raise AttributeError(f"module 'robodyn' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
