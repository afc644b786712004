"""With what contacts press along a motion, as plots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from robodyn.loads.constraint_result import ContactLoad
from robodyn.loads.history import Curves
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import GRID, SERIES, few_ticks, plot
from robodyn.report.pictures.panels import WIDE
from robodyn.report.sizes import Sizes
from robodyn.report.table import number, printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_LOW = 190
"""Height of a figure [px]."""


def contact_figures(contacts: Sequence[ContactLoad], curves: Curves, size: Sizes) -> list[Figure]:
    """Return of each contact that is ever on its force along the normal against time, all to one scale.

    Args:
        curves: of `normal` and `on`, contact by contact.
    """
    top = 1.05 * max((contact.normal.value for contact in contacts), default=0.0)
    return [_figure(contact, curves, k, top, size) for k, contact in enumerate(contacts) if contact.on]


def _figure(contact: ContactLoad, curves: Curves, column: int, top: float, size: Sizes) -> Figure:
    samples = curves.samples(column)

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.16, 0.24, 0.805, 0.6))
        time, on = samples["time"], samples["on"] > 0.0
        across = axes.get_xaxis_transform()
        axes.fill_between(time, 0.0, 1.0, where=on.tolist(), transform=across, color=GRID, linewidth=0.0, zorder=0)
        axes.plot(time, samples["normal"], color=SERIES[0], marker="o" if len(time) == 1 else None)
        axes.set_ylim(0.0, top or None)
        axes.set_title("[N]")
        axes.set_xlabel("time [s]")
        few_ticks(axes)

    name, most = printable(contact.name), number(contact.normal.value, size["N"])
    words = f"Contact {name}: force along the normal against time, up to {most} N, on {100 * contact.on:.0f} % of it"
    return Figure(f"{name}: force along the normal; shaded where it is on", words, plot(WIDE, _LOW, draw, name))
