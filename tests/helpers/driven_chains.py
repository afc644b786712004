"""Motions of the closed chains of robots/ with all their coordinates, and the drive torques of virtual work."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import robodyn
from helpers import robot_mechanisms
from helpers.jets import Jet
from helpers.robot_files import FOLDER
from helpers.virtual_work import Mechanism, Place, torques
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene

MIDDLE: dict[str, tuple[tuple[float, float], ...]] = {
    "crank_slider": ((0.7, 3.0),),
    "four_bar": ((0.1, 1.0),),
    "five_bar": ((0.1, 0.5), (-0.1, 0.4)),
    "delta": ((0.02, 0.1), (-0.01, 0.1), (-0.42, 0.05)),
    "planar_3rrr": ((0.01, 0.05), (-0.01, 0.05), (0.05, 0.2)),
}
"""By robot and coordinate: middle and swing of its motion."""
SCENES = {
    "crank_slider": "crank_slider_turn",
    "four_bar": "four_bar_lift",
    "five_bar": "five_bar_reach",
    "delta": "delta_pick",
    "planar_3rrr": "planar_3rrr_circle",
}


@dataclass(frozen=True)
class Chain:
    """A closed chain along a motion; arrays are (samples, n), in the order of the model's coordinates."""

    name: str
    u: tuple[Jet, ...]

    @cached_property
    def model(self) -> Model:
        return robodyn.load(FOLDER / f"{self.name}.urdf")

    @cached_property
    def scene(self) -> Scene:
        """That of robots/, without friction."""
        return replace(robodyn.load_scene(FOLDER / f"{SCENES[self.name]}.toml"), friction={})

    @cached_property
    def place(self) -> Place:
        return self.mechanism(self.u)

    @property
    def mechanism(self) -> Mechanism:
        found: Mechanism = getattr(robot_mechanisms, self.name)
        return found

    @cached_property
    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q, qd, qdd of all joints."""
        parts: tuple[Callable[[Jet], object], ...] = (lambda q: q.x, lambda q: q.v, lambda q: q.a)
        names, count = self.model.joint_names, len(np.asarray(self.u[0].x))
        q, qd, qdd = (
            np.column_stack([np.broadcast_to(part(self.place.joints[name]), count) for name in names])  # type: ignore[call-overload]
            for part in parts
        )
        return q, qd, qdd

    @cached_property
    def torques(self) -> np.ndarray:
        """(samples, n) of virtual work, 0 at joints that nothing drives."""
        return self.torques_with({})

    def torques_with(self, taken: Mapping[str, np.ndarray]) -> np.ndarray:
        """As `torques`, of joints at which friction, springs and rotors take (samples,) N m or N."""
        found = torques(self.mechanism, self.u, taken)
        return np.column_stack([found.get(name, 0 * self.u[0].x) for name in self.model.joint_names])


def still(name: str, samples: int = 20, seed: int = 0) -> Chain:
    """At random places, without speed or acceleration."""
    u = _drawn(name, samples, seed)
    return Chain(name, tuple(Jet(x.x, 0 * x.v, 0 * x.a) for x in u))


def moving(name: str, samples: int = 20, seed: int = 0) -> Chain:
    """At random places with random speeds and accelerations."""
    return Chain(name, _drawn(name, samples, seed))


def swinging(name: str, times: np.ndarray) -> Chain:
    """Along `middle + swing sin(w t + phase)`, another w and phase for each coordinate."""
    parts = []
    for k, (middle, swing) in enumerate(MIDDLE[name]):
        w = 3.0 + k
        s, c = np.sin(w * times + k), np.cos(w * times + k)
        parts.append(Jet(middle + 0.8 * swing * s, 0.8 * swing * w * c, -0.8 * swing * w * w * s))
    return Chain(name, tuple(parts))


def _drawn(name: str, samples: int, seed: int) -> tuple[Jet, ...]:
    rng = np.random.default_rng(seed)
    return tuple(
        Jet(middle + swing * rng.uniform(-1, 1, samples), *(swing * rng.normal(size=(2, samples)) * [[5.0], [40.0]]))
        for middle, swing in MIDDLE[name]
    )
