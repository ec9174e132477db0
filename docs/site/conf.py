"""How Sphinx builds the site: `make docs`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from peristalsis import __version__ as release

project = "peristalsis"
author = "peristalsis developers"
copyright = author
version = release

extensions = ["myst_nb", "sphinx.ext.autodoc", "pages"]
root_doc = "index"
exclude_patterns = ["site"]
pygments_style = "friendly"
default_role = "code"  # docstrings write code between single backticks, as Markdown does

html_theme = "furo"
html_title = f"peristalsis {release}"
html_copy_source = False
html_show_sphinx = False

myst_heading_anchors = 4
myst_enable_extensions = ["deflist"]
nb_execution_mode = "force"  # what a stored output shows could be another version's
nb_execution_timeout = 240
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 100
toc_object_entries_show_parents = "hide"
