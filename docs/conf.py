"""The documentation as a site: the pages as they lie, the reference from docstrings, figures drawn at the build.

Sources are the whole checkout, so that a link leads to the same place here and in the repository. Nothing is asked of
another machine, neither at the build nor by the reader: equations become MathML, fonts and scripts are the theme's.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import gyroctl  # noqa: E402

project = "gyroctl"
author = "the authors of gyroctl"
copyright = f"{author}; MIT licence"
version = release = gyroctl.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "site_math",
    "site_members",
]

# --- pages -------------------------------------------------------------------------------------------------------

root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/*.md",
    "docs/results/*.md",
    "docs/reference/**",
    "docs/figures/**",
    "notebooks/*.ipynb",
    "notebooks/*.md",
]
exclude_patterns = [
    "**/.*",
    "**/__pycache__",
    ".venv",
    "build",
    "dist",
    "results",
    "docs/gallery",
    "docs/figures/*.ipynb",
    "docs/figures/*.py",
    "docs/figures/*.md5",
    "docs/figures/*.json",
]
templates_path = [str(HERE / "templates")]  # absolute, since autosummary begins at the sources
# autosummary writes its pages with the first of them
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # notebooks lie there with their outputs, and a test executes them
nb_merge_streams = True

# --- reference ---------------------------------------------------------------------------------------------------

autosummary_generate = True
autosummary_imported_members = True
autodoc_typehints = "none"  # numpydoc's sections say it, with the units
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
viewcode_follow_imported_members = True
add_module_names = False

# --- figures -----------------------------------------------------------------------------------------------------

sphinx_gallery_conf: dict[str, Any] = {
    "examples_dirs": "docs/gallery",
    "gallery_dirs": "docs/figures",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "doc_module": ("gyroctl",),
    "backreferences_dir": "docs/reference/used",
    "min_reported_time": 1e9,
    "show_memory": False,
    "capture_repr": (),
    "write_computation_times": False,
    "abort_on_example_error": False,
    "reset_modules": ("matplotlib", "site_figures.look"),
}

# --- page layout -------------------------------------------------------------------------------------------------

html_theme = "pydata_sphinx_theme"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_title = "gyroctl"
html_show_sourcelink = False
html_copy_source = False
html_show_search_summary = False  # it would be fetched, which a browser refuses to a page from the disk
html_baseurl = ""
html_theme_options: dict[str, Any] = {
    "show_prev_next": True,
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "navigation_depth": 3,
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "search_as_you_type": False,
}
html_context = {"default_mode": "auto"}
pygments_style = "default"
copybutton_prompt_text = "$ "
