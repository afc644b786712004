"""Modes and stability against closed forms, other programs and the worst that there is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.oracles import EPS, robot, worst
from helpers.peers import mujoco
from helpers.small_robots import built, joint, link, random_tree_parts, urdf
from mpmath import mp

import robodyn
from robodyn.equations.linearized.linearize import linearize
from robodyn.robot.load import load
from robodyn.scene.scene import Drive, Friction, Scene, Spring
from robodyn.support.linear import general_eigen

G = 9.81
NO_WEIGHT = Scene(gravity=(0.0, 0.0, 0.0))


def rod(mass=2.0, com=(0.5, 0, 0), inertia=0.1, axis=(0, -1, 0)):
    arm = link("arm", mass, com, (0, 0, 0, inertia, 0, inertia))
    return built(link("base"), arm, joint("pivot", "base", "arm", "continuous", axis))


def standing(mass, com):
    """A point on a massless rod that stands up, and turns about y."""
    return built(link("base"), link("arm", mass, (0, 0, com)), joint("pivot", "base", "arm", "continuous", (0, 1, 0)))


def test_double_pendulum():
    """Two equal masses and rods: w^2 = (2 -+ sqrt 2) g / l, the lower rod at -+sqrt 2 times the upper's angle."""
    found = linearize(robot("double_pendulum"), at=[0.1, -0.2], equilibrium=True)
    assert not found.q.any()
    slow, fast = found.modes.modes
    for mode, sign in ((slow, 1), (fast, -1)):
        assert mode.frequency == pytest.approx(np.sqrt((2 - sign * np.sqrt(2)) * G) / (2 * np.pi), rel=1e-14)
        upper, lower = mode.shape
        assert (lower / upper).real == pytest.approx(sign * np.sqrt(2) - 1, rel=1e-13)
    assert (found.modes.verdict, found.modes.stable) == ("marginal", None)


@pytest.mark.parametrize("damping", [0.0, 0.7, 15.0], ids=["undamped", "damped", "overdamped"])
def test_spring_held_arm(damping):
    """I q'' + d q' + k (q - rest) + m g c cos q = 0 about its equilibrium."""
    model = rod()
    scene = Scene(spring={"pivot": Spring(40.0, 0.3)}, friction={"pivot": Friction(damping)})
    found = linearize(model, scene, [0.2], equilibrium=True)
    q = float(found.q[0])
    assert abs(40.0 * (q - 0.3) + 2.0 * G * 0.5 * np.cos(q)) <= 1e-12 * 40
    inertia, stiffness = 0.1 + 2.0 * 0.25, 40.0 - 2.0 * G * 0.5 * np.sin(q)
    assert worst(found.A, [[0, 1], [-stiffness / inertia, -damping / inertia]]) <= 4 * EPS
    values = np.roots([inertia, damping, stiffness])
    modes = found.modes
    assert modes.verdict == ("stable" if damping else "marginal")
    assert modes.margin == pytest.approx(-max(values.real), rel=1e-13, abs=1e-13)
    if damping < 10.0:
        (mode,) = modes.modes
        assert mode.frequency == pytest.approx(np.sqrt(stiffness / inertia) / (2 * np.pi), rel=1e-14)
        assert mode.damping_ratio == pytest.approx(damping / 2 / np.sqrt(stiffness * inertia), rel=1e-13)
    else:
        assert [mode.real for mode in modes.modes] == pytest.approx(sorted(values.real, reverse=True), rel=1e-13)
        assert [mode.damping_ratio for mode in modes.modes] == [1.0, 1.0]


