"""How much work something is, whatever the machine: the calls that it makes."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from types import FrameType
from typing import Any


def calls(work: Callable[[], object]) -> Counter[object]:
    """How often each function of Python, by its code, and of C is called; each step of a generator is a call."""
    found: Counter[object] = Counter()

    def profile(frame: FrameType, event: str, argument: Any) -> None:
        if event in ("call", "c_call"):
            found[frame.f_code if event == "call" else argument.__qualname__] += 1

    before = sys.getprofile()
    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(before)
    return found
