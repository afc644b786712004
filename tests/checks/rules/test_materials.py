"""Materials that are not defined."""

from __future__ import annotations

from robodyn.checks.check import found_in
from robodyn.checks.examples import arm

NAMES = ("sand", "teal", "plum", "olive", "ivory", "coral")


def test_the_materials_there_are_stand_in_the_order_of_the_file() -> None:
    """In sets names stand in another order in every process."""
    materials = "".join(f'\n  <material name="{name}"><color rgba="0 0 1 1"/></material>' for name in NAMES)
    shape = '<visual><geometry><sphere radius="0.1"/></geometry><material name="zzz"/></visual>'
    text = arm(more=materials).replace('<link name="base"/>', f'<link name="base">{shape}</link>')
    (remedy,) = (finding.remedy for finding in found_in(text.encode()).shown if finding.code == "RD621")
    assert remedy == f"materials: {', '.join(repr(name) for name in NAMES)}"
