"""The errors that robodyn raises on purpose, each of which prints as one line, its warnings, and what makes an answer
doubtful."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

TOO_FEW = "by torques that are not trusted (too few samples)"
"""The kind of caveat about what is derived from too few samples."""


class RobodynError(Exception):
    """Something the user can put right. `str(error)` is the one line that the command line prints.

    Args:
        what: what is wrong, with the number where there is one.
        remedy: what to do about it; printed in brackets.
        file: the file at fault; `line` counts lines from 1 (rows of a table are given in `what` or as `line`).
    """

    def __init__(
        self,
        what: str,
        *,
        remedy: str | None = None,
        file: str | os.PathLike[str] | None = None,
        line: int | None = None,
    ) -> None:
        self.what = what
        self.remedy = remedy
        self.file = None if file is None else os.fspath(file)
        self.line = line
        super().__init__(what)

    def __str__(self) -> str:
        line = "" if self.line is None else f"{self.line}:"
        place = "" if self.file is None else f"{self.file or repr('')}:{line} "
        return printable(place) + self.sentence

    @property
    def sentence(self) -> str:
        """What is wrong and what to do about it, without the place."""
        return printable(self.what + ("" if self.remedy is None else f" ({self.remedy})"))


def printable(text: str) -> str:
    """Return the text with what does not print, or turns what follows, as escapes."""
    return "".join(character if character.isprintable() else repr(character)[1:-1] for character in text)


class InputError(RobodynError):
    """A file, an option or an argument is wrong."""


class DescriptionError(InputError):
    """A robot description is malformed or contradicts itself."""


class NoRobotError(DescriptionError):
    """A file defines parts for others, and describes no robot."""


class TrajectoryError(InputError):
    """A trajectory cannot be read or does not fit the robot."""


class SceneError(InputError):
    """A scene asks for what does not exist or is not understood."""


def unreadable(error: OSError | ValueError, file: str) -> SceneError:
    """The error of a file of settings that cannot be opened."""
    why = (getattr(error, "strerror", None) or str(error)).lower()
    return SceneError(f"cannot be read: {why}", remedy="check the name", file=file)


class MeshError(InputError):
    """A mesh cannot be read, or what is asked of it is not defined."""


class RobodynWarning(RuntimeWarning):
    """What users are told that is no error; the command line prints it as one line."""


@dataclass(frozen=True)
class Caveat:
    """Why "No limit is exceeded" alone would mislead.

    Attributes:
        kind: how that headline goes on, such as "as long as the base is held (assumed)".
        text: the warning in full, with the numbers and how to say otherwise; it is among the warnings too.
    """

    kind: str = field(metadata={"json": "clause"})
    text: str = field(metadata={"json": "said"})


@dataclass(frozen=True)
class WrongUnits(Caveat):
    """Why the numbers of a table can hardly be in the units that they are taken in."""
