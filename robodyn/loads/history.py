"""What plots need of a motion, in bounded memory: in every span of time the samples where a quantity is extreme."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

SPANS = 400  # spans of time that a motion is divided into, about one for each pixel of a plot
_ROOM = 1.3  # so many times SPANS may be in use: the duration is an estimate until the motion has ended


@dataclass(frozen=True, eq=False)
class Curves:
    """Samples of several columns, each with the same quantities. quantities: those that decide which samples are kept,
    then those that are kept with them. kept: (spans, 1 + quantities, columns, 2 * deciding): time [s] and quantities,
    of the samples where each of the deciding ones is least, then of those where each is greatest."""

    names: tuple[str, ...]
    quantities: tuple[str, ...]
    kept: Floats

    def line(self, quantity: str, column: int) -> tuple[Floats, Floats]:
        """Time and value of a quantity, its least and greatest sample of every span, in the order of time."""
        k = self.quantities.index(quantity)
        half = self.kept.shape[3] // 2
        time, values = self.kept[:, [[0], [k + 1]], column, [[k, k + half]]].transpose(1, 0, 2)
        order = np.argsort(time, axis=1, kind="stable")
        time, values = (np.take_along_axis(each, order, axis=1).ravel() for each in (time, values))
        news = np.flatnonzero(np.append(True, np.diff(time) > 0.0))
        return time[news], values[news]

    def samples(self, column: int) -> dict[str, Floats]:
        rows = self.kept[:, :, column].transpose(1, 0, 2).reshape(1 + len(self.quantities), -1)
        rows = np.unique(rows, axis=1)
        return dict(zip(("time", *self.quantities), rows, strict=True))


@dataclass(frozen=True, eq=False)
class History:
    """The course of a motion. joints: of each joint speed, torque, power and acceleration; None without joints. energy:
    "work done" and "energy stored" since the start [J]. states: for each joint q, qd, qdd and columns at its peak
    torque. contacts: of each contact the force along its normal [N], and whether it is on; None without contacts."""

    joints: Curves | None
    base: Curves
    energy: Curves
    states: tuple[Mapping[str, Floats], ...]
    contacts: Curves | None = None


class MinMaxDecimation:
    """Gathers `Curves` block by block; spans double in length when there are too many of them."""

    def __init__(self, names: tuple[str, ...], quantities: tuple[str, ...], also: tuple[str, ...] = ()) -> None:
        """Args: quantities: that decide which samples are kept; also: those that are kept with them."""
        self.names, self.quantities, self._deciding = names, (*quantities, *also), len(quantities)
        self._start = self._width = 0.0
        self._kept: dict[int, Floats] = {}

    def update(self, time: Floats, values: tuple[Floats, ...], expected_duration: float) -> None:
        """Take in time (N,) and values (columns, N) of each quantity of a motion that goes on for about so long [s]."""
        if not self._kept:
            self._start, self._width = float(time[0]), expected_duration / SPANS or 1.0
        while (time[-1] - self._start) / self._width >= _ROOM * SPANS:
            before, self._kept, self._width = self._kept, {}, 2.0 * self._width
            for span, extreme in before.items():
                self._add(span // 2, extreme)
        spans = ((time - self._start) / self._width).astype(np.int64)
        begins = np.flatnonzero(np.append(True, np.diff(spans)))
        for first, last in zip(begins, [*begins[1:], len(time)], strict=True):
            part = (time[None, first:last], *(each[:, first:last] for each in values))
            self._add(int(spans[first]), _extreme(part, self._deciding))

    def curves(self) -> Curves:
        return Curves(self.names, self.quantities, np.stack([self._kept[span] for span in sorted(self._kept)]))

    def _add(self, span: int, extreme: Floats) -> None:
        if span in self._kept:
            both = np.concatenate((self._kept[span], extreme), axis=2)
            extreme = _extreme(tuple(both), self._deciding)
        self._kept[span] = extreme


def _extreme(samples: Sequence[Floats], deciding: int) -> Floats:
    """Of samples (columns or 1, N) of each of 1 + quantities those where one of the first quantities is least, then
    greatest: (1 + quantities, columns, 2 deciding)."""
    values = samples[1 : 1 + deciding]
    rows = np.stack([*(each.argmin(axis=1) for each in values), *(each.argmax(axis=1) for each in values)], axis=1)
    columns = np.arange(len(rows))[:, None]
    return np.stack([each[columns if len(each) > 1 else 0, rows] for each in samples])


class Recorder:
    def __init__(self, joints: tuple[str, ...], components: tuple[str, ...], contacts: tuple[str, ...] = ()) -> None:
        self.joints = MinMaxDecimation(joints, ("speed", "torque", "power"), ("acceleration",))
        self.base = MinMaxDecimation(components, ("load",))
        self.energy = MinMaxDecimation(("work done", "energy stored"), ("energy",))
        self.contacts = MinMaxDecimation(contacts, ("normal",), ("on",))

    def update(
        self,
        time: Floats,
        qd: Floats,
        qdd: Floats,
        tau: Floats,
        base: Floats,
        energy: Floats,
        rows: NDArray[np.int64],
        expected_samples: float,
        touch: tuple[Floats, Floats] | None = None,
    ) -> None:
        """Take in a block: qd, qdd, tau (joints, N) and base (components, N); energy: (2, k) work done and energy
        stored since the start [J], at these `rows`; expected_samples: how many may come, with these, by how many these
        are; touch: (contacts, N) forces along their normals [N], and where they are on."""
        expected_duration = float(time[-1] - time[0]) * expected_samples
        if len(tau):
            self.joints.update(time, (qd, tau, qd * tau, qdd), expected_duration)
        self.base.update(time, (base,), expected_duration)
        self.energy.update(time[rows], (energy,), expected_duration)
        if touch is not None:
            self.contacts.update(time, touch, expected_duration)

    def history(self, at_peak: Mapping[int, Mapping[str, Floats]]) -> History:
        states = tuple(at_peak[k] for k in range(len(at_peak)))
        joints, contacts = (each.curves() if each.names else None for each in (self.joints, self.contacts))
        return History(joints, self.base.curves(), self.energy.curves(), states, contacts)
