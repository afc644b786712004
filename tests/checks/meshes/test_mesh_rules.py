"""Rules about the files of meshes, beside real files; their names on disks that tell no case; facts that are kept."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from helpers.mesh_files import dae
from helpers.mesh_samples import binary_stl, box, flipped, moved
from helpers.one_sided import klein_bottle

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Asked
from robodyn.checks.examples import INERTIA
from robodyn.checks.meshes import files as mesh_files
from robodyn.checks.meshes.files import MeshFacts, extremes, facts_of, mesh_facts, spread_out
from robodyn.checks.rule import Finding, Severity
from robodyn.programs.vectors import product
from robodyn.robot.urdf.sources import Search
from robodyn.solids.mesh.triangles import BLOCK

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
        ("HERE/meshes/part.stl", [("RD603", W)]),
        ("file://HERE/meshes/part.stl", [("RD603", W)]),
        ("../../part.stl", [("RD603", W)]),
        ("package://arm_description/../part.stl", [("RD603", W)]),
        ("${meshes}/part.stl", []),
        (SOUND, []),
        ("../meshes/part.stl", []),
    ],
)
def test_where_meshes_are(package: Path, uri: str, expected: list[tuple[str, Severity]]) -> None:
    (package.parent.parent / "part.stl").write_bytes(binary_stl(PART))
    uri = uri.replace("HERE", str(package.parent))
    text = described(uri)
    results = findings(saved(package, text))
    assert [(one.code, one.severity) for one in results] == expected
    assert all(text.encode()[one.start : one.end].decode() == uri for one in results)
    assert all(one.line == 2 for one in results)


def test_nothing_known_of_the_package_is_one_warning(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So is a mesh that is used several times; the package path leads to it."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    other = saved(elsewhere, described(SOUND, "package://arm_description/meshes/other.stl"))
    for folder in (package.parent, package.parent.parent):
        assert found(other, Options(package_path=(str(folder),))) == [("RD601", E)]
    (package.parent / "package.xml").unlink()
    package.parent.rename(tmp_path / "unknown")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    text = described(*(f"package://arm_description/meshes/{k}.stl" for k in range(5)))
    file = saved(tmp_path, text)
    (remark,) = findings(file)
    assert (remark.code, remark.severity) == ("RD601", W)
    assert remark.message == "5 meshes are not looked at: nothing is known of the package 'arm_description'"
    assert found(text.encode()) == [("RD601", W)]
    assert found(file, Options(package_path=(str(tmp_path),))) == [("RD601", E)] * 5
    twice = findings(saved(tmp_path, described("none.stl", "none.stl", "none.stl")))
    assert [one.message for one in twice] == ["link 'l0': the mesh 'none.stl' is not there (and 2 more places)"]
    saved(tmp_path, text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert found(file) == [("RD601", E)] * 5


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


def test_surfaces_that_nothing_is_weighed_by(tmp_path: Path) -> None:
    """Collisions are with the hull or with triangles; the mass of a link without <inertial> is that of the mesh."""
    text, inertial = described("part.stl", "part.stl"), f'<inertial><mass value="1"/>{INERTIA}</inertial></link>'
    for given, severity in (
        (text, W),
        (text.replace("</link>", inertial), I),
        (text.replace("</link>", inertial, 1), W),
    ):
        (one,) = findings(saved(tmp_path, given, part_stl=binary_stl(SURFACES["open"][0])), Options(("RD604",)))
        assert one.severity is severity


@pytest.mark.parametrize(
    ("size", "scale", "joint", "wrong"),
    [
        (0.3, "", "0 0 0.3", None),
        (300, "", "0 0 0.3", 1e3),
        (0.3, "0.001 0.001 0.001", "0 0 0.3", 1e-3),
        (0.3, "0.001 0.001 0.001", "0 0 0", None),
        (30, "", "0 0 5", None),
        (300, "0.001 1 0.001", "0 0 0.3", 1e3),
        (100, "1e-3 2e-3 1e-3", "0 0 0.3", None),
    ],
)
def test_units(tmp_path: Path, size: float, scale: str, joint: str, wrong: float | None) -> None:
    file = saved(tmp_path, described("part.stl", scale=scale, joint=joint), part_stl=binary_stl(box((size,) * 3)))
    results = findings(file)
    assert [(one.code, one.severity) for one in results] == ([] if wrong is None else [("RD605", E)])
    if wrong is not None and results[0].measured is not None:
        assert results[0].bound == pytest.approx(results[0].measured / wrong, rel=1e-6)


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
    options = Options(ignore=("RD901",), asked=Asked(targets=("mujoco",) if code == "RD607" else ()))
    bad = check_one(saved(tmp_path, rule.bad), options)
    assert code in {one.code for one in bad}
    assert {one.code for one in bad if one.severity is E} <= {code}
    good = check_one(saved(tmp_path, rule.good), options)
    assert not [one for one in good if one.code == code or one.severity is E]


def test_a_pointer_of_git_lfs(tmp_path: Path) -> None:
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 12345\n"
    (tmp_path / "part.obj").write_text(pointer)
    (one,) = findings(saved(tmp_path, described("part.obj")), Options(select=("RD601",)))
    assert one.message.endswith("is a pointer of Git LFS, not the mesh")
    assert one.remedy == "git lfs pull fetches the mesh"
    (tmp_path / "arm.urdf").write_text(pointer)
    (one,) = check_one(str(tmp_path / "arm.urdf"))
    assert (one.code, one.remedy) == ("RD001", "git lfs pull fetches the description")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_no_mesh_and_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "part.stl")
    assert found(saved(tmp_path, described("part.stl"))) == [("RD601", E)]


COMPOSED, DECOMPOSED = "Gerät.stl", "Gera\u0308t.stl"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """urdf/ beside meshes/Upper/part.stl."""
    (tmp_path / "meshes" / "Upper").mkdir(parents=True)
    (tmp_path / "urdf").mkdir()
    (tmp_path / "meshes" / "Upper" / "part.stl").write_bytes(binary_stl(box()))
    return tmp_path / "urdf"


@pytest.fixture
def one_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that opens a file by its name in any case, as those of Windows and macOS do; listings keep the case."""

    find = Search.find

    def found(search: Search, uri: str) -> Path | None:
        (folder,) = search.folders
        opened = folder
        for part in uri.replace("\\", "/").split("/"):
            names = [part] if part in ("", ".", "..") else os.listdir(opened)
            same = [name for name in names if name.casefold() == part.casefold()]
            if not same:
                return None
            opened /= same[0]
        return find(search, str(opened)) and folder / uri

    monkeypatch.setattr(Search, "find", found)
    monkeypatch.setattr(mesh_files, "facts_of", lambda paths: dict.fromkeys(paths, FACTS))


