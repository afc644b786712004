"""Other programs, of the extra `test-peers`: each is imported by the test that uses it, which is skipped without it."""

from __future__ import annotations

from typing import Any

import pytest

from robodyn.support.extras import available

_ABSENT = '{} is not installed (pip install ".[test-peers]")'

needs_peers = pytest.mark.skipif(
    not all(map(available, ("pinocchio", "mujoco", "pydrake"))), reason=_ABSENT.format("one of the other programs")
)
"""For tests that compare with all of them."""


def peer(module: str) -> Any:
    """Return a module of another program; the test that asks for one that is not installed is skipped."""
    return pytest.importorskip(module, reason=_ABSENT.format(module))


class _Peer:
    """A module that is imported when something of it is used."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return getattr(peer(self._module), name)


pin, mujoco = _Peer("pinocchio"), _Peer("mujoco")
