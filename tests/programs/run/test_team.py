"""Threads that stand by: all who are called in time take part, and nobody touches a job that has ended."""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Iterator
from ctypes import CFUNCTYPE, c_int64, c_void_p, cast
from pathlib import Path
from threading import Barrier, Event
from time import sleep

import pytest
from helpers.compiled_programs import needs_compiler
from helpers.processes import python

from robodyn.programs.run import team as module
from robodyn.programs.run.team import Team

pytestmark = needs_compiler

ROBOT = Path(__file__).parents[3] / "robots" / "puma560.urdf"
SHARE = CFUNCTYPE(c_int64, c_void_p, c_int64)


@pytest.fixture
def team() -> Iterator[Team]:
    formed = Team()
    yield formed
    formed.leave()


def run(team: Team, threads: int, share: Callable[[int], object]) -> list[int]:
    """The numbers of those who took part in a job; they may come more than once."""
    came: list[int] = []

    def counted(_: int, number: int) -> int:
        came.append(number)
        share(number)
        return 0

    function = SHARE(counted)
    job = array("q", [cast(function, c_void_p).value or 0])
    team(job.buffer_info()[0], threads)
    return came


def until(ready: Callable[[], bool]) -> None:
    """Waits for it, for ten seconds at most."""
    for _ in range(10_000):
        if ready():
            return
        sleep(1e-3)
    raise AssertionError("it does not come about")


def asleep(team: Team) -> bool:
    return all(member._asleep for member in team._members)


@pytest.mark.parametrize("sleeps", [False, True])
def test_all_take_part_awake_or_not(sleeps, team):
    for threads in (1, 2, 3, 5, 2):
        met: set[int] = set()
        barrier = Barrier(threads)

        def once(number: int, met: set[int] = met, barrier: Barrier = barrier) -> None:
            if number < barrier.parties and number not in met:
                met.add(number)
                barrier.wait(10)

        run(team, threads, once)
        assert len(met) == threads
        until(lambda: not sleeps or asleep(team))


@pytest.mark.parametrize("patience", [0, module.PATIENCE])
def test_those_inside_are_waited_for(patience, team, monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", patience)
    inside, done = Event(), []

    def slow(number: int) -> None:
        if number == 0:
            assert inside.wait(10)
        else:
            inside.set()
            sleep(0.05)
            done.append(number)

    run(team, 2, slow)
    assert done


def test_those_who_are_late_are_not_waited_for_and_find_nothing(team, monkeypatch):
    run(team, 3, lambda number: None)
    until(lambda: asleep(team))
    with monkeypatch.context() as patch:
        patch.setattr(module._Member, "call", lambda member: None)
        came = run(team, 3, lambda number: None)
        assert came == [0]
    for member in team._members:
        member._awake.set()
    until(lambda: not any(member._awake.is_set() for member in team._members))
    until(lambda: asleep(team))
    assert came == [0]


def test_a_call_within_a_call_works_alone(team):
    within: list[int] = []

    def outer(number: int) -> None:
        if number == 0:
            within.extend(run(team, 3, lambda other: None))

    run(team, 3, outer)
    assert within == [0]


def test_threads_leave(team):
    run(team, 4, lambda number: None)
    threads = [member._thread for member in team._members]
    team.leave()
    assert len(threads) == 3
    assert not any(thread.is_alive() for thread in threads)
    assert 0 in run(team, 2, lambda number: None)


def test_a_fork_has_a_team_of_its_own():
    assert module._team_of(-1) is module._team_of(-1)
    assert module._team_of(-1) is not module._team_of(-2)
    assert module.the_team() is module._team_of(os.getpid())


TWO_THREADS = """
import numpy as np, os, robodyn, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # of a fork where threads run
model = robodyn.load({robot!r})
q = np.random.default_rng(0).uniform(-1, 1, (50_000, model.n))
def torques(): return robodyn.inverse_dynamics(model, q, q, q, executor="compiled", threads=2)
before = torques()
child = os.fork() if {fork} else 1
assert (torques() == before).all()
if child == 0: os._exit(0)
assert not {fork} or os.waitpid(child, 0)[1] == 0
"""


@pytest.mark.parametrize("fork", [False, True])
def test_a_process_ends_with_threads_standing_by(fork):
    if fork and not hasattr(os, "fork"):
        pytest.skip("this system does not fork")
    code = TWO_THREADS.format(robot=str(ROBOT), fork=fork)
    assert python(code).stderr == ""
