"""Whether MuJoCo and Drake refuse small descriptions as RD901 says, and what MuJoCo weighs links without <inertial>."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.consumers import answers
from helpers.mesh_files import obj
from helpers.mesh_samples import binary_stl

from robodyn.checks.check import Options, check_one
from robodyn.checks.consumers.water import invented
from robodyn.checks.context import Asked, Context
from robodyn.checks.examples import INERTIA, a_joint, a_link, arm, inertia
from robodyn.robot.urdf.document import read

LIMIT = '<limit lower="-1" upper="1" effort="3" velocity="1"/>'
AXIS = '<axis xyz="0 1 0"/>'
BALL = '<sphere radius="0.1"/>'
POINT = '<mass value="1"/>' + inertia("0 0 0 0 0 0")


def moved(
    inside: str = f'<mass value="1"/>{INERTIA}', more: str = "", joint: str = AXIS + LIMIT, kind: str = "revolute"
) -> str:
    """An arm with a tip: its <inertial>, what else is in it, and its joint."""
    tip = a_link("tip", inside).replace("</link>", f"{more}</link>")
    if not inside:
        tip = f'<link name="tip">{more}</link>'
    return arm(more=tip + a_joint("j", "upper", "tip", more=joint, kind=kind))


def shape(inner: str, kind: str = "collision", more: str = "") -> str:
    return f"<{kind}><geometry>{inner}</geometry>{more}</{kind}>"


def painted(*materials: str) -> str:
    return moved(more="".join(shape(BALL, "visual", material) for material in materials))


def weighed(mass: str, entries: str) -> str:
    return moved(f'<mass value="{mass}"/>{inertia(entries)}')


def fixed(*inertials: str) -> str:
    """A massless link on a joint, and links fixed to it."""
    links = [
        a_link(f"l{k}", inside) + a_joint(f"f{k}", "tip", f"l{k}", "", "fixed") for k, inside in enumerate(inertials)
    ]
    return moved("").replace("</robot>", "".join(links) + "</robot>")


def driven(inner: str, kind: str = "revolute", joint: str = AXIS + LIMIT) -> str:
    return moved(kind=kind, joint=joint).replace("</robot>", f'<transmission name="t">{inner}</transmission></robot>')


SIMPLE = "<type>transmission_interface/SimpleTransmission</type>"
DRIVE = f'{SIMPLE}<joint name="j"/><actuator name="m"/>'
TURNED = '<material name="paint"><color rgba="{}"/></material>'
MESH = '<mesh filename="{}"/>'
HEALTHY = f'<mass value="1"/>{INERTIA}'
CASES = {
    "healthy": moved(),
    "no inertial": moved(""),
    "a ball for a mass": moved("", shape(BALL)),
    "two balls in one place": moved("", shape(BALL) * 2),
    "a box, turned": moved("", shape('<box size="0.1 0.2 0.3"/>', more='<origin rpy="0.3 0.4 0.5" xyz="0 0 1"/>')),
    "a cylinder": moved("", shape('<cylinder radius="0.1" length="0.3"/>')),
    "a ball to look at": moved("", shape(BALL, "visual")),
    "an inertial of zeros and a ball": moved('<mass value="0"/>' + inertia("0 0 0 0 0 0"), shape(BALL)),
    "a ball too small": moved("", shape('<sphere radius="1e-4"/>')),
    "a tetrahedron": moved("", shape(MESH.format("part.stl"))),
    "two objects": moved("", shape(MESH.format("two.obj"))),
    "a flat mesh": moved(more=shape(MESH.format("flat.stl"))),
    "a flat mesh to look at": moved(more=shape(MESH.format("flat.stl"), "visual")),
    "a text": moved(more=shape(MESH.format("text.stl"))),
    "zero box": moved(more=shape('<box size="0.1 0 0.1"/>')),
    "zero box to look at": moved(more=shape('<box size="0.1 0 0.1"/>', "visual")),
    "zero sphere": moved(more=shape('<sphere radius="0"/>')),
    "negative cylinder": moved(more=shape('<cylinder radius="0.1" length="-1"/>')),
    "short box": moved(more=shape('<box size="1 1"/>')),
    "no size": moved(more=shape("<box/>")),
    "no geometry": moved(more="<collision/>"),
    "no geometry to look at": moved(more="<visual/>"),
    "a plane": moved(more=shape('<plane normal="0 0 1"/>')),
    "zero scale": moved(more=shape('<mesh filename="part.obj" scale="0 1 1"/>')),
    "one scale": moved(more=shape('<mesh filename="part.obj" scale="2"/>')),
    "moments of 1e-22": weighed("1", "1e-22 0 0 1e-22 0 1e-22"),
    "moments of 9e-15": weighed("1", "9e-15 0 0 9e-15 0 9e-15"),
    "moments of 2e-14": weighed("1", "2e-14 0 0 2e-14 0 2e-14"),
    "triangle by 1e-13": weighed("1", "0.1 0 0 0.1 0 0.20000000000002"),
    "a plate": weighed("1", "0.1 0 0 0.2 0 0.3"),
    "negative mass": weighed("-1", "0.1 0 0 0.1 0 0.1"),
    "a point": moved(POINT),
    "massless and a point": fixed(POINT),
    "massless, a point and a body": fixed(POINT, HEALTHY),
    "massless, a body and a point": fixed(HEALTHY, POINT),
    "massless and a tensor": fixed('<mass value="0"/>' + INERTIA),
    "no mass element": moved(INERTIA),
    "no product": moved(HEALTHY.replace('ixy="0"', "")),
    "a word for a mass": moved(HEALTHY.replace('"1"', '"heavy"')),
    "a unit": moved(HEALTHY.replace('value="1"', 'value="1kg"')),
    "two inertials": moved(more=f"<inertial>{HEALTHY}</inertial>"),
    "commas": moved(f'<origin xyz="0,0,0"/>{HEALTHY}'),
    "four numbers": moved(f'<origin rpy="0 0 0 0"/>{HEALTHY}'),
    "NaN": moved(more=shape(BALL, more='<origin rpy="0 0 nan"/>')),
    "commas in a visual": moved(more=shape(BALL, "visual", '<origin xyz="0,0,0"/>')),
    "axis without xyz": moved(joint="<axis/>" + LIMIT),
    "fixed axis without xyz": moved(joint="<axis/>", kind="fixed"),
    "no axis": moved(joint=LIMIT),
    "two axes": moved(joint=AXIS * 2 + LIMIT),
    "short axis": moved(joint='<axis xyz="0 5e-8 0"/>' + LIMIT),
    "negative velocity": moved(joint=AXIS + LIMIT.replace('velocity="1"', 'velocity="-1"')),
    "negative velocity, fixed": moved(joint=LIMIT.replace('velocity="1"', 'velocity="-1"'), kind="fixed"),
    "upside down": moved(joint=AXIS + LIMIT.replace('"-1"', '"2"')),
    "upside down, continuous": moved(joint=AXIS + LIMIT.replace('"-1"', '"2"'), kind="continuous"),
    "lower alone": moved(joint=AXIS + '<limit lower="1" effort="3" velocity="1"/>'),
    "a word for a limit": moved(joint=AXIS + LIMIT.replace('"3"', '"strong"')),
    "damping of a plane": moved(joint='<axis xyz="0 0 1"/><dynamics damping="1"/>', kind="planar"),
    "planar": moved(joint='<axis xyz="0 0 1"/>', kind="planar"),
    "floating far out": moved(joint="", kind="floating"),
    "mimics itself": moved(joint=AXIS + LIMIT + '<mimic joint="j"/>'),
    "a second world": moved().replace('"tip"', '"world"'),
    "colour": painted(TURNED.format("1 0 0 1")),
    "colour of 255": painted(TURNED.format("255 0 0 1")),
    "colour of three": painted(TURNED.format("1 0 0")),
    "two colours": painted(TURNED.format("1 0 0 1"), TURNED.format("1 0 1 1")),
    "colour twice": painted(TURNED.format("1 0 0 1"), TURNED.format("1 0 0 1.0")),
    "no colour": painted('<material name="paint"/>'),
    "nothing of a material": painted("<material/>"),
    "defined too late": painted('<material name="paint"/>', TURNED.format("1 0 0 1")),
    "defined by the robot": painted('<material name="paint"/>').replace(
        "</robot>", TURNED.format("1 0 0 1") + "</robot>"
    ),
    "no texture": painted('<material name="paint"><texture filename="none.png"/></material>'),
    "driven": driven(DRIVE),
    "driven by nothing": driven(f'{SIMPLE}<joint name="j"/>'),
    "drives nothing": driven(DRIVE.replace('"j"', '"none"')),
    "of no type": driven('<joint name="j"/><actuator name="m"/>'),
    "of another type": driven(DRIVE.replace('"j"', '"none"').replace("Simple", "Differential")),
    "negative effort, driven": driven(DRIVE, joint=AXIS + LIMIT.replace('"3"', '"-3"')),
    "driven though fixed": driven(DRIVE, "fixed", ""),
    "driven twice": driven(f'{DRIVE}</transmission><transmission name="u">{DRIVE}'),
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The cases as files, beside their meshes."""
    folder = tmp_path_factory.mktemp("cases")
    corners = np.array([(0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1)])
    part = corners[np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])]
    (folder / "part.stl").write_bytes(binary_stl(part))
    (folder / "part.obj").write_bytes(obj(part))
    (folder / "flat.stl").write_bytes(binary_stl(part * (1, 1, 0)))
    (folder / "text.stl").write_text("solid a\n" + "facet normal 0 0 0\n" * 9 + "endsolid\n")
    lines = obj(np.concatenate((part, part * 2 + 1))).decode().splitlines()
    (folder / "two.obj").write_text("\n".join(["o one", *lines[: -len(part)], "o two", *lines[-len(part) :], ""]))
    found = {}
    for k, (name, text) in enumerate(CASES.items()):
        found[name] = folder / f"case{k}.urdf"
        found[name].write_text(text, encoding="utf-8")
    return found


