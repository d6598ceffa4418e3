"""Configuration of the documentation, and the two generated parts it contains."""

from __future__ import annotations

import sys
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import make_gallery  # noqa: E402
import make_validation  # noqa: E402

import fivebar_atlas  # noqa: E402

project = "fivebar-atlas"
author = "the fivebar-atlas authors"
project_copyright = f"2026, {author}"
version = release = fivebar_atlas.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_click",
]
exclude_patterns = ["_build", "_generated"]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"fivebar-atlas {version}"


def generate(_app: Sphinx) -> None:
    """Run the gallery's commands and compute the validation table."""
    generated = HERE / "_generated"
    make_gallery.make(HERE / "gallery.md", generated / "gallery")
    make_validation.make(generated / "validation.md")


def escape_bars(
    _app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Keep reStructuredText from taking |x|, an absolute value, for a substitution."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def setup(app: Sphinx) -> None:
    """Generate before the sources are read."""
    app.connect("builder-inited", generate)
    app.connect("autodoc-process-docstring", escape_bars)
