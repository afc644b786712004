"""Catalogues as CSV: every fault is told with line, column and remedy, nothing is skipped, nothing brings it down."""

from __future__ import annotations

import random

import numpy as np
import pytest
from helpers.command_line import ROBOTS, document, run, shown

from robodyn.errors import InputError
from robodyn.sizing.catalogue_tables import (
    GEARS_TEMPLATE,
    MOTORS_TEMPLATE,
    CatalogueError,
    CatalogueGear,
    CatalogueMotor,
    read_rows,
)

MOTORS = "name,inertia,continuous_torque,peak_torque,max_speed,mass"
GEARS = "name,ratio,lead,efficiency,peak_torque,average_torque,max_input_speed,inertia,mass"
GOOD = "a,1e-5,1,3,300,2"
PUMA = str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv")


def motors(folder, *lines, header=MOTORS):
    (folder / "motors.csv").write_text("\n".join([header, *lines]) + "\n")
    return read_rows(str(folder / "motors.csv"), CatalogueMotor)


def gears(folder, *lines, header=GEARS):
    (folder / "gears.csv").write_text("\n".join([header, *lines]) + "\n")
    return read_rows(str(folder / "gears.csv"), CatalogueGear)


FAULTY_MOTORS = {
    "b,1e-5,4,3,300,2": ("continuous_torque", "allows 4 at 0 rad/s, and peak_torque 3"),
    "b,1e-5,0:1 300:1,0:3 200:0.5 300:0.2,300,2": ("continuous_torque", "allows 1 at 200 rad/s, and peak_torque 0.5"),
    "b,1e-5,0:1 300:1,0:3 150:0.5 300:3,300,2": ("continuous_torque", "allows 1 at 150 rad/s, and peak_torque 0.5"),
    "b,1e-5,1,3,300,-2": ("mass", "is -2 (it is 0 or between 1e-15 and 1e+15)"),
    "b,-1e-5,1,3,300,2": ("inertia", "is -1e-5"),
    "b,1e-5,1,0,300,2": ("peak_torque", "is 0 (it is between 1e-15 and 1e+15)"),
    "b,1e-5,1,nan,300,2": ("peak_torque", "'nan' is not a number"),
    "b,1e-5,1,1e400,300,2": ("peak_torque", "is 1e400"),
    "b,1e-5,1,3,1e-300,2": ("max_speed", "is 1e-300"),
    "b,1e-5,1,3 N m,300,2": ("peak_torque", "'3 N m' is not a number"),
    "b,1_0,1,3,300,2": ("inertia", "'1_0' is not a number"),
    'b,1e-5,1,"3,5",300,2': ("peak_torque", "'3,5' is not a number (write it as 1.5e-3, decimals with a point)"),
    "b,1e-5,1,,300,2": ("peak_torque", "is empty (write it, or - if it is not known, which then is not judged)"),
    "b,-,1,3,300,2": ("inertia", "is not known (write it)"),
    "b,1e-5,1,3,3000,2": ("max_speed", "is 3000 in rad/s (if it is, name the unit in the header too)"),
    "b,50,1,3,300,2": ("inertia", "is 50 in kg m^2 (if it is, name"),
    "b,1e-5,1,3,-,2": ("max_speed", "is not known (write it, or peak_torque as a curve that ends there)"),
    "b,1e-5,1,0:3 200:2,300,2": ("peak_torque", "the curve ends at 200 rad/s, max_speed is 300 rad/s"),
    "b,1e-5,1,0:3 3000:2,300,2": (
        "peak_torque",
        "the curve ends at 3000 rad/s, max_speed is 300 rad/s (write it to",
    ),
    "b,1e-5,1,0:3 0:2,300,2": ("peak_torque", "'0:3 0:2' is no curve"),
    "b,1e-5,1,0:3:4,300,2": ("peak_torque", "'0:3:4' is no curve (points speed:torque"),
    "b,1e-5,1,0:0 300:0,300,2": ("peak_torque", "'0:0 300:0' is no curve"),
    "b,1e-5,1,0:-3 300:1,300,2": ("peak_torque", "is -3"),
    "a,1e-5,1,3,300,2": ("name", "'a' is in line 2 too"),
    ",1e-5,1,3,300,2": ("name", "is empty"),
}
FAULTY_GEARS = {
    "b,50,-,85,10,5,600,0,1": ("efficiency", "is 85 (a share above 0 and up to 1, or efficiency [%])"),
    "b,50,-,0.8,10,50,600,0,1": ("average_torque", "is 50, and peak_torque 10 (are they swapped?)"),
    "b,50,0.01,0.8,10,5,600,0,1": ("ratio", "and lead are both given"),
    "b,-,-,0.8,10,5,600,0,1": ("ratio", "and lead are both empty"),
    "b,50 0,-,0.8,10,5,600,0,1": ("ratio", "is 0"),
    "b,1e-300,-,0.8,10,5,600,0,1": ("ratio", "is 1e-300"),
    "b,50 x,-,0.8,10,5,600,0,1": ("ratio", "'x' is not a number"),
}