@pytest.mark.parametrize("target", ["mujoco", "drake"])
def test_refusals(target: str, files: dict[str, Path]) -> None:
    """What is refused is foretold, and nothing else; as errors, since the program is asked for."""
    options = Options(select=("RD901",), asked=Asked(targets=(target,)))
    said = {name: check_one(str(file), options)[0] for name, file in files.items()}
    foretold = {name for name, finding in said.items() if f"{target} rejects it" in finding.message}
    refused = {
        name: one.refused for name, one in zip(files, answers(target, [*files.values()]), strict=True) if one.refused
    }
    unforetold = {name: why for name, why in refused.items() if name not in foretold}
    assert not unforetold, "\n".join(f"{name}: {why}" for name, why in unforetold.items())
    assert foretold - set(refused) == set()
    assert all((finding.severity.value == "error") == (name in foretold) for name, finding in said.items())
    assert len(refused) > 20


def test_invented_masses(files: dict[str, Path]) -> None:
    """MuJoCo's masses of the links that have none, within its rounding; in single precision for meshes."""
    compared = 0
    for (name, file), one in zip(files.items(), answers("mujoco", [*files.values()]), strict=True):
        for link, mass in invented(Context(read(str(file)))).items():
            if one.masses is not None:
                assert mass == pytest.approx(one.masses[link], rel=1e-6), name
                compared += 1
    assert compared >= 6


