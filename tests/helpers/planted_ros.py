"""Defects of what ROS reads, planted in the text of published robots, and what looks like one and is none.

An edit is given the text of the description and of the SRDF beside it, and returns both. What it is planted in, the
names of joints and links, it takes from the description, so that each is planted in several robots.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from math import degrees
from pathlib import Path
from typing import NamedTuple

from helpers.example_robots import path_of

Texts = tuple[str, str]
Edit = Callable[[str, str], Texts]


def texts_of(stem: str) -> Texts:
    """The description and the SRDF that goes with it, empty if there is none."""
    urdf = path_of(stem)
    srdf = urdf.parent.parent / "srdf" / f"{urdf.stem.partition('_')[0]}.srdf"
    return urdf.read_text(encoding="utf-8"), srdf.read_text(encoding="utf-8") if srdf.is_file() else ""


def write(folder: Path, texts: Texts) -> Path:
    """Write them as a package has them, and return the description's path."""
    for name, text in zip(("urdf/robot.urdf", "srdf/robot.srdf"), texts, strict=True):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if text:
            (folder / name).write_text(text, encoding="utf-8")
    return folder / "urdf" / "robot.urdf"


def moving(urdf: str) -> list[str]:
    """Names of the joints that move and follow no other."""
    joints = ET.fromstring(urdf).findall("joint")
    moved = [joint for joint in joints if joint.get("type") in ("revolute", "prismatic", "continuous")]
    return [joint.get("name", "") for joint in moved if joint.find("mimic") is None]


def fixed(urdf: str) -> str:
    return next(joint.get("name", "") for joint in ET.fromstring(urdf).findall("joint") if joint.get("type") == "fixed")


def follower(urdf: str) -> tuple[str, str]:
    """A joint that follows another, and that."""
    for joint in ET.fromstring(urdf).findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            return joint.get("name", ""), mimic.get("joint", "")
    raise AssertionError("none follows another")


def control(*parts: str, name: str = "drives") -> str:
    inside = "\n    ".join(parts)
    plugin = "<hardware><plugin>mock_components/GenericSystem</plugin></hardware>"
    return f'  <ros2_control name="{name}" type="system">\n    {plugin}\n    {inside}\n  </ros2_control>\n'


def driven(name: str, params: str = "", more: str = "", said: str = "") -> str:
    """A joint in <ros2_control> with a command and a state interface."""
    commanded = f'<command_interface name="position">{params}</command_interface>'
    return f'<joint name="{name}"{said}>{commanded}<state_interface name="position"/>{more}</joint>'


def seen(name: str, more: str = "", said: str = "") -> str:
    """A joint in <ros2_control> with a state interface."""
    return f'<joint name="{name}"{said}><state_interface name="position"/>{more}</joint>'


def params(**values: object) -> str:
    return "".join(f'<param name="{name}">{value}</param>' for name, value in values.items())


def gpio(name: str, inside: str = "") -> str:
    return f'<gpio name="{name}"><command_interface name="valve">{inside}</command_interface></gpio>'


def transmission(name: str, joint: str, reduction: object = 50) -> str:
    """A transmission as ros_control has it."""
    return (
        f'  <transmission name="{name}"><type>transmission_interface/SimpleTransmission</type><joint name="{joint}">'
        "<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>"
        f'<actuator name="{name}_motor"><mechanicalReduction>{reduction}</mechanicalReduction></actuator>'
        "</transmission>\n"
    )


def bare(urdf: str) -> str:
    """The description without the transmissions that it has."""
    return re.sub(r"(?s)<transmission\b.*?</transmission>", "", urdf)


def end(urdf: str, *pieces: str) -> str:
    return urdf.replace("</robot>", "".join(pieces) + "</robot>")


def ending(piece: Callable[[str], str]) -> Edit:
    """Plant a piece, made from the description, at its end."""
    return lambda urdf, srdf: (end(urdf, piece(urdf)), srdf)


def replacing(pattern: str, better: str, which: int = 0) -> Edit:
    """Replace in the description what a pattern matches in this place among its matches."""

    def edit(urdf: str, srdf: str) -> Texts:
        found = list(re.finditer(pattern, urdf))[which]
        return urdf[: found.start()] + found.expand(better) + urdf[found.end() :], srdf

    return edit


