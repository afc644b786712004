"""What commands print is the same to the last character on other kinds of processor."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from processes import python
from processor_kinds import LINEAR_ALGEBRA, variables

TESTS = Path(__file__).parent.parent
COMMANDS = """
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
torques robots/scara.urdf robots/scara_pick_and_place.csv --format json
torques robots/satellite.urdf robots/satellite_slew.csv --scene robots/satellite.toml --format json
fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2
equations robots/scara.urdf --form dae --at 0.3,-0.5,0.05 --qd elbow=2
simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.2
"""
CODE = f"""
import json, os, sys
sys.path.insert(0, {str(TESTS)!r})
os.chdir({str(TESTS.parent)!r})
from command_line import run
outputs = []
for command in {COMMANDS!r}.split("\\n")[1:-1]:
    done = run(*command.split())
    outputs.append([command, done.status, done.out, done.err])
print(json.dumps(outputs))
"""


@pytest.mark.slow
@pytest.mark.parametrize("kind", LINEAR_ALGEBRA)
def test_output_is_the_same_to_the_last_character(kind: str) -> None:
    changes = variables(kind)
    if not changes:
        pytest.skip("this processor has no AVX2 to fall back to")
    outputs = json.loads(python(CODE).stdout), json.loads(python(CODE, **changes).stdout)
    for expected, found in zip(*outputs, strict=True):
        assert found == expected
