"""What commands print as text is the same on other kinds of processor; the numbers of JSON agree."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.processes import python
from helpers.robot_catalogue import names

WRITTEN = (
    "torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml --reactions --sizing "
    "--momentum --executor numpy --out OUT/tau.npz",
    "torques robots/puma.urdf robots/puma_encoder.csv --executor numpy --out OUT/encoder.npz",
)
"""Of the second accelerations are derived, which divides rounding by the squared time between samples, 1e-6 here."""


def old_processor() -> dict[str, str]:
    """Return what makes NumPy and OpenBLAS do without AVX2 and fused multiply-add, and machine code without AVX-512.

    The test is skipped where this processor has none of them.
    """
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
    except ImportError:  # NumPy 1
        from numpy.core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    present = [feature for feature in __cpu_dispatch__ if __cpu_features__.get(feature)]
    if not __cpu_features__.get("AVX2"):
        pytest.skip("this processor has no AVX2 to do without")
    features = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": " ".join(present)}
    return {**features, "ROBODYN_CPU": "x86-64-v3", "OPENBLAS_NUM_THREADS": "1"}


TESTS = Path(__file__).parent.parent
TEXT = """
info robots/meshed_arm.urdf
check robots
inertia robots/meshed_arm.urdf --compare
inertia robots/meshed_arm.urdf --at elbow=0.5
inertia robots/meshes/bracket.stl --unit mm --density 2700
inertia robots/meshes/twisted_block.stl --density 2700
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_motors.toml --explain
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml
fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.2
"""
JSON = """
torques robots/scara.urdf robots/scara_pick_and_place.csv
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml --sizing --momentum
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_uncertain.toml
check robots/scara.urdf --trajectory robots/scara_pick_and_place.csv
torques robots/crank_slider.urdf robots/crank_slider_turn.csv --scene robots/crank_slider_turn.toml
torques robots/planar_3rrr.urdf robots/planar_3rrr_circle.csv --scene robots/planar_3rrr_circle.toml --sizing
torques robots/quadruped.urdf robots/quadruped_trot.csv --scene robots/quadruped_trot.toml
fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
equations robots/two_link_planar.urdf --form closed
linearize robots/puma.urdf --scene robots/puma_servo.toml --equilibrium --step 0.001
linearize robots/four_bars.urdf --scene robots/four_bars_a02.toml
excite robots/puma.urdf
inertia robots/meshed_arm.urdf --compare
inertia robots/meshed_arm.urdf --at elbow=0.5
inertia robots/meshes/bracket.stl --unit mm --rpy 0.3,0.2,0.1 --about 0.1,0.2,0.3
inertia robots/meshes/cross.stl --unit mm --symmetrize
inertia robots/meshes/bracket.stl robots/meshes/hub.stl --unit mm --combine --place 1,2,3,.3,.2,.1 --place 0,0,1,1,0,.4
simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.1
simulate robots/satellite.urdf --scene robots/satellite_deploy.toml --duration 0.1
simulate robots/puma560.urdf --scene robots/puma560_power_cut.toml --duration 0.1
"""
OF_A_ROBOT = ("info", "check", "inertia", "fbd", "equations", "equations --form dae", "simulate --duration 0.02")
REAL = ("panda",)
CODE = f"""
import json, os, sys
sys.path.insert(0, {str(TESTS)!r})
os.chdir({str(TESTS.parent)!r})
from helpers.command_line import run
outputs = []
for command in json.loads(sys.stdin.read()):
    done = run(*command.split())
    outputs.append([command, done.status, done.out, done.err])
print(json.dumps(outputs))
"""


def _commands() -> Iterator[str]:
    """Yield what is typed: text, and JSON of every command over a fifth of the project's robots and a real one."""
    yield from TEXT.strip().split("\n")
    robots = [*(f"robots/{name}.urdf" for name in names()[::5]), *(str(path_of(stem)) for stem in REAL)]
    meshes = sorted((TESTS.parent / "robots" / "meshes").glob("*.stl"))
    lines = [*JSON.strip().split("\n"), *(f"{command} {robot}" for robot in robots for command in OF_A_ROBOT)]
    lines += [f"inertia {mesh} --unit mm" for mesh in meshes] + [f"inertia {path_of('panda')} --compare"]
    yield from (f"{line} --format json" for line in lines)


def _outputs(commands: list[str], changes: dict[str, str]) -> list[list[Any]]:
    found: list[list[Any]] = json.loads(python(CODE, stdin=json.dumps(commands), **changes).stdout)
    return found


def _agree(one: Any, other: Any) -> bool:
    """Whether values are the same, floats within 1e-12 of the largest of their list, of themselves or of 1."""
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(_agree(one[k], other[k]) for k in one)
    if isinstance(one, list):
        if not isinstance(other, list) or len(one) != len(other):
            return False
        if one and all(isinstance(each, float) for each in (*one, *other)):
            scale = max(1.0, *map(abs, one))
            return all(abs(a - b) <= 1e-12 * scale for a, b in zip(one, other, strict=True))
        return all(map(_agree, one, other))
    if isinstance(one, float) and isinstance(other, (int, float)):
        return abs(one - other) <= 1e-12 * max(1.0, abs(one))
    return bool(one == other)


def _same(one: list[Any], found: list[Any]) -> bool:
    """Whether outputs are: text to the letter, the numbers of JSON as `_agree` has it."""
    if [*one[:2], one[3]] != [*found[:2], found[3]]:
        return False
    if "json" in one[0] and one[2]:
        return _agree(json.loads(one[2]), json.loads(found[2]))
    return bool(one[2] == found[2])


@pytest.mark.slow
def test_an_old_processor_prints_the_same_and_writes_what_agrees(tmp_path: Path) -> None:
    found = []
    for name, changes in (("here", {}), ("there", old_processor())):
        (tmp_path / name).mkdir()
        texts = _outputs([command.replace("OUT", str(tmp_path / name)) for command in WRITTEN], changes)
        found.append(json.dumps([each[1:] for each in texts]).replace(str(tmp_path / name), "OUT"))
    assert found[0] == found[1]
    for file, within in (("tau.npz", 1e-12), ("encoder.npz", 1e-9)):
        here, there = (np.load(tmp_path / name / file) for name in ("here", "there"))
        assert list(here) == list(there)
        for name in here:
            assert np.abs(here[name] - there[name]).max() <= within * max(np.abs(here[name]).max(), 1e-3), name


@pytest.mark.slow
def test_output_is_the_same() -> None:
    with ThreadPoolExecutor(2) as pool:
        expected, found = pool.map(partial(_outputs, [*_commands()]), ({}, old_processor()))
    assert sum(status == 0 for _, status, *_ in expected) > 0.8 * len(expected)
    assert [one[0] for one, other in zip(expected, found, strict=True) if not _same(one, other)] == []
