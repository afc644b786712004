"""Facts of meshes are kept by content, and only where they are intact."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.mesh_samples import binary_stl, box

from robodyn.checks.meshes import facts as mesh_store
from robodyn.checks.meshes.facts import MeshFacts, facts_of, mesh_facts


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """The files whose facts are computed, in a cache of the test's own."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path / "cache"))
    seen: list[Path] = []

    def counted(path: Path) -> MeshFacts:
        seen.append(path)
        return mesh_facts(path)

    monkeypatch.setattr(mesh_store, "mesh_facts", counted)
    return seen


def mesh(folder: Path, name: str = "part.stl", size: float = 1.0) -> Path:
    path = folder / name
    path.write_bytes(binary_stl(box((size, 0.2, 0.3))))
    return path


def kept(folder: Path) -> list[Path]:
    return [path for path in (folder / "cache").rglob("*") if path.is_file()]


def test_facts_are_computed_once_for_one_content(tmp_path: Path, computed: list[Path]) -> None:
    first, copy = mesh(tmp_path), mesh(tmp_path, "copy.stl")
    facts = facts_of([first])[first]
    assert facts_of([first, copy]) == {first: facts, copy: facts}
    assert computed == [first]


def test_another_content_is_another_mesh(tmp_path: Path, computed: list[Path]) -> None:
    path = mesh(tmp_path)
    assert facts_of([path])[path].hi == (0.5, *facts_of([path])[path].hi[1:])
    mesh(tmp_path, size=3.0)
    assert facts_of([path])[path].hi[0] == 1.5
    assert computed == [path, path]
    facts_of([mesh(tmp_path, "part.obj", size=3.0)])  # the suffix counts
    assert len(computed) == 3


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


def test_facts_of_other_code_do_not_count(
    tmp_path: Path, computed: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mesh(tmp_path)
    facts_of([path])
    monkeypatch.setattr(mesh_store, "maker", lambda: "other code")
    assert facts_of([path]) == facts_of([path])
    assert computed == [path, path]
    monkeypatch.setattr(mesh_store, "maker", lambda: "")
    facts_of([path])
    assert len(computed) == 3
    assert len(kept(tmp_path)) == 2


def test_the_code_that_counts_is_that_of_meshes_and_of_their_facts(monkeypatch: pytest.MonkeyPatch) -> None:
    folders: list[Path] = []
    monkeypatch.setattr(mesh_store, "code_digest", lambda folder: folders.append(folder) or str(len(folders)))
    assert mesh_store.maker.__wrapped__() == "1 2"
    assert all((folder / "__init__.py").exists() for folder in folders)
    assert [(folder / name).exists() for folder, name in zip(folders, ("facts.py", "mesh/indexed.py"), strict=True)]


def test_nothing_is_kept_where_nothing_may_be(
    tmp_path: Path, computed: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    path = mesh(tmp_path)
    assert facts_of([path]) == facts_of([path])
    assert len(computed) == 2
    assert kept(tmp_path) == []


def test_a_file_that_is_gone_has_a_problem(tmp_path: Path, computed: list[Path]) -> None:
    path = tmp_path / "none.stl"
    assert facts_of([path])[path].problem == "there is no such file"


def test_facts_survive_writing() -> None:
    facts = MeshFacts(triangles=3, lo=(-0.1, 0.0, 1e-17), hi=(0.1, 0.2, 1 / 3), volume=-2e-9, closed=True, inverted=1)
    assert MeshFacts.loads(facts.dumps()) == facts
    for data in (b"", b"[]", b"{}", b'{"lo": 1, "hi": 2}', b'{"lo": [], "hi": [], "more": 1}', b"\xff"):
        assert MeshFacts.loads(data) is None
