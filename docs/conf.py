"""The site of the documents: `make docs` builds it into build/site from the pages beside this file."""

from billow import __version__

project, release = "Billow", __version__
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"Billow {release}"
html_show_sourcelink = False
html_static_path, html_css_files = ["_static"], ["print.css"]
exclude_patterns = ["make_*.py"]
nitpicky = True
html_show_copyright = False