def test_a_joint_that_a_drive_holds():
    """Upright, kp - m g c is left of the stiffness: unstable below, stable above, and nothing is said in between."""
    for kp, verdict in ((2.0 * G * 0.5 * 0.99, "unstable"), (2.0 * G * 0.5, "marginal"), (200.0, "stable")):
        scene = Scene(drive={"pivot": Drive(kp=kp, kd=3.0, reference=np.pi / 2)})
        found = linearize(rod(), scene, [np.pi / 2], equilibrium=True)
        values = np.roots([0.6, 3.0, kp - 2.0 * G * 0.5])
        assert sorted(mode.real for mode in found.modes.modes) == pytest.approx(
            sorted(set(values.real)), rel=1e-12, abs=1e-9
        )
        assert found.modes.verdict == verdict
        assert found.balanced


def test_a_real_robot_with_drives():
    """An equilibrium is found, all modes decay, and LAPACK's eigenvalues lie within the errors."""
    model = robodyn.load(str(path_of("anymal")))
    scene = Scene(drive={name: Drive(kp=2000.0, kd=60.0) for name in model.joint_names})
    found = robodyn.linearize(model, scene, equilibrium=True)
    assert found.balanced
    assert found.modes.stable
    values = np.linalg.eigvals(found.A)
    for mode in found.modes.modes:
        assert np.abs(values - complex(mode.real, mode.imag)).min() <= mode.error


def test_mujoco():
    """mjd_transitionFD: steps of Euler's semi-implicit method, by differences of 1e-6."""
    text = urdf(*random_tree_parts(np.random.default_rng(0), 5, kinds=("revolute", "prismatic", "continuous")))
    model, h = load(text), 1e-3
    spec = mujoco.MjSpec.from_string(text.decode())
    for each in spec.joints:
        each.limited = 0
    for name in model.joint_names:
        spec.add_actuator(target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    other = spec.compile()
    other.opt.timestep = h
    other.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP | mujoco.mjtDisableBit.mjDSBL_CONTACT
    data, rng = mujoco.MjData(other), np.random.default_rng(0)
    dofs = np.array([other.joint(name).dofadr[0] for name in model.joint_names])
    damping = rng.uniform(0.1, 2.0, model.n)
    other.dof_damping[dofs], other.dof_frictionloss[:] = damping, 0.0
    q, qd = rng.uniform(-1, 1, (2, model.n))
    scene = Scene(friction={name: Friction(d) for name, d in zip(model.joint_names, damping, strict=True)})
    found = linearize(model, scene, q.tolist(), qd.tolist())
    data.qpos[dofs], data.qvel[dofs], data.ctrl[:] = q, qd, found.held
    n = model.n
    A, B = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, n))
    mujoco.mjd_transitionFD(other, data, 1e-6, True, A, B, None, None)
    both = np.concatenate((dofs, n + dofs))
    rates = np.hstack((found.A[n:], found.B[n:])) * h
    rates[:, n : 2 * n] += np.eye(n)
    expected = np.vstack((h * rates, rates))
    expected[:n, :n] += np.eye(n)
    rounding = 4 * EPS * max(np.abs(data.qpos).max(), np.abs(data.qvel).max(), 1.0) / 1e-6
    assert worst(A[np.ix_(both, both)], expected[:, : 2 * n], scale=1.0) <= rounding
    assert worst(B[both], expected[:, 2 * n :], scale=1.0) <= rounding


def test_equal_modes_are_marked():
    """Two alike arms beside each other: each frequency twice, and any mixture of the two is a mode."""
    parts = [link("base")]
    for name in ("left", "right"):
        parts += [link(name, 1.0, (0, 0, -0.4)), joint(f"{name}_joint", "base", name, "continuous", (0, 1, 0))]
    found = linearize(built(*parts), Scene(spring={"left_joint": Spring(3.0), "right_joint": Spring(3.0)}))
    assert [mode.alike for mode in found.modes.modes] == [True, True]
    shapes = np.array([mode.shape for mode in found.modes.modes])
    assert np.abs(np.linalg.det(shapes)) >= 0.1


