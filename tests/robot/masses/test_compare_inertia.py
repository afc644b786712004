"""Declared inertias against shapes, link by link, with the slips that explain what differs."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from robodyn.programs.vectors import rotation_from_rpy
from robodyn.report.document import text
from robodyn.report.inertia import comparison_sections
from robodyn.robot.load import load_description
from robodyn.robot.masses.shapes import Reading, compare, mistakes_in_words
from robodyn.robot.urdf.parts import Inertial, Origin
from robodyn.solids.inertia.properties import inertial_element
from robodyn.solids.inertia.solids import box

ROBOTS = Path(__file__).parents[3] / "robots"
EPS = np.finfo(float).eps
SOLID = box(0.3, 0.2, 0.1, mass=4.0)
SHAPE = '<visual><geometry><box size="0.3 0.2 0.1"/></geometry></visual>'


def one_link(body, shape=SHAPE):
    """The only link of a robot that declares this body and has this shape."""
    inertial = "" if body is None else inertial_element(body)
    (found,) = compare(
        load_description(f'<robot name="r"><link name="a">{inertial}{shape}</link></robot>'.encode())
    ).links
    return found


def test_a_right_declaration():
    found = one_link(SOLID)
    assert (found.name, found.reason, found.remarks) == ("a", None, ())
    difference = found.difference
    assert difference.density == pytest.approx(4 / 0.006, rel=4 * EPS)
    assert difference.inertia <= 4 * EPS
    assert difference.distance == 0
    np.testing.assert_allclose(difference.ratios, 1, rtol=8 * EPS)
    assert difference.room == pytest.approx(1 / 3, rel=8 * EPS)


def test_figures_of_a_wrong_declaration():
    """Twice the moments, the centre (3, 4, 0) cm off: the norm of the difference is that of the inertia itself."""
    given = box(0.3, 0.2, 0.1, mass=8.0).scaled_to_mass(8.0)
    wrong = given.__class__(4.0, np.array([0.03, 0.04, 0.0]), given.S_c)
    difference = one_link(wrong).difference
    assert difference.inertia == pytest.approx(1, rel=8 * EPS)
    assert difference.distance == pytest.approx(0.05, rel=8 * EPS)
    np.testing.assert_allclose(difference.offset, [0.03, 0.04, 0], rtol=4 * EPS)
    np.testing.assert_allclose(difference.ratios, 2, rtol=8 * EPS)
    np.testing.assert_allclose(difference.body.inertia, SOLID.inertia, rtol=8 * EPS)


def test_what_no_mass_inside_the_shapes_can_have():
    spread = SOLID.__class__(4.0, np.zeros(3), 4 * np.diag([0.03, 0.001, 0.001]))
    (remark,) = one_link(spread).remarks
    assert remark == "spread over 1.33 times what any mass inside the box around the shapes can be"
    outside = SOLID.placed(np.eye(3), np.array([1.0, 0, 0]))
    assert one_link(outside).remarks == ("the centre of mass lies outside the box around the shapes",)


@pytest.mark.parametrize(
    ("body", "shape", "reason"),
    [
        (None, SHAPE, "no <inertial>"),
        (SOLID, "", "no <visual> shape"),
        (SOLID, SHAPE.replace("visual", "collision"), "no <visual> shape"),
        (-SOLID, SHAPE, "a mass of -4 kg"),
        (SOLID, SHAPE.replace('box size="0.3 0.2 0.1"', 'mesh filename="no.stl"'), "the mesh 'no.stl' is not found"),
        (SOLID, SHAPE.replace("0.3", "-1"), "a box cannot have the length -1 m"),
        (
            SOLID,
            SHAPE.replace("0.3 0.2 0.1", "1e-100 1e-100 1e-100"),
            "a box without volume has no mass by its density",
        ),
    ],
)
def test_reasons(body, shape, reason):
    found = one_link(body, shape)
    assert (found.difference, found.reason) == (None, reason)


def test_a_dummy_inertial_of_zeros_is_no_fault_and_a_link_with_neither_mass_nor_shape_is_left_out():
    assert compare(load_description(b'<robot name="r"><link name="a"/></robot>')).links == ()
    zero = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    (found,) = compare(load_description(f'<robot name="r"><link name="a">{zero}</link></robot>'.encode())).links
    assert found.remarks == ()


@pytest.fixture(scope="module")
def arm():
    return {link.name: link for link in compare(load_description(ROBOTS / "meshed_arm.urdf")).links}


RIGHT = ("pedestal", "turret", "upper_arm", "forearm", "tool_plate", "left_finger", "right_finger")


def test_the_links_that_are_right(arm):
    """The numbers in the file are those of its meshes."""
    for name in RIGHT:
        assert arm[name].difference.inertia <= 64 * EPS
        assert arm[name].difference.distance <= 4 * EPS


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("turret", "turned to agree with neighbours"),
        ("upper_arm", "overlapping bodies united"),
        ("tool_plate", "1 hole filled"),
        ("hand", "the products of inertia (ixz) have the wrong sign"),
    ],
)
def test_remarks_of_the_arm(arm, name, words):
    assert any(words in remark for remark in arm[name].remarks), arm[name].remarks


def test_the_doubtful_link_comes_first_of_those_with_closed_meshes(arm):
    assert next(name for name in arm if name != "tray") == "hand"
    hand = arm["hand"].difference
    np.testing.assert_allclose(hand.ratios, 1, rtol=1e-12)
    I = hand.body.inertia
    assert hand.inertia == pytest.approx(2 * np.sqrt(2) * I[0, 2] / np.linalg.norm(I), rel=1e-12)


@pytest.mark.parametrize("ulps", [(3, 0, 1), (0, 5, 2)])
def test_last_digits_change_neither_order_nor_text(ulps):
    """Three links that agree with their shapes, and one that does not, all but for the last digits."""
    wrong = SOLID.__class__(4.0, np.zeros(3), 1.2 * SOLID.S_c)
    bodies = [SOLID.__class__(4.0, np.zeros(3), (1 + k * EPS) * SOLID.S_c) for k in ulps]
    links = "".join(
        f'<link name="{name}">{inertial_element(body)}{SHAPE}</link>'
        for name, body in zip("abcd", (*bodies[:2], wrong, bodies[2]), strict=True)
    )
    joints = "".join(
        f'<joint name="to_{name}" type="fixed"><parent link="a"/><child link="{name}"/></joint>' for name in "bcd"
    )
    found = compare(load_description(f'<robot name="r">{links}{joints}</robot>'.encode()))
    assert [link.name for link in found.links] == ["c", "a", "b", "d"]
    rows = text(comparison_sections(found)).splitlines()[3:7]
    assert [row.split()[1] for row in rows] == ["20", "0", "0", "0"]


def test_each_mesh_is_read_once_and_reported():
    text = (ROBOTS / "meshed_arm.urdf").read_text().replace('-0.0005 0.001"', '0.0005 0.001"')
    seen, done = [], []

    @contextmanager
    def watch(files):
        seen.extend(file.name for file in files)
        yield lambda: done.append(1)

    compare(load_description(text.encode(), str(ROBOTS / "arm.urdf")), reading=Reading({}, watch=watch))
    meshes = {path.name for path in (ROBOTS / "meshes").iterdir()}
    assert sorted(seen) == sorted(meshes)
    assert len(done) == len(seen)


OFF = SOLID.placed(rotation_from_rpy(0.4, 0.5, 0.6), np.zeros(3)).placed(np.eye(3), np.array([0.2, 0.1, -0.3]))


def inertial(I, mass=4.0, com=OFF.com):
    """What a link declares, its tensor in the axes of the link."""
    return Inertial(mass, Origin(tuple(com), (0.0, 0.0, 0.0)), tuple(I[np.triu_indices(3)]))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (inertial(2 * np.diag(np.diagonal(OFF.inertia)) - OFF.inertia), "products of inertia (ixy, ixz, iyz) have the"),
        (inertial(OFF.about(np.zeros(3))), "taken about the link's origin"),
        (inertial(1e6 * OFF.inertia), "the inertia is 1e+06 times what the shapes suggest: kg mm^2"),
        (inertial(OFF.inertia * 10.1), "the inertia is 10 times what the shapes suggest: a slipped exponent"),
        (inertial(OFF.inertia, 4000.0), "the mass is 1000 times what the shapes suggest: g?"),
        (inertial(1e3 * OFF.inertia, 4000.0), "the mass is 1000 times, the inertia is 1000 times what the shapes"),
        (inertial(OFF.inertia, com=1000 * OFF.com), "the centre of mass is 1000 times what the shapes suggest: mm?"),
        (inertial(3417.17 * OFF.inertia), "the inertia is 3417.17 times what the shapes suggest: lb in^2?"),
    ],
)
def test_slips(given, words):
    (found,) = mistakes_in_words(given, OFF)
    assert words in found
    assert float(found.rpartition("agrees within ")[2].partition(" %")[0]) <= 2


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5, 30.0])
def test_no_slip(factor):
    assert mistakes_in_words(inertial(factor * OFF.inertia), OFF) == ()


@pytest.mark.parametrize("part", [0.2, 1e-3])
def test_a_product_of_the_wrong_sign_counts_at_any_size(part):
    """Its magnitude is that of the shapes' to the last bit; beside the tensor it is small."""
    shapes = SOLID.placed(rotation_from_rpy(0.0, 0.0, part), np.zeros(3))
    wrong = 2 * np.diag(np.diagonal(shapes.inertia)) - shapes.inertia
    (found,) = mistakes_in_words(inertial(wrong, com=np.zeros(3)), shapes)
    assert "wrong sign" in found
    assert mistakes_in_words(inertial(shapes.inertia, com=np.zeros(3)), shapes) == ()
