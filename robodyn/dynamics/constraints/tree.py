"""The open tree of a constrained robot, on which the forces of loops and contacts act as wrenches given by columns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from robodyn.robot.model import Model
from robodyn.scene.parts import GROUND, Contact, ContactCost, Entry, ExternalWrench, Loop, Vector
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

PARTS = ("fx", "fy", "fz", "mx", "my", "mz")


def columns_of(name: str) -> tuple[str, ...]:
    """Return the columns of the wrench of a loop or a contact on its link, as tables of results call them."""
    return tuple(f"{part}_{name}" for part in PARTS)


def reaction_columns_of(name: str) -> tuple[str, ...]:
    """Return the columns of the wrench of a loop on the other link."""
    return tuple(f"reaction {column}" for column in columns_of(name))


def open_scene(scene: Scene) -> Scene:
    """Return the scene without constraints."""
    return replace(
        scene, loops=(), contacts=(), actuated=None, passive=(), share=Scene.share, weights={}, weight=Scene.weight,
        contact_cost=ContactCost(),
    )  # fmt: skip


@lru_cache(maxsize=16)
def tree_scene(model: Model, scene: Scene) -> Scene:
    """Return the scene in which constraints are wrenches whose entries are columns of `columns_of` and so on.

    A loop's wrench acts on its link at its point, in the axes of the other; the opposite on the other link, at its
    point. A contact's acts on its link at `middle`, in the axes of the ground.
    """
    wrenches = [*(each for loop in scene.loops for each in _of_loop(model, loop)), *map(_of_contact, scene.contacts)]
    return replace(open_scene(scene), wrenches=(*scene.wrenches, *wrenches))


def constraint_columns(scene: Scene) -> tuple[str, ...]:
    """Return all columns that `tree_scene` adds: of loops and contacts, then of loops on the other links."""
    own = [column for name in scene.constraint_names for column in columns_of(name)]
    return (*own, *(column for loop in scene.loops for column in reaction_columns_of(loop.name)))


def middle(contact: Contact) -> Vector:
    """Return the mean of a contact's points, in the frame of its link [m]."""
    x, y, z = np.mean(contact.points, axis=0).tolist()
    return x, y, z


def normal_of(contact: Contact, scene: Scene) -> Floats:
    """Return (3,) the unit normal of a contact in the axes of the ground; without gravity it is up, along z."""
    g = np.asarray(scene.gravity)
    against = -g if g.any() else np.array((0.0, 0.0, 1.0))
    n = np.asarray(against if contact.normal is None else contact.normal, dtype=float)
    n = n / np.abs(n).max()
    return np.asarray(n / np.sqrt((n * n).sum()))


def _of_loop(model: Model, loop: Loop) -> Iterator[ExternalWrench]:
    fixed = loop.to == GROUND and GROUND not in model.links
    force, moment = _entries(columns_of(loop.name))
    yield ExternalWrench(loop.link, force, moment, loop.point, "world", "loop", "" if fixed else loop.to)
    if not fixed:
        force, moment = _entries(reaction_columns_of(loop.name))
        yield ExternalWrench(loop.to, force, moment, loop.to_point, cause="loop")


def _of_contact(contact: Contact) -> ExternalWrench:
    force, moment = _entries(columns_of(contact.name))
    return ExternalWrench(contact.link, force, moment, middle(contact), "world", "contact")


Triple = tuple[Entry, Entry, Entry]


def _entries(columns: tuple[str, ...]) -> tuple[Triple, Triple]:
    a, b, c, d, e, f = columns
    return (a, b, c), (d, e, f)
