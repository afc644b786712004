"""Rules about the files of meshes, beside real files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from helpers.mesh_files import ascii_stl, dae, obj
from helpers.mesh_samples import binary_stl, box, flipped, moved
from helpers.one_sided import klein_bottle

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Asked
from robodyn.checks.examples import INERTIA
from robodyn.checks.fixes import fixed
from robodyn.checks.rule import Finding, Severity

PART = box((0.1, 0.2, 0.3))
E, W, I = Severity.ERROR, Severity.WARNING, Severity.NOTE


def described(*uris: str, kind: str = "collision", scale: str = "", joint: str = "0 0 0.3") -> str:
    """A robot of links with one mesh each, on a row of fixed joints."""
    attribute = f' scale="{scale}"' if scale else ""
    links = "".join(
        f'<link name="l{k}">\n<{kind}><geometry><mesh filename="{uri}"{attribute}/></geometry></{kind}></link>'
        f'<joint name="j{k}" type="fixed"><parent link="base"/><child link="l{k}"/><origin xyz="{joint}"/></joint>'
        for k, uri in enumerate(uris)
    )
    return f'<robot name="r"><link name="base"/>{links}</robot>'


def saved(folder: Path, text: str, **files: bytes) -> str:
    """`text` as robot.urdf, beside files whose names have _ for the dot."""
    for name, data in files.items():
        (folder / name.replace("_", ".")).write_bytes(data)
    path = folder / "robot.urdf"
    path.write_text(text)
    return str(path)


def found(source: str | bytes, options: Options = Options()) -> list[tuple[str, Severity]]:  # noqa: B008
    return [(one.code, one.severity) for one in findings(source, options)]


def findings(source: str | bytes, options: Options = Options()) -> list[Finding]:  # noqa: B008
    """Those of meshes; no other rule may find an error."""
    every = check_one(source, options)
    assert not [one for one in every if one.severity is E and not one.code.startswith(("RD6", "RD004"))]
    return [one for one in every if one.code.startswith("RD6")]


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`urdf/` of the package arm_description, with meshes/part.stl."""
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    root = tmp_path / "arm_description"
    for name in ("urdf", "meshes"):
        (root / name).mkdir(parents=True)
    (root / "package.xml").write_text("<package><name>arm_description</name></package>")
    (root / "meshes" / "part.stl").write_bytes(binary_stl(PART))
    return root / "urdf"


SOUND = "package://arm_description/meshes/part.stl"


@pytest.mark.parametrize(
    ("uri", "expected"),
    [
        ("../meshes/none.stl", [("RD601", E)]),
        ("package://arm_description/meshes/none.stl", [("RD601", E)]),
        ("package://arm_descriptoin/meshes/part.stl", [("RD601", E)]),
        ("package:///arm_description/meshes/part.stl", [("RD601", E)]),
        ("..\\meshes\\part.stl", [("RD601", E)]),
        ("http://localhost/part.stl", [("RD601", W)]),
        ("../meshes/Part.stl", [("RD602", E)]),
        ("package://arm_description/Meshes/part.STL", [("RD602", E)]),
        ("/no/such/part.stl", [("RD601", E), ("RD603", W)]),
        ("file:///no/such/part.stl", [("RD601", E), ("RD603", W)]),
        ("C:\\part.stl", [("RD601", E), ("RD603", W)]),
        ("../../part.stl", [("RD603", W)]),
        ("package://arm_description/../part.stl", [("RD603", W)]),
        ("${meshes}/part.stl", []),
        (SOUND, []),
        ("../meshes/part.stl", []),
    ],
)
def test_where_meshes_are(package: Path, uri: str, expected: list[tuple[str, Severity]]) -> None:
    (package.parent.parent / "part.stl").write_bytes(binary_stl(PART))
    text = described(uri)
    results = findings(saved(package, text))
    assert [(one.code, one.severity) for one in results] == expected
    assert all(text.encode()[one.start : one.end].decode() == uri for one in results)
    assert all(one.line == 2 for one in results)


def test_an_absolute_name_of_a_file_that_is_there(package: Path) -> None:
    path = str(package.parent / "meshes" / "part.stl")
    assert found(saved(package, described(path))) == [("RD603", W)]
    assert found(saved(package, described(f"file://{path}"))) == [("RD603", W)]


