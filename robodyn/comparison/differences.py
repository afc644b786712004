"""What is apart between two models: the tree, places and directions of joints, masses, what acts on joints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import acos, degrees, isclose, pi
from typing import Any

import numpy as np

from robodyn.comparison.alignment import Pair, moments_in
from robodyn.comparison.causes import (
    Parts,
    centre_cause,
    factor_cause,
    lost_or_twice,
    mass_cause,
    near,
    parts_of,
    tensor_cause,
)
from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.programs.vectors import length, rotation_about, rotation_from_rpy
from robodyn.robot.kinematics import Pose
from robodyn.robot.limits import binding
from robodyn.robot.model import Body, Joint, Model
from robodyn.scene.scene import Friction, Rotor, Scene, Spring
from robodyn.solids.inertia.laws import Inertia, combined
from robodyn.support.floats import Floats

SAME = 1e-5
"""Relative difference of a number that is none: texts have six digits."""
_LIKE, _ANGLE = 1e-4, 2e-5
_MANY = 3
"""Joints that have one value, from which on it may be that of a default class."""
Exchange = Callable[[Model, Scene], tuple[Model, Scene]]
"""Return the model and the scene of A with this one thing as it is in B."""


@dataclass(frozen=True, eq=False)
class Difference:
    """One thing that is not the same.

    Attributes:
        kind: what it is: "mass", "centre", "inertia", "placement", "mounting", "axis", "sign", "zero", "limit", ...
        subject, name: "link", "joint" or "robot" of A, or of B where only B has it.
        says: what A and B say.
        size: how much, relative to what is there.
        cause: why, where that can be told.
        exchange: how A is made to have it; None where it acts on no torque.
    """

    kind: str
    subject: str
    name: str
    says: tuple[str, str]
    size: float = 1.0
    cause: str = ""
    exchange: Exchange | None = None

    @property
    def acts(self) -> bool:
        return self.exchange is not None

    @property
    def words(self) -> str:
        who = f"{self.subject} {self.name!r}: " if self.name else ""
        return f"{who}{self.kind} {self.says[0]}, in B {self.says[1]}" + (f" ({self.cause})" if self.cause else "")


def differences(a: Model, b: Model, scenes: tuple[Scene, Scene], pairs: Sequence[Pair]) -> tuple[Difference, ...]:
    """Return all differences, body by body from the base; `pairs` are those of `aligned`."""
    found = [*_only_in_one(a, b, pairs)]
    for pair in pairs:
        if pair.a and pair.b and pair.same_parent:
            found += _of_joint(a, b, scenes, pair)
        found += _of_body(a, b, pair)
    return tuple(_with_defaults([*found, *_of_scene(*scenes)]))


def _only_in_one(a: Model, b: Model, pairs: Sequence[Pair]) -> Iterator[Difference]:
    here, there = {pair.a for pair in pairs}, {pair.b for pair in pairs}
    for model, other, matched, says in ((a, b, here, ("is there", "none")), (b, a, there, ("none", "is there"))):
        described = () if other.description is None else other.description.joints
        fixed = {joint.name for joint in described if joint.type == "fixed"}
        for i, body in enumerate(model.bodies):
            if i not in matched:
                cause = "it is fixed there" if body.joint.name in fixed else ""
                yield Difference("joint", "joint", body.joint.name, says, cause=cause)
    for pair in pairs:
        mine, theirs = a.bodies[pair.a].joint.name, b.bodies[pair.b].joint.name
        if pair.a and pair.b and mine != theirs:
            yield Difference("name", "joint", mine, (repr(mine), repr(theirs)), cause="they stand in one place")
    orders = [[name for name in each.joint_names if name in other.joint_names] for each, other in ((a, b), (b, a))]
    if orders[0] != orders[1]:
        yield Difference("order", "robot", "", (" ".join(orders[0]), " ".join(orders[1])), cause="q and tau are lists")
    for pair in pairs:
        if not pair.same_parent:
            mine, theirs = (each.bodies[each.bodies[k].parent].name for each, k in ((a, pair.a), (b, pair.b)))
            yield Difference("parent", "joint", a.bodies[pair.a].joint.name, (repr(mine), repr(theirs)))


def _of_joint(a: Model, b: Model, scenes: tuple[Scene, Scene], pair: Pair) -> Iterator[Difference]:
    mine, theirs = a.bodies[pair.a].joint, b.bodies[pair.b].joint
    name, unit = mine.name, "m" if mine.kind == "prismatic" else "rad"
    if mine.kind != theirs.kind:
        yield Difference("type", "joint", name, (mine.kind, theirs.kind), exchange=_joint(pair, kind=theirs.kind))
        return
    reach = max(length(mine.p), length(theirs.p), 1e-2)
    axes = _row(mine.axis), _row(theirs.axis)
    if pair.moved > SAME * reach or pair.rotated > _ANGLE:
        alone = a.bodies[pair.a].parent == 0 and sum(body.parent == 0 for body in a.bodies) == 1
        kind, size = "mounting" if alone else "placement", max(pair.moved / reach, pair.rotated)
        says = f"at {_row(mine.p)} m", f"at {_row(theirs.p)} m"
        yield Difference(kind, "joint", name, says, size, _placement_cause(mine, theirs), _as_in(b, pair))
    elif pair.turned > _ANGLE:
        cause = f"{degrees(pair.turned):.4g} deg apart"
        yield Difference("axis", "joint", name, axes, pair.turned, cause, _as_in(b, pair))
    if pair.sign < 0.0:
        yield Difference("sign", "joint", name, axes, cause="it turns the other way: q and tau change sign")
    if abs(pair.offset) > _ANGLE and not (unit == "rad" and isclose(abs(pair.offset), 2.0 * pi, rel_tol=1e-6)):
        yield Difference("zero", "joint", name, ("q = 0", f"q = {pair.offset:.6g} {unit}"), abs(pair.offset))
    if (mine.mimics is None) != (theirs.mimics is None):
        follows = tuple(f"follows {each.mimics!r}" if each.mimics else "moves by itself" for each in (mine, theirs))
        yield Difference("mimic", "joint", name, (follows[0], follows[1]))
    elif mine.mimics and not isclose(abs(mine.multiplier), abs(theirs.multiplier), rel_tol=SAME):
        yield Difference("mimic", "joint", name, (f"times {mine.multiplier:g}", f"times {theirs.multiplier:g}"))
    yield from _limits(mine, theirs, pair, unit)
    yield from _of_drive(mine, theirs, scenes)


def _row(numbers: Floats) -> str:
    return " ".join(f"{x + 0.0:.5g}" for x in np.asarray(numbers, dtype=float).ravel())


def _placement_cause(mine: Joint, theirs: Joint) -> str:
    p, d = mine.p, theirs.p
    if length(p - d) <= SAME * max(length(p), 1e-3):
        apart = degrees(acos(min(max((float(np.trace(mine.R.T @ theirs.R)) - 1.0) / 2.0, -1.0), 1.0)))
        lost = near(theirs.R, np.eye(3), 1e-6)
        return f"the rotation of the joint's origin is {'lost' if lost else 'another'}: {apart:.4g} deg apart"
    if not d.any() or not p.any():
        return f"in {'A' if d.any() else 'B'} the joint's offset is lost"
    return factor_cause(d, p, "the offset", any_factor=False) or f"{length(p - d):.4g} m apart"


def _limits(mine: Joint, theirs: Joint, pair: Pair, unit: str) -> Iterator[Difference]:
    """Ranges, efforts and speeds; of a range whose numbers are the same the joint's sign or zero tells."""
    ours, other = _range(mine), _range(theirs)
    rows: list[tuple[str, Sequence[float] | None, Sequence[float] | None, str]] = []
    if ours != other:
        ends = None if other is None else sorted(pair.sign * (end - pair.offset) for end in other)
        rows.append(("range", ours, ends, unit))
    for what, its in (("effort", "N" if unit == "m" else "N m"), ("velocity", f"{unit}/s")):
        one, two = (binding(getattr(joint, what)) for joint in (mine, theirs))
        rows.append((what, None if one is None else (one,), None if two is None else (two,), its))
    for what, here, there, its in rows:
        size, cause = 1.0, ""
        if here is None or there is None:
            if (here is None) == (there is None) or what == "velocity":
                continue
        else:
            most = max(map(abs, (*here, *there))) or 1.0
            size = max(abs(x - y) for x, y in zip(here, there, strict=True)) / most
            if size <= _LIKE:
                continue
            for right, wrong, where in ((here, there, "B"), (there, here, "A")):
                if all(isclose(y, degrees(x), rel_tol=1e-3) for x, y in zip(right, wrong, strict=True)):
                    cause = f"in {where} it is in degrees"
        says = tuple(
            f"no {what}" if ends is None else f"{what} {' to '.join(f'{x:.6g}' for x in ends)} {its}"
            for ends in (here, there)
        )
        yield Difference("limit", "joint", mine.name, (says[0], says[1]), size, cause)


