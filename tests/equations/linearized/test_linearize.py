"""Linear equations near a state against closed forms and 100 digits; equilibria, those beyond limits; steps."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.command_line import run
from helpers.exact_rates import exact_rates
from helpers.oracles import EPS, frictionless, robot, tangent, worst
from helpers.small_robots import built, joint, link
from scipy.linalg import expm

import robodyn
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.plan import Plan
from robodyn.equations.linearized.linearize import in_steps, linearize
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, Friction, Loop, Scene, Spring


def free_of_columns(scene):
    return replace(scene, wrenches=tuple(each for each in scene.wrenches if not each.columns))


def test_a_hanging_pendulum():
    """w^2 = m g l / I and 2 zeta w = d / I, as `doc` of the description has them: a point mass on a massless rod."""
    model = robot("pendulum")
    (name,) = model.joint_names
    found = linearize(model, Scene(friction={name: Friction(0.3)}), [-1.2], equilibrium=True)
    assert abs(found.q[0] + np.pi / 2) <= 4 * EPS
    M = robodyn.mass_matrix(model, found.q)[0, 0]
    weight = robodyn.bias_forces(model, [0.0], 0.0, scene=frictionless(model))[0]
    assert worst(found.A, [[0.0, 1.0], [-weight / M, -0.3 / M]]) <= 4 * EPS
    (mode,) = found.modes.modes
    assert mode.frequency == pytest.approx(np.sqrt(weight / M) / (2 * np.pi), rel=1e-14)
    assert mode.damping_ratio == pytest.approx(0.3 / (2 * np.sqrt(weight * M)), rel=1e-14)
    assert not found.held.any()


def test_it_is_held_where_it_is_put():
    model = robot("puma560")
    at = [0.1, -0.5, 0.3, 0.2, -0.4, 0.6]
    found = linearize(model, at=at)
    assert (found.held == robodyn.bias_forces(model, at, 0.0)).all()
    assert not robodyn.forward_dynamics(model, at, 0.0, found.held).round(11).any()
    name, qd = model.joint_names[2], [0.3, -0.2, 0.5, 0.1, 0.2, -0.3]
    moving = linearize(model, Scene(drive={name: Drive(2.0, 30.0, 4.0, 0.25, 0.75)}), at, qd)
    drive = [0.0, 0.0, 2.0 + 30.0 * (0.25 - 0.3) + 4.0 * (0.75 - 0.5), 0.0, 0.0, 0.0]
    assert worst(moving.drive, drive) <= 4 * EPS
    assert worst(moving.drive + moving.held, robodyn.bias_forces(model, at, qd)) <= 4 * EPS


@pytest.mark.parametrize("moving_base", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["fixed", "free"])
def test_the_accelerations_of_small_moves(moving_base):
    """A and B are how accelerations change, drives closed, with every effect of a scene on: by differences with 100
    digits."""
    model, scene = busy_robot(moving_base), replace(free_of_columns(BUSY_SCENE), slip_speed=0.3)
    scene = replace(scene, drive={name: Drive(0.5, 30.0, 4.0, 0.2, 0.1) for name in ("j1", "slide", "finger")})
    rng, n = np.random.default_rng(3), model.n
    at, qd = (dict(zip(model.joint_names[-5:], rng.uniform(-1, 1, 5), strict=True)) for _ in range(2))
    found = linearize(model, scene, at, qd)
    kp, kd = (np.array([getattr(scene.drive.get(name), k, 0.0) for name in model.rates]) for k in ("kp", "kd"))
    state = {"q": found.q[None], "qd": found.qd[None], "tau": (found.held + found.drive)[None]}
    moves = [*tangent(model, state["q"]), *({(source, i): 1} for source in ("qd", "tau") for i in range(n))]
    for k, (gains, source) in enumerate(((kp, "tau"), (kd, "tau"))):
        for i in range(n):
            moves[k * n + i] = {**moves[k * n + i], (source, i): -gains[i]}
    (exact,) = exact_rates(acceleration_program(Plan(model, scene)), moves, state).astype(float)
    condition = np.linalg.cond(robodyn.mass_matrix(model, found.q, scene=scene))
    blocks = (found.A[n:, :n], found.A[n:, n:], found.B[n:])
    for k, block in enumerate(blocks):
        assert worst(block, exact[:, k * n : (k + 1) * n]) <= 1e-14 * condition
    assert (found.A[:n, n:] == np.eye(n)).all()
    assert not found.A[:n, :n].any()
    assert not found.B[:n].any()


def test_states_of_a_base_that_moves():
    """It begins where the scene says; a weight that is held above its mass centre swings as a pendulum about any axis
    of its own, and falls freely along the ground's."""
    mass, inertia, c = 2.0, (0.1, 0.0, 0.0, 0.2, 0.0, 0.3), (0.0, 0.0, -0.4)
    model = built(link("body", mass, c, inertia), moving_base=True)
    held = linearize(model)
    assert held.states[:4] == ("q_base_wx", "q_base_wy", "q_base_wz", "q_base_vx")
    assert worst(held.held, [0, 0, 0, 0, 0, mass * 9.81]) <= 4 * EPS
    # about the mass centre, on which the held force at the origin acts as a couple m g c per turn
    for k, moment in enumerate((0.1, 0.2)):
        assert held.A[6 + k, k] == pytest.approx(-mass * 9.81 * 0.4 / moment, rel=1e-13)
    tilted = Scene(initial_q=dict(zip(("base_qx", "base_qy", "base_qz", "base_qw"), (0.6, 0.0, 0.0, 0.8), strict=True)))
    assert linearize(model, tilted).q[3:].tolist() == [0.6, 0.0, 0.0, 0.8]