def test_nothing_known_of_the_package_is_one_remark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    text = described(*(f"package://arm_description/meshes/{k}.stl" for k in range(5)))
    file = saved(tmp_path, text)
    (remark,) = findings(file)
    assert (remark.code, remark.severity) == ("RD601", I)
    assert remark.message == "5 meshes are not looked at: nothing is known of the package 'arm_description'"
    assert found(text.encode()) == [("RD601", I)]
    assert found(file, Options(package_path=(str(tmp_path),))) == [("RD601", E)] * 5
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert found(file) == [("RD601", E)] * 5


def test_package_path_leads_to_meshes(package: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    file = saved(elsewhere, described(SOUND, "package://arm_description/meshes/other.stl"))
    for folder in (package.parent, package.parent.parent):
        assert found(file, Options(package_path=(str(folder),))) == [("RD601", E)]


def test_a_name_used_twice_is_one_finding(package: Path) -> None:
    (one,) = findings(saved(package, described("none.stl", "none.stl", "none.stl")))
    assert one.message == "link 'l0': the mesh 'none.stl' is not there (and 2 more places)"


@pytest.mark.parametrize(
    "uri",
    ["../meshes/Part.STL", "package:///arm_description/meshes/part.stl", "..\\meshes\\part.stl"],
    ids=["case", "slashes", "backslashes"],
)
def test_names_are_fixed(package: Path, uri: str) -> None:
    file = saved(package, described(uri, uri))
    before = Path(file).read_bytes()
    result = fixed(before, file, lambda text: check_one(text, name=file))
    right = "../meshes/part.stl" if uri.startswith("..") else SOUND
    assert result.after == before.replace(uri.encode(), right.encode())
    assert len(result.made) == 1


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("part.stl", b"", "is empty"),
        ("part.stl", binary_stl(PART)[:300], "cannot be read"),
        ("part.stl", b"solid x\nendsolid x\n", "cannot be read"),
        ("part.obj", b"# nothing\n", "cannot be read"),
        ("part.obj", b"v 0 0\nf 1 2 3\n", "cannot be read"),
        ("part.dae", b"<COLLADA", "cannot be read"),
        ("part.mesh", b"MESH", "unknown type"),
    ],
)
def test_unreadable_meshes(tmp_path: Path, name: str, data: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(data)
    (one,) = findings(saved(tmp_path, described(name)))
    assert (one.code, one.severity) == ("RD601", E)
    assert words in one.message


HOLE, CROSS = PART[1:], np.concatenate([box((0.3, 0.05, 0.05)), box((0.05, 0.3, 0.05))])
HOLLOW = np.concatenate([box(), flipped(box((0.5, 0.5, 0.5)))])
APART = np.concatenate([box(), moved(box(), (3.0, 0.0, 0.0))])
INVERTED = np.concatenate([box(), moved(flipped(box()), (3.0, 0.0, 0.0))])
MIXED = np.concatenate([PART[:1, ::-1], PART[1:]])
INSIDE = np.concatenate([box(), box((0.5, 0.5, 0.5))])
NOT_A_NUMBER = np.concatenate([PART, np.full((1, 3, 3), np.nan)])
SURFACES = {
    "sound": (PART, None, None),
    "hollow": (HOLLOW, None, None),
    "apart": (APART, None, None),
    "open": (HOLE, (W, I), "is not closed: 14 % of its surface is missing"),
    "small hole": (box((0.2, 0.2, 0.2))[1:], (I, I), "is open by small gaps only (1): filled, it encloses a volume"),
    "given twice": (np.concatenate([PART, PART[:1]]), (I, I), "is closed but for faces without area, or given twice"),
    "one side": (klein_bottle()[1:], (W, I), "faces in surfaces with one side only"),
    "inside out": (flipped(PART), (W, W), "is inside out"),
    "one inside out": (INVERTED, (W, W), "shells that are inside out"),
    "mixed": (MIXED, (W, I), "wound against"),
    "crossed": (CROSS, (I, I), "overlap"),
    "doubled within": (INSIDE, (I, I), "overlap"),
    "NaN": (NOT_A_NUMBER, (W, W), "no number"),
}


@pytest.mark.parametrize("surface", SURFACES)
def test_surfaces(tmp_path: Path, surface: str) -> None:
    triangles, severities, words = SURFACES[surface]
    for kind, severity in zip(("collision", "visual"), severities or (None, None), strict=True):
        results = findings(saved(tmp_path, described("part.stl", kind=kind), part_stl=binary_stl(triangles)))
        assert [(one.code, one.severity) for one in results] == ([] if severity is None else [("RD604", severity)])
        assert all((words or "") in one.message for one in results)


@pytest.mark.parametrize("surface", ["open", "one side", "mixed"])
def test_surfaces_that_nothing_is_weighed_by(tmp_path: Path, surface: str) -> None:
    """Collisions are with the hull or with triangles; the mass of a link without <inertial> is that of the mesh."""
    text, inertial = described("part.stl", "part.stl"), f'<inertial><mass value="1"/>{INERTIA}</inertial></link>'
    for given, severity in (
        (text, W),
        (text.replace("</link>", inertial), I),
        (text.replace("</link>", inertial, 1), W),
    ):
        (one,) = findings(saved(tmp_path, given, part_stl=binary_stl(SURFACES[surface][0])), Options(("RD604",)))
        assert one.severity is severity


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("part.obj", obj(PART).replace(b"v ", b"v nan ", 1)),
        ("part.dae", dae(PART).replace(b">-", b">NaN -", 1)),
        ("part.stl", ascii_stl(PART, number="%g").replace(b"vertex -0.05", b"vertex nan", 1)),
    ],
)
def test_coordinates_that_are_no_numbers(tmp_path: Path, name: str, data: bytes) -> None:
    (tmp_path / name).write_bytes(data)
    assert found(saved(tmp_path, described(name))) == [("RD604", W)]


