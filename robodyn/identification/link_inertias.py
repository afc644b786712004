"""From the parameters of bodies to the inertials of their links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.identification.pseudo_inertia import parameters_of, pseudo_inertia
from robodyn.programs.vectors import product
from robodyn.robot.masses.declared import declared
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Link
from robodyn.solids.inertia.conversions import from_inertia, from_moments
from robodyn.solids.inertia.laws import Inertia, symmetric
from robodyn.solids.inertia.properties import MassProperties
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, listed, shown

_LEFT = 1e-3
"""The part of a body, in its every direction, that is left to its main link at least."""


class LinkInertias(NamedTuple):
    """What links have that change.

    Attributes:
        bodies: by link, in its frame.
        notes: what could not stay as it was, a line each.
    """

    bodies: Mapping[str, MassProperties]
    notes: tuple[str, ...]


def link_inertias(model: Model, described: Floats, theta: Floats) -> LinkInertias:
    """Return the inertials of links that give bodies the parameters theta.

    Of several links fixed to each other the change goes to the one that the joint carries, or, if that has no mass, to
    the heaviest. The others stay, unless they are more than the body: they are then scaled, masses and inertias alike,
    so that about half of the body in its narrowest direction is left to the first. Payloads of the scene, which theta
    and `described` hold both, belong to no link.

    Args:
        described, theta: of `robodyn.regressor`, before and after identification.

    Raises:
        InputError: what the log shows of a body is less than its payload.
    """
    bodies, notes = dict[str, MassProperties](), list[str]()
    for k, body in enumerate(model.bodies):
        own = slice(10 * k, 10 * k + 10)
        if (theta[own] == described[own]).all():
            continue
        m, mc, I = body.inertia
        P = pseudo_inertia(theta[own] - (described[own] - (m, *mc, *I[np.triu_indices(3)])))
        if np.linalg.eigvalsh(P / np.sqrt(np.outer(*(np.abs(np.diagonal(P)),) * 2))).min() <= 0.0:
            what = f"what the log shows of body {shown(body.name)} leaves nothing that can exist beside its payload"
            raise InputError(what, remedy="leave the payload out, or correct its mass and place")
        changed, why = _shared(model, k, P)
        bodies |= changed
        notes += why
    return LinkInertias(bodies, tuple(notes))


def _shared(model: Model, k: int, P: Floats) -> tuple[dict[str, MassProperties], list[str]]:
    """Return the links of a body that change, in their frames."""
    assert model.description is not None, "models are made of descriptions"
    links = [link for link in model.description.links if link.name in model.links and model.links[link.name].body == k]
    main = _main(links, model.bodies[k].name)
    others = {each.name: each.body for link in links if link is not main and (each := declared(link)) is not None}
    others = {name: body for name, body in others.items() if body.mass or body.S_c.any()}
    total = np.zeros((4, 4))
    for name, body in others.items():
        total += _pseudo(body.placed(model.links[name].R, model.links[name].p).moments)
    share, notes, changed = _share(P, total), list[str](), dict[str, MassProperties]()
    if share < 1.0:
        changed = {name: from_inertia(share * b.mass, b.com, share * b.inertia) for name, b in others.items()}
        what = f"the links {listed(list(others))} are more than body {shown(model.bodies[k].name)} is found to be"
        notes.append(f"{what}: their masses and inertias are scaled by {figure(share)}")
    return {main.name: _to_link(model, main.name, P - share * total), **changed}, notes


def _main(links: Sequence[Link], name: str) -> Link:
    """Return the link that takes the change: the body's own, or without mass the heaviest."""
    own = next(link for link in links if link.name == name)
    masses = [0.0 if link.inertial is None else link.inertial.mass for link in links]
    if (own.inertial is not None and own.inertial.mass > 0.0) or max(masses) <= 0.0:
        return own
    return links[int(np.argmax(masses))]


def _share(P: Floats, others: Floats) -> float:
    """Return how much of the others P leaves room for: all, if at least `_LEFT` of P remains."""
    if not others.any():
        return 1.0
    L = np.linalg.cholesky(P)
    half = np.linalg.solve(L, others)
    largest = float(np.linalg.eigvalsh(np.linalg.solve(L, half.T)).max())
    return 1.0 if largest <= 1.0 - _LEFT else float(f"{0.5 / largest:.3g}")


def _to_link(model: Model, name: str, P: Floats) -> MassProperties:
    """Return the body of a pseudo-inertia about its body's frame, in the frame of a link."""
    m, mx, my, mz, *moments = parameters_of(P).tolist()
    frame = model.links[name]
    body = from_moments(Inertia(m, np.array((mx, my, mz)), symmetric(moments)))
    return body.placed(frame.R.T, -product(frame.R.T, frame.p))


def _pseudo(moments: Inertia) -> Floats:
    return pseudo_inertia((moments.m, *moments.mc, *moments.I[np.triu_indices(3)]))