def _range(joint: Joint) -> tuple[float, float] | None:
    if joint.continuous or joint.lower is None or joint.upper is None:
        return None
    return joint.lower, joint.upper


def _of_drive(mine: Joint, theirs: Joint, scenes: tuple[Scene, Scene]) -> Iterator[Difference]:
    """Friction, rotors and springs."""
    slide, name = mine.kind == "prismatic", mine.name
    frictions = friction_of(mine, scenes[0]), friction_of(theirs, scenes[1])
    springs = scenes[0].spring.get(name), scenes[1].spring.get(theirs.name)
    rotors = [inertia * gear * gear for inertia, gear in (rotor_of(mine, scenes[0]), rotor_of(theirs, scenes[1]))]
    stiff = [0.0 if spring is None else spring.stiffness for spring in springs]
    lost = "" if all(rotors) else f"the armature is lost in {'B' if rotors[0] else 'A'}"
    friction = _friction(name, frictions[1])
    for kind, (one, other), unit, cause, exchange in (
        ("damping", [each.viscous for each in frictions], "N s/m" if slide else "N m s/rad", "", friction),
        ("friction", [each.dry for each in frictions], "N" if slide else "N m", "", friction),
        ("rotor", rotors, "kg" if slide else "kg m^2", lost, _rotor(name, rotors[1])),
        ("spring", stiff, "N/m" if slide else "N m/rad", "", _spring(name, springs[1])),
    ):
        if not isclose(one, other, rel_tol=SAME, abs_tol=1e-12):
            size = abs(one - other) / max(abs(one), abs(other))
            yield Difference(kind, "joint", name, (f"{one:.6g} {unit}", f"{other:.6g} {unit}"), size, cause, exchange)


