"""The documentation site: sphinx-build -W docs OUTPUT."""

import os
import sys
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "agg")
HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path.insert(0, str(HERE / "_ext"))

import cli_page  # noqa: E402 - from the folder that has just been named
import evidence_page  # noqa: E402
import variables_page  # noqa: E402
import yaml_page  # noqa: E402
from sphinx_gallery.sorting import FileNameSortKey  # noqa: E402

import warpdamp  # noqa: E402

project = "warpdamp"
author = "the warpdamp developers"
copyright = f"2026, {author}"
version = release = warpdamp.__version__
language = "en"
templates_path = ["_templates"]
html_math_renderer = "mathml"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "mathml",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery/GALLERY_HEADER.rst"]
suppress_warnings = ["config.cache"]  # the order of the gallery is a class, which Sphinx cannot store

myst_enable_extensions = ["colon_fence", "dollarmath", "amsmath", "deflist", "attrs_inline"]
myst_heading_anchors = 4
myst_dmath_double_inline = True

autosummary_generate = True
autodoc_typehints = "none"  # docstrings have types, units and shapes
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

sphinx_gallery_conf = {
    "examples_dirs": str(ROOT / "examples"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": FileNameSortKey,
    "abort_on_example_error": True,
    "show_memory": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "remove_config_comments": True,
    "download_all_examples": False,
    "image_scrapers": ("matplotlib", "figures.figures"),
    "reset_modules": ("matplotlib",),
    "capture_repr": (),
    "show_signature": False,
}
copybutton_exclude = ".linenos, .gp, .go"

html_theme = "pydata_sphinx_theme"
html_title = "warpdamp"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_show_sourcelink = False
html_theme_options = {
    "navbar_end": ["theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_sidebars = {"index": [], "tutorial/index": []}

WRITTEN = {
    "reference/yaml.md": yaml_page.page,
    "reference/cli.md": cli_page.page,
    "reference/variables.md": variables_page.page,
    "evidence/index.md": evidence_page.page,
}
"""Pages written from the code, by their names."""


def write_pages(_app):
    """Write the pages that have changed."""
    for name, page in WRITTEN.items():
        path, text = HERE / name, page()
        path.parent.mkdir(exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app):
    """Connect what writes pages."""
    app.connect("builder-inited", write_pages, priority=1)
