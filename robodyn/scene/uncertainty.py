"""How well a robot's parameters are known: standard deviations, or a covariance from a JSON file of `robodyn
identify`."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from robodyn.errors import SceneError, unreadable
from robodyn.support.floats import Floats
from robodyn.support.frozen import Frozen, FrozenValue
from robodyn.support.input_file import parse_json, read_input

_KEYS = ("parameters", "values", "covariance")
_ROUNDING = 1e-9
_REMEDY = "give a file that robodyn identify has written"


@dataclass(frozen=True, eq=False)
class Covariance(Frozen):
    """Parameters of a robot that are known with errors: p names, as `robodyn.regressor` has them, values (p,) in SI
    units and the covariance (p, p) of their errors."""

    parameters: tuple[str, ...]
    values: Floats
    covariance: Floats

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Covariance) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @cached_property
    def _content(self) -> tuple[tuple[str, ...], bytes, bytes]:
        return self.parameters, self.values.tobytes(), self.covariance.tobytes()


@dataclass(frozen=True)
class Deviation(FrozenValue):
    """A standard deviation: a share of the parameter's value if `relative`, else in SI units."""

    value: float
    relative: bool = True

    def of(self, size: float) -> float:
        return self.value * abs(size) if self.relative else self.value


@dataclass(frozen=True)
class LinkUncertainty(FrozenValue):
    """Standard deviations of one link; None is the scene's word for all links.

    Attributes:
        mass: with the centre of mass and the radii of gyration kept [kg].
        com: of each coordinate of the centre of mass, with the inertia about it kept; relative: of its distance from
            the link's origin [m].
        inertia: relative: of a factor of the inertia matrix about the centre of mass; else of each of ixx, iyy and izz
            about it, in the link's axes [kg m^2].
    """

    mass: Deviation | None = None
    com: Deviation | None = None
    inertia: Deviation | None = None


@dataclass(frozen=True)
class Uncertainty(FrozenValue):
    """Independent normal errors of links and joints, or a covariance.

    Attributes:
        mass, com, inertia: of every link, as `LinkUncertainty` has them.
        friction: of every joint and coupled motor; relative: of a factor of all its friction; else of Coulomb's, alike
            in both directions [N m or N].
        link, joint: by name, what holds there instead.
        covariance: of parameters of `robodyn.regressor`, the others of which are sure; stands alone.
    """

    mass: Deviation | None = None
    com: Deviation | None = None
    inertia: Deviation | None = None
    friction: Deviation | None = None
    link: Mapping[str, LinkUncertainty] = field(default_factory=dict)
    joint: Mapping[str, Deviation] = field(default_factory=dict)
    covariance: Covariance | None = None

    def of_link(self, name: str) -> LinkUncertainty:
        own = self.link.get(name, LinkUncertainty())
        pairs = (own.mass, self.mass), (own.com, self.com), (own.inertia, self.inertia)
        return LinkUncertainty(*(general if special is None else special for special, general in pairs))


def covariance_json(known: Covariance) -> bytes:
    """Return the file's content: numbers that read back as the same floats."""
    content = known.parameters, known.values.tolist(), known.covariance.tolist()
    return json.dumps(dict(zip(_KEYS, content, strict=True)), allow_nan=False).encode() + b"\n"


def read_covariance(path: str | os.PathLike[str]) -> Covariance:
    """Return what a covariance file holds; SceneError where that is none."""
    file = os.fspath(path)
    try:
        content = parse_json(read_input(path), file)
    except OSError as error:
        raise unreadable(error, file) from None
    except (ValueError, RecursionError) as error:
        raise SceneError(f"is not JSON: {error}", remedy=_REMEDY, file=file) from None
    try:
        return _covariance(content)
    except ValueError as error:
        raise SceneError(str(error), remedy=_REMEDY, file=file) from None


def _covariance(content: Any) -> Covariance:
    if not isinstance(content, Mapping) or set(content) != set(_KEYS):
        raise ValueError(f"has not just the keys {', '.join(_KEYS)}")
    names = content["parameters"]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError('"parameters" is no list of names')
    try:
        values, C = (np.array(content[key], dtype=float) for key in _KEYS[1:])
    except (ValueError, TypeError):
        raise ValueError('"values" or "covariance" are no numbers') from None
    p = len(names)
    if values.shape != (p,) or C.shape != (p, p):
        raise ValueError(f"has {p} parameters, values of shape {values.shape} and a covariance of shape {C.shape}")
    if len(set(names)) < p:
        raise ValueError(f"names {p - len(set(names))} parameters twice")
    if not (np.isfinite(values).all() and np.isfinite(C).all()):
        raise ValueError("has numbers that are not finite")
    errors = np.sqrt(np.maximum(np.diagonal(C), 0.0))
    scaled = C / np.where(errors > 0.0, errors, 1.0) / np.where(errors > 0.0, errors, 1.0)[:, None]
    if (np.diagonal(C) < 0.0).any() or np.abs(scaled - scaled.T).max(initial=0.0) > _ROUNDING:
        raise ValueError("has a covariance that is not symmetric, or negative on its diagonal")
    if p and float(np.linalg.eigvalsh((scaled + scaled.T) / 2).min()) < -_ROUNDING * p:
        raise ValueError("has a covariance that is not positive semidefinite")
    return Covariance(tuple(names), values, C)
