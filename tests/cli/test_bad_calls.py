"""Wrong calls of every command: one line with what was meant or what to do, exit status 2, nothing written."""

from __future__ import annotations

import re
import shlex
import shutil
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import click
import pytest
from helpers.command_line import ROBOTS, Outcome, refused, run, shown, write_arm

from robodyn.checks.catalogue import CODES
from robodyn.cli.main import COMMANDS
from robodyn.cli.torques import command as torques
from robodyn.errors import SceneError
from robodyn.loads import torques as loads
from robodyn.scene.read import parse_scene
from robodyn.support.wording import alternatives

ARM = ("torques", "arm.urdf", "arm.csv")
SCENES = {
    "scene.toml": "gravity = [0, 0, -1.6]\n",
    "tilt.toml": "[drive]\nwaist = { torque = 5 }\n",
    "loop.toml": '[[loop]]\nname = "pin"\nlink = "no"\n',
    "bad.toml": "q_elbow = ",
    "odd.toml": "q_elbow = 3",
}
TABLES = {
    "[base]\nmotion = 'fixed'\n": "[base]",
    "[friction.elbow]\nviscous = 1\n": "[friction] elbow",
    "[initial]\nq = { elbow = 1 }\n": "[initial]",
    "[[payload]]\nlink = 'fore'\nmass = 1\n": "[[payload]] number 1",
}
NAMES = ("base_link", "arm_1_link", "arm_2_link", "wrist_ft_link", "wrist_ft_tool_link", "Torso")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    Path("robots").symlink_to(ROBOTS)
    shutil.copy(ROBOTS / "meshes" / "bracket.stl", "part.stl")
    shutil.copy("arm.csv", "more.csv")
    for name, text in SCENES.items():
        Path(name).write_text(text)


SWAPPED = "arm.csv: this is a table, and a robot description is expected here (is it swapped with arm.urdf? the order: "
ORDER = "robodyn torques URDF TRAJECTORY...)"
POINT = "invalid value for '--about': '{}' is neither com nor origin nor X,Y,Z in m, such as 0,0,0.1"
LAST_RD2 = max(code for code in CODES if code.startswith("RD2"))
RULES = "(give codes such as RD207, or their beginnings such as RD2; robodyn rule WORD finds them)"
HIDES = "a module of this name hides"
TREES = "the scene closes loops, and this knows only the open tree (robodyn torques, fbd, simulate and linearize"
KINDS = "give one mesh, a URDF and a trajectory, or a URDF and a scene"
PAYLOAD = "is not LINK=KG or LINK=KG@X,Y,Z, such as tool0=2.5@0,0"
PUMP = "robots/crank_slider.urdf --scene robots/crank_slider_pump.toml"
SERVO = "robots/puma.urdf --scene robots/puma_polish.toml"
PLANAR = "robots/two_link_planar.urdf robots/two_link_planar_swing_down.toml"

