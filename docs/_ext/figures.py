"""Figures of the gallery that are not pyplot's: those that functions of warpdamp return."""

from __future__ import annotations

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def figures(_block, block_vars, gallery_conf) -> str:
    """Save the example's variable ``figure``, once, and return what shows it."""
    found = block_vars["example_globals"].pop("figure", None)
    if not isinstance(found, Figure):
        return ""
    path = block_vars["image_path_iterator"].next()
    found.savefig(path, dpi=110)
    return figure_rst([path], gallery_conf["src_dir"])