FLOAT = moved(joint="", kind="floating")
GAZEBO = {
    "healthy": (moved().replace('<link name="base"/>', a_link("base")), ""),
    "a root without mass": (moved(), "rejects it: it keeps nothing"),
    "a root called world": (moved().replace('"base"', '"world"'), "loads it"),
    "a root with mass fixed to it": (
        moved().replace("</robot>", a_link("body") + a_joint("f", "base", "body", "", "fixed") + "</robot>"),
        "loads it",
    ),
    "a leaf without mass": (moved(""), "drops links without mass, and all joints and links behind them (link 'tip')"),
    "a leaf with mass fixed to it": (fixed(HEALTHY), "loads it"),
    "a frame that carries": (
        fixed("")
        .replace('"tip"', '"frame"')
        .replace('"j" type="revolute"', '"j" type="fixed"')
        .replace("</robot>", a_link("hand") + a_joint("k", "frame", "hand") + "</robot>"),
        "drops links without mass, and all joints and links behind them (link 'frame')",
    ),
    "nothing joined to nothing": (
        fixed('<mass value="0"/>' + inertia("0 0 0 0 0 0"), HEALTHY),
        "finds no centre of mass of <inertial>s without mass that are fixed to each other (link 'tip')",
    ),
    "negative mass": (weighed("-1", "0.1 0 0 0.1 0 0.1"), "wants inertia that a body can have"),
    "a plate": (weighed("1", "0.1 0 0 0.2 0 0.3"), "loads it"),
    "moments of 1e-22": (weighed("1", "1e-22 0 0 1e-22 0 1e-22"), "loads it"),
    "triangle by 1e-13": (weighed("1", "0.1 0 0 0.1 0 0.20000000000002"), "wants inertia that a body can have"),
    "floating": (FLOAT, "knows no floating and no planar joints"),
    "short axis": (moved(joint='<axis xyz="0 5e-7 0"/>' + LIMIT), "wants an axis"),
    "axis without xyz": (moved(joint="<axis/>" + LIMIT), "wants an axis"),
    "no limit": (moved(joint=AXIS), "wants numbers, and <limit>"),
    "no effort": (moved(joint=AXIS + LIMIT.replace('effort="3"', "")), "wants numbers, and <limit>"),
    "continuous": (moved(joint=AXIS, kind="continuous"), "loads it"),
    "upside down": (moved(joint=AXIS + LIMIT.replace('"-1"', '"2"')), "exchanges limits"),
    "a joint called as a link": (moved().replace('name="j"', 'name="tip"'), "wants names of joints"),
    "reserved": (moved().replace('"tip"', '"__tip__"'), "none like __this__"),
}


@pytest.mark.parametrize("case", GAZEBO)
def test_gazebo(case: str) -> None:
    """What sdformat 12.3 was seen to do; all but the second case have a base with mass."""
    text, words = GAZEBO[case]
    if case not in ("a root without mass", "a root called world", "a root with mass fixed to it"):
        text = text.replace('<link name="base"/>', a_link("base"))
    (one,) = check_one(text.encode(), Options(select=("RD901",), asked=Asked(targets=("gz",))))
    assert words in one.message
    if words == "loads it":
        assert not {"drops", "exchanges"} & set(one.message.split())
