"""Recompute from the descriptions alone what an audit condemns: `python witness.py audit.json`, without robodyn."""

import json
import sys
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import numpy as np


@cache
def files_in(folder):
    return [str(path) for path in Path(folder).rglob("*")]


def numbers(element, key, default):
    return np.array((default if element is None else element.get(key, default)).split(), float)


def placed(element):
    import trimesh

    pose = trimesh.transformations.euler_matrix(*numbers(element.find("origin"), "rpy", "0 0 0"))
    pose[:3, 3] = numbers(element.find("origin"), "xyz", "0 0 0")
    return pose


def rigid_group(robot, name):
    """Return the links that fixed joints join with one, and where they are in its axes."""
    poses, todo = {name: np.eye(4)}, [name]
    for here in todo:
        for joint in robot.iterfind("joint[@type='fixed']"):
            parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
            for at, there, step in ((parent, child, placed(joint)), (child, parent, np.linalg.inv(placed(joint)))):
                if at == here and there not in poses:
                    poses[there] = poses[here] @ step
                    todo.append(there)
    return poses


def points(shape, files):
    """Return corners of a shape, of a mesh all, in the axes of its link."""
    import trimesh

    solid = shape.find("geometry")[0]
    if solid.tag == "mesh":
        tail = solid.get("filename").split("://")[-1].split("../")[-1].split("/")
        file = next(file for k in range(len(tail)) for file in files if file.endswith("/" + "/".join(tail[k:])))
        corners = trimesh.load(file, force="mesh").vertices * numbers(solid, "scale", "1 1 1")
    else:
        r = numbers(solid, "radius", "0")[0]
        half = numbers(solid, "size", f"{2 * r} {2 * r} {solid.get('length', 2 * r)}") / 2
        corners = trimesh.bounds.corners([-half, half])
    return trimesh.transform_points(corners, placed(shape))


LEAST, MOST = {"RD301": 4.0, "RD302": 1.0}, {"RD204": 2e-6, "RD206": 1e-9, "RD207": 1 - 1e-6}
"""From which and up to which number a rule's witness condemns; of the other rules 0."""


def condemns(error, number):
    code = error["rule"]
    return number > LEAST[code] if code in LEAST else number <= MOST.get(code, 0.0)


def witness(error):
    """Return what the rule judges: a mass, a share of the largest moment, a ratio, a distance, a count of namesakes."""
    import trimesh

    code, name, robot = error["rule"], error["name"], ET.parse(error["file"]).getroot()
    files = files_in(error["folder"])
    if code == "RD601":
        package, _, rest = error["names"].rpartition("://")
        ways = [rest] if not package else [rest, rest.partition("/")[2]] * (rest[0] != "/")
        return sum((up / way).exists() for up in Path(error["file"]).parents for way in ways)
    if code in ("RD510", "RD701"):
        return sum(part.tag in error["kind"] and part.get("name") == error["names"] for part in robot)
    links = {link.get("name"): link for link in robot.iterfind("link")}
    if code in ("RD201", "RD202"):
        group = rigid_group(robot, name) if code == "RD202" else [name]
        return sum(numbers(links[each].find("inertial/mass"), "value", "0")[0] for each in group)
    inertial, tensor = links[name].find("inertial"), links[name].find("inertial/inertia")
    xx, xy, xz, yy, yz, zz = (numbers(tensor, key, "0")[0] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    low, middle, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass = numbers(inertial.find("mass"), "value", "0")[0]
    if code in ("RD204", "RD206", "RD207"):
        gyration = (max(high, 0) / mass) ** 0.5 if mass else 0.0
        return {"RD204": gyration, "RD206": low / (high or 1), "RD207": (low + middle) / (high or 1)}[code]
    group = rigid_group(robot, name)
    shapes = [(shape, pose) for link, pose in group.items() for shape in links[link].iterfind("*[geometry]")]
    cloud = np.concatenate([trimesh.transform_points(points(shape, files), pose) for shape, pose in shapes])
    centre, low, high = placed(inertial)[:3, 3], cloud.min(axis=0), cloud.max(axis=0)
    if code == "RD302":
        return np.linalg.norm(np.clip(centre, low, high) - centre) / np.linalg.norm(high - low)
    return (xx + yy + zz) / 2 / mass / np.linalg.norm(cloud - centre, axis=1).max() ** 2


if __name__ == "__main__":
    for error in json.loads(Path(sys.argv[1]).read_text()):
        number = witness(error)
        verdict = "is" if condemns(error, number) else "is NOT"
        print(f"{error['rule']} {error['name']}: {number:.3g} {verdict} an error ({error['robot']}: {error['says']})")