@pytest.mark.parametrize(
    ("size", "scale", "joint", "wrong"),
    [
        (0.3, "", "0 0 0.3", None),
        (300, "", "0 0 0.3", 1e3),
        (300, "0.001 0.001 0.001", "0 0 0.3", None),
        (0.3, "0.001 0.001 0.001", "0 0 0.3", 1e-3),
        (0.3, "0.001 0.001 0.001", "0 0 0", None),
        (15, "", "0 0 0.3", None),
        (30, "", "0 0 5", None),
        (300, "0.001 1 0.001", "0 0 0.3", 1e3),
        (0.3, "0.001 1 1", "0 0 0.3", 1e3),
        (100, "1e-3 2e-3 1e-3", "0 0 0.3", None),
    ],
)
def test_units(tmp_path: Path, size: float, scale: str, joint: str, wrong: float | None) -> None:
    file = saved(tmp_path, described("part.stl", scale=scale, joint=joint), part_stl=binary_stl(box((size,) * 3)))
    results = findings(file)
    assert [(one.code, one.severity) for one in results] == ([] if wrong is None else [("RD605", E)])
    if wrong is not None and results[0].measured is not None:
        assert results[0].bound == pytest.approx(results[0].measured / wrong, rel=1e-6)


def test_the_unit_of_one_of_two_meshes_of_a_link(tmp_path: Path) -> None:
    text = described("small.stl", joint="0 0 0.001").replace(
        "</collision>", '</collision><visual><geometry><mesh filename="large.stl"/></geometry></visual>'
    )
    small, large = (binary_stl(box((size,) * 3)) for size in (2e-3, 2.0))
    (one,) = findings(saved(tmp_path, text, small_stl=small, large_stl=large))
    assert (one.code, one.severity) == ("RD605", E)
    assert "1000 times" in one.message


@pytest.mark.parametrize(
    ("scale", "severity", "words"),
    [
        ("0 1 1", E, "leaves no volume"),
        ("0 -1 1", E, "leaves no volume"),
        ("1 -1 1", W, "mirrors the mesh"),
        ("-1 -1 -1", W, "mirrors the mesh"),
        ("-1 -1 1", I, "half a turn"),
    ],
)
def test_scales(tmp_path: Path, scale: str, severity: Severity, words: str) -> None:
    text = described("part.stl", "part.stl", scale=scale)
    (one,) = findings(saved(tmp_path, text, part_stl=binary_stl(box((100.0,) * 3))), Options(select=("RD606",)))
    assert one.severity is severity
    assert words in one.message
    assert one.message.endswith(" (and 1 more of this mesh)")
    assert text.encode()[one.start : one.end].decode() == scale


