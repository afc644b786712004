"""Linear equations and their modes as JSON."""

from __future__ import annotations

from typing import Any

from robodyn.equations.linearized.linearized import Linearized
from robodyn.equations.linearized.modes import Mode
from robodyn.report.json.encode import finite, select, written


def linearized_json(found: Linearized) -> str:
    """Return A and B by rows, the state, and the modes; `stable` is null where it is not decided, see `verdict`."""
    state = select(
        found,
        "is_one:balanced coordinates:model.coordinates q rates:model.rates qd drive added:held",
    )
    return written(
        select(
            found,
            "robot states inputs A B step equilibrium modes stable verdict "
            "margin:modes.margin limits_exceeded:exceeded warnings",
            equilibrium=state,
            modes=list(map(_mode, found.modes.modes)),
        )
    )


def _mode(mode: Mode) -> dict[str, Any]:
    return select(
        mode,
        "frequency damping_ratio time_constant real imag error free alike shape shares",
        time_constant=finite(mode.time_constant),
        shape={"real": [x.real for x in mode.shape], "imag": [x.imag for x in mode.shape]},
    )
