"""How often intervals of an identified robot hold on another motion, by what the log has that the model has not."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from helpers.markdown_tables import table
from helpers.misfit_logs import CLASSES, JUDGED, Judged, judged

SAID = {
    "logged late": "how late",
    "clipped": "that torques are clipped",
    "leans by": "by how much gravity leans, `--gravity`",
    "in steps of": "the steps",
    "lacks something": "that the model lacks something",
    "that the log has not": "that no interval counts the joint",
}
"""What is said in the output, by words of it; of a gain nothing can be told, which every output says."""


def said(cases: list[Judged]) -> str:
    """What is said of most logs."""
    found = [
        words
        for key, words in SAID.items()
        if np.mean([any(key in line for line in each.said) for each in cases]) > 0.5
    ]
    return ", ".join(found) or "-"


def coverage_of_identified() -> str:
    """Coverage of classes of logs that nothing was tuned on, and errors on the other motion."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in CLASSES:
            cases = [judged(name, seed, Path(folder) / "log.csv") for seed in JUDGED]
            mean = [float(np.mean([getattr(each, part) for each in cases])) for part in Judged._fields[2:5]]
            held = 100.0 * float(np.mean([each.held for each in cases]))
            rows.append((name, f"{held:.0f} %", *(f"{100.0 * each:.1f} %" for each in mean), said(cases)))
            print(rows[-1], flush=True) if __name__ == "__main__" else None
    head = ("log", "intervals hold", "error", "by the description", "held out", "said")
    return table(head, rows, left=(0, 5))


if __name__ == "__main__":
    print(coverage_of_identified())
