"""Coulomb friction that holds, steps that are too long for it, and springs at joint limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, slide

import robodyn
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, Friction, LimitSpring, Payload, Scene, Spring
from robodyn.simulation.methods import METHODS, method_named
from robodyn.simulation.stiff_steps import reach

M, F, PUSH, SLIP = 2.0, 3.0, 2.0, 1e-4
WEIGHTLESS = Scene(gravity=(0, 0, 0))
HELD = replace(
    WEIGHTLESS, friction={"j1": Friction(forward=F, backward=-F)}, drive={"j1": Drive(torque=PUSH)}, slip_speed=SLIP
)
CREEP = SLIP * PUSH / np.sqrt(F**2 - PUSH**2)
FIXED = [method.name for method in METHODS if not (method.adaptive or method.leapfrog or method.keeps_momenta)]


@pytest.mark.parametrize("name", [*sampled(FIXED, 3), "radau"])
def test_a_block_below_breakaway_creeps_and_does_not_chatter(name):
    """From rest: the speed rises to that of the creep and stays; no method's default step lets it swing."""
    found = robodyn.simulate(slide(M), HELD, 0.5, method=name)
    speed = found.qd[:, 0]
    late = found.time > 20 * SLIP * M / F
    assert abs(speed[-1] - CREEP) <= 1e-6 * CREEP
    assert np.abs(speed[late] - CREEP).max() <= 1e-3 * CREEP
    assert (speed >= 0).all()
    assert abs(found.q[-1, 0] - 0.5 * CREEP) <= 2e-3 * 0.5 * CREEP
    assert found.notes[-1].startswith(
        'friction holds "j1" for 0.5 s, in which it creeps 4.5e-05 m, at most 8.9e-05 m/s'
    )


def test_the_default_step_follows_stiff_friction_or_another_method_does():
    usual = robodyn.simulate(slide(M), HELD, 0.5)
    assert (usual.method.name, usual.step) == ("rk4", 5e-5)
    assert 'Coulomb friction near rest of "j1" settles at 1.5e+04/s: steps of 5e-05 s follow it' in usual.notes
    stiffer = robodyn.simulate(slide(M), replace(HELD, slip_speed=1e-7), 0.5)
    assert (stiffer.method.name, stiffer.rtol) == ("radau", 1e-9)
    assert 'Coulomb friction near rest of "j1" settles at 1.5e+07/s: radau follows it' in stiffer.notes
    named = robodyn.simulate(slide(M), HELD, 0.5, method="midpoint")
    assert (named.method.name, named.step) == ("midpoint", 5e-5)


def test_a_step_that_is_too_long_chatters_and_the_report_says_what_to_do():
    found = robodyn.simulate(slide(M), HELD, 0.5, step=1e-3)
    remark = next(caveat.text for caveat in found.caveats if caveat.text.startswith("STEP TOO LONG"))
    assert remark == (
        'STEP TOO LONG: Coulomb friction near rest of "j1" settles at 1.5e+04/s, which rk4 follows with steps of up '
        "to 0.00019 s; with 0.001 s it chatters (give --step 5e-05, or --method radau, or slip_speed = 0.001 in the "
        "scene)"
    )
    assert np.abs(found.qd[-50:, 0] - CREEP).max() > 5 * CREEP
    for remedied in ({"step": 5e-5}, {"method": "radau"}):
        cured = robodyn.simulate(slide(M), HELD, 0.5, **remedied)
        assert np.abs(cured.qd[cured.time > 0.4, 0] - CREEP).max() <= 1e-4 * CREEP
        assert not any("STEP TOO LONG" in caveat.text for caveat in cured.caveats)
    slower = robodyn.simulate(slide(M), replace(HELD, slip_speed=1e-3), 0.5, step=1e-3)
    assert np.abs(slower.qd[-50:, 0] - 10 * CREEP).max() <= 1e-4 * CREEP


def test_a_step_that_does_not_get_through_is_given_a_number():
    scene = replace(WEIGHTLESS, drive={"j1": Drive(kd=1e7)}, initial_qd={"j1": 1.0}, joint_limits="ignore")
    with pytest.raises(InputError) as caught:
        robodyn.simulate(slide(M), scene, 1.0, step=0.01)
    assert caught.value.remedy == "give --step 2e-07, or --method radau"
    with pytest.raises(InputError) as caught:
        robodyn.simulate(slide(M), scene, 1.0, step=0.01, method="gauss4")
    assert caught.value.remedy == "give --step 1e-07, or --method radau"


