"""Random samples: the same numbers for every executor, in the layout that is asked for, within memory."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot

from robodyn.errors import InputError
from robodyn.measure.speed.executors import MEMORY, laid_out, random_sources
from robodyn.scene.parts import ExternalWrench
from robodyn.scene.scene import Scene

PUSHED = Scene(wrenches=(ExternalWrench("upper_link", ("fx", 0.0, "fz")),))


def test_shapes_and_range():
    model = robot("scara")
    sources = random_sources(model, PUSHED, 1000)
    assert {name: values.shape for name, values in sources.items()} == {
        "q": (1000, 3),
        "qd": (1000, 3),
        "qdd": (1000, 3),
        "columns": (1000, 2),
    }
    assert all(values.dtype == np.float64 and values.flags.f_contiguous for values in sources.values())
    assert {name: round(np.abs(values).max(), 1) for name, values in sources.items()} == {
        "q": 2.0,
        "qd": 3.0,
        "qdd": 3.0,
        "columns": 3.0,
    }


@pytest.mark.parametrize(("name", "moving"), [("scara", False), ("rigid_body", True)])
def test_single_precision_holds_them_exactly(name, moving):
    sources = random_sources(robot(name, moving), Scene(moving_base=moving), 100)
    for values in sources.values():
        assert np.array_equal(values.astype(np.float32), values)


def test_quaternions_have_unit_length():
    q = random_sources(robot("rigid_body", True), Scene(moving_base=True), 100)["q"]
    assert np.abs(np.linalg.norm(q[:, 3:7], axis=1) - 1.0).max() <= 2 * np.finfo(np.float32).eps
    assert np.abs(q[:, :3]).max() > 1.0


def test_layouts_hold_the_same_numbers():
    sources = random_sources(robot("scara"), Scene(), 50)
    for dtype in (np.float64, np.float32):
        columns, rows = laid_out(sources, "F", dtype), laid_out(sources, "C", dtype)
        for name in ("q", "qd", "qdd"):
            assert columns[name].flags.f_contiguous
            assert rows[name].flags.c_contiguous
            assert np.array_equal(columns[name], sources[name])
            assert np.array_equal(rows[name], sources[name])


def test_more_than_memory_is_refused_before_it_is_taken():
    with pytest.raises(InputError, match=r"1000000000 samples of 3 joints take 288 GB") as caught:
        random_sources(robot("scara"), Scene(), 10**9)
    fitting = int(str(caught.value).partition("--samples ")[2].partition(" ")[0])
    assert 0.99 * MEMORY < fitting * 24 * 12 <= MEMORY