@pytest.mark.parametrize(
    ("scales", "severity"),
    [
        (("0.001 -0.001 0.001", "0.001 0.001 0.001"), I),
        (("1 1 -1", ""), I),
        (("1 -1 1", "2 2 2"), W),
        (("1 -1 1", "-1 -1 1"), I),
        (("1 -1 1", "-1 1 1"), W),
    ],
)
def test_a_mesh_for_both_sides_may_be_mirrored(tmp_path: Path, scales: tuple[str, str], severity: Severity) -> None:
    """TALOS, TIAGo, Centauro: the mesh of one arm, and its mirror image for the other."""
    text = described("part.stl", "part.stl", scale="@")
    for scale in scales:
        text = text.replace(' scale="@"', f' scale="{scale}"' if scale else "", 1)
    found = findings(saved(tmp_path, text, part_stl=binary_stl(box((100.0,) * 3))), Options(select=("RD606",)))
    assert {one.severity for one in found if "mirrors" in one.message} == {severity}


def test_formats_of_named_programs(tmp_path: Path) -> None:
    text = described("a.dae", "b.stl", "c.DAE", "d.obj")
    expected = {"mujoco": 1, "drake": 2, "gz": 0, "kdl": 0}
    seen = saved(tmp_path, text.replace("collision", "visual"))
    assert found(seen, Options(select=("RD607",), asked=Asked(targets=tuple(expected)))) == []
    file = saved(tmp_path, text)
    for target, count in expected.items():
        results = findings(file, Options(select=("RD607",), asked=Asked(targets=(target,))))
        assert [(one.code, one.severity) for one in results] == [("RD607", I)] * count
    assert found(file, Options(select=("RD607",))) == []


EXAMPLES = {
    "part.stl": binary_stl(PART),
    "part.dae": dae(PART),
    "y_up.dae": dae(PART, up="Y_UP"),
    "z_up.dae": dae(PART),
    "open.stl": binary_stl(PART[2:]),
    "closed.stl": binary_stl(PART),
    "millimetres.stl": binary_stl(box((100, 200, 50))),
}


@pytest.mark.parametrize("code", ["RD602", "RD604", "RD605", "RD607", "RD624"])
def test_examples_beside_their_files(tmp_path: Path, code: str) -> None:
    (rule,) = [rule for rule in RULES if rule.code == code]
    for name, data in EXAMPLES.items():
        (tmp_path / name).write_bytes(data)
    options = Options(asked=Asked(targets=("mujoco",) if code == "RD607" else ()))
    bad = check_one(saved(tmp_path, rule.bad), options)
    assert code in {one.code for one in bad}
    assert {one.code for one in bad if one.severity is E} <= {code, "RD901"}
    good = check_one(saved(tmp_path, rule.good), options)
    assert not [one for one in good if one.code == code or one.severity is E]


@pytest.mark.parametrize("name", ["part.stl", "part.obj", "part.dae"])
def test_a_pointer_of_git_lfs(tmp_path: Path, name: str) -> None:
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 12345\n"
    (tmp_path / name).write_text(pointer)
    (one,) = findings(saved(tmp_path, described(name)), Options(select=("RD601",)))
    assert one.message.endswith("is a pointer of Git LFS, not the mesh")
    assert one.remedy == "git lfs pull fetches the mesh"
    (tmp_path / "arm.urdf").write_text(pointer)
    (one,) = check_one(str(tmp_path / "arm.urdf"))
    assert (one.code, one.remedy) == ("RD001", "git lfs pull fetches the description")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_no_mesh_and_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "part.stl")
    assert found(saved(tmp_path, described("part.stl"))) == [("RD601", E)]


def test_shapes_without_volume_tell_no_unit_of_the_robot(tmp_path: Path) -> None:
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
    text = described(*["flat.stl"] * 4, kind="visual", joint="0 0 0").replace("</link>", body)
    flat = binary_stl(np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float))
    assert {one.code for one in check_one(saved(tmp_path, text, flat_stl=flat))} >= {"RD604"}
