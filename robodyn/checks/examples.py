"""Small descriptions that the documentation of the rules is written in."""

from __future__ import annotations

SRDF = """<robot name="arm">
  <group name="all"><joint name="shoulder"/></group>
  <group_state name="home" group="all"><joint name="shoulder" value="0"/></group_state>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
</robot>
"""


def inertia(entries: str) -> str:
    """Return <inertia> with the six entries between blanks, ixx ixy ixz iyy iyz izz."""
    return '<inertia ixx="{}" ixy="{}" ixz="{}" iyy="{}" iyz="{}" izz="{}"/>'.format(*entries.split())


INERTIA = inertia("0.01 0 0 0.02 0 0.02")
SHAPED_INERTIA = inertia("0.0126 0 0 0.0124 0 0.0032")
_ONE = f'<mass value="1"/>{INERTIA}'
LIMIT = '<limit lower="-2" upper="2" effort="30" velocity="3"/>'
_TURNS = f'<axis xyz="0 1 0"/>{LIMIT}'


def one_link(inertial: str = f'<mass value="2"/>{INERTIA}') -> str:
    """Return a robot of one link with the inertial given."""
    return f"""<robot name="part">
  <link name="part">
    <inertial>
      {inertial}
    </inertial>
  </link>
</robot>
"""


def arm(joint: str = _TURNS, kind: str = "revolute", more: str = "") -> str:
    """Return an arm of one joint of some kind, with what is in the joint, and more elements of the robot."""
    return f"""<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial><mass value="2"/>{INERTIA}</inertial>
  </link>
  <joint name="shoulder" type="{kind}">
    <parent link="base"/>
    <child link="upper"/>
    {joint}
  </joint>{more}
</robot>
"""


def a_link(name: str, inertial: str = _ONE, more: str = "") -> str:
    """Return a link, to be used as `more` of an arm."""
    inside = f"<inertial>{inertial}</inertial>" if inertial else ""
    return f'\n  <link name="{name}">{inside}{more}</link>'


def a_joint(name: str, parent: str, child: str, more: str = _TURNS, kind: str = "revolute") -> str:
    """Return a joint, to be used as `more` of an arm."""
    return f"""
  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/><child link="{child}"/>{more}
  </joint>"""


def longer_arm(
    link: str = "fore", joint: str = "elbow", inertial: str = _ONE, inside: str = _TURNS, kind: str = "revolute"
) -> str:
    """Return an arm with one more link on a joint of some kind, with what is in the link and in the joint."""
    return arm(more=a_link(link, inertial) + a_joint(joint, "upper", link, inside, kind))


def a_shaped_link(
    mass: str = "2", inertia: str = SHAPED_INERTIA, centre: str = "0 0 0.12", shape: str = '<box size="0.1 0.1 0.25"/>'
) -> str:
    """Return an arm whose upper link has a shape 0.25 m long, and an inertial that fits it but for what is given."""
    inertial = f'<origin xyz="{centre}"/><mass value="{mass}"/>{inertia}'
    return arm().replace(
        f'<inertial><mass value="2"/>{INERTIA}</inertial>',
        f"""<visual><origin xyz="0 0 0.125"/><geometry>{shape}</geometry></visual>
    <inertial>{inertial}</inertial>""",
    )


def a_tower(kind: str = "visual", last: str = "revolute") -> str:
    """Return such an arm with three boxes on top, each 0.1 m above the last, the third on a joint of some kind."""
    shape = f'<{kind}><geometry><box size="0.1 0.1 0.1"/></geometry></{kind}>'
    inertial = f'<mass value="1"/>{inertia("0.0017 0 0 0.0018 0 0.0019")}'
    rows = (
        ("fore", "elbow", "upper", "revolute"),
        ("hand", "wrist", "fore", "revolute"),
        ("tool", "mount", "hand", last),
    )
    more = "".join(
        a_link(link, inertial, shape) + a_joint(joint, parent, link, f'<origin xyz="0 0 0.1"/>{_TURNS}', moves)
        for link, joint, parent, moves in rows
    )
    return a_shaped_link().replace("\n</robot>", f"{more}\n</robot>")


def a_mesh(name: str, kind: str = "collision") -> str:
    """Return a robot of one link with one mesh."""
    return f"""<robot name="part">
  <link name="part">
    <{kind}><geometry><mesh filename="{name}"/></geometry></{kind}>
  </link>
</robot>
"""


TENSOR, IMAGE = inertia("0.02 0.004 0.002 0.03 0.003 0.025"), inertia("0.02 -0.004 0.002 0.03 -0.003 0.025")
"""Mirror images of each other across y = 0."""
ORIGIN = '<origin xyz="0.1 0.05 0.2"/>'
ORIGIN_IMAGE = '<origin xyz="0.1 -0.05 0.2"/>'
ARM_LIMIT = '<limit lower="-0.5" upper="2" effort="30" velocity="3"/>'


def two_arms(
    right: str = f'{ORIGIN_IMAGE}<mass value="2"/>{IMAGE}',
    left: str = f'{ORIGIN}<mass value="2"/>{TENSOR}',
    right_joint: str = f'<axis xyz="0 1 0"/>{ARM_LIMIT}',
) -> str:
    """Return a robot that is symmetric across y = 0, but for what is given of its right arm."""
    return f"""<robot name="two_arms">
  <link name="base"/>
  <link name="left_arm">
    <inertial>{left}</inertial>
  </link>
  <link name="right_arm">
    <inertial>{right}</inertial>
  </link>
  <joint name="left_shoulder" type="revolute">
    <parent link="base"/><child link="left_arm"/>
    <origin xyz="0 0.3 0"/><axis xyz="0 1 0"/>{ARM_LIMIT}
  </joint>
  <joint name="right_shoulder" type="revolute">
    <parent link="base"/><child link="right_arm"/>
    <origin xyz="0 -0.3 0"/>{right_joint}
  </joint>
</robot>
"""


def two_elbows(right: str = "0.1 -0.05 0.3") -> str:
    """Return such a robot with a forearm on each arm, and where the right elbow is on the right arm."""
    sides = (("left", "0.1 0.05 0.3"), ("right", right))
    more = "".join(
        a_link(f"{side}_fore")
        + a_joint(f"{side}_elbow", f"{side}_arm", f"{side}_fore", f'<origin xyz="{xyz}"/>{_TURNS}')
        for side, xyz in sides
    )
    return two_arms().replace("</robot>", f"{more.lstrip()}\n</robot>")