def test_steps():
    """The exponential by another program, a singular A (a free base) and a stiff one.

    Its condition number is at least |X| (Higham, *Functions of Matrices*, 2008, chapter 10), here up to 4e6: whoever
    computes it from an X that is rounded is off by so many roundings.
    """
    puma = robot("puma560")
    for model, scene, steps in (
        (robot("satellite", True), Scene(gravity=(0.0, 0.0, 0.0)), (1e-3, 0.02)),
        (puma, Scene(drive={name: Drive(kp=1e4, kd=50.0) for name in puma.joint_names}), (1e-6, 1e-3, 0.02)),
        (robot("pendulum"), Scene(gravity=(0.0, 0.0, 0.0), spring={"pivot": Spring(1.0)}), (0.1, 0.4, 2.0)),
    ):
        found = linearize(model, scene)
        n, m = found.B.shape
        for step in steps:
            stepped = in_steps(found, step)
            X = np.block([[found.A, found.B], [np.zeros((m, n + m))]]) * step
            expected, bound = expm(X), 4 * EPS * max(1.0, np.linalg.norm(X, 1))
            assert worst(stepped.A, expected[:n, :n]) <= bound
            assert worst(stepped.B, expected[:n, n:]) <= bound
            assert stepped.step == step


def test_steps_of_what_is_slow_beside_what_is_fast():
    """A drive of 1e9 with a damping of 1e9: a root of 1 /s beside one of 1e9, and of steps both are as good."""
    scene = Scene(gravity=(0.0, 0.0, 0.0), drive={"pivot": Drive(kp=1e9, kd=1e9)})
    found = linearize(robot("pendulum"), scene, step=0.01)
    fast = 0.5e9 * (1.0 + np.sqrt(1.0 - 4e-9))
    slow = 1e9 / fast
    e, gap = np.exp(-0.01 * slow), fast - slow
    assert worst(found.A, [[fast * e / gap, e / gap], [-1e9 * e / gap, -slow * e / gap]]) <= 16 * EPS
    assert worst(found.B[0], [(-np.expm1(-0.01 * slow) - e * slow / gap) / 1e9]) <= 16 * EPS


@pytest.mark.parametrize("step", [0.0, np.nan, "0.01", 1e300])
def test_steps_that_are_none(step):
    with pytest.raises(InputError, match=r"no positive finite|overflows within"):
        linearize(robot("two_link_planar"), step=step)


@pytest.mark.parametrize("seed", range(3))
def test_equilibria_of_random_springs_and_drives(seed):
    rng = np.random.default_rng(seed)
    model = robot("puma560")
    names = model.joint_names
    scene = Scene(
        spring={name: Spring(rng.uniform(20, 80), rng.uniform(-1, 1)) for name in names[:3]},
        drive={name: Drive(kp=rng.uniform(20, 80), reference=rng.uniform(-1, 1)) for name in names[3:]},
    )
    found = linearize(model, scene, rng.uniform(-1, 1, 6).tolist(), equilibrium=True)
    given = [scene.drive[name].kp * (scene.drive[name].reference - found.q[k + 3]) for k, name in enumerate(names[3:])]
    tau = np.concatenate((np.zeros(3), given))
    assert worst(robodyn.bias_forces(model, found.q, 0.0, scene=scene), tau) <= 1e-10
    assert np.abs(np.linalg.eigvals(found.A).real.max()) < 1.0


