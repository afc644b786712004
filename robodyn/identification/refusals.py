"""Logs that tell too little, or twice the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.errors import InputError
from robodyn.identification.base import base_of
from robodyn.identification.filters import PERIODS
from robodyn.identification.gather import Gathered
from robodyn.identification.log import Log
from robodyn.identification.rows import POSITIONS
from robodyn.identification.structure import Structure, counts, system
from robodyn.robot.model import Model

_LEAST = 2
"""Rows for each base parameter."""
_JOINTS = 30
_FOLDS = 2
"""With rows in them, so that what one leaves out is told by another."""


def check_size(model: Model) -> None:
    """Raise if a robot has so many joints that fits would take longer than minutes."""
    if model.n > _JOINTS:
        what = (
            f"{model.name} has {model.n} joints, and identify fits at most {_JOINTS} together: time grows as their cube"
        )
        raise InputError(what, remedy="describe and log its limbs one by one")


def check_files(logs: Sequence[Log], cutoff: float) -> None:
    """Raise if a log is given twice, of which standard errors would know nothing, or the filter passes everything."""
    seen: dict[str, str] = {}
    for log in logs:
        if log.sha256 in seen:
            what = f"has the same content as {seen[log.sha256]}"
            raise InputError(what, remedy="give each log once, and validate by another", file=log.path)
        seen[log.sha256] = log.path
        if log.noisy and POSITIONS * cutoff * (log.stop - log.start) < 2.0 * PERIODS:
            what = f"a filter of {cutoff:g} Hz leaves 0 rows of {log.stop - log.start:.4g} s"
            raise InputError(what, remedy="choose a higher --cutoff", file=log.path)
        if cutoff >= 0.5 / log.step:
            what = f"a cutoff of {cutoff:g} Hz is above half the sampling rate, {0.5 / log.step:.4g} Hz"
            raise InputError(what, remedy="choose a lower --cutoff", file=log.path)


def check_rows(plain: Gathered, structure: Structure, logs: Sequence[Log], cutoff: float, holds: bool) -> None:
    """Raise if the filter leaves too few rows for the parameters, or none to hold out."""
    folds = len(plain.parts) - 1
    rows = int(counts(plain, range(folds)).sum())
    R, _ = system(plain, range(folds), structure, np.ones(len(plain.atoms.measured)))
    rank = base_of(R, structure.names).rank if rows else len(structure.names)
    told = sum(bool(counts(plain, [fold]).any()) for fold in range(folds))
    if rows < _LEAST * rank or told < _FOLDS:
        what = f"a filter of {cutoff:.3g} Hz leaves {rows} rows to fit {rank} parameters to"
        raise InputError(what, remedy="give a longer log, a higher --cutoff or a larger --split", file=logs[0].path)
    if holds and not counts(plain, [folds]).all():
        what = f"a filter of {cutoff:.3g} Hz leaves nothing of what is held out"
        raise InputError(what, remedy="give a longer log, a higher --cutoff, or --split 1", file=logs[-1].path)
