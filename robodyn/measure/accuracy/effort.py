"""Runs of a simulation whose cost is counted and not timed, and that end when the work allowed is done.

What is counted are evaluations of the equations of motion, at the rates of a typical machine: what is found and printed
then depends on the robot and its scene, not on the machine or on what else it does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

from robodyn.dynamics.plan import plan
from robodyn.programs.run.choice import CALL
from robodyn.programs.run.llvm.machine import compiler
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import Equations
from robodyn.simulation.methods import Method, TooMuchError, method_named
from robodyn.simulation.result import Simulation
from robodyn.simulation.run import simulate
from robodyn.simulation.stiffness import with_friction

CODE = 2e-9
"""Seconds of machine code per operation, one step after another."""
SCIPY = 1e-4
"""Seconds that a method of SciPy takes per evaluation, beside the evaluation."""
ALLOWED = 20.0
"""Seconds of work on a typical machine that the search for an accuracy may take in all."""
CALLED = 1e-7
"""Seconds of machine code per evaluation, beside its operations."""
SHARES = 4
"""Ways among which the work is divided."""
FIRST = 5e4
"""Evaluations for the usual motion, which the search begins with."""


@dataclass(eq=False)
class Effort:
    """Runs of one simulation by methods and steps.

    Attributes:
        duration: s; None for the usual one.
        given: what else `simulate` takes.
        left: seconds of work that are left; floor: what the others of the ways that are tried shall find.
        steps: done so far.
    """

    model: Model
    scene: Scene
    duration: float | None
    given: dict[str, Any]
    left: float = field(default_factory=lambda: ALLOWED)
    floor: float = 0.0
    steps: int = 0

    @cached_property
    def _run(self) -> Callable[..., Simulation]:
        return partial(simulate, self.model, self.scene, self.duration, **self.given)

    @cached_property
    def _evaluation(self) -> float:
        """Seconds of work for the equations of motion once."""
        size = Equations(plan(self.model, with_friction(self.model, self.scene)[0])).derivatives().size
        interpreted = self.given.get("executor") == "numpy" or bool(compiler().problem)
        return CALLED + size * (CALL if interpreted else CODE)

    def cost(self, method: Method) -> float:
        """Return seconds of work per evaluation."""
        return self._evaluation + (SCIPY if method.adaptive else 0.0)

    def work(self, motion: Simulation) -> float:
        """Return seconds of work of a motion."""
        return motion.evaluations * self.cost(motion.method)

    def is_stiff(self) -> bool:
        """Return whether the motion, made as it is without an accuracy, asks for an implicit method.

        Raises:
            InputError: no method can do it.
        """
        try:
            return self._counted(self._run(most=FIRST)).method.name == "radau"
        except TooMuchError as error:
            self.left -= FIRST * SCIPY if error.time else 0.0
            return error.time > 0.0

    @property
    def share(self) -> float:
        """Seconds of work for each way."""
        return ALLOWED / SHARES

    def next_way(self, share: float) -> None:
        """Give another way so many seconds of work, or what is left."""
        self.floor = max(self.left - share, 0.0)

    def run(self, name: str, **options: Any) -> Simulation:
        """Return the motion by a method, with this step or tolerance.

        Raises:
            TooMuchError: it takes more than what is left of the way's share.
            InputError: the method does not get through.
        """
        cost = self.cost(method_named(name))
        most = int(max(self.left - self.floor, 0.0) / cost)
        try:
            return self._counted(self._run(method=name, most=most, **options))
        except TooMuchError as error:
            self.left -= cost * most if error.time else 0.0
            raise

    def _counted(self, motion: Simulation) -> Simulation:
        self.left -= self.work(motion)
        self.steps += motion.steps
        return motion
