"""Bodies of a robot as one: each body's share of the inertia matrix and of the momenta, by the rotation law and the
parallel axis theorem, term by term; in numbers at a configuration, or in letters as functions of the joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Sample
from robodyn.equations.forms import TooLargeError
from robodyn.equations.letters import KINDS, Letter, Lettered, snapped
from robodyn.errors import InputError
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, narrowed, rotation_from_rpy
from robodyn.robot.kinematics import REST, Pose, Velocity, configuration, motions, named_links, poses, rates, velocities
from robodyn.robot.load import assemble
from robodyn.robot.masses.declared import BASE, RobotInertia
from robodyn.robot.model import Frame, Model
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.properties import View
from robodyn.support.wording import listed, shown

PRODUCTS, LONGEST = 100_000, 1200
"""Products of terms that may be formed for letters, and terms of an entry: some seconds of work, some pages of text."""


class Part(NamedTuple):
    """A body: mass [kg], mass centre c [m] and inertia matrix about it [kg m^2], in its own axes; its pose in the frame
    of the base; its velocities relative to the ground, in its own axes."""

    name: str
    m: Scalar
    c: Array
    I_c: Array
    pose: Pose
    velocity: Velocity


@dataclass(frozen=True, eq=False)
class Share:
    """What a body, or the whole, adds about the point asked for, in the axes asked for.

    Attributes:
        m, c: mass [kg], mass centre in the frame [m].
        own, turned, moved, inertia: I_c in the body's axes, R I_c R^T, m (|d|^2 1 - d d^T), and their sum [kg m^2]; of
            the whole `turned` and `moved` are the sums, and `own` is `turned`.
        P, L: linear [kg m/s] and angular momentum [kg m^2/s], relative to the ground.
    """

    name: str
    m: Any
    c: Any
    own: Any
    turned: Any
    moved: Any
    inertia: Any
    P: Any
    L: Any


@dataclass(frozen=True, eq=False)
class Composite:
    """Attributes: names: of the bodies; bodies: their shares, if asked for; whole: of all; frame: a link, or the base;
    point: in the frame [m]; place: in the axes asked for; first: first moments about it in these, 0 where the mass
    centre is in the plane through the point [kg m]; momentum: whether it was asked for; letters: those that occur;
    joints: of each coordinate q_k that occurs k and the joint's name."""

    names: tuple[str, ...]
    bodies: tuple[Share, ...]
    whole: Share
    frame: str
    point: Any
    place: Any
    first: Any
    momentum: bool
    letters: tuple[Letter, ...] = ()
    joints: tuple[tuple[int, str], ...] = ()


def in_numbers(found: RobotInertia, description: Description, view: View, qd: Any = None) -> Composite:
    """Return the shares of the links of a robot at its configuration, its base at rest.

    Args: qd: velocities of all joints, or of some by name; without any, momenta are not asked for.

    Raises: InputError: the momenta overflow.

    Accuracy: sums within 1e-13 of the robot's mass times its size squared, as `robot_inertia` has them.
    """
    model = assemble(description)
    q, speeds = configuration(model, found.at), rates(model, () if qd is None else qd)
    moving = velocities(model.parents, motions(model, q.tolist(), speeds.tolist(), [0.0] * model.n))
    parts = []
    for link in found.links:
        body, R, p = model.links[link.name]
        w, v = moving[body]
        velocity = Velocity(*map(narrowed, (R.T @ w, R.T @ (v + cross(w, p)))))
        parts.append(Part(link.name, link.body.mass, link.body.com, link.body.inertia, link.pose, velocity))
    made = composed(parts, found.frame, found.frame_pose, view, qd is not None)
    if not np.isfinite([*made.whole.P, *made.whole.L]).all():
        raise InputError("the momentum overflows", remedy="smaller velocities", file=model.file)
    return made


