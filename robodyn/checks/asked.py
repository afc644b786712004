"""What a check is asked beyond the file itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from robodyn.errors import InputError
from robodyn.support.wording import alternatives, shown

TARGETS = ("mujoco", "drake", "gz", "kdl", "isaac")
"""The programs whose verdict is known; see `robodyn.checks.consumers`."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked.

    Attributes:
        targets: programs whose verdict RD901 gives.
        against: a git revision whose version of the file RD902 compares with.
        trajectory: a file with a motion along which RD802 holds the limits against the loads; reading: how it is read,
            as for `read_motion`.

    Raises:
        InputError: a target is not known.
    """

    targets: tuple[str, ...] = ()
    against: str | None = None
    trajectory: str | None = None
    reading: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for target in self.targets:
            if target not in TARGETS:
                raise InputError(f"there is no target {shown(target)}", remedy=alternatives(target, TARGETS, "targets"))


NOTHING = Asked()
