"""Robots for tests of simulations: pendulums, a slide, and a free robot that tumbles."""

from __future__ import annotations

from functools import cache

from small_robots import built, joint, link, random_tree

from robodyn.scene import Drive, Friction, Scene

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
    """A free robot that tumbles with its joints moving, driven and rubbing, under gravity."""
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