def in_srdf(piece: str | Callable[[str, str], str]) -> Edit:
    """Plant a piece at the end of the SRDF."""
    return lambda urdf, srdf: (urdf, end(srdf, piece if isinstance(piece, str) else piece(urdf, srdf)))


def state(value: str) -> Edit:
    """Plant a state with a value of the first joint that moves."""

    def piece(urdf: str, srdf: str) -> str:
        group = re.findall(r'<group name="([^"]+)"', srdf)[0]
        joint = f'<joint name="{moving(urdf)[0]}" value="{value}"/>'
        return f'<group_state name="planted" group="{group}">{joint}</group_state>'

    return in_srdf(piece)


def without_neighbours(urdf: str, srdf: str) -> Texts:
    """The SRDF without what it says of the links of the first joints that move."""
    for joint in ET.fromstring(urdf).findall("joint"):
        if joint.get("type") == "revolute":
            pair = {joint.find(end).get("link") for end in ("parent", "child")}  # type: ignore[union-attr]
            for line in re.findall(r"<disable_collisions[^>]*/>", srdf):
                if pair == set(re.findall(r'link[12]="([^"]+)"', line)):
                    srdf = srdf.replace(line, "")
    return urdf, srdf


def another(urdf: str, srdf: str) -> Texts:
    return urdf, texts_of("kinova")[1]


def limited(attribute: str) -> Edit:
    return replacing(rf'(<limit\b[^>]*?)\s{attribute}="[^"]*"', r"\1")


def plugin(tag: str, name: str) -> str:
    """A plugin of Gazebo that names a joint or a link."""
    return f'<gazebo><plugin name="p" filename="p.so"><{tag}>{name}</{tag}></plugin></gazebo>'


def material(inside: str, name: str = ' name="planted"') -> str:
    return f"<material{name}>{inside}</material>"


def shape(inside: str) -> Edit:
    """Plant a small visual at the end of the second link that has children."""
    ball = '<visual><geometry><sphere radius="0.001"/></geometry>'
    return replacing(r"</link>", f"{ball}{inside}</visual></link>", 1)


def joint(kind: str, inside: str) -> Edit:
    """Plant something at the beginning of the first joint of a kind."""
    return replacing(rf'(<joint\b[^>]*type="{kind}"[^>]*>)', rf"\1{inside}")


ARMS, FOLLOWERS = ("z1", "a1", "ur5_robot", "panda"), ("panda", "panda_collision", "romeo")
OTHERS = ("z1", "ur5_robot", "panda")
WITH_SRDF = ("panda", "a1", "xarm7")
GREEN = '<color rgba="0 1 0 1"/>'


class Planted(NamedTuple):
    kind: str
    code: str
    edit: Edit
    robots: tuple[str, ...] = ARMS[:3]


HEALTHY = (
    ending(lambda u: control(driven(moving(u)[0], params(min=-0.1, max=0.1)), gpio("io", params(min=0, max=1)))),
    ending(lambda u: control(seen(moving(u)[0])) + control(driven(moving(u)[1]), name="more")),
    lambda u, s: (end(bare(u), *(transmission(f"t{k}", joint) for k, joint in enumerate(moving(u)))), s),
    ending(lambda u: plugin("joint", moving(u)[0]) + plugin("jointName", f" r::{moving(u)[1]} ")),
    ending(lambda u: plugin("bodyName", "world") + plugin("frameName", "map")),
    ending(lambda u: material('<color rgba="0 1 0.5 0"/>')),
)
"""What may look like a defect and is none; of joints that follow others, `FOLLOWING`."""
FOLLOWING = (
    ending(lambda u: control(driven(follower(u)[1]), seen(follower(u)[0]))),
    ending(lambda u: control(driven(follower(u)[1]), driven(follower(u)[0], said=' mimic="false"'))),
)


def _first(params: str = "", said: str = "") -> Edit:
    """Control the first joint that moves."""
    return ending(lambda u: control(driven(moving(u)[0], params, said=said)))