def test_a_double_root():
    """Critically damped: real, not a pair, and within the error that is said."""
    model = rod(mass=1.0, com=(0, 0, 0), inertia=1.0)
    for rate in (0.3, 0.7, 1.0, 1.3, 1.7, 2.1, 2.9):
        modes = linearize(model, Scene(drive={"pivot": Drive(kp=rate * rate, kd=2.0 * rate)})).modes
        assert len(modes.modes) == 2
        for mode in modes.modes:
            assert (mode.imag, mode.alike) == (0.0, True)
            assert abs(mode.real + rate) <= mode.error <= 1e-5
        assert modes.stable


def test_rounding_is_no_growth():
    """Undamped modes have real parts of either sign, within their errors."""
    modes = linearize(robodyn.load(str(path_of("anymal")))).modes
    assert max(mode.real for mode in modes.modes) > 0.0
    assert modes.verdict == "marginal"


def test_a_free_robot_drifts():
    """Eigenvalues are zero to the last bit; of a damped joint one is, and the other is -d / I."""
    model = robot("satellite", True)
    modes = linearize(model, NO_WEIGHT).modes
    assert (len(modes.modes), modes.verdict, modes.margin) == (model.n, "marginal", None)
    assert all(mode.free and mode.error == 0.0 for mode in modes.modes)
    slowed = linearize(rod(axis=(0, 0, 1)), Scene(friction={"pivot": Friction(0.3)})).modes
    assert [mode.free for mode in slowed.modes] == [True, False]
    assert slowed.modes[1].real == pytest.approx(-0.3 / 0.6, rel=1e-14)
    assert slowed.stable is None


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scales(scale):
    """Frequencies of a pendulum do not depend on its mass, nor on that of what it hangs on."""
    parts = [link("base"), link("cart", 1.0 / scale), joint("rail", "base", "cart", "prismatic", (0, 0, 1))]
    parts += [link("bob", scale, (0, 0, -0.25)), joint("pivot", "cart", "bob", "continuous", (0, 1, 0))]
    drive = {"rail": Drive(torque=G * (scale + 1 / scale), kp=9.0 * (scale + 1.0 / scale))}
    found = linearize(built(*parts), Scene(drive=drive), equilibrium=True)
    assert found.balanced
    first, second = found.modes.modes
    assert first.frequency == pytest.approx(3.0 / (2 * np.pi), rel=1e-12)
    assert second.frequency == pytest.approx(np.sqrt(G / 0.25) / (2 * np.pi), rel=1e-12)
    assert not first.free
    assert not second.alike


def test_a_small_stiffness_holds_and_a_rounded_right_angle_does_not():
    """1.570796327 tilts an axis by 2e-10, and the weight holds nothing; a spring of as little holds, without weight."""
    tilted = joint("pivot", "base", "hub", "continuous", (0, 1, 0), rpy=(1.570796327, 0, 0))
    arm = (link("hub", 1e-12), link("arm", 2.0, (0.3, 0.1, 0.4), (0.1, 0, 0, 0.1, 0, 0.1)))
    model = built(link("base"), *arm, tilted, joint("second", "hub", "arm", "continuous", (0, 1, 0), (0.1, 0, 0)))
    found = linearize(model)
    assert found.motion.stiffness.any()
    assert [mode.free for mode in found.modes.modes] == [True, True]
    soft = Scene(gravity=(0.0, 0.0, 0.0), spring={"pivot": Spring(1e-10), "second": Spring(1e-10)})
    assert all(mode.oscillates for mode in linearize(model, soft).modes.modes)


def test_pairs_that_are_as_fast_have_one_order():
    """Upright, every mode grows or decays at the same rate as another: rounding does not say which comes first."""
    model = robot("two_link_planar")
    for k in range(-4, 5):
        modes = linearize(model, at=[np.pi * (2 * k + 0.5), 0.0], equilibrium=True).modes.modes
        assert [np.sign(mode.real) for mode in modes] == [-1, 1, -1, 1], k


