"""Figures drawn by processes beside this one are those that it draws itself, and none is lost with a process."""

from __future__ import annotations

import math
import os
import sys
from functools import partial

import pytest
from helpers.dying_workers import at_home
from helpers.oracles import ROBOTS, robot

from robodyn.loads.torques import torques
from robodyn.report.drawing import at_once, beside
from robodyn.report.torques_page import torques_page
from robodyn.scene.scene import DEFAULT


def test_pages_are_the_same() -> None:
    model = robot("puma560")
    result = torques(model, ROBOTS / "puma560_sweep.csv", history=True)
    with beside() as draw:
        there = torques_page(result, model, DEFAULT, draw=draw)
    assert there == torques_page(result, model, DEFAULT)


def test_what_a_process_raises_is_raised() -> None:
    with beside() as draw, pytest.raises(ValueError, match=r"math domain error|nonnegative"):
        draw([partial(math.sqrt, -1.0)])[0]()


def test_work_of_a_process_that_ends_is_done_here() -> None:
    home = os.getpid()
    with beside() as draw:
        assert draw([os.getpid])[0]() != home
        waiting = draw([partial(at_home, home, k) for k in range(3)])
        assert [each() for each in waiting] == [0, 1, 2]
        assert draw([partial(at_home, home, 7)])[0]() == 7
    assert at_once([partial(at_home, home, 4)])[0]() == 4


def test_tasks_are_parted() -> None:
    """Each is done once, by processes that are not the first of those beside this one."""
    with beside() as draw:
        first, second = (draw([os.getppid, os.getppid])[k]() for k in range(2))
    assert os.getpid() not in (first, second)
    assert (first == second) == (sys.platform == "linux")
