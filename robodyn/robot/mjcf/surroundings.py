"""What MJCF says beyond bodies and joints: equality constraints, actuators, springs, fluid; and what cannot be said."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, NamedTuple

import numpy as np

from robodyn.programs.vectors import product, rotation_from_quaternion, rpy_from_rotation, snapped
from robodyn.robot.urdf.parts import Mimic
from robodyn.support.floats import Floats
from robodyn.support.wording import count, listed, shown

_EARTH = [0.0, 0.0, -9.81]
"""The gravity of a scene that says nothing, in m/s^2."""


class Names(NamedTuple):
    """Of each body its link and where the link's origin is in the body's frame [m]; of each joint its name; and whether
    the world is the ground of a base that moves, not a link."""

    links: list[str]
    origins: list[Floats]
    joints: list[str]
    moving: bool


def actuated(found: dict[str, Any]) -> tuple[dict[int, float], dict[int, float], dict[int, float]]:
    """Return by joint the effort limit |gear| max |force| of all its actuators together, where each is bounded, within
    the joint's own bound; and what armature and damping of actuators add, gear^2 times theirs."""
    kinds, force, armature, damping = found["kinds"], dict[int, float](), dict[int, float](), dict[int, float]()
    for a, (kind, ends) in enumerate(zip(found["actuator_trntype"], found["actuator_trnid"], strict=True)):
        if kind not in (kinds["trn_joint"], kinds["trn_jointinparent"]):
            continue
        gear = found["actuator_gear"][found.get("actuator_outadr", range(a + 1))[a]][0]
        joint = ends[0]
        force[joint] = force.get(joint, 0.0) + (abs(gear) * _most(found, a) if gear else 0.0)
        for key, added in (("actuator_armature", armature), ("actuator_damping", damping)):
            added[joint] = added.get(joint, 0.0) + gear * gear * (found[key][a] if key in found else 0.0)
    for joint, limited in enumerate(found["jnt_actfrclimited"]):
        if limited:
            force[joint] = min(force.get(joint, inf), max(map(abs, found["jnt_actfrcrange"][joint])))
    return {joint: most for joint, most in force.items() if most < inf}, armature, damping


def _most(found: dict[str, Any], a: int) -> float:
    """Return the largest force of an actuator, by the range of its force, or of a control that is the force; or inf."""
    bounds = [max(map(abs, found["actuator_forcerange"][a]))] if found["actuator_forcelimited"][a] else []
    control = found.get("actuator_ctrladr", range(a + 1))[a]
    direct = found["actuator_gaintype"][a] == found["kinds"]["gain_fixed"] and not found["actuator_biastype"][a]
    direct = direct and found["actuator_dyntype"][a] in found["filters"]
    if direct and control >= 0 and found["actuator_ctrllimited"][control]:
        bounds.append(abs(found["actuator_gainprm"][a][0]) * max(map(abs, found["actuator_ctrlrange"][control])))
    return min(bounds, default=inf)


def _equalities(found: dict[str, Any], *kinds: str) -> list[tuple[int, str]]:
    """Return numbers and kinds of the constraints that hold at the start."""
    named = {found["kinds"][kind]: kind for kind in kinds}
    held = zip(found["eq_type"], found["eq_active0"], strict=True)
    return [(e, named[kind]) for e, (kind, active) in enumerate(held) if active and kind in named]


def mimics_of(found: dict[str, Any], names: Names) -> tuple[dict[str, Mimic], list[str]]:
    """Return as mimic rules the constraints `q = q0 + a + b (leader - leader0)` between two joints by the follower, and
    those that are none, in words."""
    mimics, lost = dict[str, Mimic](), list[str]()
    for e, _ in _equalities(found, "eq_joint"):
        follower, leader = found["eq_obj1id"][e], found["eq_obj2id"][e]
        a, b, *rest = found["eq_data"][e][:5]
        name, why = names.joints[follower], ""
        if leader < 0:
            why = "holds it where it is"
        elif any(rest):
            why = "is not a straight line"
        elif name in mimics:
            why = "is a second one"
        elif _leads_to(names.joints[leader], name, mimics):
            why = "closes a circle"
        if why:
            lost.append(f"the constraint of joint {shown(name)}, which {why}")
            continue
        at, there = (found["qpos0"][found["jnt_qposadr"][joint]] for joint in (follower, leader))
        mimics[name] = Mimic(names.joints[leader], b, at + a - b * there)
    return {} if "equality" in found["off"] else mimics, lost