FACTS = mesh_files.MeshFacts(triangles=12, hi=(1.0, 1.0, 1.0), volume=1.0, closed=True)


def beside(folder: Path, uri: str) -> list[Finding]:
    shape = f'<collision><geometry><mesh filename="{uri}"/></geometry></collision>'
    (folder / "robot.urdf").write_text(f'<robot name="r"><link name="base">{shape}</link></robot>', encoding="utf-8")
    return [one for one in check_one(str(folder / "robot.urdf")) if one.code.startswith("RD6")]


CASES = {
    "../meshes/Upper/part.stl": [],
    "../meshes/Upper/Part.STL": [("RD602", "../meshes/Upper/part.stl")],
    "../Meshes/upper/part.stl": [("RD602", "../meshes/Upper/part.stl")],
    "./../MESHES//UPPER/PART.STL": [("RD602", "./../meshes//Upper/part.stl")],
}


@pytest.mark.parametrize("disk", ["tells cases", "does not"])
def test_names_in_another_case(disk: str, folder: Path, request: pytest.FixtureRequest) -> None:
    """Where the file is opened in any case it is still said that the description works nowhere else."""
    if disk == "does not":
        request.getfixturevalue("one_case")
    for uri, expected in CASES.items():
        found = beside(folder, uri)
        assert [(one.code, one.fix.edits[0].text) for one in found if one.fix] == expected
        assert len(found) == len(expected)


@pytest.mark.usefixtures("one_case")
def test_folders_between_backslashes_are_found_on_windows_and_warned_of(folder: Path) -> None:
    (one,) = beside(folder, "..\\meshes\\Upper\\part.stl")
    assert (one.code, one.severity) == ("RD603", W)
    assert "has \\ between folders, which Windows alone reads" in one.message


