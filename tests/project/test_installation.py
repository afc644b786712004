"""A checkout is installed as its users and its developers install it; `.ci/run` runs what the README says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
from importlib import import_module
from pathlib import Path
from shutil import copytree, ignore_patterns

import pytest

ROOT = Path(__file__).parents[2]
LIBRARIES = "numpy", "click", "yourdfpy", "platformdirs"
CALLS = ["bin/python", "-m", "robodyn"], ["bin/robodyn"]
NOT_INSTALLED = """
import sys
sys.meta_path = [finder for finder in sys.meta_path if "editable" not in repr(finder)]
sys.path[:] = ["", *(place for place in sys.path if place)]
"""
"""Modules are looked for in the current folder, as `python -m` does, and in no checkout that is installed."""
RUN = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def called(*call: str | Path) -> subprocess.CompletedProcess[str]:
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(call, capture_output=True, text=True, check=False, env=kept, cwd="/")


def in_a_checkout(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    for name in ("robodyn", "cli", "tests", "robots", "pyproject.toml"):
        (folder / name).symlink_to(ROOT / name)
    call = [sys.executable, "-c", NOT_INSTALLED + code]
    return subprocess.run(call, capture_output=True, text=True, check=False, cwd=folder)


@pytest.mark.parametrize(
    ("module", "arguments", "printed"),
    [
        pytest.param(
            "pytest",
            ["tests/cli/test_bad_calls.py", "--collect-only", "-p", "no:cacheprovider"],
            "test_call",
            marks=pytest.mark.slow,
        ),
        ("robodyn", ["info", "robots/scara.urdf"], "robot 'scara'"),
    ],
)
def test_a_checkout_runs_as_it_is(module: str, arguments: list[str], printed: str, tmp_path: Path) -> None:
    """`python -m pytest` and `python -m robodyn`: the folder `robodyn` comes before the package that is installed."""
    code = (
        f"import runpy\nsys.argv[1:] = {arguments}\nrunpy.run_module({module!r}, run_name='__main__', alter_sys=True)"
    )
    done = in_a_checkout(code, tmp_path)
    assert (done.returncode, done.stderr) == (0, ""), done
    assert printed in done.stdout


def test_the_command_line_of_a_checkout_is_its_own(tmp_path: Path) -> None:
    done = in_a_checkout("import robodyn.cli.main as main; print(main.__file__)", tmp_path)
    assert done.stdout.strip() == str(tmp_path / "cli" / "main.py"), done


def test_the_source_distribution_is_the_package_and_no_test(tmp_path: Path) -> None:
    """setuptools adds tests/test*.py by itself, which would not run without the others: there are none."""
    checkout = tmp_path / "checkout"
    copytree(
        ROOT, checkout, ignore=ignore_patterns(".*", "build", "dist", "data", "docs", "robots", "*cache*", "*.egg-info")
    )
    code = "import sys; from setuptools.build_meta import build_sdist; print(build_sdist(sys.argv[1]))"
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=False, cwd=checkout
    )
    assert done.returncode == 0, done.stderr
    with tarfile.open(tmp_path / done.stdout.splitlines()[-1]) as archive:
        names = {str(Path(*Path(name).parts[1:])) for name in archive.getnames()}
    modules = {
        str(path.relative_to(checkout)) for name in ("robodyn", "cli") for path in checkout.glob(f"{name}/**/*.py")
    }
    assert modules <= names
    assert {"pyproject.toml", "README.md", "LICENSE", "robodyn/py.typed"} <= names
    assert {name.split("/")[0] for name in names - {"."}} <= {
        *("robodyn", "cli", "robodyn.egg-info", "pyproject.toml", "README.md", "LICENSE"),
        *("PKG-INFO", "setup.cfg"),
    }


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="an environment has its programs elsewhere")
@pytest.mark.parametrize("options", [(), ("-e",)], ids=["plain", "editable"])
def test_pip_installs_a_checkout(options: tuple[str, ...], tmp_path: Path) -> None:
    checkout, place = tmp_path / "checkout", tmp_path / "place"
    copytree(ROOT, checkout, ignore=ignore_patterns(".git", "tests", "docs", "robots", "__pycache__"))
    assert called(sys.executable, "-m", "venv", place).returncode == 0
    done = called(place / "bin/python", "-m", "pip", "install", "-q", "--no-deps", *options, checkout)
    assert done.returncode == 0, done.stderr
    packages = next(place.glob("lib/python*/site-packages"))
    for folder in {Path(str(import_module(name).__file__)).parents[1] for name in LIBRARIES}:
        for library in folder.iterdir():  # this process may have a robodyn of its own among them
            if "robodyn" not in library.name and not (packages / library.name).exists():
                (packages / library.name).symlink_to(library)
    where = called(place / "bin/python", "-c", "import robodyn.cli as cli; print(cli.__file__)")
    assert (checkout in Path(where.stdout).parents) == bool(options), where
    for program, *more in CALLS:
        info = called(place / program, *more, "info", str(ROOT / "robots" / "scara.urdf"))
        assert (info.returncode, info.stderr) == (0, "")
        assert "robot 'scara'" in info.stdout


def bash(code: str) -> list[str]:
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return done.stdout.splitlines()


def test_the_commands_of_the_readme_are_run_to_the_letter() -> None:
    """They are taken from it: one after the other, the first that fails ends them."""
    written = [line for block in re.findall(r"^```sh\n(.*?)^```$", README, re.M | re.S) for line in block.splitlines()]
    assert len(written) == 2
    assert all(line.startswith('pip install ".[') for line in written)
    found = re.search(r"^ *(sed -n .* README\.md) >\"\$scratch/commands\"$", RUN, re.M)
    assert found
    assert bash(found[1]) == [f"{line} || exit 1" for line in written]
    assert not re.search(r'pip install .*"\.\[test\]"', RUN)


def test_what_the_documentation_does_not_run_is_run() -> None:
    """Its examples leave out what installs, tests and builds."""
    assert re.search(r'^pip install .*"\.\[[\w,-]+\]"$', RUN, re.M)
    assert re.search(r"^sphinx-build .*-W", RUN, re.M)
    assert re.search(r"suite slow pytest .*-m slow", RUN)


def test_the_tests_that_are_named_are_there() -> None:
    found = re.search(r"^numeric=\(.*?\)$", RUN, re.M | re.S)
    assert found
    paths = bash(f'{found[0]}\nprintf "%s\\n" "${{numeric[@]}}"')
    assert len(paths) > 5
    assert [path for path in paths if not (ROOT / path).exists()] == []