@pytest.mark.parametrize("at", [0.0, 0.3], ids=["an equilibrium", "held by a torque"])
def test_what_is_soft_because_a_drive_nearly_balances_the_weight(at):
    """A rod on a spring of m g l cos q (1 + 1e-8) swings at 0.0003 rad/s, known to 1e-12, not to 1e-16, of them."""
    for k in range(0, 40, 5):
        mass, com = 0.7 + 0.1 * k, 0.3 + 0.013 * k
        stiffness = float(mass * G * com * np.cos(at) * (1.0 + 1e-8))
        found = linearize(standing(mass, com), Scene(spring={"pivot": Spring(stiffness)}), [at])
        assert found.balanced == (at == 0.0)
        (mode,) = found.modes.modes
        with mp.workdps(50):
            m, c = mp.mpf(mass), mp.mpf(com)
            exact = float(mp.sqrt((mp.mpf(stiffness) - m * c * mp.mpf(G) * mp.cos(mp.mpf(at))) / (m * c * c)))
        assert abs(complex(mode.real, mode.imag) - 1j * exact) <= mode.error <= 1e-8


@pytest.mark.parametrize("at", [0.0, 0.5, 1.0, 2.0, 1.57079, 1.5708])
def test_nothing_is_decided_at_a_fold(at):
    """A torque of m g l is balanced at a right angle alone, where all stiffness is gone and a push one way is lost."""
    model, scene = standing(1.0, -1.0), Scene(drive={"pivot": Drive(torque=G, kd=0.5)})
    found = linearize(model, scene, [at], equilibrium=True)
    assert found.balanced
    assert found.modes.verdict == "marginal"
    aside = linearize(model, replace(scene, drive={"pivot": Drive(torque=0.999 * G, kd=0.5)}), [at], equilibrium=True)
    assert aside.modes.verdict == ("stable" if aside.q[0] < np.pi / 2 else "unstable")


def test_what_is_cut_off_moves_the_others_by_no_more_than_their_errors():
    """s^2 + c s + k with a k that counts as none: beside 0 the other root is -c within k / c, and not within k."""
    model, scene = rod(1.0, (0, 0, 1.0), 1.0, (0, 1, 0)), Scene(spring={"pivot": Spring(G + 2e-9)})
    free, slow = linearize(model, replace(scene, friction={"pivot": Friction(2e-3)})).modes.modes
    c, k = 1e-3, (G + 2e-9 - G) / 2.0
    exact = -0.5 * (c + np.sqrt(c * c - 4.0 * k))
    assert free.free
    assert 1e-7 < abs(slow.real - exact) <= slow.error <= 1e-5


@pytest.mark.parametrize("stiffness", [1e3, 1e12])
def test_equilibria_of_stiff_drives(stiffness):
    """kp (1 - q) = m g l cos(q) within what q is rounded to."""
    found = linearize(rod(), Scene(drive={"pivot": Drive(kp=stiffness, kd=1.0, reference=1.0)}), equilibrium=True)
    (q,) = found.q.tolist()
    assert abs(stiffness * (1.0 - q) - G * np.cos(q)) <= 4 * EPS * stiffness + 1e-11
    assert (found.balanced, found.modes.verdict) == (True, "stable")


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(k, marks=pytest.mark.slow) for k in range(3, 9))])
def test_errors_hold_the_truth(seed):
    """Gains over 15 decades: eigenvalues with 60 digits lie within the errors, and no verdict contradicts them."""
    rng = np.random.default_rng(seed)
    model = load(urdf(*random_tree_parts(rng, 3)))
    kp, kd = 10.0 ** rng.uniform(-6, 9, (2, model.n)) * (rng.random((2, model.n)) < 0.8)
    gains = zip(model.joint_names, kp.tolist(), kd.tolist(), strict=True)
    scene = Scene(drive={name: Drive(kp=p, kd=d) for name, p, d in gains})
    found = linearize(model, scene, rng.uniform(-1, 1, model.n).tolist())
    with mp.workdps(60):
        M, D, K = (mp.matrix(each.tolist()) for each in (found.motion.M, found.motion.damping, found.motion.stiffness))
        n, inverse = model.n, M**-1
        A = mp.zeros(2 * n)
        A[:n, n:], A[n:, :n], A[n:, n:] = mp.eye(n), -inverse * K, -inverse * D
        values = mp.eig(A, left=False, right=False)
        for mode in found.modes.modes:
            nearest = float(min(abs(value - mp.mpc(mode.real, mode.imag)) for value in values))
            assert nearest <= (1e-7 if mode.free else mode.error)
        largest = max(mp.re(value) for value in values)
    assert found.modes.verdict != ("stable" if largest >= 0 else "unstable")


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (
            Scene((0.0, 0.0, 0.0), initial_qd={"pivot": 3.0}),
            "initial qd of 'pivot' in the scene is left out: linearized",
        ),
        (Scene(friction={"pivot": Friction(0.1, 0.5, -0.5)}), "Coulomb friction of 'pivot' is left out"),
    ],
)
def test_what_is_left_out_at_rest_is_said(scene, says):
    (warning,) = linearize(rod(), scene).warnings
    assert warning.startswith(says)
    moving = linearize(rod(), scene, qd=[1.0])
    assert not moving.warnings
    assert (moving.modes.verdict, moving.modes.stable, moving.balanced) == ("moving", None, False)


