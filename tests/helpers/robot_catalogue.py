"""What is in robots/: descriptions, the motions and scenes that go with each, and what their headers say."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import robodyn
from helpers.markdown_tables import table

FOLDER = Path(__file__).parents[2] / "robots"


def names() -> list[str]:
    return sorted(path.stem for path in FOLDER.glob("*.urdf"))


def belonging(name: str, suffix: str) -> list[Path]:
    """Files that begin with this robot's name and with no longer one."""
    return sorted(path for path in FOLDER.glob(f"*{suffix}") if _owner(path.stem) == name)


def _owner(stem: str) -> str:
    return max((name for name in names() if stem == name or stem.startswith(f"{name}_")), key=len)


def headline(name: str) -> str:
    """The first paragraph of the comment at the head of a description, without the robot's name before the colon."""
    comment = re.search(r"<!--\s*(.*?)\n\s*\n", (FOLDER / f"{name}.urdf").read_text(encoding="utf-8"), re.DOTALL)
    assert comment, f"{name}.urdf has no header"
    return " ".join(comment[1].split()).rstrip(".")


def simulation_command(scene: Path) -> str:
    """The command that a scene says it is for, empty if it says none."""
    found = re.search(r"^# Run: (.*)$", scene.read_text(encoding="utf-8"), re.MULTILINE)
    return found[1] if found else ""


def robots_table() -> str:
    def listed(paths: list[Path]) -> str:
        return ", ".join(f"`{path.name}`" for path in paths) or "none"

    def row(name: str) -> tuple[str, ...]:
        scenes = belonging(name, ".toml")
        commands = [f"`{command}`" for command in map(simulation_command, scenes) if command]
        return (
            f"`{name}.urdf`",
            headline(name),
            listed(belonging(name, ".csv")),
            listed(scenes),
            *(commands or ["none"]),
        )

    return table(("description", "robot", "motions", "scenes", "how it moves"), [*map(row, names())], left=range(5))


@cache
def runs() -> tuple[tuple[str, robodyn.Result], ...]:
    """The results of every motion in every scene that goes with it, and in none."""
    return tuple(_runs())


def _runs() -> Iterator[tuple[str, robodyn.Result]]:
    for name in names():
        scenes = [robodyn.Scene(), *map(robodyn.load_scene, belonging(name, ".toml"))]
        for motion in belonging(name, ".csv"):
            for scene in scenes:
                model = robodyn.load(FOLDER / f"{name}.urdf", moving_base=scene.moving_base)
                try:
                    with robodyn.read_motion(motion, model, scene) as reader:
                        yield motion.stem, robodyn.torques(model, reader, scene)
                except robodyn.RobodynError:
                    continue
