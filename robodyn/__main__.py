"""`python -m robodyn`: the command line, also from a checkout that is not installed."""

import os
import sys
from importlib.util import find_spec, module_from_spec, spec_from_file_location


def _beside() -> None:
    """Let `robodyn.cli` be the folder `cli` beside this package, as an installation makes it."""
    folder = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "cli")
    first = os.path.join(folder, "__init__.py")
    spec = spec_from_file_location("robodyn.cli", first, submodule_search_locations=[folder])
    assert spec is not None
    assert spec.loader is not None
    sys.modules["robodyn.cli"] = module = module_from_spec(spec)
    spec.loader.exec_module(module)


if find_spec("robodyn.cli") is None:
    _beside()

if __name__ == "__main__":
    from robodyn.cli.start import start

    start()
