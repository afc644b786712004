"""Closed chains for tests: the IFToMM benchmark's four-bars, and loops in space."""

from __future__ import annotations

import numpy as np

from helpers.small_robots import body_numbers, built, joint, link
from robodyn.scene.scene import Loop, Scene

ROD = (1.0, (0.5, 0, 0), (0, 0, 0, 1 / 12, 0, 1 / 12))
"""A thin rod of 1 kg and 1 m along x."""


def four_bars(count, **more):
    """IFToMM's benchmark A02: `count` four-bars side by side, upright, B0 moving to +x at 1 m/s.

    Cranks k0 .. kN stand on the ground 1 m apart; each coupler hangs on the crank before it and is tied to the next.
    Angles count from +x to +z.
    """
    parts = [link("frame")]
    turn = (0, -1, 0)
    for k in range(count + 1):
        parts += [link(f"crank{k}", *ROD), joint(f"k{k}", "frame", f"crank{k}", "continuous", turn, (k, 0, 0))]
    for k in range(count):
        parts += [link(f"coupler{k}", *ROD), joint(f"c{k}", f"crank{k}", f"coupler{k}", "continuous", turn, (1, 0, 0))]
    loops = tuple(Loop(f"B{k + 1}", f"coupler{k}", (1, 0, 0), f"crank{k + 1}", (1, 0, 0)) for k in range(count))
    q = {f"k{k}": np.pi / 2 for k in range(count + 1)} | {f"c{k}": -np.pi / 2 for k in range(count)}
    scene = Scene(loops=loops, initial_q=q, initial_qd={"k0": -1.0}, **more)
    return built(*parts), scene


def parallelogram(crank=0.5, bar=1.0, **more):
    """Two cranks that stand `bar` apart and a bar between their ends, lying flat along x at rest."""
    turn = (0, -1, 0)

    def rod(name, length):
        return link(name, 1.0, (length / 2, 0, 0), (0, 0, 0, length**2 / 12, 0, length**2 / 12))

    parts = [link("frame"), rod("left", crank), rod("right", crank), rod("bar", bar)]
    for name, before, after, x in (
        ("a", "frame", "left", 0),
        ("b", "frame", "right", bar),
        ("c", "left", "bar", crank),
    ):
        parts.append(joint(name, before, after, "continuous", turn, (x, 0, 0)))
    loop = Loop("pin", "bar", (bar, 0, 0), "right", (crank, 0, 0))
    return built(*parts), Scene(loops=(loop,), initial_q=dict.fromkeys("abc", 0.0), **more)


def branch(rng, name, length):
    """Bodies of full inertias on skew hinges, and a slide, one after another on l0."""
    parts = []
    for k in range(length):
        axis, before = rng.normal(size=3), f"{name}{k - 1}" if k else "l0"
        placed = {"xyz": rng.uniform(-0.6, 0.6, 3), "rpy": rng.uniform(-3, 3, 3)}
        kind = "prismatic" if k == 1 else "revolute"
        parts.append(link(f"{name}{k}", *body_numbers(rng)))
        parts.append(joint(f"j{name}{k}", before, f"{name}{k}", kind, axis / np.linalg.norm(axis), **placed))
    return parts


def spatial_loop(seed=0, kind="point", moving_base=False, to="b2", **more):
    """A tree of skew joints with full inertias, two of whose branches are closed, or one to the ground."""
    rng = np.random.default_rng(seed)
    parts = [link("l0", *body_numbers(rng)), *branch(rng, "a", 4), *branch(rng, "b", 3)]
    axes = {"axis": tuple(rng.normal(size=3)), "to_axis": tuple(rng.normal(size=3))} if kind == "hinge" else {}
    turn = {"rpy": tuple(rng.uniform(-1, 1, 3))} if kind == "weld" else {}
    loop = Loop("tie", "a3", (0.1, 0.2, -0.1), to, (0.2, 0, 0.1), kind, **axes, **turn)
    return built(*parts, moving_base=moving_base), Scene(loops=(loop,), moving_base=moving_base, **more)


def crank_slider(*, cut="small_end", **more):
    """A crank of 0.3 m, a rod of 0.8 m and a slider along x; the tree is open at one of the rod's pins.

    Returns:
        The model, and the scene that closes it, with the crank at 0.7 rad and 2 rad/s.
    """
    turn, crank, rod = (0, -1, 0), 0.3, 0.8
    parts = [
        link("frame"),
        link("crank", 2.0, (0.15, 0, 0), (0, 0, 0, 0.02, 0, 0)),
        link("rod", 1.5, (0.25, 0, 0.05), (0, 0, 0, 0.05, 0, 0)),
        link("slider", 3.0),
        joint("main", "frame", "crank", "continuous", turn),
        joint("rail", "frame", "slider", "prismatic", (1, 0, 0)),
    ]
    tilt = np.arcsin(crank * np.sin(0.7) / rod)
    q = {"main": 0.7, "rail": crank * np.cos(0.7) + rod * np.cos(tilt)}
    if cut == "small_end":
        parts.append(joint("big_end", "crank", "rod", "continuous", turn, (crank, 0, 0)))
        q["big_end"] = -tilt - 0.7
        loop = Loop("pin", "rod", (rod, 0, 0), "slider")
    else:
        parts += [link("pin_of_rod"), joint("small_end", "slider", "pin_of_rod", "continuous", turn)]
        parts.append(joint("held", "pin_of_rod", "rod", "fixed", xyz=(-rod, 0, 0)))
        q["small_end"] = -tilt
        loop = Loop("pin", "rod", (0, 0, 0), "crank", (crank, 0, 0))
    scene = Scene(loops=(loop,), initial_q=q, initial_qd={"main": 2.0}, joint_limits="ignore", **more)
    return built(*parts), scene


def bennett(*beside, **more):
    """Bennett's linkage: four hinges in space that move though their equations should not let them.

    Args:
        beside: further links and joints, on l0.
    """
    alpha, beta, a = 0.6, 1.1, 0.4
    b = a * np.sin(beta) / np.sin(alpha)
    parts, before, place = [link("l0")], "l0", {}
    for k, (length, twist) in enumerate(((a, alpha), (b, beta), (a, alpha)), 1):
        moment = length**2 / 12
        parts.append(link(f"l{k}", 1.0, (length / 2, 0.02, 0.03), (0.01, 0, 0, moment, 0, moment)))
        parts.append(joint(f"j{k}", before, f"l{k}", "continuous", **place))
        before, place = f"l{k}", {"xyz": (length, 0, 0), "rpy": (twist, 0, 0)}
    axes = {"axis": (0, -np.sin(alpha), np.cos(alpha)), "to_axis": (0, np.sin(beta), np.cos(beta))}
    loop = Loop("pin", "l3", (a, 0, 0), to_point=(-b, 0, 0), kind="hinge", **axes)
    start = {"j1": 0.8, "j2": 2.9, "j3": -0.8}
    return built(*parts, *beside), Scene(loops=(loop,), initial_q=start, initial_qd={"j1": 3.0}, **more)
