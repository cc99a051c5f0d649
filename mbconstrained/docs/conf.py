"""Configuration of Sphinx. The docstrings of the Python names are inserted while the pages are read."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from generated import api

project = "mbconstrained"
author = "the mbconstrained developers"
version = release = installed_version("mbconstrained")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
html_theme = "alabaster"
html_theme_options = {"description": "Closed-form motion of constrained mechanical systems", "page_width": "1100px"}
html_static_path: list[str] = []
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_use_rtype = False
napoleon_use_ivar = True
html_math_renderer = "mathml"  # MathJax would load a script from the network

SECTIONS = ("Args:", "Attributes:", "Returns:", "Raises:", "Yields:", "Example:", "Examples:")


def _insert_docstrings(app, name: str, source: list[str]) -> None:
    """Replace the line ``<!-- docstrings: Sphinx -->`` of the page of the Python API by its directives."""
    if "<!-- docstrings: Sphinx -->" in source[0]:
        source[0] = source[0].replace("<!-- docstrings: Sphinx -->", api())


def _valid_docstring(app, what, name, obj, options, lines: list[str]) -> None:
    """Make a docstring valid reStructuredText: equations become literal blocks, and signs of mathematics no markup."""
    text: list[str] = []
    section = False
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if line.strip() and not indent:
            section = line.strip() in SECTIONS
        before = lines[number - 1].strip() if number else ""
        if indent >= 4 and not section and not before and not _in_literal(text):
            text += ["::", ""]
        literal = (indent >= 4 and not section) or line.lstrip().startswith(">>>")
        text.append(line if literal else re.sub(r"(?<!`)([|*])", r"\\\1", re.sub(r"(?<=\w)_(?=\W|$)", r"\\_", line)))
    lines[:] = text


def _in_literal(text: list[str]) -> bool:
    previous = [line for line in text if line.strip()]
    return bool(previous) and (previous[-1].startswith("    ") or previous[-1].endswith("::"))


def _inline_math(translator, node) -> None:
    """A formula in a line as MathML, which browsers show without a script."""
    translator.body.append(tex2mathml(node.astext()))
    raise SkipNode


def _display_math(translator, node) -> None:
    """A formula of its own as MathML."""
    translator.body.append(tex2mathml(node.astext(), as_block=True))
    raise SkipNode


def setup(app) -> None:
    """Connect the hooks and the renderer of formulas."""
    app.add_html_math_renderer("mathml", (_inline_math, None), (_display_math, None))
    app.connect("source-read", _insert_docstrings)
    app.connect("autodoc-process-docstring", _valid_docstring, priority=1)
