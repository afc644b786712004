"""Base parameters: known counts, closed forms, Y_base beta = Y theta, exact estimates, names that nothing turns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import VARIANTS, cases, path_of
from helpers.oracles import EPS, ROBOTS, random_state, robot, worst
from helpers.sampled import sampled

from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.parameters.base import base_of, random_rows, structural_base
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Scene

LWR4 = Path(__file__).parents[1] / "data" / "lwr4.urdf"
_INERTIAL = '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
ARM = f"""<robot name="arm"><link name="base"/><link name="upper">{_INERTIAL}</link><link name="fore">{_INERTIAL}</link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous">
<origin xyz="0.7 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/></joint></robot>""".encode()


def inertial(names):
    return [k for k, name in enumerate(names) if name.rpartition(".")[2] in INERTIAL]


@pytest.mark.parametrize(
    ("path", "known"),
    [
        pytest.param(ROBOTS / "puma560.urdf", 36, id="PUMA 560: Gautier and Khalil 1990"),
        pytest.param(LWR4, 43, id="LWR4+: Jubien, Gautier and Janot 2014"),
        pytest.param(path_of("ur10_robot"), 36, id="UR10"),
        pytest.param(ROBOTS / "two_link_planar.urdf", 6, id="a double pendulum"),
    ],
)
def test_known_counts(path, known):
    rows, names = random_rows(load(path))
    columns = inertial(names)
    base = base_of(rows[:, columns], [names[k] for k in columns])
    assert base.rank == known
    assert base.kept > 0.1
    assert base.dropped < 1e-12


def test_groups_of_a_double_pendulum():
    """In closed form: M and m of both links, what the elbow carries is added to the upper arm at 0.7 m."""
    assert structural_base(load(ARM)).groups == (
        "upper.mx + 0.7 fore.m",
        "upper.mz",
        "upper.Iyy + 0.49 fore.m + shoulder.rotor",
        *("fore.mx", "fore.mz", "fore.Iyy", "shoulder.viscous", "shoulder.forward", "shoulder.backward"),
        *("elbow.viscous", "elbow.forward", "elbow.backward", "elbow.rotor"),
    )
    weightless = structural_base(load(ARM), Scene(gravity=(0.0, 0.0, 0.0)))
    assert weightless.groups[0] == "upper.Iyy + 0.49 fore.m + shoulder.rotor"


OURS = [
    ROBOTS / f"{name}.urdf" for name in ("scara", "gripper", "cylindrical", "puma560", "two_link_spatial", "satellite")
]


@pytest.mark.parametrize("path", [*sampled(OURS, 3), *sampled([*cases(VARIANTS)][::5], 6)])
def test_base_parameters_make_all_torques(path):
    """Coefficients below 1e-9 of a column are taken for rounding: so many small ones may be missing."""
    model = load(path)
    base = structural_base(model)
    found = regressor(model, *random_state(model, np.random.default_rng(2), 4), executor="numpy")
    chosen = found.Y[..., base.independent]
    largest = np.abs(found.Y).max(axis=(0, 1), initial=0.0)
    bound = 1e-9 * np.sqrt(base.rank) * largest
    assert (np.abs(chosen @ base.matrix - found.Y).max(axis=(0, 1), initial=0.0) <= bound)[
        [k for k in range(len(base.names)) if k not in base.invisible]
    ].all()
    expected = found.Y @ found.theta
    assert worst(chosen @ base.values(found.theta), expected, max(np.abs(expected).max(initial=0), 1e-300)) <= 3e-10
    assert base.matrix[:, base.independent].tolist() == np.eye(base.rank).tolist()


def test_every_kind_of_friction_and_a_base_that_floats():
    model = busy_robot(True)
    scene = replace(BUSY_SCENE, friction={"j1": Friction(0.1, 0.2, -0.3, 0.4, 0.05)})
    base = structural_base(model, scene)
    assert {"j1.stribeck", "j1.viscous", "j1.forward", "j1.backward"} <= {base.names[k] for k in base.independent}
    base_body = model.bodies[0].name
    assert base.groups[0].startswith(f"{base_body}.m + "), "afloat, the mass of the base is felt"


def test_estimates_are_exact_and_have_the_errors_of_the_normal_equations():
    model = robot("two_link_planar")
    base = structural_base(model)
    found = regressor(model, *random_state(model, np.random.default_rng(6), 30), executor="numpy")
    rows = found.Y.reshape(-1, len(found.names))
    factor = np.linalg.qr(np.column_stack((rows, rows @ found.theta)), mode="r")
    for estimate in (base.estimate(factor[:, :-1], factor[:, -1]), base.estimate(rows, rows @ found.theta)):
        assert worst(estimate.values, base.values(found.theta)) <= 1e-12
    estimate = base.estimate(rows / 0.3, np.zeros(len(rows)))
    chosen = rows[:, base.independent]
    expected = 0.09 * np.linalg.inv(chosen.T @ chosen)
    assert worst(estimate.covariance, expected) <= 1e-12
    assert worst(estimate.standard_errors, np.sqrt(np.diag(expected))) <= 1e-12


def test_what_a_motion_does_not_show():
    """The elbow at rest: its friction and rotor are invisible, and the forearm is a part of the upper arm."""
    model = load(ARM)
    base = structural_base(model)
    rng = np.random.default_rng(7)
    q, qd, qdd = rng.uniform(-1, 1, (3, 40, 2))
    q[:, 1], qd[:, 1], qdd[:, 1] = 0.3, 0.0, 0.0
    found = regressor(model, q, qd, qdd, executor="numpy")
    rows = found.Y.reshape(-1, len(found.names))
    shown = base.within(rows)
    assert {"elbow.viscous", "elbow.rotor", "elbow.forward"} <= {shown.names[k] for k in shown.invisible}
    chosen = [shown.names[k] for k in shown.independent]
    assert [name for name in chosen if name.startswith("upper")] == ["upper.mx", "upper.mz", "upper.Iyy"]
    assert worst(rows[:, shown.independent] @ shown.matrix, rows) <= 1e-10
    again = base.within(rows)
    assert again.groups == shown.groups


def test_names_do_not_hang_on_rounding_or_units():
    """In millimetres and grams, or with torques of another size, the same parameters are chosen."""
    rows, names = random_rows(robot("puma560"))
    rng = np.random.default_rng(8)
    base = base_of(rows, names)
    for _ in range(2):
        noisy = rows * (1.0 + 16 * EPS * rng.uniform(-1, 1, rows.shape))
        assert base_of(noisy[rng.permutation(len(rows))], names).groups == base.groups
    rows, names = random_rows(robot("puma"))
    sizes = 10.0 ** rng.integers(-3, 3, len(names))
    sizes[inertial(names)] = 1e-3
    assert base_of(1e6 * rows * sizes, names).independent == base_of(rows, names).independent
