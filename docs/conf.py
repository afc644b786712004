"""Sphinx: `pip install ".[docs]"`, then `sphinx-build -W docs build/docs`."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from generated_pages import write_pages  # noqa: E402

project = "robodyn"
author = "the authors of robodyn"
release = version = installed("robodyn")
extensions = ["myst_parser"]
exclude_patterns = ["_build"]
myst_heading_anchors = 3
myst_fence_as_directive = ["math"]
html_math_renderer = "mathml"
html_theme = "furo"
html_show_copyright = False
smartquotes = False
html_title = f"robodyn {release}"
html_static_path = ["static"]
html_css_files = ["wide.css"]

write_pages(HERE)


def inline_mathml(translator, node):
    """Write a formula as MathML, which browsers show without a script from the network."""
    translator.body.append(tex2mathml(node.astext()))
    raise SkipNode


def display_mathml(translator, node):
    """Write a formula that has lines of its own likewise."""
    translator.body.append(tex2mathml(node.astext()).replace("<math ", '<math display="block" ', 1))
    raise SkipNode


def setup(app):
    """Register how formulas are shown; on pages they are fences of the language `math`."""
    app.add_html_math_renderer("mathml", (inline_mathml, None), (display_mathml, None))
