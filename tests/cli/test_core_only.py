"""Every command where only the core is installed: it works, or one line names the extra that it needs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, Outcome, refused
from helpers.processes import python

import robodyn
from robodyn.cli.main import COMMANDS
from robodyn.support.extras import OPTIONAL

pytestmark = pytest.mark.slow
PEERS = "pinocchio", "mujoco", "pydrake", "idyntree", "igl"
WORKS = (
    "torques scara.urdf scara_pick_and_place.csv --out {out}/tau.csv --reactions --sizing --explain",
    "torques scara.urdf scara_pick_and_place.csv --out {out}/tau.npz --report {out}/tau.md --format json",
    "torques scara.urdf scara_pick_and_place.csv puma_sweep_none.csv --out {out}/many",
    "torques scara.urdf {out}/example.csv --example",
    "simulate two_link_planar.urdf --scene two_link_planar_swing_down.toml --duration 0.05 --out {out}/motion.csv",
    "simulate two_link_planar.urdf --scene two_link_planar_swing_down.toml --duration 0.05 --accuracy 1e-3",
    "inertia meshes/bracket.stl meshes/hub.stl --mass 2 --report {out}/parts.md",
    "check scara.urdf --format sarif",
    "fbd scara.urdf --at 0.1,0.2,0 --svg {out}/bodies",
    "equations scara.urdf --form dae --at 0.1,0.2,0",
    "envelope scara.urdf --payload spindle --report {out}/scara.md",
    "linearize scara.urdf --step 0.001 --out {out}/linear.npz --report {out}/linear.md",
    "export scara.urdf --to c --what torques,mass_matrix,bias,forward",
    "export scara.urdf --to casadi --out {out}/scara_casadi.py",
    "export scara.urdf --to jax --what forward,regressor --out {out}/scara_jax.py",
    "retime puma560.urdf puma560_waypoints.csv --grid 100 --out {out}/fast.csv --report {out}/fast.md",
    "excite pendulum.urdf --out {out}/excite.csv --report {out}/excite.md",
    "identify pendulum.urdf {out}/log.csv --out {out}/calibrated.urdf",
    "scene init scara.urdf --out {out}/scene.toml",
    "info scara.urdf",
    "diff puma560.urdf puma.urdf",
    "size puma560.urdf puma560_sweep.csv --catalog catalogue/motors.csv --scene-out {out}/chosen.toml",
    "convert scara.urdf --to mjcf --out {out}/scara.xml",
    "accuracy meshes/hub.stl",
    "accuracy two_link_planar.urdf two_link_planar_swing_down.toml --duration 0.01",
    "rule",
    "doctor",
)
"""Calls in the folder of robots; a file that is not there makes one of many fail."""
NEEDS = {
    "torques scara.urdf scara_pick_and_place.csv --report {out}/tau.html": "report",
    "torques scara.urdf scara_pick_and_place.csv --out {out}/tau.parquet": "parquet",
    "torques scara.urdf scara_pick_and_place.csv --accuracy 1e-9 --out {out}/tau.csv": "exact",
    "torques scara.urdf scara_pick_and_place.csv more.csv --out {out}/many --dask tcp://127.0.0.1:9": "dask",
    "torques {out}/arm.xacro scara_pick_and_place.csv": "xacro",
    "torques scara.urdf {out}/log.mcap": "ros",
    "torques scara.urdf {out}/plan.yaml": "ros",
    "simulate two_link_planar.urdf --duration 3000 --report {out}/swing.html": "report",
    "inertia meshes/bracket.stl --report {out}/part.html": "report",
    "check scara.urdf --report {out}/check.html": "report",
    "equations two_link_planar.urdf --form closed": "symbolic",
    "derive two_link_planar.urdf": "symbolic",
    "view scara.urdf": "report",
    "lsp": "lsp",
    "accuracy meshes/hub.stl --report {out}/front.html": "report",
    "accuracy scara.urdf scara_pick_and_place.csv": "exact",
}
CODE = """
import json, os, sys
class Absent:
    def find_spec(self, name, *_):
        if name.partition(".")[0] in {absent!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Absent())
sys.path.insert(0, {tests!r})
import pytest
from helpers.command_line import run
from helpers.hurried import hurry
hurry(pytest.MonkeyPatch())
os.chdir({robots!r})
found = {{}}
for call in {calls!r}:
    outcome = run(*call.format(out={out!r}).split())
    found[call] = outcome.status, outcome.out, outcome.err
sys.__stdout__.write(json.dumps(found))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("core")
    (made / "arm.xacro").write_text("<robot/>")
    angles = [(t, math.sin(t / 20) + 0.3 * math.sin(t / 7)) for t in range(3000)]
    rows = "".join(f"{t / 100},{q},{9.0 * math.sin(q)}\n" for t, q in angles)
    joint = robodyn.load(ROBOTS / "pendulum.urdf").rates[0]
    (made / "log.csv").write_text(f"time,q_{joint},tau_{joint}\n{rows}")
    return made


@pytest.fixture(scope="module")
def outcomes(folder: Path) -> dict[str, Outcome]:
    """What every call ends with in a process that finds no optional library."""
    absent = {*PEERS, *(library.module.partition(".")[0] for library in OPTIONAL)}
    paths = {"tests": str(Path(__file__).parents[1]), "robots": str(ROBOTS), "out": str(folder)}
    done = python(CODE.format(absent=absent, calls=(*NEEDS, *WORKS), **paths), ROBODYN_CACHE=folder / "cache")
    return {call: Outcome(*outcome) for call, outcome in json.loads(done.stdout).items()}


def test_no_command_is_left_out() -> None:
    assert {call.split()[0] for call in (*WORKS, *NEEDS)} == set(COMMANDS)


@pytest.mark.parametrize("call", WORKS)
def test_the_core_suffices(call: str, outcomes: dict[str, Outcome]) -> None:
    found = outcomes[call]
    assert found.status in ((0, 1) if "none.csv" not in call else (2,)), found.err
    assert found.out
    assert "internal error" not in found.err


@pytest.mark.parametrize("call", NEEDS)
def test_an_extra_is_named_before_anything_is_written(call: str, outcomes: dict[str, Outcome], folder: Path) -> None:
    found = outcomes[call]
    refused(found, "")
    assert f' (pip install "robodyn[{NEEDS[call]}]"' in found.err
    written = [word.format(out=folder) for word in call.split() if word.startswith("{out}")]
    assert not any(Path(name).exists() for name in written if not name.endswith((".csv", ".xacro", "many")))
