"""Bodies made of the shapes of a link, closed forms and meshes at their poses; meshes fixed to each other."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import mesh_samples

from robodyn.errors import DescriptionError, InputError, MeshError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.load import load_description
from robodyn.robot.masses.shapes import link_from_shapes
from robodyn.solids.inertia import solids
from robodyn.solids.inertia.solids import box
from robodyn.solids.mass_properties import combined, mass_properties

EPS = np.finfo(float).eps
SHAPES = {
    '<box size="0.3 0.2 0.1"/>': solids.box(0.3, 0.2, 0.1, density=1000),
    '<sphere radius="0.2"/>': solids.sphere(0.2, density=1000),
    '<cylinder radius="0.1" length="0.5"/>': solids.cylinder(0.1, 0.5, density=1000),
    '<capsule radius="0.1" length="0.5"/>': solids.capsule(0.1, 0.5, density=1000),
}
POSE = '<origin xyz="1 -2 0.5" rpy="0.3 -0.2 1"/>'
R, P = rotation_from_rpy(0.3, -0.2, 1), np.array([1, -2, 0.5])


def described(*visuals, folder=None, inertial=""):
    shapes = "".join(f"<visual>{pose}<geometry>{shape}</geometry></visual>\n" for pose, shape in visuals)
    text = f'<robot name="r"><link name="a">{inertial}{shapes}</link></robot>'
    return load_description(text.encode(), None if folder is None else str(folder / "r.urdf"))


def close(found, expected):
    assert found.mass == pytest.approx(expected.mass, rel=8 * EPS)
    np.testing.assert_allclose(found.com, expected.com, rtol=0, atol=8 * EPS * max(np.abs(expected.com).max(), 0.1))
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=32 * EPS * np.abs(expected.inertia).max())


@pytest.mark.parametrize("shape", SHAPES)
def test_a_solid_at_its_pose_and_the_box_around_it(shape):
    found = link_from_shapes(described((POSE, shape)), "a")
    close(found.body, SHAPES[shape].placed(R, P))
    assert found.weight == "at an assumed density"
    around = link_from_shapes(described(('<origin rpy="0 1.5707963267948966 0"/>', shape)), "a").shapes.box
    half = {"box": (0.05, 0.1, 0.15), "sphere": (0.2,) * 3, "cylinder": (0.25, 0.1, 0.1), "capsule": (0.35, 0.1, 0.1)}
    np.testing.assert_allclose(around.hi, half[shape[1:].partition(" ")[0]], rtol=4 * EPS)
    np.testing.assert_array_equal(around.lo, -around.hi)


def test_several_shapes_are_one_body():
    found = link_from_shapes(described(("", '<box size="0.3 0.2 0.1"/>'), (POSE, '<sphere radius="0.2"/>')), "a")
    close(found.body, SHAPES['<box size="0.3 0.2 0.1"/>'] + SHAPES['<sphere radius="0.2"/>'].placed(R, P))
    assert found.shapes.remarks == ()


def test_shapes_that_may_overlap_are_remarked():
    found = link_from_shapes(described(("", '<sphere radius="0.2"/>'), ("", '<sphere radius="0.1"/>')), "a")
    assert found.shapes.remarks == ("boxes of 1 pair of bodies overlap: what bodies share counts twice",)


@pytest.mark.parametrize("factors", [(0.01, 0.01, 0.01), (0.01, -0.02, 0.005)])
def test_a_mesh_with_scale_and_pose(tmp_path, factors):
    wedge = mesh_samples.tetrahedron()
    (tmp_path / "wedge.stl").write_bytes(mesh_samples.binary_stl(wedge))
    scale = " ".join(map(str, factors))
    found = link_from_shapes(described((POSE, f'<mesh filename="wedge.stl" scale="{scale}"/>'), folder=tmp_path), "a")
    corners = wedge * factors
    around = corners.reshape(-1, 3) @ R.T + P
    A, volume = np.diag(factors), 10 * abs(np.prod(factors))
    S = 1000 * abs(np.prod(factors)) * A @ _second_moments() @ A
    expected = R @ S @ R.T
    assert found.body.mass == pytest.approx(1000 * volume, rel=8 * EPS)
    np.testing.assert_allclose(found.body.com, R @ A @ [1.25, 1, 0.75] + P, rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(found.body.S_c, expected, rtol=0, atol=32 * EPS * np.abs(expected).max())
    assert (found.shapes.box.lo <= around.min(axis=0) + EPS).all()
    assert (found.shapes.box.hi >= around.max(axis=0) - EPS).all()


def _second_moments():
    """Of Mirtich's tetrahedron, from its inertia matrix."""
    I = np.array([[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]])
    return np.trace(I) / 2 * np.eye(3) - I


