"""Robots for tests of simulations: pendulums, a slide, and a free robot that tumbles."""

from __future__ import annotations

from functools import cache

from helpers.small_robots import built, joint, link, random_tree
from robodyn.scene.scene import Drive, Friction, Scene

POINT = (1.0, (0, 0, -1))


@cache
def pendulum(*, masses=1):
    """Point masses below one another on rods of 1 m that turn about -y, so that positive angles go to +x."""
    parts = [link("l0")]
    for k in range(1, masses + 1):
        parts += [link(f"l{k}", *POINT)]
        place = (0, 0, -1 if k > 1 else 0)
        parts.append(joint(f"j{k}", f"l{k - 1}", f"l{k}", "continuous", (0, -1, 0), place))
    return built(*parts)


@cache
def slide(mass=2.0, axis=(1, 0, 0)):
    return built(link("l0"), link("l1", mass), joint("j1", "l0", "l1", "prismatic", axis))


@cache
def tumbling():
    """A free robot that tumbles with its joints moving, driven and joints_with_friction, under gravity."""
    model = random_tree(5, n=3, moving_base=True, kinds=("revolute", "prismatic"))
    speeds = dict(zip(model.rates, (1.5, -1.0, 0.8, 0.3, 0.2, -0.4, 1.0, -1.2, 0.7), strict=True))
    scene = Scene(
        initial_q={"base_qx": 0.5, "j1": 0.4},
        initial_qd=speeds,
        drive={"j1": Drive(kp=3.0, kd=0.5), "j2": Drive(torque=0.2)},
        friction={"j3": Friction(viscous=0.1)},
        joint_limits="ignore",
        moving_base=True,
    )
    return model, scene


def mass_on_a_table(inertia):
    """1 kg on a slide through the axis of a turntable."""
    return built(
        link("l0"),
        link("table", 0.001, inertia=(inertia, 0, 0, inertia, 0, inertia)),
        link("mass", 1.0),
        joint("turn", "l0", "table", "continuous"),
        joint("rail", "table", "mass", "prismatic", (1, 0, 0)),
    )


@cache
def turntable(friction=None, **more):
    """A turntable of 1e-4 kg m^2, pushed by 0.8 N m and held by 1 N m of friction, under 1 kg on a slide.

    The slide is driven from 0.5 m to the table's axis, where the friction settles 2500 times as fast as at the start.
    """
    scene = Scene(
        gravity=(0, 0, 0),
        initial_q={"rail": 0.5},
        friction={"turn": friction or Friction(forward=1.0, backward=-1.0)},
        drive={"rail": Drive(kp=100.0, kd=20.0), "turn": Drive(torque=0.8)},
        **more,
    )
    return mass_on_a_table(1e-4), scene
