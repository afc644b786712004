"""What commands print as text is the same on other kinds of processor; the numbers of JSON agree."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from helpers.example_robots import path_of
from helpers.processes import python
from helpers.robot_catalogue import names

LINEAR_ALGEBRA = {"avx2": "Haswell", "prescott": "Prescott"}
"""The processor that OpenBLAS is to take this one for: with AVX2, and one of 2004 without fused multiply-add."""


def variables(name: str) -> dict[str, str]:
    """Return what makes NumPy, OpenBLAS and machine code do without AVX-512; nothing where it is not x86-64's."""
    import numpy as np

    inside = np._core if hasattr(np, "_core") else np.core
    core = inside._multiarray_umath

    present = {feature for feature, there in core.__cpu_features__.items() if there}
    if not {"AVX2", "FMA3"} <= present:
        return {}
    wide = [feature for feature in core.__cpu_dispatch__ if feature.startswith(("AVX512", "X86_V4"))]
    return {
        "OPENBLAS_CORETYPE": LINEAR_ALGEBRA[name],
        "NPY_DISABLE_CPU_FEATURES": ",".join(feature for feature in wide if feature in present),
        "ROBODYN_CPU": "x86-64-v3",
    }


TESTS = Path(__file__).parent.parent
TEXT = """
info robots/meshed_arm.urdf
check robots
inertia robots/meshed_arm.urdf --compare
inertia robots/meshed_arm.urdf --at elbow=0.5
inertia robots/meshes/bracket.stl --unit mm --density 2700
inertia robots/meshes/cross.stl --density 2700
inertia robots/meshes/twisted_block.stl --density 2700
inertia robots/meshes/worn_pad.stl --density 2700
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_motors.toml --explain
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml
fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.2
"""
JSON = """
torques robots/scara.urdf robots/scara_pick_and_place.csv
torques robots/satellite.urdf robots/satellite_slew.csv --scene robots/satellite.toml
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml --sizing --momentum
torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_uncertain.toml
check robots/scara.urdf --trajectory robots/scara_pick_and_place.csv
torques robots/crank_slider.urdf robots/crank_slider_turn.csv --scene robots/crank_slider_turn.toml
torques robots/planar_3rrr.urdf robots/planar_3rrr_circle.csv --scene robots/planar_3rrr_circle.toml --sizing
torques robots/quadruped.urdf robots/quadruped_trot.csv --scene robots/quadruped_trot.toml
fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
fbd robots/puma560.urdf --traj robots/puma560_sweep.csv --time 0.5
equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
equations robots/two_link_planar.urdf --form closed
linearize robots/puma.urdf --scene robots/puma_servo.toml --equilibrium --step 0.001
linearize robots/four_bars.urdf --scene robots/four_bars_a02.toml
excite robots/puma.urdf
inertia robots/meshed_arm.urdf --compare
inertia robots/meshed_arm.urdf --at elbow=0.5
inertia robots/meshes/bracket.stl --unit mm --rpy 0.3,0.2,0.1 --about 0.1,0.2,0.3
inertia robots/meshes/bracket.stl --unit mm --shell 0.001
inertia robots/meshes/cross.stl --unit mm --symmetrize
inertia robots/meshes/bracket.stl robots/meshes/hub.stl --unit mm --combine --place 1,2,3,.3,.2,.1 --place 0,0,1,1,0,.4
simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.1
simulate robots/four_bars.urdf --scene robots/four_bars_a02.toml --duration 0.1
simulate robots/satellite.urdf --scene robots/satellite_deploy.toml --duration 0.1
simulate robots/puma560.urdf --scene robots/puma560_power_cut.toml --duration 0.1
simulate robots/composite.urdf --scene robots/composite_throw.toml --duration 0.1
simulate robots/heavy_top.urdf --scene robots/heavy_top_steady.toml --duration 0.1
accuracy robots/meshes/bracket.stl
"""
OF_A_ROBOT = ("info", "check", "inertia", "fbd", "equations", "equations --form dae", "simulate --duration 0.02")
REAL = ("ur5_robot", "anymal", "panda")
MEASURED = ("time", "front", "cheapest", "dominated_by")
"""Keys of `accuracy` whose values follow from how long a computation took."""
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
    """Yield what is typed: text, and JSON of every command over half of the project's robots and some real ones."""
    yield from TEXT.strip().split("\n")
    robots = [*(f"robots/{name}.urdf" for name in names()[::2]), *(str(path_of(stem)) for stem in REAL)]
    meshes = sorted((TESTS.parent / "robots" / "meshes").glob("*.stl"))
    lines = [*JSON.strip().split("\n"), *(f"{command} {robot}" for robot in robots for command in OF_A_ROBOT)]
    lines += [f"inertia {mesh} --unit mm" for mesh in meshes] + [f"inertia {path_of('panda')} --compare"]
    yield from (f"{line} --format json" for line in lines)


def _outputs(changes: dict[str, str]) -> list[list[object]]:
    return [_unmeasured(*each) for each in json.loads(python(CODE, stdin=json.dumps([*_commands()]), **changes).stdout)]


def _unmeasured(command: str, status: int, out: str, err: str) -> list[object]:
    """Return an output without what was measured."""
    if not command.startswith("accuracy"):
        return [command, status, out, err]
    document = json.loads(out, object_hook=lambda found: {k: v for k, v in found.items() if k not in MEASURED})
    return [command, status, document]


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
    if one[:2] != found[:2] or one[3:] != found[3:]:
        return False
    parsed = [
        json.loads(each[2]) if "json" in each[0] and isinstance(each[2], str) and each[2] else each[2]
        for each in (one, found)
    ]
    return _agree(*parsed)


@pytest.mark.slow
def test_output_is_the_same() -> None:
    kinds = [{}, *map(variables, LINEAR_ALGEBRA)]
    if not all(kinds[1:]):
        pytest.skip("this processor has no AVX2 to fall back to")
    with ThreadPoolExecutor(2) as pool:
        expected, *others = pool.map(_outputs, kinds)
    assert sum(status == 0 for _, status, *_ in expected) > 0.8 * len(expected)
    for outputs in others:
        assert [one[0] for one, found in zip(expected, outputs, strict=True) if not _same(one, found)] == []