CALLS: dict[str, str] = {
    # commands and options
    "torqes": "there is no command 'torqes'; did you mean 'torques'? (try: robodyn --help)",
    "zebra": "there is no command 'zebra'; commands: 'torques', 'retime', 'envelope', 'size', 'simulate', 'inertia', "
    "'check', 'fbd', ... (23 in all) (try: robodyn --help)",
    "--verson": "no such option '--verson'; did you mean '--version'? (try: robodyn --help)",
    "torques": "missing argument 'URDF' (try: robodyn torques --help)",
    "torques arm.urdf arm.csv --gravty 0,0,0": "no such option '--gravty'; did you mean '--gravity'? (try: robodyn tor",
    "torques arm.urdf arm.csv --gravity": "option '--gravity' requires an argument",
    "torques arm.urdf arm.csv --format xml": "invalid value for '--format': 'xml' is not one of 'text', 'json'",
    "torques arm.urdf arm.csv --derivatives magic": "invalid value for '--derivatives': 'magic' is not one of 'auto', "
    "'anew', 'given', ",
    "torques arm.urdf arm.csv --reactions": "--reactions goes to a file, and --out names none (try: robodyn torques ",
    "accuracy": "missing argument 'MESH|URDF TRAJECTORY|URDF SCENE.toml' (try: robodyn accuracy --help)",
    "scene int arm.urdf": "no such command 'int'. Did you mean 'init'? (try: robodyn scene --help)",
    "export arm.urdf": "missing option '--to'",
    "export arm.urdf --to rust": "invalid value for '--to': 'rust' is not one of 'c', 'numpy', 'jax', 'torch', 'ca",
    # outputs
    "torques arm.urdf arm.csv --out tau.xlsx": "tau.xlsx: unknown type of table by this suffix (name it .csv, .parquet "
    "or .npz)",
    "torques arm.urdf arm.csv --out ''": "'': unknown type of table by this suffix",
    "torques arm.urdf arm.csv --out arm.csv": "arm.csv: the output would overwrite an input (give --out another name)",
    "torques arm.urdf arm.csv --out 'nul\0.csv'": "nul\\x00.csv: cannot be written: the name has a null character",
    "torques arm.urdf arm.csv --report r.pdf": "r.pdf: unknown type of report by this suffix (name it .html or .md)",
    "torques arm.urdf arm.csv --report no/r.html": "no/r.html: cannot be written: there is no such folder",
    "linearize arm.urdf --out linear.csv": "linear.csv: is no .npz file (--out FILE.npz)",
    "export arm.urdf --to c --out no/f.c": "no/f.c: cannot be written: no such file or directory (name another file)",
    "export arm.urdf --to c --out .": ".: cannot be written: is a directory (name another file)",
    "export arm.urdf --to torch --out torch.py": f"torch.py: {HIDES} torch, which it or what ",
    "export arm.urdf --to jax --out NumPy.py": f"NumPy.py: {HIDES} numpy, which it or what ",
    "export arm.urdf --to casadi --out platform.py": f"platform.py: {HIDES} platform, which ",
    # files of another kind, or none
    "torques arm.csv arm.urdf": SWAPPED + ORDER,
    "torques arm.urdf arm.urdf": "arm.urdf: this is a robot description, and a table is expected here (the order: ",
    "torques arm.urdf scene.toml": "scene.toml: this is a scene, and a table is expected here (the order: ",
    "torques part.stl arm.csv": "part.stl: this is a mesh, and a robot description is expected here (the order: ",
    "torques arm.urdf arm.csv --scene arm.urdf": "arm.urdf: this is a robot description, and a scene is expected here "
    "(robodyn scene init URDF writes one)",
    "simulate arm.urdf scene.toml": "got unexpected extra argument (scene.toml); did you mean --scene scene.toml? (",
    "fbd arm.urdf arm.csv": "got unexpected extra argument (arm.csv); did you mean --traj arm.csv? (try: ",
    "info arm.urdf scene.toml": "got unexpected extra argument (scene.toml) (try: robodyn info --help)",
    "torques arm.urdf arm.csv --scene no.toml": "no.toml: cannot be read: no such file or directory (check the name)",
    "info no.urdf": "no.urdf: there is no such file (check the name)",
    "info .": ".: this is a folder, not a file (give a URDF file)",
    "accuracy arm.urdf no.csv": "no.csv: cannot be read",
    "check - -": "<stdin>: standard input is asked for twice",
    "torques arm.urdf - --measured": "<stdin>: a log is read several times, and standard input only once (name a file)",
    "identify arm.urdf -": "<stdin>: a log is read several times, and standard input only once (name a file)",
    "torques arm.urdf - --accuracy 1e-9": "<stdin>: --accuracy reads the trajectory twice (name a file)",
    "accuracy arm.urdf": KINDS,
    f"accuracy robots/crank_slider.urdf arm.csv {PUMP.partition(' ')[2]}": f"robots/crank_slider_pump.toml: {TREES}",
    f"export {PUMP} --to c": f"robots/crank_slider_pump.toml: {TREES}",
    f"excite {PUMP}": f"robots/crank_slider_pump.toml: {TREES[:22]}",
    # vectors, numbers, points, links, joints
    **{
        f"torques arm.urdf arm.csv --gravity {shlex.quote(vector)}": "invalid value for '--gravity': "
        f"{vector!r} is not three finite numbers"
        for vector in ("1,2", "nan,0,0", "1e400,0,0", "", "1_0,0,0", "0 0 9")
    },
    "torques arm.urdf arm.csv --gravity 0,0,1e308": "arm.csv: row 1: base_fx overflows",
    "inertia part.stl --about tool0": POINT.format("tool0") + "; --frame takes the name of a link; --link takes",
    "torques arm.urdf arm.csv --momentum --about fore": POINT.format("fore") + "; --frame takes the name of a link (",
    "torques arm.urdf arm.csv --momentum --frame bse": "arm.urdf: no frame 'bse' (did you mean 'base'?)",
    "inertia part.stl --rpy 1,2": "invalid value for '--rpy': '1,2' is not three finite numbers between commas, such "
    "as 0,0,1.57",
    "inertia part.stl --combine --place 0,0": "invalid value for '--place': '0,0' is not three or six finite numbers",
    "inertia part.stl --mass heavy": "invalid value for '--mass': 'heavy' is no number (try: ",
    "inertia part.stl --mass nan": "a mass of nan kg is not positive and finite",
    "inertia part.stl --density 0": "a density of 0 kg/m^3 is not positive and finite",
    "inertia part.stl --shell inf": "a thickness of inf m is not positive and finite",
    "inertia part.stl --density 1 --mass 2": "both a density and a mass are given (give one of them)",
    "accuracy part.stl --target nan": "invalid value for '--target': nan is no positive finite number",
    "envelope arm.urdf --payload tool@1,2": "invalid value for '--payload': 'tool@1,2' is not LINK or LINK@X,Y,Z",
    "envelope arm.urdf --box elbow=1..x": "invalid value for '--box': 'elbow=1..x' is no range, such as",
    "envelope arm.urdf --box elbow=1,elbow=2": "invalid value for '--box': 'elbow=1,elbow=2' names 'elbow' twice",
    "envelope arm.urdf --payload a --payload b": "--payload looks for one mass; give the others as LINK=KG",
    "linearize arm.urdf --step 0": "invalid value for '--step': 0 is no positive finite number (try: robodyn linearize",
    "retime arm.urdf arm.csv --speed fast": "invalid value for '--speed': 'fast' is no share, such as 80% or 0.8",
    "retime arm.urdf arm.csv --speed 0%": "speed is 0 % (more than 0 %, at most 100 % of the velocity limits)",
    "retime arm.urdf arm.csv --grid 5": "a grid of 5 intervals (10 to 50000)",
    "retime arm.urdf arm.csv --acceleration elbo=1": "arm.urdf: no joint 'elbo' to set (did you mean 'elbow'?)",
    "retime arm.urdf arm.csv --jerk 1 --profile trapezoid": "a trapezoid has no limit of jerk (--profile scurve)",
    f"retime robots/crank_slider.urdf arm.csv {PUMP.partition(' ')[2]}": f"robots/crank_slider_pump.toml: {TREES[:22]}",
    "excite arm.urdf --seed -1": "invalid value for '--seed': -1 is less than 0",
    "excite arm.urdf --noise 0": "noise is 0 (it is positive [N m, N])",
    "excite arm.urdf --harmonics 1": "1 harmonics: one cannot begin and end at rest",
    "excite arm.urdf --joints elbo": "there is no joint 'elbo' to move (did you mean 'elbow'?)",
    "excite arm.urdf --joints elbow,": "invalid value for '--joints': 'elbow,' is not names between commas",
    "excite robots/satellite.urdf --scene robots/satellite.toml": 'robots/satellite.urdf: "base" floats: nothing ',
    "fbd arm.urdf --at elbow=1,elbow=2": "invalid value for '--at': 'elbow=1,elbow=2' names 'elbow' twice",
    "fbd arm.urdf --at ELBOW=1": "arm.urdf: no joint 'ELBOW' to set (did you mean 'elbow'?)",
    "fbd arm.urdf --qd 1": "arm.urdf: 1 value for 2 coordinates (in the order: 'shoulder', 'elbow')",
    "equations arm.urdf --at '1;2'": "invalid value for '--at': '1;2' is neither numbers",
    "linearize arm.urdf --at 1,1e400": "invalid value for '--at'",
    "inertia robots/meshed_arm.urdf --at right_finger_slide=1": "robots/meshed_arm.urdf: no joint 'right_finger_slide' "
    "to set (it follows 'finger_slide')",
    "inertia arm.urdf --link Fore": "arm.urdf: there is no link 'Fore' (did you mean 'fore'?)",
    "torques arm.urdf arm.csv --payload for=1": "--payload: the robot has no link 'for' (did you mean 'fore'?)",
    **{
        f"torques arm.urdf arm.csv --payload {value}": f"invalid value for '--payload': '{value}' {PAYLOAD}"
        for value in ("fore", "=1", "fore=0", "fore=nan", "fore=1@0,0")
    },
    # columns and joints of tables
    "torques arm.urdf arm.csv --map q_elbow": "invalid value for '--map': 'q_elbow' is not OURS=THEIRS, nor a file: ",
    "torques arm.urdf arm.csv --map =a": "invalid value for '--map': '=a' is not OURS=THEIRS, such as q_elbow='El",
    "torques arm.urdf arm.csv --map bad.toml": "invalid value for '--map': bad.toml: is not TOML",
    "torques arm.urdf arm.csv --map odd.toml": "invalid value for '--map': odd.toml: 'q_elbow' is 3, not a name",
    "torques arm.urdf arm.csv --map q_elbw=q_elbow": "arm.csv:1: a column is called 'q_elbw', which the robot does ",
    "torques arm.urdf arm.csv --hold lying": "'lying' is no place to hold a joint",
    "torques arm.urdf arm.csv --hold rest,elbo=1": "arm.csv:1: no joint 'elbo' to hold (did you mean 'elbow'?)",
    "torques arm.urdf arm.csv --time-unit h": "invalid value for '--time-unit': 'h' is not one of 's', 'ms', 'us', ",
    # options that do not go together
    "inertia arm.urdf --unit mm": "--unit is not for a whole robot, but for meshes (try: robodyn inertia --help)",
    "inertia arm.urdf --density 1": "--density is not for a whole robot, but for meshes or a URDF with --link NAME "
    "--geometry visual (try: ",
    "inertia arm.urdf --link fore --at 1": "--at is not for a link as declared",
    "inertia robots/meshed_arm.urdf --link hand --geometry visual --shell 1": "--shell is not for a link's shapes",
    "inertia arm.urdf --compare --link fore": "--link is not for --compare",
    "inertia arm.urdf --compare --format urdf": "--format urdf is not for --compare; --link NAME --geometry",
    "inertia arm.urdf part.stl": "a URDF stands alone: one robot at a time, and no meshes beside it",
    "inertia part.stl --at 1": "--at is not for meshes one by one, but for a URDF (try: ",
    "inertia part.stl --place 0,0,0": "--place is not for meshes one by one, but for meshes with --combine (try: ",
    "inertia part.stl --density 1 --density 2": "--density is given 2 times for 1 mesh (give it once, or once for",
    "inertia part.stl part.stl --combine --place 0,0,0": "1 places for 2 meshes (give one for each mesh, in order)",
    "accuracy part.stl --gravity 0,0,1": "--scene, --payload, --gravity, --package-path, --xacro-arg and --trust-xacro "
    "are for robots",
    "accuracy part.stl --map a=b": "--map is for the trajectory of a robot",
    f"accuracy {PLANAR} --scene robots/two_link_planar_swing_down.toml": "the scene is given twice",
    "accuracy arm.urdf arm.csv --duration 1": "--duration and --traj are for a URDF and a scene",
    "torques arm.urdf arm.csv --about com": "--about goes with --momentum (try: robodyn torques --help)",
    "torques arm.urdf arm.csv --measured --sizing": "--sizing does not go with --measured",
    "torques arm.urdf arm.csv more.csv --measured": "--measured compares one log",
    "torques arm.urdf arm.csv --cutoff 5": "--cutoff goes with --measured",
    "simulate arm.urdf --time-unit ms": "--time-unit goes with --traj",
    "simulate arm.urdf --traj arm.csv": "no scene says what the columns of arm.csv drive (give --scene FILE.toml, with "
    'e.g. drive.elbow = { kp = 100, kd = 10, reference = "q_elbow" })',
    "fbd arm.urdf --at 0,0 --hold rest": "--hold goes with --traj",
    "fbd arm.urdf --traj x.csv": "--traj needs --time (try: robodyn fbd --help)",
    "fbd arm.urdf --traj x.csv --time 1 --at 1,2": "--traj says all of the state: leave out --at, ",
    "fbd arm.urdf --traj arm.csv --time 99": "arm.csv: time 99 s is outside the motion (it lasts from 0 s to ",
    f"fbd {SERVO}": "the scene needs columns of a trajectory: give --traj and --time (try: robodyn fbd --help)",
    "equations arm.urdf --format latex": "--format latex is for --form closed or dae (try: robodyn equations --help)",
    "equations arm.urdf --form closed --at 1,2": "--at is for numbers: --form ode or dae as text or json (try",
    "equations arm.urdf --format c": "invalid value for '--format': 'c' is not one of 'text', 'latex', 'json', 'python'"
    "; robodyn export --to c writes C (try: robodyn equations --help)",
    "equations arm.urdf --tau 1,2": "--tau is for --form dae (try",
    "equations robots/composite.urdf": "robots/composite.urdf: nothing can move: the robot has no joint that moves",
    "equations arm.urdf --format python": "--format python is for --form closed (try",
    "equations arm.urdf --form dae --symbols": "--symbols is for --form closed (try",
    "equations arm.urdf --assume 'l_1>0'": "--assume is for --symbols (try",
    "equations robots/scara.urdf --symbols m,x": "no symbols 'x' (symbols: 'm', 'l', 'c', 'I', 'g')",
    "equations robots/scara.urdf --symbols --assume 'l_1<0'": "no assumption 'l_1<0' (as in --assume 'l_1>0')",
    "equations robots/scara.urdf --symbols --assume 'l_7>0'": "no symbol 'l_7' (",
    "equations robots/puma.urdf --symbols --assume 'c_2y>0'": "c_2y is -0.016, not positive (leave the assumption out)",
    f"equations {SERVO}": "the scene's wrenches name columns of a trajectory: ",
    "linearize arm.urdf --qd 1,2 --equilibrium": "an equilibrium is at rest (leave out the speeds, or do not look for",
    "linearize robots/puma.urdf --scene tilt.toml --equilibrium": "there is no equilibrium: 5 N m at waist stay "
    "unbalanced at every ",
    "linearize robots/puma.urdf --scene loop.toml": "loop.toml: [[loop]] 'pin': the robot has no link 'no' (links: ",
    "export arm.urdf --to c --what torqes": "there is no function 'torqes' to export (did you mean 'torques'?)",
    # many trajectories
    "torques arm.urdf arm.csv more.csv": "many trajectories need --out FOLDER for their results (try: robodyn torques ",
    "torques arm.urdf arm.csv more.csv --out arm.urdf": "arm.urdf: is a file, many trajectories need a folder (give --",
    "torques arm.urdf arm.csv more.csv --out r --report r.html": "--report is of one trajectory",
    "torques arm.urdf *.txt --out r": "*.txt: no file fits this pattern",
    "torques - arm.csv more.csv --out r": "<stdin>: standard input serves one trajectory (name files",
    "torques arm.urdf arm.xlsx": "arm.xlsx: unknown type of table by this suffix (suffixes: .csv",
    "torques arm.urdf arm.csv arm.urdf --out r": "arm.urdf: unknown type of table by this suffix (suffixes: .csv",
    "torques arm.urdf arm.csv --jobs 2": "--jobs goes with many trajectories: give several, or --out FOLDER/ (try: ",
    "torques arm.urdf arm.csv more.csv --out r --jobs 0": "invalid value for '--jobs': 0 is less than 1",
    "torques arm.urdf arm.csv more.csv --out r --momentum --frame hnad": "arm.urdf: no frame 'hnad'",
    # rules and settings of check
    "check arm.urdf --select RD2xx": f"there is no rule 'RD2XX' (RD2 means RD201 to {LAST_RD2})",
    "check arm.urdf --select inertia": f"there is no rule 'inertia' {RULES}",
    "check arm.urdf --ignore mesh-missing": "there is no rule 'mesh-missing' ('mesh-missing' is RD601)",
    "check arm.urdf --select R207": "there is no rule 'R207' (did you mean 'RD207'?)",
    "rule RD2xx": f"no rule has the code or the word 'RD2xx' (RD2 means RD201 to {LAST_RD2})",
    "rule zebra": f"no rule has the code or the word 'zebra' {RULES}",
    "check arm.urdf --write-baseline": "--write-baseline needs --baseline FILE (try: robodyn check --help)",
    "check arm.urdf --baseline no.json": "no.json: there is no such baseline (write it with",
    "check arm.urdf --baseline arm.urdf": "arm.urdf: this is no baseline (write it anew with",
    "check arm.urdf --unsafe-fixes": "--unsafe-fixes needs --fix or --diff (try: robodyn check --help)",
    "check - --fix": "--fix cannot edit standard input; --diff shows the edit (try: robodyn check --help)",
    "check arm.urdf --statistics --format json": "--statistics is text; leave --format out (try: ",
    "check arm.urdf --config arm.urdf": "arm.urdf:1: is not TOML: ",
}