def _leads_to(joint: str, name: str, mimics: dict[str, Mimic]) -> bool:
    while joint != name and joint in mimics:
        joint = mimics[joint].joint
    return joint == name


def loops_of(found: dict[str, Any], names: Names) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the constraints that connect or weld bodies as loops of a scene, and those of bodies that never move
    against each other, in words."""
    loops, lost, taken = list[dict[str, Any]](), list[str](), set[str]()
    for e, kind in [] if "equality" in found["off"] else _equalities(found, "eq_connect", "eq_weld"):
        given, data = found["names"]["equality"][e], found["eq_data"][e]
        ends, turns = [found["eq_obj1id"][e], found["eq_obj2id"][e]], [np.eye(3), np.eye(3)]
        if found["eq_objtype"][e] == found["kinds"]["obj_site"]:
            sites, ends = ends, [found["site_bodyid"][site] for site in ends]
            points = [found["site_pos"][site] for site in sites]
            turns = [rotation_of(found["site_quat"][site]) for site in sites]
        elif kind == "eq_connect":
            points = [data[0:3], data[3:6]]
        else:  # a point of the second body is held at one of the first, turned by a quaternion in its axes
            points, turns[0] = [data[3:6], data[0:3]], rotation_of(data[6:10])
        where = [_moved(point, names.origins[end]) for point, end in zip(points, ends, strict=True)]
        if found["body_weldid"][ends[0]] == found["body_weldid"][ends[1]]:
            lost.append(f"the constraint of {listed([names.links[end] for end in ends])}, which never part")
            continue
        to, link = (1, 0) if ends[1] == 0 else (0, 1)
        usual = f"{kind[3:]} {names.links[ends[link]]} {names.links[ends[to]]}"
        name, k = given or usual, 1
        while name in taken:
            k += 1
            name = f"{given or usual} {k}"
        taken.add(name)
        loop = {
            "name": name,
            "link": names.links[ends[link]],
            "point": where[link],
            "to": "ground" if ends[to] == 0 and names.moving else names.links[ends[to]],
            "to_point": where[to],
            "kind": "point",
        }
        if kind == "eq_weld" and data[10]:  # else it only connects
            turn = product(turns[0], turns[1].T)
            loop |= {"kind": "weld", "rpy": list(rpy_from_rotation(turn if link == 1 else turn.T))}
        loops.append(loop)
    return loops, lost


def told(found: dict[str, Any], names: Names, mimics: Mapping[str, Mimic]) -> dict[str, Any]:
    """Return gravity, springs, fluid and where a simulation begins as the tables of a scene; empty where they are those
    of any scene.

    A link in a fluid has MuJoCo's drag on the box of its inertia, `rho/2 b_j b_k |v_i| v_i` at its centre of mass,
    where the axes of that box are those of the link.
    """
    scene: dict[str, Any] = {}
    option = found["option"]
    gravity = [0.0, 0.0, 0.0] if "gravity" in found["off"] else option["gravity"]
    if gravity != _EARTH:
        scene["gravity"] = gravity
    single = (found["kinds"]["jnt_hinge"], found["kinds"]["jnt_slide"])
    start: dict[str, float] = {}
    for j, (kind, at) in enumerate(zip(found["jnt_type"], found["jnt_qposadr"], strict=True)):
        name = names.joints[j]
        if kind == found["kinds"]["jnt_free"]:
            values = dict(zip(("x", "y", "z", "qw", "qx", "qy", "qz"), found["qpos0"][at : at + 7], strict=True))
            start |= {f"{'base' if names.moving else name}_{key}": value for key, value in values.items()}
        elif kind in single and name not in mimics:
            start[name] = found["qpos0"][at]
    if any(value for name, value in start.items() if not name.endswith("_qw")):
        scene["initial"] = {"q": {name: value for name, value in start.items() if value}}
    springs = {
        names.joints[j]: {"stiffness": stiffness, "rest": found["qpos_spring"][found["jnt_qposadr"][j]]}
        for j, stiffness in enumerate(found["jnt_stiffness"])
        if stiffness and found["jnt_type"][j] in single
    }
    if springs and "spring" not in found["off"]:
        scene["spring"] = springs
    if option["density"]:
        links, of_body = [], geoms_of(found)
        for body in range(1, len(names.links)):
            box, R = _box(found, body, of_body[body]), rotation_of(found["body_iquat"][body])
            if box is not None and ((np.abs(R) == 1.0) | (R == 0.0)).all():
                area = np.abs(R) @ np.array([box[1] * box[2], box[2] * box[0], box[0] * box[1]])
                centre = _moved(found["body_ipos"][body], names.origins[body])
                links.append({"link": names.links[body], "centre": centre, "drag_area": area.tolist()})
        scene["fluid"] = {"density": option["density"], "velocity": option["wind"], "link": links}
    return scene


def _box(found: dict[str, Any], body: int, geoms: list[int]) -> Floats | None:
    """Return the edges of the box of a body's mass and moments [m]; None where it has none, or shapes of its own."""
    if found["body_mass"][body] < 1e-15 or any(found["geom_fluid"][g][0] for g in geoms):
        return None
    x, y, z = found["body_inertia"][body]
    squares = np.array([y + z - x, z + x - y, x + y - z]) * 6.0 / found["body_mass"][body]
    edges: Floats = np.sqrt(np.maximum(squares, 1e-15))
    return edges


