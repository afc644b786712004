"""What `bench` says of a robot, apart from times: operations, agreement, and what there is where."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler
from helpers.example_robots import real
from helpers.oracles import ROBOTS, robot
from helpers.peers import needs_peers

from robodyn.dynamics.balance import energy, laws
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.measure.speed import executors as bench_executors
from robodyn.measure.speed import peers as bench_peers
from robodyn.measure.speed import run as module
from robodyn.measure.speed.result import Timing
from robodyn.measure.speed.run import bench
from robodyn.programs.run.llvm.machine import Compiler
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene

MISSING = "llvmlite is not installed; pip install llvmlite"
SAMPLES = 300
EPS = {"float64": np.finfo(np.float64).eps, "float32": np.finfo(np.float32).eps}


def without_compiler(monkeypatch):
    for each in (module, bench_executors, bench_peers):
        monkeypatch.setattr(each, "compiler", lambda: Compiler(MISSING, None))


def motors():
    return robot("puma560"), load_scene(ROBOTS / "puma560_motors.toml")


def test_operations_are_those_of_the_plan():
    model, scene = motors()
    found = bench(model, scene, samples=SAMPLES)
    whole = plan(model, scene)
    rest = frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))
    assert (found.robot, found.joints, found.samples, found.gravity) == ("puma560", 6, SAMPLES, scene.gravity)
    assert found.operations == whole.torques().size
    assert found.operations_at_rest == plan(model, scene, rest).torques().size < found.operations
    assert [each.report.name for each in found.effects] == [effect.name for effect in whole.effects]
    for each, effect in zip(found.effects, whole.effects, strict=True):
        assert each.report.operations == whole.share(effect).size
        assert each.report.saved == found.operations - whole.without(effect).size


def test_programs():
    model, scene = motors()
    whole = plan(model, scene)
    found = {each.name: each for each in bench(model, scene, samples=SAMPLES).programs}
    expected = {
        "torques and joint wrenches": whole.wrenches(True),
        "bias forces": plan(model, scene, frozenset(("qdd", i) for i in range(6))).torques(),
        "energy and losses": energy(whole),
        "momentum laws": laws(whole),
    }
    assert list(found) == [*list(expected)[:2], "mass matrix", *list(expected)[2:]]
    for name, program in expected.items():
        assert (found[name].operations, found[name].outputs) == (program.size, len(program.outputs))
    assert found["mass matrix"].outputs == mass_matrix(model, np.zeros(6)).size
    assert all(each.trace > 0.0 for each in found.values())


@needs_compiler
@pytest.mark.parametrize(("name", "moving"), [("gripper", False), ("rigid_body", True), ("puma560", False)])
def test_executors_agree(name, moving):
    found = bench(robot(name, moving), Scene(moving_base=moving), samples=SAMPLES, threads=2)
    assert [(each.name, each.dtype) for each in found.executors] == [
        ("numpy", "float64"),
        ("compiled", "float64"),
        ("compiled float32", "float32"),
    ]
    assert found.executors[0].difference == 0.0
    for each in found.executors[1:]:
        assert 0.0 < each.difference <= 8 * EPS[each.dtype]
    assert found.problem is None


@needs_compiler
def test_what_is_measured_of_which_executor():
    numpy, compiled, single = bench(robot("scara"), samples=SAMPLES, threads=3).executors
    assert numpy.load is numpy.columnar_threads is numpy.row_major_threads is None
    for each in (compiled, single):
        times = (each.build, each.load, each.columnar, each.row_major, each.columnar_threads, each.row_major_threads)
        assert all(isinstance(time, Timing) and time.runs >= 1 and 0 < time.least <= time.median for time in times)


@needs_compiler
def test_one_thread_has_no_row_for_many():
    found = bench(robot("scara"), samples=SAMPLES, threads=1)
    assert found.threads == 1
    assert found.copying.all is None
    assert all(each.columnar_threads is each.row_major_threads is None for each in found.executors)


@needs_compiler
def test_bytes_are_those_of_the_columns_that_are_read_and_written():
    """The shoulder's angle of a SCARA about the vertical is nowhere needed."""
    found = bench(robot("scara"), samples=SAMPLES)
    read = len(plan(robot("scara"), Scene()).torques().inputs)
    assert read < 9
    assert [each.bytes for each in found.executors] == [8 * (read + 3), 8 * (read + 3), 4 * (read + 3)]
    assert found.copying.bytes == found.executors[0].bytes
    for each in found.executors:
        speed, of_copying = each.bytes / each.columnar.least, found.copying.bytes / found.copying.one.least
        assert each.of_copying == pytest.approx(speed / of_copying, rel=1e-12)


@needs_compiler
def test_large_results_are_of_fewer_samples(monkeypatch):
    monkeypatch.setattr(module, "LARGEST_RESULT", 8 * 9 * 50)
    found = {each.name: each.samples for each in bench(robot("scara"), samples=SAMPLES).programs}
    assert found["mass matrix"] == 50
    assert found["bias forces"] == 150


@needs_peers
def test_without_a_compiler(monkeypatch):
    without_compiler(monkeypatch)
    found = bench(robot("scara"), samples=SAMPLES, peers=True)
    assert [each.name for each in found.executors] == ["numpy"]
    assert found.problem == MISSING
    assert found.whole is None
    assert all(each.without is None and each.report.operations >= 0 for each in found.effects)
    assert all(each.build is each.compiled is each.samples is None for each in found.programs)
    assert found.peers.executor == "numpy"
    assert all(peer.difference <= 5e-15 for peer in found.peers.peers)


def test_without_a_cache(monkeypatch):
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    assert all(each.load is None for each in bench(robot("scara"), samples=SAMPLES).executors)


def test_peers_are_there_when_asked_for():
    assert bench(robot("scara"), samples=5).peers is None
    assert bench(robot("scara"), samples=5, peers=True).peers is not None


def test_it_tells_what_it_measures():
    told = []
    bench(robot("scara"), samples=5, watch=told.append)
    assert told[:2] == ["executors", "effects"]
    assert told[-1] == "programs"


@pytest.mark.parametrize("wrong", [partial(bench, real("iris_simple")), partial(bench, robot("composite"))])
def test_a_robot_without_joints(wrong):
    with pytest.raises(InputError, match=r"nothing can move: the robot has no joint that moves"):
        wrong()


def test_a_wrong_number_of_threads():
    with pytest.raises(InputError, match="0 threads cannot work"):
        bench(robot("scara"), samples=5, threads=0)


def test_torques_that_overflow():
    with pytest.raises(InputError, match="the torques of some samples overflow"):
        bench(robot("puma"), Scene(gravity=(0.0, 0.0, 1.7e308)), samples=SAMPLES)


@needs_compiler
def test_single_precision_that_overflows():
    found = bench(robot("puma"), Scene(gravity=(0.0, 0.0, 1e50)), samples=SAMPLES)
    assert [each.difference is None for each in found.executors] == [False, False, True]
