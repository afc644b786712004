"""A small arm with places for defects."""

from __future__ import annotations

FAMILIES = ("RD0", "RD1", "RD2", "RD5")
"""The rules that these tests plant defects for; select them where findings are counted."""
INERTIA = '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>'
IDENTITY = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'


def arm(*, upper: str = INERTIA, fore: str = INERTIA, shoulder: str = "0 1 0", elbow: str = "0 1 0") -> str:
    """Two links on a base, with an inertia each and two axes; clean as it is."""
    limit = '<limit lower="-2" upper="2" effort="30" velocity="3"/>'
    return f"""<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.2 0 0"/>
      <mass value="2"/>
      {upper}
    </inertial>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0.1 0 0.02"/>
      <mass value="2"/>
      {fore}
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="{shoulder}"/>
    {limit}
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0.4 0 0"/>
    <parent link="upper"/>
    <child link="fore"/>
    <axis xyz="{elbow}"/>
    {limit}
  </joint>
</robot>
"""
