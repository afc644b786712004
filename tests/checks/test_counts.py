"""How often what is costly is done for one robot: once for the same numbers, however many rules ask."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from robodyn.checks.bodies import bodies, masses
from robodyn.checks.check import Options, check_one
from robodyn.solids.inertia.validity import Box

LINK = """
  <link name="{name}">
    <inertial><origin xyz="0 0 0.2"/><mass value="{mass}"/>
      <inertia ixx="0.028" ixy="0" ixz="0" iyy="0.028" iyz="0.001" izz="0.003"/></inertial>
    <visual><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></visual>
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></collision>
  </link>"""
JOINT = """
  <joint name="to_{name}" type="revolute"><origin xyz="0 0 0.4"/><parent link="{parent}"/><child link="{name}"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="2"/></joint>"""


@pytest.fixture
def count(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any, str], Counter[str]]:
    """Counts the calls of functions from now on."""
    counts: Counter[str] = Counter()

    def counted(owner: Any, name: str) -> Counter[str]:
        function = getattr(owner, name)

        def call(*arguments: Any) -> Any:
            counts[name] += 1
            return function(*arguments)

        monkeypatch.setattr(owner, name, call)
        return counts

    return counted


def chain(links: int, mass: Callable[[int], float]) -> bytes:
    parts = [LINK.format(name=f"l{k}", mass=mass(k)) for k in range(links)]
    parts += [JOINT.format(name=f"l{k}", parent=f"l{k - 1}") for k in range(1, links)]
    return f'<robot name="chain">{"".join(parts)}\n</robot>'.encode()


def test_links_alike_are_weighed_and_their_moments_found_once(count: Callable[[Any, str], Counter[str]]) -> None:
    """Of nine links of two kinds, which differ in the mass."""
    bodies._verdict.cache_clear()
    masses.principal_moments.cache_clear()
    count(masses.np.linalg, "eigvalsh")
    counts = count(bodies, "mistake_posterior")
    check_one(chain(9, lambda k: 2.0 + k % 2), Options(select=("ALL",)))
    assert counts["mistake_posterior"] == 2
    assert counts["eigvalsh"] <= 3


def test_a_shape_is_put_along_its_link_once(count: Callable[[Any, str], Counter[str]]) -> None:
    """Its visual and its collision shape; the others are a neighbour's box seen from a link, and the root's axes."""
    counts = count(Box, "placed")
    of = []
    for links in (4, 12):
        counts.clear()
        check_one(chain(links, lambda k: 2.0), Options(select=("ALL",)))
        of.append(counts["placed"])
    assert of[1] - of[0] == 5 * 8
