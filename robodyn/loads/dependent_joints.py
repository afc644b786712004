"""Blocks of a motion of which loops tell a part: completed, one after another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robodyn.dynamics.loops.position_continuation import Follow, Misfit, Whole
from robodyn.dynamics.plan import Plan
from robodyn.support.caveats import Caveat
from robodyn.trajectory.motion import Sampling, Trajectory


class Follower:
    """Completes the blocks of a motion whose scene has loops; the loops' mismatch is gathered on the way."""

    def __init__(self, plan: Plan, followed: Sequence[str] = (), file: str | None = None) -> None:
        """
        Args:
            plan: of a scene with loops. followed: joints without columns, as a reader or a trajectory has them.
            file: as messages name it.

        Raises:
            TrajectoryError: a joint is in no loop.
        """
        self._follow = Follow(plan, followed, file)
        self._rates = [*self._follow.branch.followed]

    @property
    def mismatch(self) -> tuple[Misfit, ...]:
        """The largest |phi|, |phi'| and |phi''| so far."""
        return self._follow.mismatch

    @property
    def notes(self) -> tuple[str, ...]:
        """Which of several branches was chosen, and what is open."""
        return self._follow.notes

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        """What makes the motion so far doubtful."""
        return self._follow.caveats

    def take(self, block: Trajectory) -> Trajectory:
        """Return a block with what follows in it, its accelerations with the error bars that theirs come of.

        Raises:
            TrajectoryError: see `Follow.take`.

        Accuracy: as `Follow.take`.
        """
        if not len(block):
            return replace(block, followed=())
        found = block.sampling
        bars = () if found is None else (found.off, found.noise)
        whole = self._follow.take(block.given_time, block.q, block.qd, block.qdd, bars, block.first_row)
        sampling = None if found is None else self._trusted(found, whole)
        return replace(block, q=whole.q, qd=whole.qd, qdd=whole.qdd, sampling=sampling, followed=())

    def _trusted(self, found: Sampling, whole: Whole) -> Sampling:
        """Return how far accelerations can be trusted; those that follow are open where any that they come of are."""
        off, noise = whole.bars
        off_squares, squares = found.off_squares.copy(), found.squares.copy()
        if self._rates:
            given = self._follow.branch.given
            is_open = bool((found.off_squares[given] > 0.0).any())
            off_squares[self._rates] = (off[:, self._rates] ** 2).sum(axis=0) if is_open else 0.0
            squares[self._rates] = (whole.qdd[:, self._rates] ** 2).sum(axis=0)
        return Sampling(off, noise, off_squares, squares, found.guessed)
