"""Rules that hold inertials against shapes."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.mesh_samples import binary_stl, box

from robodyn.checks.bodies.bodies import bodies
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Context
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Finding, Severity
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia import solids

E, W, I = Severity.ERROR, Severity.WARNING, Severity.NOTE
SHAPE = ("RD301", "RD302", "RD303", "RD304", "RD305")


def findings(source: str | bytes) -> list[Finding]:
    return list(check_one(source, Options(select=SHAPE)))


def found(source: str | bytes) -> list[tuple[str, Severity]]:
    return [(one.code, one.severity) for one in findings(source)]


def tensor(xx: float, yy: float, zz: float) -> str:
    return f'<inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/>'


def scaled(factor: float) -> str:
    return tensor(0.0126 * factor, 0.0124 * factor, 0.0032 * factor)


def rod(mass: float, apart: float) -> str:
    """A tensor of two points on the z axis, with a little thickness."""
    along = mass * apart**2 / 4
    return tensor(along + 1e-9, along + 1e-9, 2e-9)


@pytest.mark.parametrize(
    ("apart", "expected"),
    [(0.24, []), (0.2499, []), (0.27, [("RD301", I)]), (0.31, [("RD301", W)]), (0.59, [("RD301", E)])],
)
def test_two_points_within_and_beyond_the_box(apart: float, expected: list[tuple[str, Severity]]) -> None:
    """The box is 0.1 x 0.1 x 0.25; its corners are 0.1436 from the middle. Points on its faces reach the bound."""
    given = found(a_shaped_link(inertia=rod(2.0, apart), centre="0 0 0.125").encode())
    assert [one for one in given if one[0] == "RD301"] == expected
    assert ("RD303", W) in given, "all of its mass is on a line"


def test_a_root_that_may_stand_still_is_a_warning() -> None:
    text = a_shaped_link(inertia=rod(2.0, 0.59), centre="0 0 0.125")
    link = text[text.index('<link name="upper">') : text.index("</link>") + len("</link>")]
    assert ("RD301", E) in found(text.encode())
    assert ("RD301", W) in found(f'<robot name="root">{link}</robot>'.encode())


def test_the_bound_and_the_measure_are_second_moments() -> None:
    (one, _) = findings(a_shaped_link(inertia=rod(2.0, 0.59), centre="0 0 0.125").encode())
    assert one.measured == pytest.approx(2 * 0.59**2 / 4, rel=1e-6)
    assert one.bound == pytest.approx(2 * (0.125**2 + 2 * 0.05**2), rel=1e-12)


@pytest.mark.parametrize(
    ("z", "expected"),
    [(0.25, []), (0.278, []), (0.28, [("RD302", W)]), (0.53, [("RD302", W)]), (0.55, [("RD302", E)])],
)
def test_a_centre_outside_the_box(z: float, expected: list[tuple[str, Severity]]) -> None:
    """The diagonal of the box is 0.287."""
    assert found(a_shaped_link(centre=f"0 0 {z}").encode()) == expected


@pytest.mark.parametrize(("z", "cause"), [(-0.12, "it may be that z has the wrong sign"), (-0.05, None), (0.3, None)])
def test_a_sign_of_the_centre(z: float, cause: str | None) -> None:
    """The palm of Allegro is drawn below its frame, and has its centre above. With 0.05, 0.075 from the middle, it may
    as well be something else."""
    (one,) = [one for one in findings(a_shaped_link(centre=f"0 0 {z}").encode()) if one.code == "RD302"]
    assert one.cause == cause


@pytest.mark.parametrize("what", ["mass", "inertia", "centre of mass"])
@pytest.mark.parametrize("factor", [1e3, 1e6, 1e9, 25.4, 1e-3, 1e-6])
def test_factors_between_units(what: str, factor: float) -> None:
    known = {"mass": (1e3, 1e6, 1e-3), "inertia": (1e3, 1e6, 1e9, 1e-3, 1e-6), "centre of mass": (1e3,)}
    changed = {
        "mass": {"mass": repr(2 * factor)},
        "inertia": {"inertia": scaled(factor)},
        "centre of mass": {"centre": f"0 0 {0.12 * factor!r}"},
    }[what]
    results = findings(a_shaped_link(**changed).encode())
    if factor in known[what]:
        assert [(one.code, one.severity, one.measured) for one in results] == [("RD305", E, pytest.approx(factor))]
        assert f"the {what} is" in results[0].message
    else:
        assert "RD305" not in {one.code for one in results}


def test_a_factor_is_not_named_where_its_neighbours_are_as_good() -> None:
    """A centre 0.12 m from the origin of a box 0.25 m long may be anywhere in it: 16.7 times is as good as 25.4."""
    for factor in (16.7, 25.4):
        (one,) = findings(a_shaped_link(centre=f"0 0 {0.12 * factor!r}").encode())
        assert (one.code, one.severity) in [("RD302", E), ("RD305", W)]


def test_grams_in_mass_and_tensor_alike() -> None:
    assert found(a_shaped_link(mass="2000", inertia=scaled(1e3)).encode()) == [("RD305", E)]


def test_tensors_that_were_made_up_are_no_slip() -> None:
    """Nor are those that were raised to a floor for the sake of a simulator, as in iCubGazeboV2_5."""
    raised = '<inertia ixx="10" ixy="1e-5" ixz="-3e-3" iyy="10" iyz="6e-5" izz="10.01"/>'
    for inertia in (tensor(10.0, 10.0, 10.0), raised):
        (one,) = findings(a_shaped_link(inertia=inertia).encode())
        assert (one.code, one.severity) == ("RD301", E)
        floor = "it may be that its moments were raised to 10 kg m^2, as simulators are helped"
        assert one.cause == (floor if inertia == raised else None)
    (one,) = findings(a_shaped_link(inertia=tensor(10.0, 11.0, 10.0)).encode())
    assert "raised" not in (one.cause or "")


@pytest.mark.parametrize(("factor", "expected"), [(1.01, []), (0.99, [("RD303", W)]), (0.009, [])])
def test_a_link_without_shapes_is_no_denser_than_tungsten(factor: float, expected: list[tuple[str, Severity]]) -> None:
    """TIAGo's camera was held against the shapes of the head that it is fixed to; they say nothing of the least."""
    ball = float(solids.sphere((3 / (4 * np.pi * 19300)) ** (1 / 3), mass=1.0).inertia[0, 0]) * factor
    link = f'<link name="camera"><inertial><mass value="1"/>{tensor(ball, ball, ball)}</inertial></link>'
    joint = '<joint name="mount" type="fixed"><parent link="upper"/><child link="camera"/></joint></robot>'
    assert found(a_shaped_link().replace("</robot>", link + joint).encode()) == expected


