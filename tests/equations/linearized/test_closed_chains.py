"""Linear equations on the manifold that loops leave: closed forms, and the period of a simulated motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.oracles import robot
from helpers.small_robots import built, joint, link
from mpmath import mp, mpf

import robodyn
from robodyn.equations.linearized.linearize import linearize
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, Friction, Loop, Scene, Spring

R, L, G = mpf("0.1"), mpf("0.3"), mpf("9.81")
PUMP = robodyn.load_scene(str(ROBOTS / "crank_slider_pump.toml"))
BARS = robodyn.load_scene(str(ROBOTS / "four_bars_a02.toml"))
HANGING = {"A0": -np.pi / 2, "A1": -np.pi / 2, "A2": -np.pi / 2, "B0": np.pi / 2, "B1": np.pi / 2}


def slider(th):
    return R * mp.cos(th) + mp.sqrt(L**2 - R**2 * mp.sin(th) ** 2)


def rod(th):
    """Angle of the rod, and where its middle is."""
    phi = -mp.asin(R / L * mp.sin(th))
    return phi, R * mp.cos(th) + L / 2 * mp.cos(phi), R * mp.sin(th) + L / 2 * mp.sin(phi)


def inertia(th):
    """J with T = J th'^2 / 2, of the flywheel, the rod and the slider."""
    turn, x, z, slide = (mp.diff(f, th) for f in (*(lambda t, k=k: rod(t)[k] for k in range(3)), slider))
    return mpf("0.0216") + mpf("0.0045216") * turn**2 + mpf("0.6") * (x**2 + z**2) + mpf("1.2") * slide**2


@pytest.mark.parametrize(("torque", "viscous"), [(0.0, 0.0), (2.0, 30.0)], ids=["bent", "loaded and damped"])
def test_crank_slider(torque, viscous):
    """J th'' + d x'^2 th' + V'' th = 0 with V of the rod's weight, a bent spring at the slider and the motor's torque:
    what the pin carries makes a part of the stiffness."""
    k, rest = mpf(500), mpf("0.35")

    def energy(th):
        return mpf("0.6") * G * rod(th)[2] + k / 2 * (slider(th) - rest) ** 2 - torque * th

    with mp.workdps(30):
        angle = mp.findroot(lambda th: mp.diff(energy, th), mpf(1))
        stiffness, J = mp.diff(energy, angle, 2), inertia(angle)
        damping = viscous * mp.diff(slider, angle) ** 2
        expected = [complex(x) for x in mp.polyroots([J, damping, stiffness])]
    scene = replace(
        PUMP,
        drive={"main": Drive(torque=torque)},
        friction={"rail": Friction(viscous)},
        spring={"rail": Spring(500.0, 0.35)},
        initial_q={},
        initial_qd={},
    )
    found = linearize(robot("crank_slider"), scene, {"main": 1.0, "rail": 0.33}, equilibrium=True)
    assert found.balanced
    assert abs(found.q[0] - float(angle)) <= 1e-11
    assert abs(found.q[2] - float(slider(angle))) <= 1e-12
    (mode,) = found.modes.modes
    assert abs(complex(mode.real, mode.imag) - max(expected, key=lambda x: x.imag)) <= 1e-10 * abs(expected[0])
    assert found.modes.verdict == ("stable" if viscous else "marginal")
    assert (len(found.states), len(found.inputs)) == (2, 3)
    main, pin, rail = mode.shape
    assert (pin / main).real == pytest.approx(float(mp.diff(lambda t: rod(t)[0], angle)) - 1.0, rel=1e-10)
    assert (rail / main).real == pytest.approx(float(mp.diff(slider, angle)), rel=1e-10)


def test_inputs_of_all_joints_act():
    found = linearize(robot("crank_slider"), PUMP, {"main": 0.7})
    slope, J = float(mp.diff(slider, found.q[0])), float(inertia(mpf(found.q[0])))
    assert found.states == ("q_main", "qd_main")
    turned = float(mp.diff(lambda t: rod(t)[0], mpf(found.q[0]))) - 1.0
    assert found.B[1] == pytest.approx([1 / J, turned / J, slope / J], rel=1e-11)
    assert not found.B[0].any()


