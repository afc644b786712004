"""How well a robot's parameters are known: standard deviations, or a covariance that an identification found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from robodyn.scene.covariance import Covariance
from robodyn.support.frozen import FrozenValue


@dataclass(frozen=True)
class Deviation(FrozenValue):
    """A standard deviation: a share of the parameter's value if `relative`, else in SI units."""

    value: float
    relative: bool = True

    def of(self, size: float) -> float:
        """Return the standard deviation of a parameter of this size, in its unit."""
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
        """Return what holds of a link."""
        own = self.link.get(name, LinkUncertainty())
        return LinkUncertainty(
            *(
                general if special is None else special
                for special, general in ((own.mass, self.mass), (own.com, self.com), (own.inertia, self.inertia))
            )
        )

    def of_joint(self, name: str) -> Deviation | None:
        """Return what holds of the friction of a joint or a coupled motor."""
        return self.joint.get(name, self.friction)
