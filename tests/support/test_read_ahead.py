"""Reading ahead and writing behind: order, errors and early ends are those of plain loops."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from robodyn.support.threads import prefetch, write_behind


def counted(stop: int, made: list[int]) -> Iterator[int]:
    for i in range(stop):
        made.append(i)
        yield i


def test_ahead_gives_the_same_items_in_order_and_what_they_raise() -> None:
    def failing() -> Iterator[int]:
        yield 1
        raise ValueError("second")

    assert list(prefetch(iter(range(100)))) == list(range(100))
    assert list(prefetch(iter(()))) == []
    items = prefetch(failing())
    assert next(items) == 1
    with pytest.raises(ValueError, match="second"):
        next(items)


def test_ahead_holds_few_items_and_ends_its_thread_when_it_is_left_early() -> None:
    made: list[int] = []
    before = threading.active_count()
    items = prefetch(counted(1000, made))
    assert next(items) == 0
    items.close()  # type: ignore[attr-defined]
    assert threading.active_count() == before
    assert len(made) <= 5


def test_behind_uses_everything_in_order_before_it_ends() -> None:
    used: list[int] = []
    with write_behind(used.append) as call:
        for i in range(100):
            call(i)
    assert used == list(range(100))


def test_behind_raises_a_failure_and_uses_nothing_after_it() -> None:
    used: list[int] = []

    def use(i: int) -> None:
        if i == 3:
            raise OSError("disk full")
        used.append(i)

    def run() -> None:
        with write_behind(use) as call:
            for i in range(100):
                call(i)

    with pytest.raises(OSError, match="disk full"):
        run()
    assert used == [0, 1, 2]
