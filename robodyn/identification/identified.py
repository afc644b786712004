"""What identification found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robodyn.identification.base import Base
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

_HALF = 0.5


@dataclass(frozen=True)
class Errors:
    """||computed - measured|| / ||measured|| in N m, both sides filtered; of all joints together, and by joint."""

    relative_error: float
    joints: Mapping[str, float]


@dataclass(frozen=True)
class MotorFit:
    """What was found of a motor, joint side.

    Attributes:
        joints: how it turns with joints: {"wrist": 1.0}; of a joint's own motor that joint alone.
        viscous: N m s/rad; coulomb, offset: half the difference and half the sum of friction forwards and backwards
            [N m]; rotor: reflected inertia [kg m^2].
        load: friction as a part of the torque that passes the gear, None without.
        stribeck: torque of breakaway [N m], None without, which decays with `stribeck_velocity` [rad/s].
    """

    joints: Mapping[str, float]
    viscous: float
    coulomb: float
    offset: float
    rotor: float
    stribeck: float | None = None
    stribeck_velocity: float | None = None
    load: float | None = None


@dataclass(frozen=True, eq=False)
class BaseFit:
    """Base parameters: their groups by least squares without bounds, and what the consistent parameters make of them.

    Attributes:
        base: which groups; values, standard_errors, consistent: (r,) SI units; covariance: (r, r).
    """

    base: Base
    values: Floats
    standard_errors: Floats
    consistent: Floats
    covariance: Floats


@dataclass(frozen=True, eq=False)
class Identified:
    """A description that explains logs.

    Attributes:
        names, described, theta: of `robodyn.regressor` of `model` in `scene`: before and after.
        scene: the given one with what was found of friction and rotors.
        motors: by name.
        coupled: names of motors of two joints, and what part of the squares of both joints' residuals they leave.
        train, held_out: of the consistent parameters; `bound_*` of least squares without bounds; `original_*` of the
            description. None where nothing is held out.
        discrepancy: by joint, standard error of torques of another motion beside that of the parameters, for what the
            model has not [N m]; see `misfit`.
        delays: by joint, how late its torque is logged, which was taken out [s].
        alone: relative error of held-out torques (all, where none are held out) by the calibrated description without
            its scene: without rotors, coupled motors, and what friction is beside viscous and Coulomb's.
        strength: of the prior, chosen by cross-validation; see `choose.strength`.
        cutoff: of the filter on both sides [Hz]; slip_speed: below which friction is smoothed [rad/s].
        consistent: whether every body that is shown can exist.
        unseen: bodies of which no torque of the log shows anything.
        rows: that were compared, of all joints; samples: rows of the logs.
        faults: torques that are exchanged or have the wrong sign, and units that are doubtful, a line each, which are
            among the warnings.
        warnings: one line each.
    """

    model: Model
    scene: Scene
    names: tuple[str, ...]
    described: Floats
    theta: Floats
    base: BaseFit
    motors: Mapping[str, MotorFit]
    coupled: Mapping[str, float]
    train: Errors
    held_out: Errors | None
    bound_train: Errors
    bound_held_out: Errors | None
    original_train: Errors
    original_held_out: Errors | None
    discrepancy: Mapping[str, float]
    delays: Mapping[str, float]
    alone: float
    strength: float
    cutoff: float
    slip_speed: float
    consistent: bool
    unseen: tuple[str, ...]
    rows: int
    samples: int
    duration: float
    hashes: Mapping[str, str]
    faults: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def explains(self) -> bool:
        """Whether less than half of held-out torques (of all, where none are held out) is left."""
        return (self.held_out or self.train).relative_error < _HALF

    @property
    def better(self) -> bool:
        """Whether held-out torques (all, where none are held out) are explained better than by the description
        and by zero."""
        new, old = self.held_out or self.train, self.original_held_out or self.original_train
        return new.relative_error < min(old.relative_error, 1.0)
