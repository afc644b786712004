"""Planting defects of what ROS reads in the text of published robots; `planted_ros_kinds` has the kinds.

An edit is given the text of the description and of the SRDF beside it, and returns both. What it is planted in, the
names of joints and links, it takes from the description, so that each is planted in several robots.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

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
    return f'<gazebo><plugin name="p"><{tag}>{name}</{tag}></plugin></gazebo>'


def material(inside: str, name: str = ' name="planted"') -> str:
    return f"<material{name}>{inside}</material>"


def shape(inside: str) -> Edit:
    """Plant a small visual at the end of the second link that has children."""
    ball = '<visual><geometry><sphere radius="0.001"/></geometry>'
    return replacing(r"</link>", f"{ball}{inside}</visual></link>", 1)


def joint(kind: str, inside: str) -> Edit:
    """Plant something at the beginning of the first joint of a kind."""
    return replacing(rf'(<joint\b[^>]*type="{kind}"[^>]*>)', rf"\1{inside}")
