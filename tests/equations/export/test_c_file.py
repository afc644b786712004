"""The C file of a robot: it compiles without warnings and computes what robodyn computes."""

from __future__ import annotations

import ctypes
import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from helpers.c_functions import CC, compiled_c, needs_c
from helpers.exported import ARGUMENTS, CASES, arguments, each_case, expected, named, states, tolerance
from helpers.oracles import worst
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.errors import InputError
from robodyn.scene.scene import Immersed, Scene

WHOLE = ",".join(ARGUMENTS)


@needs_c
@each_case
def test_it_computes_what_robodyn_computes(case, tmp_path):
    model, scene = CASES[case]()
    text = robodyn.export(model, "c", WHOLE, scene=scene)
    library = compiled_c(text, tmp_path)
    prefix = re.search(r"void (\w+)_torques", text)[1]
    given, columns = states(model, scene)
    for word in ARGUMENTS:
        right = expected(word, model, scene, given, columns)
        found = called_with_results(getattr(library, f"{prefix}_{word}"), arguments(word, given, columns), right)
        bound = tolerance(word, model, scene, given, 1e-13)
        assert max(worst(ours, theirs) for ours, theirs in zip(found, right, strict=True)) <= bound
    found = robodyn.regressor(model, *(given[x] for x in ("q", "qd", "qdd")), scene=scene, columns=columns or None)
    theta = (ctypes.c_double * len(found.theta)).in_dll(library, f"{prefix}_theta")
    assert list(theta) == found.theta.tolist()


def called_with_results(function, sources, right):
    """The results of every row, whose shapes are those of `right`."""
    function.restype = None
    out = [np.full(each.shape, np.nan) for each in right]
    for k in range(len(right[0])):
        rows = [np.ascontiguousarray(source[k], dtype=float) for source in sources]
        results = [each[k] for each in out]
        function(*(array.ctypes.data_as(ctypes.c_void_p) for array in (*rows, *results)))
    return out


ODD = ["*/ int", "a-b", "a b", "A_b", "\u00fcml\u00e4ut", "??/", "7", "if", "/*"]


@needs_c
def test_odd_names(tmp_path):
    parts = [link("l0"), *(link(f"l{k}", 1, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)) for k in range(1, len(ODD) + 1))]
    escaped = [name.replace("&", "&amp;").replace("<", "&lt;") for name in ODD]
    parts += [joint(name, f"l{k}", f"l{k + 1}", axis=(0, 0, 1)) for k, name in enumerate(escaped)]
    text = robodyn.export(replace(built(*parts), name="3 of */ ??/ them"), "c")
    compiled_c(text, tmp_path)
    assert "void robot_3_of_them_torques(" in text
    enumerated = re.findall(r"ROBOT_3_OF_THEM_QD_(\w+) = (\d+)", text)
    assert len({name for name, _ in enumerated}) == len(ODD)
    assert [int(place) for _, place in enumerated] == list(range(len(ODD)))


@needs_c
def test_declarations_stand_alone_and_twice(tmp_path):
    (tmp_path / "scara.c").write_text(robodyn.export(named("scara")[0], "c", "mass_matrix"))
    (tmp_path / "main.c").write_text(
        "#define SCARA_DECLARATIONS_ONLY\n"
        + 2 * '#include "scara.c"\n'
        + "int main(void) { double M[SCARA_N * SCARA_N], q[SCARA_NQ] = {0.0, 0.0, 0.0};\n"
        "scara_mass_matrix(q, M); return M[SCARA_QD_QUILL * SCARA_N + SCARA_QD_QUILL] > 1.4 ? 0 : 1; }\n"
    )
    strict = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0")
    subprocess.run([CC, *strict, "-o", "main", "main.c", "scara.c", "-lm"], cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "main"], check=True)


FRICTION = "lift: viscous 35.0, forward 18.0, backward -14.0, stribeck 22.0, stribeck_velocity 0.01\n"


def test_the_head_says_what_is_in_the_file():
    model, scene = named("gripper", "gripper.toml")
    text = robodyn.export(model, "c", scene=scene)
    head = text[: text.index("*/")]
    for words in (
        '"gripper"',
        "lift: prismatic, m",
        "wrist: revolute, rad",
        "Gravity (0.0, 0.0, -9.81) m/s^2",
        "Coulomb friction: sign(0) = 0",
        FRICTION,
    ):
        assert words in head
    assert re.search(r"coulomb friction: f sign\(qd\).*; \d joints with Coulomb friction\n", head)
    assert re.search(r"\* +\w+ = -?1\.0 jaw \+ ", head)
    assert re.search(r"/\* the torques of a motion; \d+ operations\n", text)
    assert "No friction." in robodyn.export(named("scara")[0], "c")


def test_the_head_says_how_friction_leaves_rest():
    """The speed over which it grows where there is one; nothing where the only signs are those of a fluid's drag."""
    model, scene = named("gripper", "gripper.toml")
    smooth = "sign(qd) is qd / sqrt(qd^2 + slip_speed^2), slip_speed 0.05"
    for text, slip in ((robodyn.export(model, "jax", scene=replace(scene, slip_speed=x)), x) for x in (0.0, 0.05)):
        assert (smooth in text, "sign(0) = 0, and sign has derivative 0" in text) == (bool(slip), not slip)
    water = Scene(immersed=(Immersed("spindle", drag_area=(0.1, 0.1, 0.1)),), fluid_density=1000.0)
    text = robodyn.export(named("scara")[0], "jax", scene=water)
    assert "sign(" in text.split("No friction.")[1]
    assert "Coulomb" not in text


def test_forward_dynamics_is_refused_where_nothing_resists():
    parts = (link("a"), link("b", 1, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)), link("c"))
    model = built(*parts, joint("j1", "a", "b"), joint("j2", "b", "c"))
    assert "_torques(" in robodyn.export(model, "c", "torques,mass_matrix")
    with pytest.raises(InputError, match='joint "j2" moves nothing that has inertia'):
        robodyn.export(model, "c", "torques,forward")


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_constants_that_overflow_are_refused(target):
    with pytest.raises(InputError, match="overflows"):
        robodyn.export(named("scara")[0], target, "bias", scene=Scene(gravity=(0, 0, 1e308)))
