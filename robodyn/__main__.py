"""`python -m robodyn`: the command line, also from a checkout that is not installed."""

import os
import sys


def _leave_out_the_current_folder() -> None:
    """Import nothing from it, which `python -m` has put first; robodyn itself is found already."""
    if sys.path and os.path.realpath(sys.path[0] or os.curdir) == os.path.realpath(os.curdir):
        del sys.path[0]


def _beside() -> None:
    """Let `robodyn.cli` be the folder `cli` beside this package, as an installation makes it."""
    from importlib.util import find_spec, module_from_spec, spec_from_file_location
    from pathlib import Path

    if find_spec("robodyn.cli") is not None:
        return
    folder = Path(__file__).resolve().parents[1] / "cli"
    spec = spec_from_file_location("robodyn.cli", folder / "__init__.py", submodule_search_locations=[str(folder)])
    assert spec is not None
    assert spec.loader is not None
    sys.modules["robodyn.cli"] = module = module_from_spec(spec)
    spec.loader.exec_module(module)


if __name__ == "__main__":
    _leave_out_the_current_folder()
_beside()

if __name__ == "__main__":
    from robodyn.cli.start import start

    start()
