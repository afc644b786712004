"""A robot with a left and a right arm, that the documentation of the mirror rules is written in."""

from __future__ import annotations

TENSOR = '<inertia ixx="0.02" ixy="0.004" ixz="0.002" iyy="0.03" iyz="0.003" izz="0.025"/>'
IMAGE = '<inertia ixx="0.02" ixy="-0.004" ixz="0.002" iyy="0.03" iyz="-0.003" izz="0.025"/>'
"""Of `TENSOR` across y = 0."""
ORIGIN = '<origin xyz="0.1 0.05 0.2"/>'
ORIGIN_IMAGE = '<origin xyz="0.1 -0.05 0.2"/>'
LIMIT = '<limit lower="-0.5" upper="2" effort="30" velocity="3"/>'


def two_arms(
    right: str = f'{ORIGIN_IMAGE}<mass value="2"/>{IMAGE}',
    left: str = f'{ORIGIN}<mass value="2"/>{TENSOR}',
    right_joint: str = f'<axis xyz="0 1 0"/>{LIMIT}',
) -> str:
    """A robot that is symmetric across y = 0, but for what is given of its right arm."""
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
    <origin xyz="0 0.3 0"/><axis xyz="0 1 0"/>{LIMIT}
  </joint>
  <joint name="right_shoulder" type="revolute">
    <parent link="base"/><child link="right_arm"/>
    <origin xyz="0 -0.3 0"/>{right_joint}
  </joint>
</robot>
"""
