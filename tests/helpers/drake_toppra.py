"""Drake's Toppra along our paths, in a process of its own: its libraries and Pinocchio's do not go together."""

from __future__ import annotations

import json
import re
import subprocess
import sys

from helpers.peers import peer

_CODE = """
import contextlib, json, sys
import numpy as np
from pydrake.multibody.optimization import Toppra
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.polynomial import Polynomial
from pydrake.trajectories import PiecewisePolynomial

asked = json.load(sys.stdin)
plant = MultibodyPlant(0.0)
Parser(plant).AddModelsFromString(asked["urdf"], "urdf")
with contextlib.suppress(RuntimeError):  # it is welded, where a joint of the description says so
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(asked["base"]))
plant.Finalize()
places = [plant.GetJointByName(name).position_start() for name in asked["names"]]
found = []
for breaks, c, limits in asked["paths"]:
    c, pieces = np.array(c), []
    for k in range(c.shape[1]):
        piece = np.array([[Polynomial(np.zeros(1))] for _ in range(plant.num_positions())])
        for i, place in enumerate(places):
            piece[place, 0] = Polynomial(c[:, k, i])
        pieces.append(piece)
    grid = np.unique(np.concatenate((np.linspace(0.0, breaks[-1], 1001), breaks)))
    path = PiecewisePolynomial(pieces, breaks)  # which the solver does not own
    solver = Toppra(path, plant, grid)
    bounds = np.full((3, plant.num_positions()), 1e9)
    bounds[:, places] = np.minimum(limits, 1e9)
    solver.AddJointVelocityLimit(-bounds[0], bounds[0])
    solver.AddJointAccelerationLimit(-bounds[1], bounds[1])
    solver.AddJointTorqueLimit(-bounds[2], bounds[2])
    times = solver.SolvePathParameterization()
    found.append(None if times is None else times.end_time())
print(json.dumps(found))
"""


def durations(file, model, found):
    """What it takes along each path of `retime` [s], under its limits of speed, acceleration and effort; None where it
    finds nothing."""
    peer("pydrake")
    text = file.read_text()
    for tag in ("visual", "collision", "transmission", "gazebo"):
        text = re.sub(rf"<{tag}\b[^>]*/>", "", text)
        text = re.sub(rf"<{tag}\b.*?</{tag}>", "", text, flags=re.DOTALL)
    paths = [(one.path.breaks.tolist(), one.path.c.tolist(), one.limits[:3].clip(max=1e9).tolist()) for one in found]
    asked = {"urdf": text, "base": model.bodies[0].name, "names": model.joint_names, "paths": paths}
    done = subprocess.run(
        [sys.executable, "-c", _CODE], input=json.dumps(asked), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])