@pytest.mark.parametrize("name", ["symplectic-euler", "rk4"])
def test_the_reach_is_the_end_of_stability(name):
    """Of a joint with friction d qd, at a step of 0.98 and 1.02 times the longest."""
    scene = replace(WEIGHTLESS, friction={"j1": Friction(viscous=100.0)}, initial_qd={"j1": 1.0})
    longest = reach(method_named(name)) * M / 100.0
    ends = [robodyn.simulate(slide(M), scene, 200 * k * longest, step=k * longest, method=name) for k in (0.98, 1.02)]
    below, above = (abs(found.qd[-1, 0]) for found in ends)
    assert below < 1.0 < above
    assert [any("STEP TOO LONG: viscous friction" in caveat.text for caveat in found.caveats) for found in ends] == [
        False,
        True,
    ]


CAUSES = {
    "the drive's kd": Scene(drive={"elbow": Drive(kd=1e5)}),
    "the drive's kp": Scene(drive={"elbow": Drive(kp=1e8)}),
    "the spring": Scene(spring={"elbow": Spring(1e8)}),
    "the limit spring": Scene(limit_spring=LimitSpring(1e8)),
    "the limit spring's damping": Scene(limit_spring=LimitSpring(1.0, 1e5)),
    "viscous friction": Scene(friction={"elbow": Friction(viscous=1e5)}),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_the_stiffest_is_named(cause):
    found = robodyn.simulate(robot("two_link_planar"), replace(CAUSES[cause], gravity=(0, 0, 0)), 1e-3)
    assert any(note.startswith(f'{cause} of "elbow" settles at ') for note in found.notes)


def test_what_is_not_stiff_is_left_alone():
    for scene in (Scene(), Scene(friction={"j1": Friction(viscous=1.0)}), Scene(payloads=(Payload("l1", 1.0),))):
        found = robodyn.simulate(pendulum(), scene, 0.01)
        assert (found.step, found.notes) == (1e-3, ())


HIT = replace(WEIGHTLESS, joint_limits="spring", initial_qd={"j1": 2.0}, initial_q={"j1": 8.9})


@pytest.mark.parametrize("how", [{"step": 1e-4}, {"step": 1e-4, "method": "gauss4"}, {"rtol": 1e-10}])
def test_a_slide_bounces_off_a_spring(how):
    """x = v / w sin(w t), w^2 = k / m: the deepest is v / w, and the speed comes back."""
    k = 5e4
    w = np.sqrt(k / M)
    found = robodyn.simulate(slide(M), replace(HIT, limit_spring=LimitSpring(k)), 0.1, **how)
    assert abs(found.qd[-1, 0] + 2.0) <= 3e-6
    assert found.energy_drift <= 1e-5
    assert not found.ended
    assert f"{2.0 / w:.4g}" == "0.01265"
    (note,) = found.notes
    assert note.startswith('springs at limits: "j1" passes its upper limit of 9 m by at most 0.01265 m, at 0.0599')


def test_a_damped_limit_takes_energy_and_never_pulls():
    """m xdd = -k x - d xd until the push ends: with zeta the share of critical damping, a closed form."""
    k, d = 5e4, 60.0
    w, zeta = np.sqrt(k / M), d / 2 / np.sqrt(k * M)
    scene = replace(HIT, limit_spring=LimitSpring(k, d))
    found = robodyn.simulate(slide(M), scene, 0.1, step=1e-5)
    damped = w * np.sqrt(1 - zeta**2)
    end = np.arctan2(2 * zeta * np.sqrt(1 - zeta**2), 2 * zeta**2 - 1) / damped  # where k x + d xd is 0 again
    speed = 2.0 * np.exp(-zeta * w * end) * (np.cos(damped * end) - zeta * w / damped * np.sin(damped * end))
    assert abs(found.qd[-1, 0] - speed) <= 1e-4
    assert speed < 0
    assert found.work[-1] < 0
    assert found.energy_drift <= 1e-3


def test_limits_that_no_joint_reaches():
    none = ("springs at limits: no joint reaches a limit",)
    scene = replace(HIT, initial_q={}, limit_spring=LimitSpring(1e3))
    assert robodyn.simulate(slide(M), scene, 0.01).notes == none
    assert robodyn.simulate(pendulum(), replace(scene, gravity=(0, 0, -1)), 0.01).notes == none


def test_a_tolerance_alone_leaves_stiff_friction_to_radau():
    usual = robodyn.simulate(slide(M), replace(HELD, slip_speed=1e-7), 0.5, rtol=1e-6)
    assert (usual.method.name, usual.rtol) == ("radau", 1e-6)
    assert usual.evaluations <= 1000
    assert robodyn.simulate(slide(M), replace(HELD, slip_speed=1e-2), 0.5, rtol=1e-6).method.name == "dop853"
