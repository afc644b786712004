"""Charts that answer in the page: curves over time, and planes of points and lines, drawn there by uPlot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from robodyn.report.document import Chart
from robodyn.report.table import NEGLIGIBLE
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from robodyn.support.courses import Courses

Band = tuple[Floats, Floats]
"""Least and greatest values in buckets of rows."""
COLOURS = tuple(f"c{k}" for k in range(1, 11))
"""Of a page, for curves; "ink", "soft", "bad", "good", "doubtful" besides."""


class Course:
    """Curves of a motion as charts have them: rows of time, and of each curve values, or the least and greatest."""

    def __init__(self, motion: Courses) -> None:
        self.motion = motion
        self.time = motion.first[:, 0]
        self.rows: Floats = 1.0 + motion.per * np.arange(float(len(self.time)))
        numbers, frames = motion.frames()
        self.frames = dict(zip(motion.names, np.ascontiguousarray(frames.T), strict=True))
        self.frame_rows = 1.0 + numbers

    def curve(self, name: str, scale: float) -> Floats | Band:
        """Return a curve, zero throughout where there is nothing but rounding noise."""
        low, high = self.motion.of(name)
        if max(np.abs(low).max(), np.abs(high).max()) <= NEGLIGIBLE * scale:
            return np.zeros(len(low))
        return self.frames[name] if self.motion.per == 1 and name in self.frames else (low, high)


def time_chart(
    caption: str,
    alt: str,
    time: Floats,
    curves: Mapping[str, Floats | Band],
    unit: str,
    *,
    rows: Floats | None = None,
    levels: Sequence[tuple[float, str]] = (),
    spans: Sequence[tuple[float, float, str]] = (),
    colours: Sequence[str] = COLOURS,
    held: Iterable[str] = (),
    wide: Iterable[str] = (),
) -> Chart:
    """Return curves of one unit over time [s].

    Args:
        curves: by label, (N,) each, or a pair where a sample stands for a bucket of rows: the least and the greatest.
        rows: (N,) numbers of samples in the table, counted from 1.
        levels: values with a word, drawn across as dashed lines; limits.
        spans: (from, to, word) of times that are shaded.
        held: labels of curves that hold a value until the next; wide: of those drawn as pale bands below others.
    """
    series, held, wide = [], set(held), set(wide)
    for (label, values), colour in zip(curves.items(), colours, strict=False):
        low, high = values if isinstance(values, tuple) else (values, None)
        if high is not None and np.array_equal(low, high, equal_nan=True):
            high = None
        each = {"label": label, "colour": colour, "y": low, "high": high, "held": label in held}
        series.append(each | {"wide": label in wide})
    look = {"kind": "time", "unit": unit, "x": time, "rows": rows, "series": series}
    return Chart(caption, alt, look | {"levels": [*levels], "spans": [*spans]})


def plane_chart(
    caption: str,
    alt: str,
    across: str,
    up: str,
    *,
    dots: Mapping[str, tuple[Floats, Floats]] | None = None,
    lines: Mapping[str, tuple[Floats, Floats]] | None = None,
    marks: Sequence[tuple[float, float, str, str]] = (),
    colours: Mapping[str, str] | None = None,
    names: Mapping[str, Sequence[str]] | None = None,
    spans: Sequence[tuple[float, float, str]] = (),
    time: Floats | None = None,
    log: bool = False,
    equal: bool = False,
) -> Chart:
    """Return points and lines over two quantities, named with their units.

    Args:
        dots, lines: by label (N,) across and up; lines end at nan and go on behind it.
        marks: (across, up, word, colour) of single points, told when they are hovered.
        colours: by label; those of curves in turn without. names: by label those of its dots.
        spans: (from, to, word) across that are shaded.
        time: (N,) of the first dots [s], so that the cursor in time is shown among them.
        log: whether both axes are logarithmic; equal: whether both have one scale.
    """
    series, chosen = [], cycle(COLOURS)
    for style, group in (("dots", dots or {}), ("line", lines or {})):
        for label, (x, y) in group.items():
            colour = (colours or {}).get(label) or next(chosen)
            each = {"label": label, "colour": colour, "x": x, "y": y, "style": style}
            series.append(each | {"names": (names or {}).get(label)})
    look = {"kind": "plane", "across": across, "up": up, "series": series, "marks": [*marks], "time": time}
    return Chart(caption, alt, look | {"spans": [*spans], "log": log, "equal": equal})
