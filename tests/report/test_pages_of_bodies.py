"""Pages of `inertia`, `diff` and `check`: what is drawn is what the numbers say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.html_pages import checked as kept
from helpers.oracles import ROBOTS, robot

import robodyn
from robodyn.checks.check import check_tasks, tasks_for
from robodyn.comparison.compare import compare
from robodyn.report.check import check_page
from robodyn.report.comparison import comparison_page
from robodyn.report.document import Document, Findings, Folded, Levels, Stage
from robodyn.report.inertia_pages import combination_page, parts_page
from robodyn.report.renderers.pages import html
from robodyn.robot.kinematics import link_poses
from robodyn.solids.inertia.properties import View
from robodyn.solids.mass_properties import combined, mass_properties
from robodyn.solids.mesh.read.load import load_triangles

PARTS = [str(ROBOTS / "meshes" / name) for name in ("bracket.stl", "hub.stl")]
PUMA = (ROBOTS / "puma560.urdf").read_text()


def stage_of(document: Document) -> Stage:
    kept(html(document))
    (found,) = (block for block in document.blocks if isinstance(block, Stage))
    return found


def triangles(name: str) -> np.ndarray:
    found = load_triangles(name, unit="mm")
    return found.array() * found.scale


def test_a_solid_has_its_axes_and_planes() -> None:
    part = mass_properties(PARTS[0], unit="mm", symmetry=True)
    seen = stage_of(parts_page([part], View(), [triangles(PARTS[0])]))
    (drawn,) = seen.look["robots"]
    (body,) = drawn["bodies"]
    assert (body["mass"], body["centre"]) == (part.body.mass, part.body.com.tolist())
    axes, half = np.reshape(body["ellipsoid"][0], (3, 3)), np.array(body["ellipsoid"][1])
    second = part.body.mass / 5.0 * axes @ np.diag(half**2) @ axes.T
    assert np.trace(second) * np.eye(3) - second == pytest.approx(part.body.inertia, rel=1e-9, abs=1e-15)
    *lines, plane = seen.look["marks"]
    for k, line in enumerate(lines):
        ((at, along, _),) = line["pieces"]
        assert np.array(at) + 0.5 * np.array(along) == pytest.approx(part.body.com, abs=1e-12)
        assert along / np.linalg.norm(along) == pytest.approx(part.body.principal.axes[k])
        assert float(line["what"].split()[3]) == pytest.approx(part.body.principal.moments[k], rel=1e-3)
    assert plane["what"] == "1 plane of symmetry"
    ((at, along, _),) = plane["pieces"]
    assert np.cross(along, (0.0, 1.0, 0.0)) == pytest.approx(0.0, abs=1e-15)
    assert at[1] == pytest.approx(0.0, abs=1e-12)
    assert f"{part.body.mass:.4g} kg, centre of mass" in seen.alt


def test_solids_stand_beside_each_other_or_where_they_belong() -> None:
    parts, shapes = [mass_properties(name, unit="mm") for name in PARTS], [triangles(name) for name in PARTS]
    one, other = stage_of(parts_page(parts, View(), shapes)).look["robots"]
    assert one["bodies"][0]["p"][0] + shapes[0][..., 0].min() > other["bodies"][0]["p"][0] + shapes[1][..., 0].max()
    whole = combined(parts, ((np.eye(3), np.zeros(3)), (np.eye(3), np.array((0.0, 0.0, 0.1)))))
    look = stage_of(combination_page(whole, View(), shapes)).look
    assert [each["bodies"][0]["p"] for each in look["robots"]] == [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]
    assert look["marks"][0]["what"].startswith("principal axis 1: ")


def test_robots_that_are_compared_move_together() -> None:
    """The waist turns the other way in B, whose forearm is heavier: the same sliders put both in one place."""
    start = PUMA.index('<joint name="waist"')
    turned = PUMA[:start] + PUMA[start:].replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>', 1)
    a, b = robot("puma560"), robodyn.load(turned.replace('mass value="4.8"', 'mass value="6"').encode())
    seen = stage_of(comparison_page(compare(a, b)))
    mine, theirs = seen.look["robots"]
    assert [body["name"] for body in mine["bodies"] if body["lit"]] == ["forearm"]
    assert [body["name"] for body in theirs["bodies"] if body["lit"]] == ["forearm"]
    assert (mine["alpha"], theirs["alpha"]) == (1.0, 0.45)
    assert "mass 4.8 kg in A, 6 kg in B" in seen.alt
    signs = [slider["sign"] for slider in theirs["motions"][0]["sliders"]]
    assert signs == [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    for one, other in zip(mine["motions"], theirs["motions"], strict=True):
        q = np.array(one["rest"]) + 0.3
        q_b = np.array(other["rest"])
        for slider in other["sliders"]:
            q_b[slider["q"]] = slider["sign"] * q[slider["of"]] + slider["offset"]
        for name, pose in link_poses(a, q).items():
            assert link_poses(b, q_b)[name].p.astype(float) == pytest.approx(pose.p.astype(float), abs=1e-12)
    assert mine["motions"][1]["name"] == "pose where shoulder differs most"


def test_findings_are_grouped_explained_and_lit(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(PUMA.replace('<mass value="4.8"/>', '<mass value="4800"/>'))
    found = check_tasks(tasks_for([str(file)], robodyn.checks.check.Options(select=("ALL",))))
    document = check_page(found, {str(file): robodyn.load(file)})
    levels, rules = (next(each for each in document.blocks if isinstance(each, kind)) for kind in (Levels, Folded))
    groups = [each for each in document.blocks if isinstance(each, Findings)]
    assert [group.caption for group in groups] == [words for _, words in levels.items]
    assert [{level for level, *_ in group.items} for group in groups] == [{level} for level, _ in levels.items]
    assert {code for group in groups for code in group.links} == {code for code, *_ in rules.items}
    bodies = {body["name"]: body for body in stage_of(document).look["robots"][0]["bodies"]}
    assert bodies["forearm"]["lit"] == "doubtful"
    assert "warning RD304, link 'forearm': " in bodies["forearm"]["words"]
    assert {name for name, body in bodies.items() if not body["lit"]} == {"base", "hand"}


def test_a_page_without_a_robot_has_the_script_of_tables_alone() -> None:
    source = html(check_page(check_tasks(tasks_for([PUMA.replace("</robot>", "").encode()]))))
    assert "uPlot" not in source
    assert "webgl2" not in source
