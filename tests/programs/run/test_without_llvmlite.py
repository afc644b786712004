"""What a process of its own does that has no llvmlite, one that does not load, or no need of it."""

from __future__ import annotations

import json

from helpers.command_line import write_arm
from helpers.oracles import REFERENCE
from helpers.processes import python

ROBOT = str(REFERENCE / "urdf" / "puma560_corke.urdf")
WORK = f"""
import json, sys
import numpy as np
import robodyn
from robodyn.programs.run.runner import Runner
from robodyn.dynamics.plan import Plan
from robodyn.scene.scene import DEFAULT
model = robodyn.load({ROBOT!r})
q = np.random.default_rng(5).uniform(-2, 2, (50, 6))
sources = {{"q": q, "qd": q, "qdd": q}}
program = Plan(model, DEFAULT).torques()
def runner():
    return Runner(program, dict.fromkeys(sources, 6))
def told(**figures):
    print(json.dumps({{**figures, "loaded": sorted({{name.partition(".")[0] for name in sys.modules}})}}))
"""
LACKING = "import sys; sys.modules['llvmlite'] = None\n"
PROBLEM = "llvmlite is not installed; pip install llvmlite"
EVERYTHING = """
tau = robodyn.inverse_dynamics(model, q, q, q)
M, b = robodyn.mass_matrix(model, q), robodyn.bias_forces(model, q, q)
ours = all((runner()(sources, 50, expected=10**9) == tau).all() for _ in range(3))
errors = []
for _ in range(2):
    try:
        robodyn.inverse_dynamics(model, q, q, q, executor="compiled")
    except robodyn.RobodynError as error:
        errors.append(str(error))
residual = float(abs((M @ q[..., None])[..., 0] + b - tau).max())
told(ours=ours, residual=residual, largest=float(abs(tau).max()), errors=errors)
"""


def _told(done):
    return json.loads(done.stdout)


def test_everything_works_and_large_work_says_so_once(tmp_path):
    done = python(LACKING + WORK + EVERYTHING, ROBODYN_CACHE=tmp_path)
    told = _told(done)
    assert told["ours"]
    assert told["residual"] < 1e-13 * told["largest"]
    assert told["errors"] == [f"the compiled executor cannot run: {PROBLEM} (choose auto or numpy)"] * 2
    assert done.stderr.count("Warning") == 1
    assert f"RobodynWarning: large work goes without machine code, tens of times slower: {PROBLEM}\n" in done.stderr


def test_the_command_shows_robodyns_warnings_wherever_they_come_from(tmp_path):
    """And nobody else's: by their category, not by the module that warns."""
    write_arm(tmp_path)
    call = ["robodyn", "torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv")]
    done = python(f"""
import sys, warnings
import robodyn.programs.run.runner as runner
from robodyn.errors import RobodynWarning
before = runner.choice
def elsewhere(work):
    warnings.warn("this goes slowly", RobodynWarning)
    warnings.warn("not for users", RuntimeWarning)
    return before(work)
runner.choice = elsewhere
sys.argv = {call!r}
from robodyn.cli.main import main; main()""")
    assert set(done.stderr.splitlines()) == {"warning: this goes slowly"}


def test_little_work_loads_no_compiler_and_looks_at_no_cache(tmp_path):
    code = "for _ in range(20): robodyn.inverse_dynamics(model, q, q, q)\ntold()"
    told = _told(python(WORK + code, ROBODYN_CACHE=tmp_path))
    assert not {"llvmlite", "platformdirs"} & set(told["loaded"])
    assert not list(tmp_path.iterdir())
