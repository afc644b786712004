"""Bodies of a robot as one: each body's share of the inertia matrix and of the momenta, by the rotation law and the
parallel axis theorem, term by term; in numbers at a configuration, or in letters as functions of the joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Sample
from robodyn.equations.closed import MOST_JOINTS
from robodyn.equations.forms import TooLargeError
from robodyn.equations.letters import KINDS, Letter, Lettered, snapped
from robodyn.errors import InputError
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, rotation_from_rpy
from robodyn.robot.kinematics import REST, Pose, Velocity, configuration, motions, poses, rates, velocities
from robodyn.robot.load import assemble
from robodyn.robot.masses.declared import BASE, RobotInertia, named_links
from robodyn.robot.model import Frame, Model
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.properties import View
from robodyn.support.wording import listed, shown

AXES = "xyz"


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
            the whole `turned` and `moved` are the sums, and it has no axes of its own.
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
    """Attributes: bodies: their shares; whole: of all; point: in the frame [m]; letters: those that occur;
    joints: of each coordinate q_k that occurs k and the joint's name."""

    bodies: tuple[Share, ...]
    whole: Share
    point: Any
    letters: tuple[Letter, ...] = ()
    joints: tuple[tuple[int, str], ...] = ()


def in_numbers(found: RobotInertia, description: Description, view: View, qd: Any = ()) -> Composite:
    """Return the shares of the links of a robot at its configuration, its base at rest.

    Args: qd: velocities of all joints, or of some by name.

    Accuracy: sums within 1e-13 of the robot's mass times its size squared, as `robot_inertia` has them.
    """
    model = assemble(description)
    q, speeds = configuration(model, found.at), rates(model, qd)
    moving = velocities(model.parents, motions(model, q.tolist(), speeds.tolist(), [0.0] * model.n))
    parts = []
    for link in found.links:
        body, R, p = model.links[link.name]
        w, v = moving[body]
        velocity = Velocity(R.T @ w, R.T @ (v + cross(w, p)))
        parts.append(Part(link.name, link.body.mass, link.body.com, link.body.inertia, link.pose, velocity))
    return composed(parts, found.frame_pose, view)


def in_letters(
    description: Description,
    view: View,
    kinds: Sequence[str] = KINDS,
    links: Sequence[str] = (),
    frame: str = BASE,
    momentum: bool = False,
) -> Composite:
    """Return the shares of bodies as SymPy expressions of q_i, qd_i and letters; see `robodyn.equations.letters`.

    Args:
        kinds: of letters; none leaves numbers. links: all of a body's that have mass, or none of them; none is all.
        frame: a link, or the base; momentum: without it momenta are zero.

    Raises:
        InputError: no such link, no mass, more than six coordinates, or links that are part of a body.

    Accuracy: with the letters' values in their place 1e-12 of `in_numbers`.
    """
    model = assemble(description)
    joints = [joint for joint in model.independent[1 if model.floating else 0 :] if joint.kind != "fixed"]
    if len(joints) > MOST_JOINTS or any(joint.kind == "floating" for joint in joints):
        what = f"letters are for up to {MOST_JOINTS} joints of one coordinate"
        raise InputError(what, remedy="--at gives numbers", file=model.file)
    chosen, lettered = _bodies(model, description, links), Lettered(model, kinds=kinds)
    at = (
        model.links[named_links(model, [frame])[0]]
        if frame != BASE or BASE in model.links
        else Frame(0, IDENTITY, ZERO)
    )

    def outputs(tape: Tape, sample: Sample) -> Iterable[Scalar]:
        moving = sample.motions()
        where = poses(model.parents, [REST, *moving[1:]])
        speeds = velocities(model.parents, moving) if momentum else [Velocity(ZERO, ZERO)] * len(where)
        parts = [Part(model.bodies[i].name, *lettered.mass_properties(i, tape), where[i], speeds[i]) for i in chosen]
        stand = where[at.body].after(Pose(snapped(at.R), at.p))
        found = composed(parts, stand, view)
        flat: list[Scalar] = list(found.point)
        for share in (found.whole, *found.bodies):
            for value in list(vars(share).values())[1:]:
                flat += [] if value is None else np.ravel(np.asarray(value, dtype=object)).tolist()
        return flat

    try:
        written = lettered.written(lettered.program(outputs))
    except TooLargeError:
        what = "the expressions of these bodies are too long"
        raise InputError(what, remedy="fewer --links, --about origin, or --at for numbers", file=model.file) from None
    values = iter(written)
    point = np.array([next(values) for _ in range(3)], dtype=object)
    shares: list[Share] = []
    for name in ("whole", *(model.bodies[i].name for i in chosen)):
        mass, centre = next(values), _taken(values, 3)
        own = None if name == "whole" and not shares else _taken(values, 9)
        turned, moved, inertia = (_taken(values, 9) for _ in range(3))
        shares.append(Share(name, mass, centre, own, turned, moved, inertia, _taken(values, 3), _taken(values, 3)))
    occur = {symbol.name for entry in written for symbol in entry.free_symbols}
    letters = tuple(letter for letter in lettered.letters if letter.name in occur)
    named = [(k, body.joint.name) for k, body in enumerate(model.bodies) if {f"q_{k}", f"qd_{k}"} & occur]
    return Composite(tuple(shares[1:]), shares[0], point, letters, tuple(named))