@pytest.mark.parametrize("call", CALLS)
def test_call(call: str) -> None:
    before = sorted(Path().iterdir())
    refused(run(*shlex.split(call)), CALLS[call])
    assert sorted(Path().iterdir()) == before


def test_a_fault_of_the_program_is_one_line_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("two\nlines \x1b[31m")

    monkeypatch.setattr(loads, "torques", broken)
    outcome = run(*ARM)
    refused(outcome, "internal error at test_bad_calls.py:")
    assert "RuntimeError: two lines \\x1b[31m (please report this line" in outcome.err


@pytest.mark.parametrize("stop", [KeyboardInterrupt, click.Abort, MemoryError])
def test_interrupted_or_out_of_memory(stop: type[BaseException], monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise stop

    before = sorted(Path().iterdir())
    monkeypatch.setattr(loads, "torques", stopped)
    outcome = run(*ARM, "--out", "tau.csv")
    if stop is MemoryError:
        refused(outcome, "out of memory")
    else:
        assert (outcome.status, outcome.out, outcome.err.strip()) == (130, "", "")
    assert sorted(Path().iterdir()) == before


@pytest.mark.parametrize(
    ("call", "start"),
    [
        ("--help", "Usage: robodyn [OPTIONS]"),
        ("", "Usage: robodyn [OPTIONS]"),
        ("torques -h", "Usage: robodyn torques [OPTIONS] URDF TRAJECTORY..."),
    ],
)
def test_help_has_an_example(call: str, start: str) -> None:
    text = shown(*call.split())
    assert text.startswith(start)
    assert "\n    robodyn torques robots/scara.urdf robots/scara_pick_and_place.csv --out tau.csv\n" in text


def test_every_option_says_what_it_is_for() -> None:
    commands = {name: import_module(f"robodyn.cli.{name}").command for name in COMMANDS}
    options = [(name, each) for name, command in commands.items() for each in command.params]
    assert [(name, each.name) for name, each in options if isinstance(each, click.Option) and not each.help] == []


def test_version() -> None:
    assert run("--version") == Outcome(0, f"robodyn {version('robodyn')}\n", "")


@pytest.mark.parametrize("table", TABLES)
def test_a_key_of_the_scene_below_a_table_says_where_it_belongs(table: str) -> None:
    parse_scene(f"slip_speed = 1\n{table}".encode())
    with pytest.raises(SceneError) as error:
        parse_scene(f"{table}slip_speed = 1".encode())
    what = '"slip_speed" is a key of the whole scene, and below the header of a table it belongs to that table'
    assert error.value.what == f"{TABLES[table]}: {what}"
    assert error.value.remedy == "write slip_speed = ... above the first [table]"


def test_rules_are_found_by_words_of_their_titles_first() -> None:
    listed = run("rule", "parallel axis").out.splitlines()
    assert [line.split()[0] for line in listed] == ["RD308", "RD307"]
    assert {line.split()[0] for line in run("rule", "RD9").out.splitlines()} == {"RD901", "RD902"}
    assert "RD207" in run("rule", "inertia").out
    both = run("rule", "RD207", "mirror")
    assert both.out.startswith("RD207 ")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("torso", "did you mean 'Torso'?"),
        ("ARM_1_LINK", "did you mean 'arm_1_link'?"),
        ("arm_1_lnk", "did you mean 'arm_1_link'?"),
        ("wrist", "did you mean 'wrist_ft_link' or 'wrist_ft_tool_link'?"),
        ("baes", "did you mean 'base_link'?"),
        ("my_torso_joint_1", "did you mean 'Torso'?"),
        ("link", "links like it: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link'"),
        ("zz", "links: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link', 'Torso'"),
        ("", "links: 'base_link', "),
    ],
)
def test_names_that_are_near(name: str, expected: str) -> None:
    assert alternatives(name, NAMES, "links").startswith(expected)


def test_help_of_torques_is_in_groups() -> None:
    text = run("torques", "--help").out
    titles = re.findall(r"^(\S.*):$", text, re.MULTILINE)
    assert titles[:2] == ["The robot and what surrounds it", "The trajectory"]
    assert len(titles) == 8
    assert titles[-1] == "Other options"
    assert text.partition("Other options:\n")[2].strip().startswith("-h, --help")
    for option in (name for each in torques.params for name in each.opts if name.startswith("--")):
        assert len(re.findall(rf"^  {option}\b", text, re.MULTILINE)) == 1
