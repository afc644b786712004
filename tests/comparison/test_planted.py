"""Differences planted in published robots are named at the link or joint, with their cause; the unplanted are equal."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from math import atan2, degrees, hypot
from pathlib import Path
from random import Random

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.sampled import sampled

import robodyn
from robodyn.comparison.compare import compare
from robodyn.programs.vectors import rotation_about, rotation_from_rpy

KEYS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
Edit = Callable[[ET.Element, ET.Element], bool]
"""Change a link's inertial, or a joint; False where this one is not fit for it."""


def numbers(element: ET.Element | None, key: str, default: str = "0 0 0") -> np.ndarray:
    return np.array((default if element is None else element.get(key, default)).split(), float)


def matrix(inertial: ET.Element) -> np.ndarray:
    tensor = inertial.find("inertia")
    assert tensor is not None
    xx, xy, xz, yy, yz, zz = (float(tensor.get(key, 0)) for key in KEYS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def write(inertial: ET.Element, I: np.ndarray) -> None:
    tensor = inertial.find("inertia")
    assert tensor is not None
    for key, value in zip(KEYS, I[np.triu_indices(3)], strict=True):
        tensor.set(key, repr(float(value)))


def origin(element: ET.Element) -> ET.Element:
    found = element.find("origin")
    return ET.SubElement(element, "origin") if found is None else found


def turned(element: ET.Element) -> np.ndarray:
    return np.asarray(rotation_from_rpy(*numbers(element.find("origin"), "rpy")), dtype=float)


def rpy(R: np.ndarray) -> str:
    angles = atan2(R[2, 1], R[2, 2]), atan2(-R[2, 0], hypot(R[0, 0], R[1, 0])), atan2(R[1, 0], R[0, 0])
    return " ".join(map(repr, angles))


def distinct(I: np.ndarray) -> bool:
    return bool(np.ptp(np.linalg.eigvalsh(I)) > 0.05 * np.abs(I).max())


def mass(inertial: ET.Element, _: ET.Element) -> bool:
    element = inertial.find("mass")
    assert element is not None
    element.set("value", repr(1.3 * float(element.get("value", 0))))
    return True


def rotation_lost(inertial: ET.Element, _: ET.Element) -> bool:
    R, I = turned(inertial), matrix(inertial)
    if np.abs(R @ I @ R.T - I).max() <= 0.02 * np.abs(I).max():
        return False
    origin(inertial).set("rpy", "0 0 0")
    return True


def about_origin(inertial: ET.Element, _: ET.Element) -> bool:
    c, I, R = numbers(inertial.find("origin"), "xyz"), matrix(inertial), turned(inertial)
    m = float(inertial.find("mass").get("value"))  # type: ignore[union-attr, arg-type]
    steiner = m * (c @ c * np.eye(3) - np.outer(c, c))
    write(inertial, I + R.T @ steiner @ R)
    return bool(np.abs(steiner).max() > 0.02 * np.abs(I).max())


def products_dropped(inertial: ET.Element, _: ET.Element) -> bool:
    I = matrix(inertial)
    write(inertial, np.diag(np.diagonal(I)))
    return bool(np.abs(I - np.diag(np.diagonal(I))).max() > 0.02 * np.abs(I).max())


def products_sign(inertial: ET.Element, _: ET.Element) -> bool:
    I = matrix(inertial)
    write(inertial, 2 * np.diag(np.diagonal(I)) - I)
    return bool(np.abs(I - np.diag(np.diagonal(I))).max() > 0.02 * np.abs(I).max())


def axes_permuted(inertial: ET.Element, _: ET.Element) -> bool:
    I = matrix(inertial)
    order = [1, 2, 0]
    write(inertial, I[np.ix_(order, order)])
    return distinct(I) and bool(np.abs(I[np.ix_(order, order)] - I).max() > 0.02 * np.abs(I).max())


def tensor_unit(inertial: ET.Element, _: ET.Element) -> bool:
    write(inertial, 1e6 * matrix(inertial))
    return True


def centre_sign(inertial: ET.Element, _: ET.Element) -> bool:
    c = numbers(inertial.find("origin"), "xyz")
    k = int(np.argmax(np.abs(c)))
    if abs(c[k]) < 5e-3:
        return False
    c[k] = -c[k]
    origin(inertial).set("xyz", " ".join(map(repr, c.tolist())))
    return True


def centre_unit(inertial: ET.Element, _: ET.Element) -> bool:
    c = numbers(inertial.find("origin"), "xyz")
    origin(inertial).set("xyz", " ".join(map(repr, (1e3 * c).tolist())))
    return bool(np.abs(c).max() > 1e-3)


def inertial_lost(inertial: ET.Element, link: ET.Element) -> bool:
    link.remove(inertial)
    return True


def axis_sign(joint: ET.Element, _: ET.Element) -> bool:
    axis = joint.find("axis")
    if axis is None:
        return False
    axis.set("xyz", " ".join(map(repr, (-numbers(axis, "xyz", "1 0 0")).tolist())))
    return True


def zero(joint: ET.Element, _: ET.Element) -> bool:
    if joint.get("type") == "prismatic":
        return False
    axis = numbers(joint.find("axis"), "xyz", "1 0 0")
    R = turned(joint) @ np.asarray(rotation_about(axis / np.linalg.norm(axis), 0.3), dtype=float)
    origin(joint).set("rpy", rpy(R))
    return True


def placement(joint: ET.Element, _: ET.Element) -> bool:
    p = numbers(joint.find("origin"), "xyz")
    origin(joint).set("xyz", " ".join(map(repr, (p + np.array([0.0, 0.03, 0.02])).tolist())))
    return True


def axis_letter(joint: ET.Element, _: ET.Element) -> bool:
    axis = joint.find("axis")
    if axis is None:
        return False
    axis.set("xyz", " ".join(map(repr, np.roll(numbers(axis, "xyz", "1 0 0"), 1).tolist())))
    return True


def degrees_limit(joint: ET.Element, _: ET.Element) -> bool:
    limit = joint.find("limit")
    if limit is None or joint.get("type") != "revolute" or not float(limit.get("upper", 0)):
        return False
    for key in ("lower", "upper"):
        limit.set(key, repr(degrees(float(limit.get(key, 0)))))
    return True


def damping(joint: ET.Element, _: ET.Element) -> bool:
    dynamics = joint.find("dynamics")
    dynamics = ET.SubElement(joint, "dynamics") if dynamics is None else dynamics
    dynamics.set("damping", repr(float(dynamics.get("damping", 0)) + 0.7))
    return True


LINKS: dict[str, tuple[Edit, str, str]] = {
    "mass": (mass, "mass", "1.3 times"),
    "rotation of the inertial lost": (rotation_lost, "inertia", "rotation of the inertial"),
    "tensor about the origin": (about_origin, "inertia", "about the link's origin|subtracted"),
    "products dropped": (products_dropped, "inertia", "dropped"),
    "products with the other sign": (products_sign, "inertia", "wrong sign"),
    "axes permuted": (axes_permuted, "inertia", "permuted"),
    "tensor in another unit": (tensor_unit, "inertia", "unit"),
    "centre on the other side": (centre_sign, "centre", "sign|origin"),
    "centre in mm": (centre_unit, "centre", "unit"),
    "inertial lost": (inertial_lost, "mass", "not in B|no mass"),
}
JOINTS: dict[str, tuple[Edit, str, str]] = {
    "axis turned round": (axis_sign, "sign", "other way"),
    "zero elsewhere": (zero, "zero", ""),
    "placed elsewhere": (placement, "placement|mounting", "apart|offset|unit"),
    "axis of another letter": (axis_letter, "axis", "apart"),
    "limits in degrees": (degrees_limit, "limit", "degrees"),
    "damping": (damping, "damping", ""),
}
KINDS = {**LINKS, **JOINTS}
ROBOTS = [path_of(stem) for stem in ("ur5_robot", "panda", "anymal", "talos_reduced", "g1_29dof_rev_1_0", "kinova")]


def moving(root: ET.Element) -> list[ET.Element]:
    return [one for one in root.iterfind("joint") if one.get("type") in ("revolute", "continuous", "prismatic")]


def planted(path: Path, kind: str) -> Iterator[tuple[bytes, str]]:
    """Yield the text with the difference at one link or joint, drawn by chance, and its name."""
    edit = KINDS[kind][0]
    text = path.read_bytes()
    root = ET.fromstring(text)
    children = {one.find("child").get("link") for one in moving(root)}  # type: ignore[union-attr]
    names = [one.get("name", "") for one in moving(root) if one.find("mimic") is None]
    if kind in LINKS:
        names = [link.get("name", "") for link in root.iterfind("link[inertial]") if link.get("name") in children]
    Random(f"{path.stem} {kind}").shuffle(names)
    for name in names:
        root = ET.fromstring(text)
        element = root.find(f"{'link' if kind in LINKS else 'joint'}[@name='{name}']")
        assert element is not None
        inertial = element.find("inertial")
        if kind in JOINTS:
            fit = edit(element, element)
        elif inertial is None or float(inertial.find("mass").get("value")) <= 0:  # type: ignore[union-attr, arg-type]
            fit = False
        else:
            fit = edit(inertial, element)
        if fit:
            yield ET.tostring(root), name
            return


CASES = [pytest.param(path, kind, id=f"{path.stem}-{kind}") for kind in KINDS for path in ROBOTS]


@pytest.mark.parametrize(("path", "kind"), sampled(CASES, 14))
def test_planted(path: Path, kind: str) -> None:
    for text, name in planted(path, kind):
        found = compare(robodyn.load(path), robodyn.load(text))
        _, kinds, cause = KINDS[kind]
        right = [
            one
            for one in found.differences
            if one.name == name and one.kind in kinds.split("|") and any(word in one.cause for word in cause.split("|"))
        ]
        assert right, [one.words for one in found.differences]
        assert not found.equal


@pytest.mark.parametrize("path", sampled([pytest.param(path, id=path.stem) for path in ROBOTS], 6))
def test_equal_to_itself(path: Path) -> None:
    found = compare(robodyn.load(path), robodyn.load(path.read_bytes()))
    assert found.equal
    assert not found.differences
    assert not found.torques or not found.notes