def _of_body(a: Model, b: Model, pair: Pair) -> Iterator[Difference]:
    """Mass, centre and tensor of the links of a body; of the body as a whole where its links are others in B."""
    mine, theirs = a.bodies[pair.a].inertia, moments_in(pair.frame, b.bodies[pair.b].inertia)
    if _alike(mine, theirs):
        return
    parts = parts_of(a, pair.a)
    others: Parts = {
        name: (moments_in(pair.frame, part), inertial) for name, (part, inertial) in parts_of(b, pair.b).items()
    }
    whole = _inertia(pair, theirs)
    for one, other, its, where in ((mine, theirs, parts, "B"), (theirs, mine, others, "A")):
        for name, how in lost_or_twice(one, other, its):
            said = ("once", how) if where == "B" else (how, "once")
            cause = f"{its[name][0].m:.6g} kg of it {'count twice' if how == 'twice' else 'are not'} in {where}"
            yield Difference("mass", "link", name, said, its[name][0].m / one.m, cause, whole)
            return
    apart = [name for name in parts if name in others and not _alike(parts[name][0], others[name][0])]
    if not apart or parts.keys() != others.keys():
        yield from _of_inertial(a.bodies[pair.a].name, (mine, theirs), (np.eye(3), np.eye(3)), whole)
        return
    for name in apart:
        link, there = (Pose(*(np.asarray(x, dtype=float) for x in each.links[name][1:])) for each in (a, b))
        seen = link.inverse.after(pair.frame).R @ there.R
        axes = [np.asarray(rotation_from_rpy(*each[name][1].origin.rpy), dtype=float) for each in (parts, others)]
        inertials = (moments_in(link.inverse, parts[name][0]), moments_in(link.inverse, others[name][0]))
        rest = [part for each, (part, _) in parts.items() if each != name]
        exchange = _inertia(pair, combined([*rest, others[name][0]]))
        yield from _of_inertial(name, inertials, (axes[0], seen @ axes[1]), exchange)


def _alike(mine: Inertia, theirs: Inertia) -> bool:
    if abs(mine.m - theirs.m) > SAME * max(abs(mine.m), abs(theirs.m)):
        return False
    if not mine.m or not theirs.m:
        return near(mine.I, theirs.I, SAME)
    apart = length(mine.centre_of_mass - theirs.centre_of_mass)
    return apart <= _LIKE * _gyration(mine) and near(mine.about_centre, theirs.about_centre, _LIKE)


def _gyration(of: Inertia) -> float:
    """Return the radius of gyration about the origin [m], at least 0.1 mm."""
    return max(float(max(np.trace(of.I), 0.0) / (2.0 * abs(of.m))) ** 0.5 if of.m else 0.0, 1e-4)


