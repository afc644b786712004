"""Columns in which `simulate` writes what the loops of a closed chain carry."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from robodyn.statistics import COMPONENTS


def loops_in(columns: Sequence[str], joints: Collection[str]) -> list[str]:
    """Names of the loops whose wrenches are among some columns, as nothing but their names tells.

    A loop has all six of `fx_<loop>` to `mz_<loop>`. Those of joints may be what `torques --reactions` writes, which
    writes them for every joint; a loop that bears a joint's name is known by the joints that have none.

    Args:
        columns: that mean nothing to the robot.
        joints: of the robot.
    """
    there = set(columns)
    names = [column[3:] for column in columns if column.startswith(f"{COMPONENTS[0]}_")]
    whole = [name for name in names if there >= {f"{part}_{name}" for part in COMPONENTS}]
    reactions = set(joints) if set(joints) <= set(whole) else set()
    return [name for name in whole if name not in reactions]