def test_four_bars():
    """Parallelograms of five unit rods: J = 3 / 3 + 2, V'' = -+3.5 m g l, hanging and upright."""
    model = robot("four_bars")
    scene = replace(BARS, initial_q={}, initial_qd={})
    (swing,) = linearize(model, scene, HANGING, equilibrium=True).modes.modes
    assert swing.imag == pytest.approx(np.sqrt(3.5 * 9.81 / 3.0), rel=1e-12)
    upright = linearize(model, scene, {name: -angle for name, angle in HANGING.items()}, equilibrium=True)
    assert upright.modes.verdict == "unstable"
    assert sorted(mode.real for mode in upright.modes.modes) == pytest.approx([-swing.imag, swing.imag], rel=1e-12)


def test_drives_of_a_closed_chain_hold_it():
    scene = replace(PUMP, drive={"main": Drive(kp=50.0, kd=1.0, reference=0.8)}, initial_q={}, initial_qd={})
    found = linearize(robot("crank_slider"), scene, {"main": 0.7}, equilibrium=True)
    assert found.modes.stable
    assert found.drive[0] == pytest.approx(50.0 * (0.8 - found.q[0]))
    with mp.workdps(30):
        weight = float(mp.diff(lambda th: mpf("0.6") * G * rod(th)[2], mpf(found.q[0])))
    assert found.drive[0] == pytest.approx(weight, rel=1e-10)


def test_refusals():
    model, flat = robot("crank_slider"), replace(BARS, initial_q={}, initial_qd={})
    turned = replace(PUMP, spring={}, drive={"main": Drive(torque=4.0)}, gravity=(0.0, 0.0, 0.0), friction={})
    rod, hinge = link("arm", 1.0, (0.5, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1)), joint("j", "base", "arm", axis=(0, -1, 0))
    held = Scene(loops=(Loop("pin", "arm", (1.0, 0, 0), to_point=(1.0, 0, 0)),))
    level = dict.fromkeys(HANGING, 0.0)
    for says, refused, equilibrium in (
        ("closed chains are linearized at rest", (model, PUMP, {"main": 0.5}, {"main": 1.0}), False),
        ("allow 3 motions here and 1 nearby, so that nothing is linear", (robot("four_bars"), flat, level), False),
        ("a closed chain on a base that moves is not linearized", (robot("four_bars", True), flat, HANGING), False),
        ("no equilibrium", (model, turned, {"main": 0.5}), True),
        ("nothing can move: the loops hold all joints", (built(link("base"), rod, hinge), held), False),
    ):
        with pytest.raises(InputError, match=says):
            linearize(*refused, equilibrium=equilibrium)


@pytest.mark.parametrize("mass", [1.0, 1e-3, 1e-9])
def test_what_hangs_beside_a_loop_is_balanced_by_what_it_carries(mass):
    """Bars of a ton, and beside them a pendulum that weighs next to nothing: it is at rest where it hangs down."""
    parts = [link("base")]
    for k, name in enumerate("abc"):
        parts.append(link(name, 1e3, (0.5 * (k > 1), 0, -0.5 * (k < 2)), (100.0, 0, 0, 100.0, 0, 100.0)))
        parts.append(joint(f"j{name}", ("base", "base", "a")[k], name, "continuous", (0, 1, 0), (k % 2, 0, -(k // 2))))
    parts += [link("bob", mass, (0, 0, -1e-3)), joint("swing", "base", "bob", "continuous", (0, 1, 0), (5, 0, 0))]
    model = built(*parts)
    scene = Scene(loops=(Loop("pin", "c", (1.0, 0.0, 0.0), to="b", to_point=(0.0, 0.0, -1.0)),))
    aside = linearize(model, scene, {"swing": 1e-3})
    assert not aside.balanced
    assert aside.held[3] == pytest.approx(mass * 9.81 * 1e-3 * np.sin(1e-3), rel=1e-6)
    found = linearize(model, scene, {"swing": 1.0}, equilibrium=True)
    assert abs(found.q[3]) <= 1e-9
    assert sorted(mode.imag for mode in found.modes.modes) == pytest.approx([np.sqrt(9.81 * 2 / 1.7), np.sqrt(9810.0)])