def geoms_of(found: dict[str, Any]) -> list[list[int]]:
    """Return the numbers of the geoms of each body."""
    out: list[list[int]] = [[] for _ in found["body_mass"]]
    for g, body in enumerate(found["geom_bodyid"]):
        out[body].append(g)
    return out


def rotation_of(quat: list[float]) -> Floats:
    """Return the rotation of one of MuJoCo's quaternions, whose w comes first."""
    w, x, y, z = quat
    R: Floats = snapped(rotation_from_quaternion(x, y, z, w))
    return R


def _moved(point: list[float], origin: Floats) -> list[float]:
    moved: list[float] = (np.array(point) - origin + 0.0).tolist()
    return moved


def lost_of(found: dict[str, Any]) -> list[str]:
    """Return what has no counterpart in a description or a scene, in words."""
    kinds, lost = found["kinds"], list[str]()
    touching = sum(bool(a or b) for a, b in zip(found["geom_contype"], found["geom_conaffinity"], strict=True))
    if (touching > 1 or found.get("npair")) and "contact" not in found["off"]:
        lost.append("contacts")
    joints = (kinds["trn_joint"], kinds["trn_jointinparent"])
    muscles = sum(kind == kinds["gain_muscle"] for kind in found["actuator_gaintype"])
    others = sum(kind not in joints for kind in found["actuator_trntype"])
    single = (kinds["jnt_hinge"], kinds["jnt_slide"])
    round_ = [j for j, kind in enumerate(found["jnt_type"]) if kind not in single]
    equalities = [kinds[kind] for kind in ("eq_connect", "eq_weld", "eq_joint")]
    for number, noun in (
        (found["ntendon"], "tendon"),
        (muscles, "muscle"),
        (others, "actuator of no single joint"),
        (sum(map(bool, found["body_gravcomp"])), "gravcomp of bodies"),
        (found["nflex"], "flex of soft bodies"),
        (found["nplugin"], "plugin"),
        (found["nmocap"], "frame of mocap"),
        (sum(kind not in equalities for kind in found["eq_type"]), "constraint of other kinds"),
        (found["eq_active0"].count(False), "inactive constraint"),
        (sum(bool(found["jnt_stiffness"][j]) for j in round_), "spring of ball or free joints"),
        (sum(found["jnt_limited"][j] for j in round_), "range of ball joints"),
        (sum(map(any, found.get("jnt_stiffnesspoly", []))), "spring of higher powers"),
        (sum(map(any, found.get("dof_dampingpoly", []))), "damping of higher powers"),
    ):
        if number:
            first, _, rest = noun.partition(" of ")
            lost.append(count(number, first) + (rest and f" of {rest}"))
    if found["option"]["viscosity"]:
        lost.append(f"the viscosity {found['option']['viscosity']:g}")
    if found["option"]["density"]:
        lost.append("drag of the fluid on what turns, and on links whose inertia is not along their axes")
    return lost
