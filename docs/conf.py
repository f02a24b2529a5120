"""The documentation site: `make docs` builds it into build/docs, every warning an error."""

project = "Particle-damper virtual test rig"
author = "The authors of particle-damper-rig"
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "Particle-damper rig"
html_show_copyright = False
html_show_sphinx = False
exclude_patterns = ["conf.py"]
myst_heading_anchors = 3
nitpicky = True