def test_shapes_of_links_that_are_fixed_count() -> None:
    """A tensor too large for its own shape fits that of its rigid group."""
    large = '<collision><geometry><box size="2 2 2"/></geometry></collision>'
    text = a_shaped_link(inertia=tensor(0.3, 0.32, 0.28))
    assert found(text.encode()) == [("RD301", E)]
    more = f"""<link name="cover">{large}</link>
  <joint name="glue" type="fixed"><parent link="upper"/><child link="cover"/></joint>"""
    assert [severity for _, severity in found(text.replace("</robot>", more + "</robot>").encode())] == [W]


def test_bodies_stand_in_the_link_s_axes() -> None:
    """A solid box turned by the inertial's rpy has the second moments of the turned box."""
    body = solids.box(0.1, 0.2, 0.3, density=1000.0)
    xx, yy, zz = np.diag(body.inertia).tolist()
    text = a_shaped_link(mass=repr(body.mass), inertia=tensor(xx, yy, zz))
    text = text.replace('<origin xyz="0 0 0.12"/>', '<origin xyz="0 0 0.12" rpy="0 1.5707963267948966 0"/>')
    context = Context(read(text.encode()))
    (one,) = context.once(bodies).values()
    assert one.S is not None
    second = np.diag(body.S_c)
    assert np.abs(one.S - np.diag(second[[2, 1, 0]])).max() <= 8 * np.finfo(float).eps * second.max()


def test_meshes_count_as_shapes(tmp_path: object) -> None:
    folder = str(tmp_path)
    with open(f"{folder}/part.stl", "wb") as stream:
        stream.write(binary_stl(box((100.0, 100.0, 250.0))))
    shape = '<mesh filename="part.stl" scale="-0.001 0.001 0.001"/>'
    for centre, expected in (("0 0 0.12", []), ("0 0 0.55", [("RD302", E)])):
        with open(f"{folder}/arm.urdf", "w") as stream:
            stream.write(a_shaped_link(shape=shape, centre=centre))
        assert found(f"{folder}/arm.urdf") == expected


def test_wrists_of_the_ur5() -> None:
    results = [one for one in findings(str(path_of("ur5_robot"))) if one.severity is E]
    assert {one.subject.name for one in results if one.subject} == {"wrist_1_link", "wrist_2_link", "wrist_3_link"}
    assert {one.code for one in results} == {"RD301"}


def test_mass_on_a_line_is_seen() -> None:
    """A slender femur with 5.17e-6 about one axis, where a solid rod of its shape has 2.9e-4: a slipped exponent."""
    rod = '<cylinder radius="0.02" length="0.16"/>'
    right, wrong = tensor(2.9e-4, 2.9e-4, 2.6e-5), tensor(5.17e-6, 2.9e-4, 2.88e-4)
    assert found(a_shaped_link(mass="0.13", inertia=right, centre="0 0 0.125", shape=rod).encode()) == []
    codes = {one.code for one in check_one(a_shaped_link("0.13", wrong, "0 0 0.125", rod).encode())}
    assert codes & {"RD303", "RD311", "RD312"}


@pytest.mark.parametrize(("radius", "expected"), [(0.05, []), (0.1, ["RD208"])])
def test_a_solid_ball_is_no_stand_in(radius: float, expected: list[str]) -> None:
    """1 kg of 5 cm radius have 0.001 kg m^2 in all directions."""
    text = a_shaped_link("1", tensor(0.001, 0.001, 0.001), "0 0 0.125", f'<sphere radius="{radius}"/>')
    assert [one.code for one in check_one(text.encode(), Options(select=("RD208",)))] == expected
