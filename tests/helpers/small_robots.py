"""Small descriptions for tests, written as URDF text: links, joints, chains and random trees."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from robodyn.robot.load import load


def numbers(values):
    return " ".join(repr(float(x)) for x in values)


def link(name, m=None, com=(0, 0, 0), inertia=(0, 0, 0, 0, 0, 0), rpy=(0, 0, 0)):
    """A link; `inertia` is ixx, ixy, ixz, iyy, iyz, izz about the centre of mass."""
    if m is None:
        return f'<link name="{name}"/>'
    entries = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), inertia, strict=True)
    moments = " ".join(f'{key}="{float(value)!r}"' for key, value in entries)
    return (
        f'<link name="{name}"><inertial><origin xyz="{numbers(com)}" rpy="{numbers(rpy)}"/>'
        f'<mass value="{float(m)!r}"/><inertia {moments}/></inertial></link>'
    )


def joint(name, parent, child, kind="revolute", axis=(0, 0, 1), xyz=(0, 0, 0), rpy=(0, 0, 0), more=""):
    limit = '<limit lower="-9" upper="9" effort="1000" velocity="100"/>' if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/><axis xyz="{numbers(axis)}"/>{limit}{more}</joint>'
    )


def urdf(*parts, name="small"):
    return f'<?xml version="1.0"?>\n<robot name="{name}">\n{chr(10).join(parts)}\n</robot>\n'.encode()


@lru_cache(maxsize=32)
def built(*parts, moving_base=False):
    """The robot of these links and joints; the same one for the same parts, so that its programs are traced once."""
    return load(urdf(*parts), moving_base=moving_base)


def body_numbers(rng):
    """Mass, centre of mass, and a full inertia that a cloud of points could have."""
    spread = rng.normal(size=(3, 3))
    second = spread @ spread.T * 0.05
    I = np.trace(second) * np.eye(3) - second
    return rng.uniform(0.5, 3), rng.uniform(-0.4, 0.4, 3), I[np.triu_indices(3)]


def random_tree_parts(rng, n, kinds=("revolute", "prismatic", "continuous", "fixed"), branching=2):
    """Links and joints of a tree that excites every term: skew axes and frames, full inertias, a heavy base."""
    parts = [link("l0", *body_numbers(rng))]
    for i in range(1, n + 1):
        parent = max(0, i - int(rng.integers(1, branching + 1)))
        kind = kinds[int(rng.integers(len(kinds)))]
        axis = rng.normal(size=3)
        placed = {"xyz": rng.uniform(-0.6, 0.6, 3), "rpy": rng.uniform(-3, 3, 3)}
        parts.append(link(f"l{i}", *body_numbers(rng), rng.uniform(-3, 3, 3)))
        parts.append(joint(f"j{i}", f"l{parent}", f"l{i}", kind, axis / np.linalg.norm(axis), **placed))
    return parts


def random_tree(seed, n=8, moving_base=False, **kinds):
    return built(*random_tree_parts(np.random.default_rng(seed), n, **kinds), moving_base=moving_base)


def chain_parts(n, skew=False, mass=1.0, taper=1.0):
    """n equal links of length 1 with the centre of mass in the middle; with `skew` every joint turns by 90 degrees."""
    parts = [link("l0")]
    for i in range(1, n + 1):
        m = mass * taper ** (i - 1)
        parts.append(link(f"l{i}", m, (0.5, 0, 0), (m / 400, 0, 0, m * 1.015 / 12, 0, m * 1.015 / 12)))
        turn = (np.pi / 2 if skew else 0.0, 0, 0)
        parts.append(joint(f"j{i}", f"l{i - 1}", f"l{i}", "continuous", (0, 0, 1), (1.0 if i > 1 else 0.0, 0, 0), turn))
    return parts


def chain(n, skew=False, **more):
    return built(*chain_parts(n, skew, **more))