def _of_inertial(
    name: str, inertials: tuple[Inertia, Inertia], axes: tuple[Floats, Floats], exchange: Exchange
) -> Iterator[Difference]:
    """The difference of one inertial, both in the axes of its link: of the mass, or else of centre and tensor. `axes`
    (3, 3) are those that each file writes its tensor in."""
    mine, theirs = inertials
    c, d = (np.asarray(each.centre_of_mass, dtype=float) for each in inertials)
    I, J = (np.asarray(each.about_centre, dtype=float) for each in inertials)
    most = max(abs(mine.m), abs(theirs.m))
    if abs(mine.m - theirs.m) > SAME * most:
        cause = mass_cause((mine.m, c, I), (theirs.m, d, J))
        says = f"{mine.m:.6g} kg", f"{theirs.m:.6g} kg"
        yield Difference("mass", "link", name, says, abs(mine.m - theirs.m) / most, cause, exchange)
        return
    moved = length(c - d) / max(map(_gyration, inertials))
    if moved > _LIKE:
        cause = centre_cause(c, d)
        yield Difference("centre", "link", name, (f"{_row(c)} m", f"{_row(d)} m"), moved, cause, exchange)
    if not near(I, J, _LIKE):
        upper = np.triu_indices(3)
        says = f"{_row(I[upper])} kg m^2", f"{_row(J[upper])} kg m^2"
        size = float(np.abs(I - J).max() / max(np.abs(I).max(), np.abs(J).max()))
        yield Difference("inertia", "link", name, says, size, tensor_cause(c, (I, J), axes, mine.m), exchange)


def _of_scene(mine: Scene, theirs: Scene) -> Iterator[Difference]:
    if length(np.subtract(mine.gravity, theirs.gravity)) > 1e-3:
        says = (f"{' '.join(f'{x:g}' for x in scene.gravity)} m/s^2" for scene in (mine, theirs))
        exchange: Exchange = lambda model, scene: (model, replace(scene, gravity=theirs.gravity))  # noqa: E731
        yield Difference("gravity", "robot", "", (next(says), next(says)), exchange=exchange)
    loops = [{frozenset((loop.link, loop.to)): loop for loop in scene.loops} for scene in (mine, theirs)]
    for key in dict.fromkeys([*loops[0], *loops[1]]):
        one, other = (each.get(key) for each in loops)
        kinds = ("open" if one is None else one.kind, "open" if other is None else other.kind)
        if kinds[0] != kinds[1]:
            named = one or other
            assert named is not None
            yield Difference("loop", "robot", named.name, kinds, cause=f"{named.link} to {named.to}")


def _with_defaults(found: Sequence[Difference]) -> Iterator[Difference]:
    """Say where one value of B stands at several joints that are not alike in A: that of a default class."""
    many = Counter((one.kind, one.says[1]) for one in found if one.kind in ("damping", "friction", "rotor", "limit"))
    for one in found:
        alike = many[one.kind, one.says[1]]
        default = alike >= _MANY and not one.cause
        yield replace(one, cause=f"so at {alike} joints of B: a default class?") if default else one


def _with_body(model: Model, i: int, body: Body) -> Model:
    bodies = (*model.bodies[:i], body, *model.bodies[i + 1 :])
    return Model(model.name, model.file, bodies, model.links, model.notes)


def _inertia(pair: Pair, theirs: Inertia) -> Exchange:
    return lambda model, scene: (_with_body(model, pair.a, replace(model.bodies[pair.a], inertia=theirs)), scene)


def _joint(pair: Pair, **changes: Any) -> Exchange:
    def exchange(model: Model, scene: Scene) -> tuple[Model, Scene]:
        body = model.bodies[pair.a]
        return _with_body(model, pair.a, replace(body, joint=replace(body.joint, **changes))), scene

    return exchange


def _as_in(b: Model, pair: Pair) -> Exchange:
    """Put the joint of A where B has its own: `place` at q_b = 0, the body of A as `frame` says."""
    at = pair.place.after(pair.frame.inverse)
    theirs = b.bodies[pair.b].joint
    axis = pair.sign * (at.R.T @ pair.place.R @ theirs.axis)
    there = -pair.sign * pair.offset  # q_a, where q_b = 0
    R, p = at.R, at.p
    if theirs.kind == "prismatic":
        p = p - there * (R @ axis)
    elif there:
        R = R @ np.asarray(rotation_about(axis, -there), dtype=float)
    return _joint(pair, R=R, p=p, axis=axis)


def _with(scene: Scene, key: str, name: str, value: object) -> Scene:
    entries: Mapping[str, object] = getattr(scene, key)
    changes: dict[str, Any] = {key: {**entries, name: value}}
    return replace(scene, **changes)


def _friction(name: str, friction: Friction) -> Exchange:
    return lambda model, scene: (model, _with(scene, "friction", name, friction))


def _rotor(name: str, reflected: float) -> Exchange:
    return lambda model, scene: (model, _with(scene, "rotor", name, Rotor(reflected, 1.0)))


def _spring(name: str, spring: Spring | None) -> Exchange:
    return lambda model, scene: (model, _with(scene, "spring", name, spring or Spring(0.0)))
