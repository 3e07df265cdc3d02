# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the handbook; `python docs/build.py` builds it."""

import sys
from pathlib import Path

import sitedda

sys.path.insert(0, str(Path(__file__).parent))

project = "sitedda"
author = "The sitedda developers"
version = release = sitedda.__version__
copyright = "the authors, GPL-3.0-or-later"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "mathml",
]
myst_enable_extensions = ["deflist", "colon_fence", "dollarmath"]
math_number_all = True
html_math_renderer = "mathml"
myst_heading_anchors = 3
myst_links_external_new_tab = False
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
exclude_patterns = ["ford.md", "packaging/*", "joss/*"]
smartquotes = False  # quotes are those of the input

html_theme = "furo"
html_title = f"sitedda {release}"
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072b2", "color-brand-content": "#0072b2"},
    "dark_css_variables": {"color-brand-primary": "#6cb8ea", "color-brand-content": "#6cb8ea"},
}
html_static_path = ["static"]
html_css_files = ["tables.css"]