def _following(more: str) -> Edit:
    """Control a joint and its follower, and say something of that."""
    return ending(lambda u: control(driven(follower(u)[1]), seen(follower(u)[0], more.format(follower(u)[1]))))


def _geared(*reductions: object) -> Edit:
    """Drive the first joint that moves by transmissions."""
    return lambda u, s: (end(bare(u), *(transmission(f"t{k}", moving(u)[0], r) for k, r in enumerate(reductions))), s)


def _drives(*names: int, old: str = "", new: str = "") -> Edit:
    """Drive as many joints by transmissions of these names, in which one text stands for another."""
    return lambda u, s: (
        end(bare(u), *(re.sub(old, new, transmission(f"t{n}", moving(u)[k]), count=1) for k, n in enumerate(names))),
        s,
    )


def _degrees(urdf: str) -> str:
    """The range of the first joint that moves, in degrees."""
    named = urdf[re.search(rf'<joint\b[^>]*name="{moving(urdf)[0]}"[^>]*type="revolute"', urdf).start() :]  # type: ignore[union-attr]
    limit = re.search(r"<limit[^>]*>", named)
    assert limit
    ends = {end: re.search(rf'{end}="([^"]*)"', limit[0]) for end in ("lower", "upper")}
    low, high = (degrees(float(found[1])) for found in ends.values() if found)
    return params(min=round(low), max=round(high))


def _effector(urdf: str, srdf: str) -> str:
    found = re.search(r'<link\s+name="([^"]+)"', urdf)
    assert found
    return f'<end_effector name="planted" parent_link="{found[1]}" group="nobody"/>'


def _reversed_chain(urdf: str) -> str:
    found = re.search(r'<parent\s+link="([^"]+)"\s*/>\s*<child\s+link="([^"]+)"', urdf)
    assert found
    return f'<group name="planted"><chain base_link="{found[2]}" tip_link="{found[1]}"/></group>'


def _two_colours(urdf: str, srdf: str) -> Texts:
    """Plant a shape whose colour of this name another one has otherwise."""
    blue = '\n  <material name="planted"><color rgba="0 0 1 1"/></material>'
    return shape(material(GREEN))(end(urdf, blue), srdf)