def in_letters(
    description: Description,
    view: View,
    kinds: Sequence[str] = KINDS,
    links: Sequence[str] = (),
    frame: str = BASE,
    terms: bool = False,
    momentum: bool = False,
    moving_base: bool = False,
) -> Composite:
    """Return bodies as one as SymPy expressions of q_i, qd_i and letters; see `robodyn.equations.letters`.

    Args:
        kinds: of letters; none leaves numbers. links: all of a body's that have mass, or none of them; none is all.
        frame: a link, or the base; terms: whether shares are wanted; momentum: without it momenta are zero;
            moving_base: whether the base moves at w_x .. v_z, in its own axes.

    Raises:
        InputError: no such link, no mass, a floating joint between bodies, links that are part of a body, or too long
            expressions.

    Accuracy: with the letters' values in their place 1e-12 of `in_numbers`.
    """
    model = assemble(description, moving_base=moving_base)
    if any(body.joint.kind == "floating" for body in model.bodies[1:]):
        what = "a floating joint between bodies has no letters"
        raise InputError(what, remedy="--at gives numbers", file=model.file)
    chosen, lettered = _bodies(model, description, links), Lettered(model, kinds=kinds)
    of_base = frame == BASE not in model.links
    at = Frame(0, IDENTITY, ZERO) if of_base else model.links[named_links(model, [frame])[0]]
    traced: list[Composite] = []

    def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
        moving = sample.motions()
        where = poses(model.parents, [REST, *moving[1:]])
        speeds = velocities(model.parents, moving) if momentum else [Velocity(ZERO, ZERO)] * len(where)
        parts = [Part(model.bodies[i].name, *lettered.mass_properties(i, tape), where[i], speeds[i]) for i in chosen]
        stand = where[at.body].after(Pose(snapped(at.R), at.p))
        found = composed(parts, frame, stand, view, momentum)
        traced.append(found if terms else replace(found, bodies=()))
        shares = [value for share in (found.whole, *traced[-1].bodies) for value in _values(share)]
        return [x for array in (found.point, found.place, found.first, *shares) for x in np.ravel(array)]

    try:
        written = lettered.written(lettered.program(outputs), LONGEST, PRODUCTS)
    except TooLargeError:
        what = "the expressions of these bodies are too long"
        remedy = "fewer --links, --about origin, fewer letters as --symbols m, or --at for numbers"
        raise InputError(what, remedy=remedy, file=model.file) from None
    found, values = traced[-1], iter(written)

    def taken(array: Any) -> Any:
        entries = np.array([next(values) for _ in range(np.size(array))], dtype=object)
        return entries.reshape(np.shape(array))[()]

    point, place, first = map(taken, (found.point, found.place, found.first))
    whole, *bodies = (Share(share.name, *map(taken, _values(share))) for share in (found.whole, *found.bodies))
    occur = {symbol.name for entry in written for symbol in entry.free_symbols}
    letters = tuple(letter for letter in lettered.letters if letter.name in occur)
    named = [(k, body.joint.name) for k, body in enumerate(model.bodies) if {f"q_{k}", f"qd_{k}"} & occur]
    rest = (frame, point, place, first, momentum, letters, tuple(named))
    return Composite(found.names, tuple(bodies), whole, *rest)


def _values(share: Share) -> list[Any]:
    return list(vars(share).values())[1:]


def _bodies(model: Model, description: Description, links: Sequence[str]) -> list[int]:
    """Return the bodies with mass that the links make, or all."""
    names = named_links(model, links) or tuple(model.links)
    chosen = sorted({model.links[name].body for name in names})
    heavy = {link.name for link in description.massive}
    for name, place in model.links.items():
        if place.body in chosen and name in heavy and name not in names:
            with_it = [other for other in names if model.links[other].body == place.body]
            what = f"link {shown(name)} is fixed to {shown(with_it[0])}: in letters they are one body"
            raise InputError(what, remedy=f"name it too, or leave {listed(with_it)} away", file=model.file)
    chosen = [i for i in chosen if model.bodies[i].inertia.m]
    if not chosen:
        raise InputError("the links have no mass", remedy="give links an <inertial>", file=model.file)
    return chosen


def composed(parts: Sequence[Part], frame: str, stand: Pose, view: View, momentum: bool) -> Composite:
    """Return shares and sum about the point and in the axes of a view in a frame that stands there, for any scalar.

    With d from the point to the mass centre: `I = R I_c R^T + m (|d|^2 1 - d d^T)`, `P = m (v + w x c)`,
    `L = R I_c w + d x P`. About the mass centre the terms of the theorem add up to
    `sum_{i<j} m_i m_j / m (|r|^2 1 - r r^T)`, r from one to the other.
    """
    turn = rotation_from_rpy(*view.rpy).T
    stands = [stand.inverse.after(part.pose) for part in parts]
    centres = [pose.R @ part.c + pose.p for part, pose in zip(parts, stands, strict=True)]
    m = sum((part.m for part in parts), 0.0)
    centre = centres[0] if len(parts) == 1 else _moment(parts, centres) * (1.0 / m)
    own_point = view.about == "com"
    point = centre if own_point else np.array(ZERO if view.about == "origin" else view.about)
    shares = []
    for part, pose, c in zip(parts, stands, centres, strict=True):
        # about the mass centre by distances between centres, in which the origin does not occur
        d = turn @ (_moment(parts, [c - other for other in centres]) * (1.0 / m) if own_point else c - point)
        R = turn @ pose.R
        turned, moved = R @ part.I_c @ R.T, _spread(d) * part.m
        w, v = part.velocity
        P = R @ (v + cross(w, part.c)) * part.m
        L = R @ (part.I_c @ w) + cross(d, P)
        shares.append(Share(part.name, part.m, c, part.I_c, turned, moved, turned + moved, P, L))
    turned, moved, P, L = (
        sum((getattr(share, name) for share in shares[1:]), getattr(shares[0], name))
        for name in ("turned", "moved", "P", "L")
    )
    if own_point:
        pairs = combinations(zip(parts, centres, strict=True), 2)
        spreads = [_spread(turn @ (at - c)) * (one.m * other.m) for (one, at), (other, c) in pairs]
        moved = sum(spreads, np.zeros((3, 3))) * (1.0 / m)
    whole = Share("whole", m, centre, turned, turned, moved, turned + moved, P, L)
    names = tuple(part.name for part in parts)
    first = ZERO if own_point else turn @ _moment(parts, [c - point for c in centres])
    return Composite(names, tuple(shares), whole, frame, point, turn @ point, first, momentum)


def _moment(parts: Sequence[Part], places: Sequence[Array]) -> Array:
    """sum m_i x_i."""
    return np.asarray(sum((x * part.m for x, part in zip(places, parts, strict=True)), ZERO))


def _spread(d: Array) -> Array:
    """|d|^2 1 - d d^T."""
    out: Array = IDENTITY * (d @ d) - np.outer(d, d)
    return out
