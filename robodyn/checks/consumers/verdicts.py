"""What other programs make of a description, from what they document and from running them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from operator import eq, gt

from robodyn.checks.consumers import facts
from robodyn.checks.consumers.facts import Find, Found, joints, missing_meshes, ranges, root, unread_meshes
from robodyn.checks.context import Context


class Verdict(IntEnum):
    """From good to bad."""

    LOADS = 0
    ALTERS = 1
    REJECTS = 2


@dataclass(frozen=True, slots=True)
class Fact:
    """One thing that a program does: to what (`find`), what (`does`), and how that is known (`source`)."""

    target: str
    verdict: Verdict
    does: str
    source: str
    find: Find


_MUJOCO = "MuJoCo 4.0, run; its XML reference, compiler"
_DRAKE = "Drake 1.51, run"
_SDFORMAT = "sdformat issues 199 and 1007, pull request 1238"
_GZ = "gz-common 6, MeshManager"
_KDL = "kdl_parser.cpp"
_ISAAC = "Isaac Sim 5, URDF importer and its ImportConfig"
_REJECTS, _ALTERS = Verdict.REJECTS, Verdict.ALTERS
_NO_AXIS = joints(lambda joint: joint.moves and joint.axis.values == (0, 0, 0))
_MIMIC = joints(lambda joint: joint.mimic)
_FIXED = joints(lambda joint: joint.type == "fixed")
_FLOATING = joints(lambda joint: joint.type == "floating")
_DRIVEN = joints(lambda joint: (joint.damping.value or 0.0) < 0)
_HEAVY_ROOT = root(lambda link: link.mass)
_FREE_ROOT = root(lambda link: link.name != "world")

FACTS = (
    Fact("mujoco", _REJECTS, "wants mass and inertia in what moves", _MUJOCO, facts.massless),
    Fact("mujoco", _REJECTS, "wants principal moments that a body can have", _MUJOCO, facts.unphysical),
    Fact("mujoco", _REJECTS, "wants <mass> and <inertia> in <inertial>", _MUJOCO, facts.no_tensor),
    Fact("mujoco", _REJECTS, "wants an axis that is not zero", _MUJOCO, _NO_AXIS),
    Fact("mujoco", _REJECTS, "reads meshes in .stl, .obj and .msh only", _MUJOCO, unread_meshes("mujoco")),
    Fact("mujoco", _REJECTS, "wants meshes to be there", _MUJOCO, missing_meshes("mujoco", "collision")),
    Fact(
        "mujoco",
        _REJECTS,
        'opens no URI without <mujoco><compiler strippath="true" meshdir="..."/>',
        _MUJOCO,
        facts.uris,
    ),
    Fact("mujoco", _ALTERS, "leaves out what is only <visual>", _MUJOCO, facts.visuals),
    Fact("mujoco", _ALTERS, "makes the root a part of the world, without its mass", _MUJOCO, _HEAVY_ROOT),
    Fact("mujoco", _ALTERS, "ignores equal limits", _MUJOCO, ranges(eq)),
    Fact("mujoco", _ALTERS, "makes mimic a soft equality constraint", _MUJOCO, _MIMIC),
    Fact("drake", _REJECTS, "wants lower <= upper", _DRAKE, ranges(gt)),
    Fact("drake", _REJECTS, "wants an axis that is not zero", _DRAKE, _NO_AXIS),
    Fact("drake", _REJECTS, "wants damping that is not negative", _DRAKE, _DRIVEN),
    Fact("drake", _REJECTS, "wants mimic and leader with equal degrees of freedom", _DRAKE, facts.mimic_leader),
    Fact("drake", _REJECTS, "collides with meshes in .obj, .vtk and .gltf only", _DRAKE, unread_meshes("drake")),
    Fact("drake", _REJECTS, "wants meshes to be there", _DRAKE, missing_meshes("drake", "visual", "collision")),
    Fact("drake", _REJECTS, "wants a name of the robot", _DRAKE, facts.nameless),
    Fact("drake", _ALTERS, "ignores joint friction", _DRAKE, facts.friction),
    Fact("drake", _ALTERS, "lets the root float unless it is called world", _DRAKE, _FREE_ROOT),
    Fact("drake", _ALTERS, "leaves the child of a floating joint free of its parent", _DRAKE, _FLOATING),
    Fact("gz", _ALTERS, "drops links without mass that a joint moves, and all below", _SDFORMAT, facts.no_mass),
    Fact("gz", _ALTERS, "leaves out meshes in formats that it does not read", _GZ, unread_meshes("gz")),
    Fact("gz", _ALTERS, "merges links on fixed joints", _SDFORMAT, _FIXED),
    Fact("kdl", _ALTERS, "ignores the mass of the root", _KDL, _HEAVY_ROOT),
    Fact("kdl", _ALTERS, "makes the joint fixed", _KDL, joints(lambda joint: joint.type in ("floating", "planar"))),
    Fact("kdl", _ALTERS, "moves mimic joints on their own", _KDL, _MIMIC),
    Fact("isaac", _ALTERS, "replaces characters in names by _", _ISAAC, facts.odd_names),
    Fact("isaac", _ALTERS, "merges links on fixed joints", _ISAAC, _FIXED),
    Fact("isaac", _ALTERS, "makes up a mass for links without one", _ISAAC, facts.no_mass),
)


@dataclass(frozen=True, slots=True)
class Opinion:
    """What one program makes of a file: the verdict, and for each fact that counts where it was found."""

    target: str
    verdict: Verdict
    found: tuple[tuple[Fact, tuple[Found, ...]], ...]


def opinion(context: Context, target: str) -> Opinion:
    """Return the opinion of a program, its facts with the worst verdict first. From stage TREE on."""
    found = [(fact, tuple(fact.find(context))) for fact in FACTS if fact.target == target]
    counted = sorted((one for one in found if one[1]), key=lambda one: -one[0].verdict)
    return Opinion(target, counted[0][0].verdict if counted else Verdict.LOADS, tuple(counted))