@pytest.mark.parametrize("line", FAULTY_MOTORS)
def test_faulty_motors(line, tmp_path):
    with pytest.raises(CatalogueError) as error:
        motors(tmp_path, GOOD, "", "# c", line)
    column, what = FAULTY_MOTORS[line]
    assert str(error.value).startswith(f"{tmp_path}/motors.csv:5: column '{column}': {what}"), error.value
    assert len(error.value.faults) == 1


@pytest.mark.parametrize("line", FAULTY_GEARS)
def test_faulty_gears(line, tmp_path):
    with pytest.raises(CatalogueError) as error:
        gears(tmp_path, "a,50,-,0.8,10,5,600,0,1", line)
    column, what = FAULTY_GEARS[line]
    assert str(error.value).startswith(f"{tmp_path}/gears.csv:3: column '{column}': {what}"), error.value


HEADERS = {
    "name,inertia,continuous_torque,peak_torque,max_speed": "no column 'mass' (add it; robodyn size --init writes",
    f"{MOTORS},massy": "unknown column 'massy' (did you mean 'mass'?)",
    f"{MOTORS},mass": "column 'mass' stands twice",
    MOTORS.replace(
        "inertia", "inertia [lb ft^2]"
    ): "column 'inertia': unknown unit 'lb ft^2' (units: 'kg m^2', 'kg cm^2'",
    MOTORS.replace("peak_torque", "peak_torque [rpm:lb]"): "column 'peak_torque': unknown unit 'rpm:lb' (units: 'N m'",
    MOTORS.replace("mass", "mass [rpm:kg]"): "column 'mass': unknown unit 'rpm:kg'",
}


@pytest.mark.parametrize("header", HEADERS)
def test_faulty_headers(header, tmp_path):
    with pytest.raises(CatalogueError) as error:
        motors(tmp_path, ",".join("1" * (header.count(",") + 1)), header=header)
    assert f"motors.csv:1: {HEADERS[header]}" in str(error.value.faults[0])


def test_every_row_at_fault_is_told(tmp_path):
    (tmp_path / "m.csv").write_text(f"{MOTORS}\na,1e-5,1,3,300\nb,x,1,3,300,y\n" + 'c,"1,1,1,3,2\n')
    outcome = run("size", *PUMA, "--catalog", str(tmp_path / "m.csv"))
    assert (outcome.status, outcome.out) == (2, "")
    lines = [line.partition(f"error: {tmp_path}/")[2] for line in outcome.err.splitlines()]
    assert [line[:40] for line in lines] == [
        "m.csv:2: 5 cells where the header names ",
        "m.csv:3: column 'inertia': 'x' is not a ",
        "m.csv:4: cannot be read: unexpected end ",
    ]
    assert all(line.endswith(")") for line in lines)  # with a remedy


def test_units(tmp_path):
    header = (
        "name;inertia [g cm^2];continuous_torque [mN m];peak_torque [rpm:mN m];max_speed [rpm];mass [g];price [EUR]"
    )
    (motor,), notes = motors(tmp_path, "M;12;80;0:250 6000:120;6000;160;95", header=header)
    assert motor.inertia == pytest.approx(1.2e-6)
    assert motor.continuous_torque == pytest.approx(0.08)
    assert np.allclose(motor.peak_torque, ((0.0, 0.25), (200 * np.pi, 0.12)))
    assert (motor.max_speed, motor.mass, motor.price) == pytest.approx((200 * np.pi, 0.16, 95.0))
    assert notes == []
    (gear,), _ = gears(
        tmp_path,
        "s,-,10,90,10,5,3000,0.1,1",
        header=GEARS.replace("lead", "lead [mm]")
        .replace("efficiency", "efficiency [%]")
        .replace("input_speed", "input_speed [rpm]"),
    )
    assert gear.ratios == pytest.approx((200 * np.pi,))
    assert (gear.efficiency, gear.max_input_speed) == pytest.approx((0.9, 100 * np.pi))


def test_what_is_not_judged_is_told(tmp_path):
    _, notes = motors(tmp_path, "a,1e-5,1,3,300,2", "b,1e-5,-,3,300,2", "c,1e-5,-,3,300,2")
    assert notes == [f"{tmp_path}/motors.csv: not known, and not judged: continuous_torque of 'b', 'c'"]
    assert motors(tmp_path, "a,1e-5,1,3,3000,2", header=MOTORS.replace("max_speed", "max_speed [rad/s]"))[1] == []


def test_a_curve_may_end_where_rounding_puts_it(tmp_path):
    header = MOTORS.replace("peak_torque", "peak_torque [rpm:N m]")
    (motor,), _ = motors(tmp_path, "a,1e-5,1,0:3 6000:2,629,2", header=header)
    assert motor.peak_torque[-1][0] < motor.max_speed == 629


