"""What RD901 says of small descriptions and of published robots, held against MuJoCo and Drake.

The table makes no refusal up; where a program is installed it is asked, and what it says is the verdict.
"""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest
from helpers.importers import answers
from helpers.mesh_files import dae, obj
from helpers.mesh_samples import binary_stl
from helpers.peers import needs_peers
from helpers.robot_catalogue import FOLDER
from pinned_findings import published

from robodyn.checks import imported as programs
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Asked, Context
from robodyn.checks.examples import INERTIA, a_joint, a_link, arm, inertia
from robodyn.checks.importers import FACTS, Verdict
from robodyn.checks.rule import Finding
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


def weighed(mass: str, entries: str) -> str:
    return moved(f'<mass value="{mass}"/>{inertia(entries)}')


def fixed(*inertials: str) -> str:
    """A massless link on a joint, and links fixed to it."""
    links = [
        a_link(f"l{k}", inside) + a_joint(f"f{k}", "tip", f"l{k}", "", "fixed") for k, inside in enumerate(inertials)
    ]
    return moved("").replace("</robot>", "".join(links) + "</robot>")


MESH = '<mesh filename="{}"/>'
HEALTHY = f'<mass value="1"/>{INERTIA}'
CASES = {
    "healthy": moved(),
    "a plane": moved(more=shape('<plane normal="0 0 1"/>')),
    "no product": moved(HEALTHY.replace('ixy="0"', "")),
    "no inertial": moved(""),
    "a ball for a mass": moved("", shape(BALL)),
    "a box, turned": moved("", shape('<box size="0.1 0.2 0.3"/>', more='<origin rpy="0.3 0.4 0.5" xyz="0 0 1"/>')),
    "a cylinder": moved("", shape('<cylinder radius="0.1" length="0.3"/>')),
    "an inertial of zeros and a ball": moved('<mass value="0"/>' + inertia("0 0 0 0 0 0"), shape(BALL)),
    "a ball too small": moved("", shape('<sphere radius="1e-4"/>')),
    "a tetrahedron": moved("", shape(MESH.format("part.stl"))),
    "two objects": moved("", shape(MESH.format("two.obj"))),
    "a flat mesh": moved(more=shape(MESH.format("flat.stl"))),
    "zero box": moved(more=shape('<box size="0.1 0 0.1"/>')),
    "zero sphere": moved(more=shape('<sphere radius="0"/>')),
    "negative cylinder": moved(more=shape('<cylinder radius="0.1" length="-1"/>')),
    "no geometry": moved(more="<collision/>"),
    "zero scale": moved(more=shape('<mesh filename="part.obj" scale="0 1 1"/>')),
    "moments of 1e-22": weighed("1", "1e-22 0 0 1e-22 0 1e-22"),
    "moments of 2e-14": weighed("1", "2e-14 0 0 2e-14 0 2e-14"),
    "triangle by 1e-13": weighed("1", "0.1 0 0 0.1 0 0.20000000000002"),
    "negative mass": weighed("-1", "0.1 0 0 0.1 0 0.1"),
    "a point": moved(POINT),
    "massless and a point": fixed(POINT),
    "no mass element": moved(INERTIA),
    "axis without xyz": moved(joint="<axis/>" + LIMIT),
    "short axis": moved(joint='<axis xyz="0 5e-8 0"/>' + LIMIT),
    "negative velocity": moved(joint=AXIS + LIMIT.replace('velocity="1"', 'velocity="-1"')),
    "upside down": moved(joint=AXIS + LIMIT.replace('"-1"', '"2"')),
    "planar": moved(joint='<axis xyz="0 0 1"/>', kind="planar"),
    "negative damping": moved(joint=AXIS + LIMIT + '<dynamics damping="-1"/>'),
    "mimic of nothing": moved(joint=AXIS + LIMIT + '<mimic joint="none"/>'),
    "mimic of another": moved(joint=AXIS + LIMIT + '<mimic joint="shoulder"/>'),
    "nameless": moved().replace('<robot name="arm">', "<robot>"),
    "a package": moved(more=shape(MESH.format("package://none/part.stl"))),
    "a mesh that is not there": moved(more=shape(MESH.format("none.obj"))),
    "COLLADA": moved(more=shape(MESH.format("part.dae"))),
    "seen COLLADA": moved(more=shape(MESH.format("part.dae"), "visual")),
    "mimics itself": moved(joint=AXIS + LIMIT + '<mimic joint="j"/>'),
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
    (folder / "part.dae").write_bytes(dae(part))
    lines = obj(np.concatenate((part, part * 2 + 1))).decode().splitlines()
    (folder / "two.obj").write_text("\n".join(["o one", *lines[: -len(part)], "o two", *lines[-len(part) :], ""]))
    found = {}
    for k, (name, text) in enumerate(CASES.items()):
        found[name] = folder / f"case{k}.urdf"
        found[name].write_text(text, encoding="utf-8")
    return found


@pytest.fixture
def absent(monkeypatch: pytest.MonkeyPatch) -> None:
    """No program is installed."""

    def version(package: str) -> str:
        raise PackageNotFoundError(package)

    monkeypatch.setattr("importlib.metadata.version", version)


def asked(file: Path | str, target: str) -> Finding:
    source = file.encode() if isinstance(file, str) else str(file)
    (one,) = check_one(source, Options(select=("RD901",), asked=Asked(targets=(target,))))
    return one


@pytest.mark.usefixtures("absent")
@pytest.mark.parametrize(("target", "least"), [("mujoco", 12), ("drake", 4)])
def test_the_table_makes_no_refusal_up(target: str, least: int, files: dict[str, Path]) -> None:
    said = {name: asked(file, target) for name, file in files.items()}
    foretold = {name for name, finding in said.items() if f"{target} rejects it" in finding.message}
    found = dict(zip(files, answers(target, [*files.values()]), strict=True))
    assert {name for name in foretold if found[name].refused is None} == set()
    assert len(foretold) >= least
    assert all((finding.severity.value == "error") == (name in foretold) for name, finding in said.items())
    assert all("not run, since it is not installed" in finding.remedy for finding in said.values())


CHANGES = {
    ("healthy", "mujoco"): "mujoco loads it as it is",
    ("a ball for a mass", "mujoco"): "it gives link 'tip' 4.189 kg, not 0 kg",
    ("negative mass", "drake"): "it gives link 'tip' 1 kg, not -1 kg",
    ("triangle by 1e-13", "drake"): "it gives link 'tip' principal moments of 0.001539, 0.001539, 0.001539 kg m^2, not",
    ("upside down", "mujoco"): "it ignores the limits of joint 'j'",
    ("mimic of another", "mujoco"): "it makes <mimic> of joint 'j' a soft constraint",
    ("no product", "drake"): "it lets link 'base' float",
    ("seen COLLADA", "mujoco"): "it leaves out 1 of 1 <visual>",
    ("fused", "mujoco"): "it fuses link 'l0', link 'l1' with what carries them",
    ("a root", "mujoco"): "it makes link 'base' a part of the world, without mass",
    ("friction", "drake"): "it ignores the friction of joint 'j'",
    ("a plane", "mujoco"): 'mujoco rejects it: it says "XML Error: visual geometry specification not found',
    ("moments of 1e-22", "mujoco"): 'mujoco rejects it: it says "Error: error',
    ("mimic of nothing", "drake"): "mimic element specifies joint 'none' which does not exist",
    ("upside down", "drake"): 'drake rejects it: it says "Failure at',
    ("a mesh that is not there", "mujoco"): """none.obj'"; without its shapes it makes link 'base'""",
}


REPEATED = [
    ("negative mass", "drake"),
    ("friction", "drake"),
    ("a plane", "mujoco"),
    ("moments of 1e-22", "mujoco"),
    ("mimic of nothing", "drake"),
]
"""Of changes and refusals that others have, too."""


@needs_peers
@pytest.mark.parametrize(
    ("name", "target"), [pytest.param(*each, marks=[pytest.mark.slow] * (each in REPEATED)) for each in CHANGES]
)
def test_what_a_program_changes_is_what_it_holds(name: str, target: str, files: dict[str, Path]) -> None:
    texts = {
        "fused": fixed(HEALTHY, HEALTHY),
        "a root": moved().replace('<link name="base"/>', a_link("base")),
        "friction": moved(joint=AXIS + LIMIT + '<dynamics friction="1"/>'),
        "a mesh that is not there": moved(more=shape(MESH.format("none.obj"))).replace(
            '<link name="base"/>', a_link("base")
        ),
    }
    one = asked(texts.get(name) or files[name], target)
    assert CHANGES[name, target] in one.message
    assert "run in version" in one.remedy


@needs_peers
def test_a_frame_that_moves_and_turns_what_it_holds_is_no_change() -> None:
    """Moments of a fused body are compared in the frame of what carries it."""
    turned = '<origin xyz="0.3 0.1 -0.2" rpy="0.4 -0.5 0.6"/>'
    skew = f'{turned}<mass value="2"/>' + inertia("0.02 0.001 0.002 0.03 -0.001 0.04")
    text = moved(skew, more="").replace(
        "</robot>", a_link("l0", skew) + a_joint("f", "tip", "l0", turned, "fixed") + "</robot>"
    )
    for target in ("mujoco", "drake"):
        assert not {"principal", "centre", " kg"} & set(re.findall("principal|centre| kg", asked(text, target).message))


@needs_peers
def test_what_a_program_prints_and_how_it_ends_stay_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A package of that name prints to both streams, not by Python alone, and fails, or ends the process."""
    (tmp_path / "mujoco.py").write_text(
        "import os\nos.system('echo loud; echo loud >&2')\nprint('loud')\n"
        "class MjModel:\n    def from_xml_path(path):\n        os.write(1, b'loud')\n"
        "        os._exit(3) if 'x3' in path else 1 / 0\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    for name, said in (("a.urdf", "division by zero"), ("x3.urdf", "its process ended with status 3")):
        (tmp_path / name).write_text(moved())
        assert f'mujoco rejects it: it says "{said}"' in asked(tmp_path / name, "mujoco").message
    (tmp_path / "mujoco.py").write_text("raise ImportError('libGL')")
    assert "not run, since it is not installed" in asked(tmp_path / "a.urdf", "mujoco").remedy
    assert capfd.readouterr() == ("", "")


@needs_peers
def test_text_without_a_file_is_asked_about(files: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """The meshes of a xacro file lie where the check finds them."""
    assert "mujoco rejects it" in asked(CASES["moments of 1e-22"], "mujoco").message
    file = files["healthy"].parent / "a & b" / "arm.xacro"
    file.parent.mkdir()
    (file.parent / "part.obj").write_bytes((files["healthy"].parent / "part.obj").read_bytes())
    file.write_text(moved(more=shape(MESH.format("part.obj"))))
    monkeypatch.chdir(file.parent.parent)
    assert "mujoco loads it" in asked(Path("a & b") / "arm.xacro", "mujoco").message


@needs_peers
def test_a_program_that_does_not_end_is_killed(files: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programs, "PATIENCE", 0.01)
    one = asked(files["healthy"], "drake")
    assert one.severity.value == "error"
    assert one.message.startswith('drake rejects it: it says "it is not done after 0.01 s"')


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
    "negative mass": (weighed("-1", "0.1 0 0 0.1 0 0.1"), "requires inertia that a body can have"),
    "a plate": (weighed("1", "0.1 0 0 0.2 0 0.3"), "loads it"),
    "triangle by 1e-13": (weighed("1", "0.1 0 0 0.1 0 0.20000000000002"), "requires inertia that a body can have"),
    "floating": (FLOAT, "knows no floating and no planar joints"),
    "short axis": (moved(joint='<axis xyz="0 5e-7 0"/>' + LIMIT), "requires an axis"),
    "no limit": (moved(joint=AXIS), "requires numbers, and <limit>"),
    "continuous": (moved(joint=AXIS, kind="continuous"), "loads it"),
    "upside down": (moved(joint=AXIS + LIMIT.replace('"-1"', '"2"')), "exchanges limits"),
    "a joint called as a link": (moved().replace('name="j"', 'name="tip"'), "requires names of joints"),
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


_WITHOUT = re.compile(r"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
ROBOTS = [*(path for path in published() if path.name != "ur3.urdf"), *sorted(FOLDER.glob("*.urdf"))][::3]
"""Of those that are installed and have a link."""


def without_shapes(path: Path, target: str, folder: Path) -> Path:
    copy = folder / f"{target}-{ROBOTS.index(path)}.urdf"
    copy.write_text(_WITHOUT.sub("", path.read_text(encoding="utf-8")), encoding="utf-8")
    return copy


def foretold(file: Path, target: str) -> bool:
    context = Context(read(str(file)))
    facts = [fact for fact in FACTS if (fact.target, fact.verdict) == (target, Verdict.REJECTS)]
    return any(any(True for _ in fact.find(context)) for fact in facts)


@pytest.mark.slow
@pytest.mark.parametrize("target", ["mujoco", "drake"])
def test_refusals(target: str, tmp_path: Path) -> None:
    """Without shapes: as they are, most robots are refused for their meshes."""
    files = [without_shapes(path, target, tmp_path) for path in ROBOTS]
    found = answers(target, files, ROBOTS)
    said = [foretold(file, target) for file in files]
    assert not [path for path, one, told in zip(ROBOTS, found, said, strict=True) if told and one.refused is None]
