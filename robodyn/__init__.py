"""Robot dynamics from URDF descriptions: torques, reactions and sizing along a motion.

    model = robodyn.load("robot.urdf")
    tau = robodyn.inverse_dynamics(model, q, qd, qdd)

Names are imported when they are first used, so that `import robodyn` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robodyn.assemble import load as load
    from robodyn.checks.run import check as check
    from robodyn.errors import RobodynError as RobodynError
    from robodyn.forward import forward_dynamics as forward_dynamics
    from robodyn.free_body.bodies import free_bodies as free_bodies
    from robodyn.inverse import bias_forces as bias_forces
    from robodyn.inverse import inverse_dynamics as inverse_dynamics
    from robodyn.inverse import mass_matrix as mass_matrix
    from robodyn.loads import torques as torques
    from robodyn.model import Model as Model
    from robodyn.momentum import momenta as momenta
    from robodyn.motion_input import motion as motion
    from robodyn.motion_input import read_motion as read_motion
    from robodyn.motor import Motor as Motor
    from robodyn.part import mass_properties as mass_properties
    from robodyn.scene import Drive as Drive
    from robodyn.scene import ExternalWrench as ExternalWrench
    from robodyn.scene import Friction as Friction
    from robodyn.scene import Immersed as Immersed
    from robodyn.scene import Loop as Loop
    from robodyn.scene import Payload as Payload
    from robodyn.scene import Rotor as Rotor
    from robodyn.scene import Scene as Scene
    from robodyn.scene import Spring as Spring
    from robodyn.scene_file import load_scene as load_scene
    from robodyn.simulation.rollouts import rollouts as rollouts
    from robodyn.simulation.run import simulate as simulate

_HOMES = {
    "assemble": ("load",),
    "checks.run": ("check",),
    "errors": ("RobodynError",),
    "forward": ("forward_dynamics",),
    "free_body.bodies": ("free_bodies",),
    "inverse": ("bias_forces", "inverse_dynamics", "mass_matrix"),
    "loads": ("torques",),
    "model": ("Model",),
    "momentum": ("momenta",),
    "motion_input": ("motion", "read_motion"),
    "motor": ("Motor",),
    "part": ("mass_properties",),
    "scene": ("Drive", "ExternalWrench", "Friction", "Immersed", "Loop", "Payload", "Rotor", "Scene", "Spring"),
    "scene_file": ("load_scene",),
    "simulation.rollouts": ("rollouts",),
    "simulation.run": ("simulate",),
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