@pytest.mark.parametrize(
    "data", [b"", b"\n# only a comment\n", b"\xff\xfea\x00", b"\0\0", MOTORS.encode(), b"name\n\xe9\n"]
)
def test_no_table(data, tmp_path):
    (tmp_path / "motors.csv").write_bytes(data)
    with pytest.raises(InputError):
        read_rows(str(tmp_path / "motors.csv"), CatalogueMotor)


def test_large_catalogues_are_refused(tmp_path, monkeypatch):
    (tmp_path / "motors.csv").write_text(MOTORS_TEMPLATE)
    monkeypatch.setenv("ROBODYN_LIMITS", "catalogue_bytes=100")
    with pytest.raises(InputError, match="too many bytes, at most 100 are read"):
        read_rows(str(tmp_path / "motors.csv"), CatalogueMotor)
    monkeypatch.setenv("ROBODYN_LIMITS", "catalogue_pairs=100")
    files = "--catalog", str(ROBOTS / "catalogue" / "motors.csv"), "--gears", str(ROBOTS / "catalogue" / "gears.csv")
    assert "motors with gears in a ratio, at most 100 are read" in run("size", *PUMA, *files).err


def test_faults_beyond_a_hundred_are_not_read(tmp_path):
    with pytest.raises(CatalogueError, match="and 99 more faults"):
        gears(tmp_path, *["a"] * 1_000_000)


@pytest.mark.parametrize("seed", range(4))
def test_changed_bytes_are_faults_or_rows(seed, tmp_path):
    """Whatever is changed, it is told or read; no row is lost."""
    rng, path = random.Random(seed), tmp_path / "table.csv"
    for _ in range(100):
        text, kind = rng.choice([(MOTORS_TEMPLATE, CatalogueMotor), (GEARS_TEMPLATE, CatalogueGear)])
        data = bytearray(text.encode())
        for _ in range(rng.randrange(1, 4)):
            at = rng.randrange(text.index("\nname"), len(data))
            data[at : at + rng.randrange(3)] = bytes(
                rng.choice(b'0123,.-:"\n [];eE%\0\xffnif_#') for _ in range(rng.randrange(3))
            )
        path.write_bytes(bytes(data))
        try:
            found, faults = read_rows(str(path), kind)[0], ()
        except CatalogueError as error:
            found, faults = (), error.faults
        assert all(fault.file == str(path) and fault.remedy for fault in faults)
        lines = data.decode(errors="replace").split("\n")
        rows = sum(bool(line.strip()) and line.lstrip()[:1] != "#" for line in lines) - 1
        assert faults or len(found) == rows


def test_templates_run_and_are_part_of_those_of_robots(tmp_path):
    files = str(tmp_path / "m.csv"), str(tmp_path / "g.csv")
    for robot, motion in (PUMA, (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))):
        assert "Every joint has a motor that suffices" in shown(
            "size", robot, motion, "--catalog", files[0], "--gears", files[1], *(["--init"] if robot == PUMA[0] else [])
        )
    for path, name in zip(files, ("motors.csv", "gears.csv"), strict=True):
        with open(path, encoding="utf-8") as stream:
            assert set(stream) <= set((ROBOTS / "catalogue" / name).read_text().splitlines(keepends=True))
    again = run("size", *PUMA, "--catalog", files[0], "--init")
    assert again.status == 2
    assert "--init writes a new file, and this one is there already" in again.err


def test_nothing_suffices(tmp_path):
    (tmp_path / "motors.csv").write_text(f"{MOTORS}\nsmall,1e-6,0.001,0.002,300,0.1\n")
    outcome = run("size", *PUMA, "--catalog", str(tmp_path / "motors.csv"), "--scene-out", str(tmp_path / "none.toml"))
    assert outcome.status == 1
    assert "Nothing in the catalogue suffices for waist, shoulder, elbow" in outcome.out
    assert "small, ratio 1" in outcome.out
    scara = str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv")
    outcome = run("size", *scara, "--catalog", str(tmp_path / "motors.csv"))
    assert "quill: the catalogue has no motor and gear that fit this joint" in outcome.out


def test_json(tmp_path):
    files = "--catalog", str(ROBOTS / "catalogue" / "motors.csv"), "--gears", str(ROBOTS / "catalogue" / "gears.csv")
    found = document("size", *PUMA, *files, "--by", "price", "--joints", "waist,elbow")
    assert [joint["name"] for joint in found["joints"]] == ["waist", "elbow"]
    for joint in found["joints"]:
        assert joint["best"] == joint["choices"][0]
        assert sum(each["feasible"] for each in joint["choices"]) == joint["feasible"]
        assert sum(joint["ruled_out"].values()) + joint["feasible"] == len(joint["choices"])
    assert found["price"] == sum(joint["best"]["price"] for joint in found["joints"])
