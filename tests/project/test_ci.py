"""`.ci/run` runs what the README says, and leaves out and singles out tests that are there."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
RUN = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


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