def _taken(values: Any, n: int) -> Array:
    out = np.empty(n, dtype=object)
    out[:] = [next(values) for _ in range(n)]
    return out.reshape(3, 3) if n == 9 else out


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


def composed(parts: Sequence[Part], frame: Pose, view: View) -> Composite:
    """Return shares and sum about the point and in the axes of a view that is in this frame, for any scalar.

    With d from the point to the mass centre: `I = R I_c R^T + m (|d|^2 1 - d d^T)`, `P = m (v + w x c)`,
    `L = R I_c w + d x P`. About the mass centre the terms of the theorem add up to
    `sum_{i<j} m_i m_j / m (|r|^2 1 - r r^T)`, r from one to the other.
    """
    turn = snapped(rotation_from_rpy(*view.rpy)) if any(view.rpy) else IDENTITY
    stands = [frame.inverse.after(part.pose) for part in parts]
    centres = [stand.R @ part.c + stand.p for part, stand in zip(parts, stands, strict=True)]
    heavy = [k for k, part in enumerate(parts) if not (isinstance(part.m, float) and part.m == 0.0)]
    m = sum((parts[k].m for k in heavy), 0.0)
    centre = centres[heavy[0]] if len(heavy) == 1 else sum((centres[k] * parts[k].m for k in heavy), ZERO) * (1.0 / m)
    own_point = view.about == "com"
    point = centre if own_point else np.array(ZERO if view.about == "origin" else view.about)
    shares = []
    for k, (part, stand) in enumerate(zip(parts, stands, strict=True)):
        if not own_point:
            d = turn.T @ (centres[k] - point)
        elif len(heavy) == 1 and k in heavy:
            d = ZERO
        else:  # by distances between centres, in which the origin does not occur
            d = turn.T @ sum(((centres[k] - centres[j]) * parts[j].m for j in heavy if j != k), ZERO) * (1.0 / m)
        R = turn.T @ stand.R
        turned, moved = R @ part.I_c @ R.T, _spread(d) * part.m
        w, v = part.velocity
        P = R @ (v + cross(w, part.c)) * part.m
        L = R @ (part.I_c @ w) + cross(d, P)
        shares.append(Share(part.name, part.m, centres[k], part.I_c, turned, moved, turned + moved, P, L))
    turned, moved, P, L = (
        sum((getattr(share, name) for share in shares[1:]), getattr(shares[0], name))
        for name in ("turned", "moved", "P", "L")
    )
    if own_point:
        between = combinations(heavy, 2)
        pairs = [_spread(turn.T @ (centres[i] - centres[j])) * (parts[i].m * parts[j].m) for i, j in between]
        moved = sum(pairs, np.zeros((3, 3))) * (1.0 / m) if pairs else np.zeros((3, 3))
    return Composite(tuple(shares), Share("whole", m, centre, None, turned, moved, turned + moved, P, L), point)


def _spread(d: Array) -> Array:
    """|d|^2 1 - d d^T."""
    out: Array = IDENTITY * (d @ d) - np.outer(d, d)
    return out
