"""Cold start against imports it cannot do without, in one run: `cd tests && python -m benchmarks.bench_startup`.

Every process is new; they take turns, so that all meet the same load, and the medians count. Bytecode is cached in a
temporary folder, as that of an installed package is; the first round writes it and does not count.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from statistics import median

from benchmarks.timing import of_process
from helpers.machine import machine
from helpers.markdown_tables import main, table

ROBOTS = Path(__file__).parent.parent.parent / "robots"
JOB = (
    "import sys; from robodyn.cli.start import start; "
    f"sys.argv = ['robodyn', 'torques', {str(ROBOTS / 'scara.urdf')!r}, "
    f"{str(ROBOTS / 'scara_pick_and_place.csv')!r}, '--out', sys.argv[1]]; start()"
)
REFERENCE = 'python -c "import numpy, click"'
CODES = {
    'python -c "pass"': "pass",
    REFERENCE: "import numpy, click",
    "robodyn torques scara.urdf scara_pick_and_place.csv --out tau.csv": JOB,
}


def medians(turns: int) -> dict[str, float]:
    """Median time [s] of every command."""
    with tempfile.TemporaryDirectory() as folder:
        rounds = [
            {
                name: of_process([sys.executable, "-c", code, f"{folder}/tau.csv"], PYTHONPYCACHEPREFIX=folder)[0]
                for name, code in CODES.items()
            }
            for _ in range(turns + 1)
        ]
    return {name: median(each[name] for each in rounds[1:]) for name in CODES}


def report(turns: int) -> str:
    found = medians(turns)
    rows = [(f"`{name}`", f"{1e3 * time:.0f} ms", f"{time / found[REFERENCE]:.2f}") for name, time in found.items()]
    return table(("process", "median", "ratio"), rows) + "\n" + machine("click")


if __name__ == "__main__":
    main(report, __doc__, turns=21)