def test_folders_between_backslashes_are_not_found_elsewhere(folder: Path) -> None:
    (one,) = beside(folder, "..\\meshes\\Upper\\part.stl")
    assert (one.code, one.severity) == ("RD601", E)
    assert one.fix is not None
    assert one.fix.edits[0].text == "../meshes/Upper/part.stl"
    (other,) = beside(folder, "..\\meshes\\none.stl")
    assert (other.code, other.fix) == ("RD601", None)


def test_a_listing_that_decomposes_letters_is_no_other_case(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on macOS: the file opens by the composed name, and is listed by the decomposed one."""
    (folder / COMPOSED).write_bytes(binary_stl(box()))
    listed = os.listdir
    monkeypatch.setattr(os, "listdir", lambda path: [name.replace(COMPOSED, DECOMPOSED) for name in listed(path)])
    assert beside(folder, COMPOSED) == []


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """The files whose facts are computed, in a cache of the test's own."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path / "cache"))
    seen: list[Path] = []

    def counted(path: Path) -> MeshFacts:
        seen.append(path)
        return mesh_facts(path)

    monkeypatch.setattr(mesh_files, "mesh_facts", counted)
    return seen


def mesh(folder: Path, name: str = "part.stl", size: float = 1.0) -> Path:
    path = folder / name
    path.write_bytes(binary_stl(box((size, 0.2, 0.3))))
    return path


def kept(folder: Path) -> list[Path]:
    return [path for path in (folder / "cache").rglob("*") if path.is_file()]


def test_facts_are_computed_once_for_one_content_and_suffix(tmp_path: Path, computed: list[Path]) -> None:
    first, copy = mesh(tmp_path), mesh(tmp_path, "copy.stl")
    facts = facts_of([first])[first]
    assert facts_of([first, copy]) == {first: facts, copy: facts}
    assert computed == [first]
    mesh(tmp_path, size=3.0)
    assert facts_of([first])[first].hi[0] == 1.5
    facts_of([mesh(tmp_path, "part.obj", size=3.0)])
    assert len(computed) == 3


def test_facts_of_other_code_or_without_a_cache_do_not_count(
    tmp_path: Path, computed: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mesh(tmp_path)
    facts_of([path])
    monkeypatch.setattr(mesh_files, "maker", lambda: "other code")
    assert facts_of([path]) == facts_of([path])
    assert (computed, len(kept(tmp_path))) == ([path, path], 2)
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    facts_of([path])
    assert (len(computed), len(kept(tmp_path))) == (3, 2)
    assert facts_of([tmp_path / "none.stl"])[tmp_path / "none.stl"].problem == "there is no such file"


def test_a_mesh_with_its_data_elsewhere_is_always_read(tmp_path: Path, computed: list[Path]) -> None:
    path = tmp_path / "part.gltf"
    path.write_text("{}")
    assert facts_of([path]) == facts_of([path])
    assert computed == [path, path]
    assert kept(tmp_path) == []


@pytest.mark.parametrize("damage", [b"", b"{}", b"robodyn object 1\n"])
def test_a_damaged_entry_is_ignored(tmp_path: Path, computed: list[Path], damage: bytes) -> None:
    path = mesh(tmp_path)
    facts = facts_of([path])
    (entry,) = kept(tmp_path)
    entry.write_bytes(damage)
    assert facts_of([path]) == facts
    assert len(computed) == 2
    assert facts_of([path]) == facts
    assert len(computed) == 2


def test_no_corner_lies_farther_than_the_outermost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an ellipsoid's points in several blocks, and of one corner far out in the last."""
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    rng = np.random.default_rng(3)
    points = rng.normal(size=(2 * BLOCK + 7, 3, 3))
    points *= (0.3, 0.2, 0.1) / np.linalg.norm(points, axis=2, keepdims=True)
    points[-1, 1] = 0.4, -0.1, 0.2
    (tmp_path / "part.stl").write_bytes(binary_stl(points))
    corners, found = points.reshape(-1, 3).astype(np.float32).astype(float), extremes(tmp_path / "part.stl", "")
    assert found is not None
    assert {*map(tuple, found)} <= {*map(tuple, corners)}
    for direction in spread_out(240):
        assert product(found, direction).max() == pytest.approx(product(corners, direction).max(), rel=1e-15)
    (tmp_path / "part.stl").write_bytes(b"solid")
    assert extremes(tmp_path / "part.stl", "") is None
