"""Sphinx: `pip install ".[docs]"`, then `sphinx-build -W docs build/docs`."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from generated_pages import write_pages  # noqa: E402

project = "robodyn"
author = "the authors of robodyn"
release = version = installed("robodyn")
extensions = ["myst_parser"]
exclude_patterns = ["_build"]
myst_heading_anchors = 3
html_theme = "furo"
html_show_copyright = False
smartquotes = False
html_title = f"robodyn {release}"
html_static_path = ["static"]
html_css_files = ["wide.css"]

write_pages(HERE)