def test_refusals():
    model, pendulum, puma = busy_robot(), robot("pendulum"), robot("puma")
    massless = (link("a", 1.0, (0, 0, 0.3)), link("b"), joint("ja", "base", "a", axis=(0, 1, 0)), joint("jb", "a", "b"))
    heavy, steep = (0.0, 0.0, -1e308), Scene((0.0, 0.0, -1.7e308), drive={"pivot": Drive(kp=1.7e308)})
    for says, refused, more in (
        ("wrenches name columns", (model, BUSY_SCENE), {}),
        ("an equilibrium is at rest", (model,), {"qd": {"j1": 0.1}, "equilibrium": True}),
        ('loop "l" does not close: it is open by 1.07 m', (model, Scene(loops=(Loop("l", "tool"),))), {}),
        ("the mass matrix is singular: nothing moves with 'jb'", (built(link("base"), *massless),), {}),
        ("the motion overflows within a step of 1e+06 s", (pendulum,), {"at": [np.pi / 2], "step": 1e6}),
        ("within a step of 1e+300 s", (pendulum, Scene(drive={"pivot": Drive(kp=1e9)})), {"step": 1e300}),
        ("overflow at this state", (puma, Scene(gravity=heavy)), {"equilibrium": True}),
        ("overflow at this state", (pendulum, steep, [-1.5]), {}),
        ("there is no equilibrium: 981 N at base_vz stay", (robot("satellite", True),), {"equilibrium": True}),
    ):
        with pytest.raises(InputError) as caught:
            linearize(*refused, **more)
        assert says in str(caught.value)
    assert linearize(puma, Scene(gravity=(0.0, 0.0, -1e300)), [0.0, 1.5, -1.5], equilibrium=True).balanced


ROBOT = """<robot name="p"><link name="base"/><link name="rod"><inertial><origin xyz="1 0 0"/><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit effort="{effort:.9g}" velocity="5" lower="{lower:.9g}" upper="{upper:.9g}"/>
<dynamics damping="0.5"/></joint></robot>"""


def call(folder: Path, angle: float, effort: float, lower: float, upper: float) -> tuple[str, ...]:
    """A rod that a stiff drive holds at an angle, where it carries 9.81 cos(angle) N m."""
    (folder / "rod.urdf").write_text(ROBOT.format(effort=effort, lower=lower, upper=upper))
    torque = float(-9.81 * np.cos(angle))
    (folder / "drive.toml").write_text(
        f"drive.hinge = {{ kp = 1000, kd = 10, torque = {torque!r}, reference = {angle!r} }}\n"
    )
    return ("linearize", str(folder / "rod.urdf"), "--scene", str(folder / "drive.toml"))


@pytest.mark.parametrize("seed", [0, 9, 2, *(pytest.param(k, marks=pytest.mark.slow) for k in (6, 11, 15))])
def test_limits_are_asked(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    angle = float(rng.uniform(-1.2, 1.2))
    needed = abs(9.81 * np.cos(angle))
    weak, out = bool(seed & 1), bool(seed & 2)
    lower, upper = (angle + 0.1, angle + 2.0) if out and seed & 4 else (-3.0, angle - 0.1 if out else 3.0)
    base = call(tmp_path, angle, needed * (0.99 if weak else 1.01), lower, upper)
    base += ("--equilibrium",) if seed & 8 else (f"--at={angle!r}",)
    found, outcome = json.loads(run(*base, "--format", "json").out), run(*base, "--report", str(tmp_path / "r.md"))
    assert (found["stable"], found["verdict"]) == ((False, "beyond limits") if weak or out else (True, "stable"))
    assert sorted(each["quantity"] for each in found["limits_exceeded"]) == ["effort"] * weak + ["position"] * out
    page = (tmp_path / "r.md").read_text()
    assert ("**✅ Stable" in page) == (not weak and not out)
    assert ("**❌ The equilibrium is beyond limits" in page) == (weak or out)
    assert ("\nStable: every small push dies away.\n" in outcome.out) == (not weak and not out)
    if weak:
        assert f"% of its limit of {needed * 0.99:g} N m." in outcome.out
    assert outcome.status == 0
    assert run(*base, "--fail-on-limits").status == (weak or out)


def test_matrices_are_printed(tmp_path: Path) -> None:
    base = call(tmp_path, 0.0, 100.0, -3.0, 3.0)
    out, found = run(*base, "--equilibrium").out, json.loads(run(*base, "--equilibrium", "--format", "json").out)
    rows = "          q_hinge  qd_hinge\nq_hinge       0       1.000\nqd_hinge   -990.1   -10.40\n"
    assert f"\nA of x' = A x + B u\n{rows}" in out
    assert "\nB of x' = A x + B u\n          tau_hinge\nq_hinge      0\nqd_hinge     0.9901\n" in out
    assert found["A"][1] == pytest.approx([-1000 / 1.01, -10.5 / 1.01])
    assert "\nA of x(t + 0.01 s) = A x(t) + B u\n" in run(*base, "--step", "0.01").out