_WITHOUT_PLUGIN = '<ros2_control name="drives" type="system"><hardware/></ros2_control>'
CONTROLLED = (
    Planted("joint twice", "RD702", ending(lambda u: control(driven(moving(u)[0]), driven(moving(u)[0])))),
    Planted("joint in two", "RD702", ending(lambda u: control(driven(moving(u)[0])) + control(driven(moving(u)[0])))),
    Planted("fixed joint controlled", "RD702", ending(lambda u: control(driven(fixed(u))))),
    Planted("interface without name", "RD702", ending(lambda u: control(seen(moving(u)[0], "<state_interface/>")))),
    Planted("gpio twice", "RD702", ending(lambda u: control(gpio("io"), gpio("io")))),
    Planted("joint absent", "RD701", ending(lambda u: control(driven(moving(u)[0] + "_2")))),
    Planted("min above max", "RD704", _first(params(min=1, max=-1))),
    Planted("gpio min above max", "RD704", ending(lambda u: control(gpio("io", params(min=5, max=0))))),
    Planted("min no number", "RD704", _first(params(min="-0,5", max=0.1))),
    Planted("initial value outside", "RD704", _first(params(min=-0.1, max=0.1, initial_value=0.15))),
    Planted("mimic of none", "RD705", ending(lambda u: control(seen(moving(u)[0], said=' mimic="true"')))),
    Planted("follower commanded", "RD705", ending(lambda u: control(*map(driven, reversed(follower(u))))), FOLLOWERS),
    Planted("leader elsewhere", "RD705", ending(lambda u: control(seen(follower(u)[0]))), FOLLOWERS),
    Planted("mimic parameter absent", "RD705", ending(lambda u: control(seen(moving(u)[0], params(mimic="nobody"))))),
    Planted("multiplier differs", "RD705", _following(params(mimic="{}", multiplier=-7)), FOLLOWERS),
    Planted("driven twice", "RD703", _geared(50, 50)),
    Planted("reduction 0", "RD703", _geared(0)),
    Planted("reduction no number", "RD703", _geared("1:50")),
    Planted("hardware without plugin", "RD702", ending(lambda u: _WITHOUT_PLUGIN)),
    Planted("interface misspelt", "RD702", ending(lambda u: control(driven(moving(u)[0]).replace("osit", "ost", 1)))),
    Planted("gpio offers nothing", "RD702", ending(lambda u: control('<gpio name="flange"/>'))),
    Planted("range in degrees", "RD704", ending(lambda u: control(driven(moving(u)[0], _degrees(u))))),
    Planted("drive of a fixed joint", "RD703", lambda u, s: (end(bare(u), transmission("t", fixed(u))), s)),
    Planted("drive's name twice", "RD703", _drives(0, 0)),
    Planted("drive without type", "RD703", _drives(0, old="<type>.*</type>")),
    Planted("drive's type misspelt", "RD703", _drives(0, old="SimpleT", new="SimplT")),
    Planted("drive's interface misspelt", "RD703", _drives(0, old="EffortJ", new="EfortJ")),
    Planted("plugin's joint absent", "RD701", ending(lambda u: plugin("mimicJoint", moving(u)[0] + "x"))),
    Planted("plugin's link absent", "RD701", ending(lambda u: plugin("bodyName", "no_link"))),
)
PLANNED = (
    Planted("SRDF of another robot", "RD706", another),
    Planted("SRDF of another name", "RD706", lambda u, s: (u, re.sub('(<robot[^>]*name)="[^"]*"', r'\1="emu"', s))),
    Planted("state of no group", "RD707", in_srdf('<group_state name="planted" group="legs_and_arms"/>')),
    Planted("subgroup absent", "RD707", in_srdf('<group name="both"><group name="nobody"/></group>')),
    Planted("effector of no group", "RD707", in_srdf(_effector)),
    Planted("group twice", "RD707", in_srdf(lambda u, s: 2 * '<group name="planted"/>')),
    Planted("chain reversed", "RD707", in_srdf(lambda u, s: _reversed_chain(u))),
    Planted("state beyond a limit", "RD708", state("99")),
    Planted("state no number", "RD708", state("half")),
    Planted("state of two numbers", "RD708", state("0.1 0.2")),
)
SHOWN = (
    Planted("material undefined", "RD621", shape(material("", ' name="plaid"'))),
    Planted("material twice", "RD621", ending(lambda u: 2 * material(GREEN))),
    Planted("material of two colours", "RD621", _two_colours),
    Planted("material without name", "RD621", shape(material(GREEN, ""))),
    Planted("colour of 255", "RD622", ending(lambda u: material('<color rgba="255 128 0 1"/>'))),
    Planted("colour below 0", "RD622", ending(lambda u: material('<color rgba="-0.5 0.1 0 1"/>'))),
    Planted("texture absent", "RD623", ending(lambda u: material('<texture filename="nowhere.png"/>'))),
    Planted("visual without shape", "RD608", replacing(r"</link>", "<visual/></link>", 1)),
    Planted("two shapes in one", "RD608", replacing("</geometry>", '<box size="1 1 1"/></geometry>'), OTHERS),
    Planted("collision without shape", "RD608", replacing(r"</link>", "<collision><geometry/></collision></link>", 1)),
)
REFUSED = (
    Planted("version", "RD010", replacing(r"<robot\b", '<robot version="2"')),
    Planted("no effort", "RD506", limited("effort")),
    Planted("no velocity", "RD506", limited("velocity")),
    Planted("fixed with half a limit", "RD506", joint("fixed", '<limit effort="1"/>')),
    Planted("safety without gain", "RD007", joint("revolute", '<safety_controller k_position="1"/>')),
    Planted("nothing in dynamics", "RD007", joint("fixed", "<dynamics/>")),
)
PLANTED = (*CONTROLLED, *(each._replace(robots=WITH_SRDF) for each in PLANNED), *SHOWN, *REFUSED)
NEIGHBOURS = Planted("neighbours collide", "RD709", without_neighbours, ("panda", "xarm7", "b1"))
