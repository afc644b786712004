"""What is the same for all trajectories of a batch, in a form that goes to other processes and machines."""

from __future__ import annotations

import threading
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path
from typing import Any

from robodyn.dynamics.momenta import View
from robodyn.robot.assemble import load
from robodyn.robot.model import Model
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import DEFAULT, Payload, Scene
from robodyn.support.libraries import code_digest, version_of

VERSION = f"{version_of('robodyn')}, code {code_digest(Path(__file__).parents[1], without='cli')[:12]}"
"""Of robodyn as this process has loaded it; the command line, which computes nothing, does not count."""


@dataclass(frozen=True)
class Setup:
    """Robot, scene and options.

    Attributes:
        robot, scene: the files' bytes, packed by zlib; the scene None where there is none.
        gravity: m/s^2, in place of the scene's; payloads: beside the scene's; base_held: something carries the base.
        reactions, sizing, momentum, explain: as for `torques`; reading: as for `read_motion`.
        executor: "numpy" or "compiled"; threads: of each process.
        version: of robodyn and its code, which all machines must have.
    """

    robot: bytes
    scene: bytes | None
    gravity: tuple[float, float, float] | None
    payloads: tuple[Payload, ...]
    reactions: bool
    sizing: bool
    momentum: View | None
    reading: Mapping[str, Any]
    explain: bool
    executor: str
    threads: int
    version: str = VERSION
    base_held: bool = False

    def loaded(self) -> tuple[Model, Scene]:
        """The robot and its scene, read once by each thread, which then has programs of its own."""
        if getattr(_KEPT, "setup", None) != self:
            scene = DEFAULT if self.scene is None else parse_scene(zlib.decompress(self.scene))
            scene = scene.changed(self.gravity, self.payloads, held=self.base_held)
            _KEPT.robot = load(zlib.decompress(self.robot), moving_base=scene.moving_base), scene
            _KEPT.setup = self
        robot: tuple[Model, Scene] = _KEPT.robot
        return robot

    def digest(self, path: str) -> str:
        """A hash of everything that the results of a trajectory depend on: its bytes, robot, scene, options, version.

        Raises:
            OSError: the file cannot be read.
        """
        scene = None if self.scene is None else zlib.decompress(self.scene)
        same = replace(self, robot=zlib.decompress(self.robot), scene=scene, threads=1)
        hashed = blake2b(repr(same).encode(), digest_size=20)
        with open(path, "rb") as stream:
            while piece := stream.read(1 << 20):
                hashed.update(piece)
        return hashed.hexdigest()


_KEPT = threading.local()
