"""The documentation site: `make docs` builds it into build/docs, every warning an error."""

project = "Particle-damper virtual test rig"
author = "The authors of particle-damper-rig"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = "Particle-damper rig"
html_show_copyright = False
html_show_sphinx = False
exclude_patterns = ["conf.py"]
myst_heading_anchors = 3
nitpicky = True
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
nitpick_ignore_regex = [("py:.*", ".*")]  # types of other libraries have no page here