INERTIAL = """<inertial><mass value="{}"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"""


@pytest.mark.parametrize(
    ("declared", "how", "mass", "weight"),
    [
        ("5", {}, 5, "as declared"),
        ("0", {}, 6, "at an assumed density"),
        ("5", {"density": 500}, 3, "by the density"),
        ("5", {"mass": 2}, 2, "as asked"),
    ],
)
def test_where_the_mass_is_from(declared, how, mass, weight):
    description = described(("", '<box size="0.3 0.2 0.1"/>'), inertial=INERTIAL.format(declared))
    found = link_from_shapes(description, "a", **how)
    close(found.body, solids.box(0.3, 0.2, 0.1, mass=mass))
    assert found.weight == weight


@pytest.mark.parametrize(
    ("shape", "kind", "how", "error", "message"),
    [
        ('<box size="1 1 1"/>', "collision", {}, InputError, "link 'a' has no <collision> shape"),
        ('<box size="1 1 1"/>', "visual", {"density": 1, "mass": 1}, InputError, "both a density and a mass"),
        ('<box size="1 1 1"/>', "visual", {"density": 0}, InputError, "a density of 0 kg/m^3 is not positive"),
        ('<box size="1 1 1"/>', "visual", {"mass": np.inf}, InputError, "a mass of inf kg is not positive"),
        ('<sphere radius="-1"/>', "visual", {}, DescriptionError, "<stdin>:1: a sphere cannot have the length -1 m"),
        ('<box size="1 0 1"/>', "visual", {}, DescriptionError, "<stdin>:1: a box without volume has no mass"),
        ('<mesh filename="no.stl"/>', "visual", {}, DescriptionError, "<stdin>:1: the mesh 'no.stl' is not found"),
        (
            '<mesh filename="package://p/no.stl"/>',
            "visual",
            {},
            DescriptionError,
            "--package-path DIR names the package",
        ),
    ],
)
def test_refused(shape, kind, how, error, message):
    with pytest.raises(error) as caught:
        link_from_shapes(described(("", shape)), "a", kind, **how)
    assert message in str(caught.value)


def test_a_mesh_that_is_no_solid(tmp_path):
    (tmp_path / "flat.stl").write_bytes(mesh_samples.binary_stl(mesh_samples.sheet()))
    with pytest.raises(MeshError, match=r"flat\.stl"):
        link_from_shapes(described(("", '<mesh filename="flat.stl"/>'), folder=tmp_path), "a")


SIZES = ((0.5, 0.25, 0.125), (0.25, 0.25, 1.0))
POSES = (
    (rotation_from_rpy(0.1, 0.2, 0.3), np.array([1.0, 0, 0])),
    (rotation_from_rpy(-0.5, 0, 1), np.array([0, -1.0, 2])),
)


def parts(*densities):
    return [mass_properties(mesh_samples.box(size), density=rho) for size, rho in zip(SIZES, densities, strict=True)]


def test_the_mass_of_the_whole_is_shared_as_the_densities_say():
    found = combined(parts(1000, 500), POSES, mass=2.0)
    one, other = (
        box(*size, density=rho).placed(*pose) for size, rho, pose in zip(SIZES, (1000, 500), POSES, strict=True)
    )
    close(found.body, (one + other).scaled_to_mass(2.0))
    assert [part.body.mass for part in found.parts] == pytest.approx([2 / 3, 4 / 3], rel=8 * EPS)


def test_without_places_meshes_stay_where_they_are():
    moved = mass_properties(mesh_samples.moved(mesh_samples.box(), (2, 0, 0)), density=1)
    still = mass_properties(mesh_samples.box(), density=1)
    one = box(1, 1, 1, density=1)
    close(combined([still, moved]).body, one + one.placed(np.eye(3), np.array([2.0, 0, 0])))
    assert len(combined([still, still]).warnings) == 1
    found = combined([still, moved]).box
    np.testing.assert_array_equal((found.lo, found.hi), ([-0.5] * 3, [2.5, 0.5, 0.5]))


@pytest.mark.parametrize(("poses", "mass"), [(POSES[:1], None), (POSES, 0.0), (POSES, np.nan), (POSES, np.inf)])
def test_parts_without_places_or_mass_are_refused(poses, mass):
    with pytest.raises(InputError):
        combined(parts(1, 1), poses, mass)