@pytest.mark.parametrize("mass", [1e-13, 1e13])
def test_equilibria_of_the_lightest_and_the_heaviest_link(mass):
    parts = [link("base")]
    for k, (name, each) in enumerate((("a", 1.0), ("b", mass), ("c", 1.0))):
        parts += [link(name, each, (0.2, 0, 0), (each * 0.01, 0, 0, each * 0.02, 0, each * 0.03))]
        parts += [joint(f"j{name}", ("base", "a", "a")[k], name, "continuous", (0, 1, 0), (0.3 * (k > 0), 0, 0))]
    found = linearize(built(*parts), at=[0.4, -0.8, 1.1], equilibrium=True)
    assert np.abs(np.sin(np.cumsum(found.q * [1, 1, 0])[:2] - np.pi / 2)).max() <= 1e-9
    assert np.abs(np.sin(found.q[0] + found.q[2] - np.pi / 2)) <= 1e-9
    assert found.modes.verdict == "marginal"
    assert all(mode.oscillates for mode in found.modes.modes)


def test_two_carts_on_a_spring_swing_against_each_other():
    """Free along x as a whole: the first moves by -m2 / (m1 + m2) of the stretch, at sqrt(k (1 / m1 + 1 / m2))."""
    carts = [link(name, mass, inertia=(0.1, 0, 0, 0.1, 0, 0.1)) for name, mass in (("first", 3), ("second", 1))]
    rails = [joint(*names, "prismatic", (1, 0, 0)) for names in (("r", "base", "first"), ("s", "first", "second"))]
    scene = Scene(spring={"s": Spring(12.0)}, friction={"s": Friction(0.5)})
    found = linearize(built(link("base"), *carts, *rails), scene).modes.modes
    assert [mode.free for mode in found] == [True, False]
    assert found[1].frequency == pytest.approx(np.sqrt(12.0 * 4 / 3) / (2 * np.pi), rel=1e-14)
    assert np.abs(np.array(found[1].shape) / found[1].shape[1] - [-0.25, 1]).max() <= 4 * EPS


@pytest.mark.parametrize("unit", [1e-310, 1e-200, 1.0, 1e139, 1e300])
def test_eigenvalues_of_any_size(unit):
    """LAPACK's own scale of a matrix above 7e137, or below its inverse, is lost on the way to the eigenvalues."""
    found = general_eigen(np.array([[0.0, 1.0], [2.0, 0.0]]) * unit)
    assert np.abs(np.sort(found.values.real) / unit - [-np.sqrt(2), np.sqrt(2)]).max() <= 1e-12
