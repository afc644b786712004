"""What other programs make of a description, from what they document and from running them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from robodyn.checks.consumers import drake, gazebo, mujoco, mujoco_shapes, others, written
from robodyn.checks.consumers.found import Find, Found, joints, nameless, root, when_asked
from robodyn.checks.consumers.meshes import missing_meshes, unread_meshes
from robodyn.checks.context import Context


class Verdict(IntEnum):
    """From good to bad."""

    LOADS = 0
    ALTERS = 1
    REJECTS = 2


@dataclass(frozen=True, slots=True)
class Fact:
    """One thing that a program does: to what (`find`), what (`does`), and how that is known (`source`).

    KG in what it does stands for the mass of all that is found.
    """

    target: str
    verdict: Verdict
    does: str
    source: str
    find: Find

    def says(self, found: tuple[Found, ...]) -> str:
        """Return what it does."""
        return self.does.replace("KG", f"{sum(one.mass for one in found):.3g} kg")


_MUJOCO = "MuJoCo 4.0, run; its XML reference, compiler"
_DRAKE = "Drake 1.51, run"
_SDFORMAT = "sdformat 12.3 with urdfdom 3.0, run"
_GZ = "gz-common 6, MeshManager"
_KDL = "kdl_parser.cpp"
_ISAAC = "Isaac Sim 5, URDF importer and its ImportConfig"
_REJECTS, _ALTERS = Verdict.REJECTS, Verdict.ALTERS
_MIMIC = joints(lambda joint: joint.mimic)
_FIXED = joints(lambda joint: joint.type == "fixed")
_FLOATING = joints(lambda joint: joint.type == "floating")
_FRICTION = joints(lambda joint: joint.friction.value)
_UNACTUATED = joints(lambda joint: joint.type in ("floating", "planar"))
_HEAVY_ROOT = root(lambda link: link.mass)
_FREE_ROOT = root(lambda link: link.name != "world")


def _facts(target: str, verdict: Verdict, source: str, *pairs: tuple[str, Find]) -> tuple[Fact, ...]:
    return tuple(Fact(target, verdict, does, source, find) for does, find in pairs)


FACTS = (
    *_facts(
        "mujoco",
        _REJECTS,
        _MUJOCO,
        ("wants mass and inertia in what moves", mujoco.massless),
        ("wants principal moments of 1e-14 kg m^2 or more, no two of them below the third", mujoco.unphysical),
        ("wants <mass> and <inertia> in <inertial>", mujoco.incomplete),
        ("wants elements once, complete, and with numbers", written.MUJOCO.refused),
        ("wants an axis of 1e-7 or more", mujoco.no_axis),
        ("wants positive sizes of what collides", mujoco_shapes.sizeless),
        ("wants a name or a colour of a material", mujoco_shapes.blank_materials),
        ("takes no joint that mimics itself", mujoco.own_mimics),
        ("takes floating joints only on what stands still", mujoco.deep_floats),
        ("takes no link but the root for its world", mujoco.second_worlds),
        ("reads meshes in .stl, .obj and .msh only", when_asked("mujoco", unread_meshes("mujoco"))),
        ("reads .stl with 1 to 200000 faces only, and no text", when_asked("mujoco", mujoco_shapes.bad_stl)),
        ("wants meshes that enclose 1e-15 m^3", when_asked("mujoco", mujoco_shapes.thin_meshes)),
        ("wants meshes to be there", when_asked("mujoco", missing_meshes("collision"))),
        (
            'opens no URI without <mujoco><compiler strippath="true" meshdir="..."/>',
            when_asked("mujoco", mujoco_shapes.uris),
        ),
    ),
    *_facts(
        "mujoco",
        _ALTERS,
        _MUJOCO,
        ("invents KG: links without <inertial> weigh what water in their collision shapes does", mujoco.inventions),
        ("takes the first object or group of an .obj only", when_asked("mujoco", mujoco_shapes.cut_meshes)),
        ("leaves out what is only <visual>", mujoco.visuals),
        ("makes the root a part of the world, without its mass", _HEAVY_ROOT),
        ("ignores limits unless lower < upper, both given", mujoco.unlimited),
        ("makes mimic a soft equality constraint", _MIMIC),
    ),
    *_facts(
        "drake",
        _REJECTS,
        _DRAKE,
        ("wants lower <= upper", drake.upside_down),
        ("wants a velocity that is not negative, and ends the process otherwise", drake.backwards),
        ("wants an axis of 1e-8 or more", drake.no_axis),
        ("wants damping that is not negative", drake.negative_damping),
        ("wants three numbers as the damping of a planar joint", drake.single_damping),
        ("wants mimic and another joint as leader, with equal degrees of freedom", drake.mimic_leader),
        ("wants finite numbers, colours, sizes and shapes where they are due", written.DRAKE.refused),
        ("wants positive sizes and scales", drake.sizeless),
        ("wants materials defined before they are used, once, with colours from 0 to 1", drake.materials),
        ("wants one joint and one actuator in a simple transmission", drake.transmissions),
        ("collides with meshes in .obj, .vtk and .gltf only", when_asked("drake", unread_meshes("drake"))),
        ("wants meshes to be there", when_asked("drake", missing_meshes("visual", "collision"))),
        ("wants textures to be there", when_asked("drake", drake.missing_textures)),
        ("wants a name of the robot", nameless),
    ),
    *_facts(
        "drake",
        _ALTERS,
        _DRAKE,
        ("ignores joint friction", _FRICTION),
        ("lets the root float unless it is called world", _FREE_ROOT),
        ("leaves the child of a floating joint free of its parent", _FLOATING),
    ),
    *_facts(
        "gz",
        _REJECTS,
        _SDFORMAT,
        ("keeps nothing, since it drops links without mass and all behind them", gazebo.nothing_left),
        ("wants inertia that a body can have, of links with what is fixed to them", gazebo.bad_bodies),
        ("finds no centre of mass of <inertial>s without mass that are fixed to each other", gazebo.nowhere),
        ("knows no floating and no planar joints", gazebo.unknown_joints),
        ("wants an axis of 1e-6 or more", gazebo.no_axis),
        ("wants numbers, and <limit> with effort and velocity, in revolute and prismatic joints", gazebo.malformed),
        ("wants names of joints that are no links', and none like __this__", gazebo.taken_names),
        ("wants a name of the robot", nameless),
    ),
    Fact("gz", _ALTERS, "drops links without mass, and all joints and links behind them", _SDFORMAT, gazebo.dropped),
    Fact("gz", _ALTERS, "exchanges limits where lower > upper", _SDFORMAT, gazebo.turned),
    Fact(
        "gz", _ALTERS, "leaves out meshes in formats that it does not read", _GZ, when_asked("gz", unread_meshes("gz"))
    ),
    Fact("gz", _ALTERS, "merges links on fixed joints", _SDFORMAT, _FIXED),
    Fact("kdl", _ALTERS, "ignores the mass of the root", _KDL, _HEAVY_ROOT),
    Fact("kdl", _ALTERS, "makes the joint fixed", _KDL, _UNACTUATED),
    Fact("kdl", _ALTERS, "moves mimic joints on their own", _KDL, _MIMIC),
    Fact("isaac", _ALTERS, "replaces characters in names by _", _ISAAC, others.odd_names),
    Fact("isaac", _ALTERS, "merges links on fixed joints", _ISAAC, _FIXED),
    Fact("isaac", _ALTERS, "makes up a mass for links without one", _ISAAC, others.no_mass),
)


@dataclass(frozen=True, slots=True)
class Opinion:
    """What one program makes of a file: the verdict, and for each fact that counts where it was found."""

    target: str
    verdict: Verdict
    found: tuple[tuple[Fact, tuple[Found, ...]], ...]


def opinion(context: Context, target: str, least: Verdict = Verdict.ALTERS) -> Opinion:
    """Return the opinion of a program, its facts with the worst verdict first. From stage TREE on.

    Args:
        least: facts of better verdicts do not count.
    """
    asked = (fact for fact in FACTS if fact.target == target and fact.verdict >= least)
    found = [(fact, tuple(fact.find(context))) for fact in asked]
    counted = sorted((one for one in found if one[1]), key=lambda one: -one[0].verdict)
    return Opinion(target, counted[0][0].verdict if counted else Verdict.LOADS, tuple(counted))
