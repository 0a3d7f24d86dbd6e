# SPDX-License-Identifier: MIT
"""The site of `./run docs`: pages, public headers and the Python package, by Sphinx. It reads a copy of the tree, so that
links between pages and to other files lead somewhere."""
import inspect
import pathlib
import re

import dermis

project = "dermis"
author = "the dermis authors"
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = "dermis"
html_copy_source = False
exclude_patterns = ["host/packaging/docs"]
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
breathe_projects = {"dermis": "doxygen/xml"}
breathe_default_project = "dermis"
breathe_default_members = ("members", "undoc-members")
breathe_show_include = False
autodoc_member_order = "bysource"
autoclass_content = "both"
highlight_language = "text"
# Doxygen repeats a namespace in each file, and knows a struct of C by its tag and by its name.
suppress_warnings = ["duplicate_declaration.cpp"]
toc_object_entries_show_parents = "hide"


def reference(lines):
    """Docstrings are plain text with code indented by four spaces: as reStructuredText."""
    made, in_code = [], False
    for line in lines:
        if line.strip():
            code = line.startswith("    ")
            if code and not in_code:
                made += ["", ".. code-block:: python", ""]
            elif in_code and not code:
                made.append("")
            in_code = code
        made.append(line if in_code else re.sub(r"([*|\\]|_\b)", r"\\\1", line.replace("`", "``")))
    return made


def page_of_python():
    """Every public name: autodoc itself would pass over compiled functions."""
    page = ["Python", "======", "", ".. automodule:: dermis", ""]
    for module, names in [("dermis", dermis.__all__), ("dermis.contact", dermis.contact.__all__)]:
        page += [module, "-" * len(module), ""]
        for name in names:
            thing = getattr(dermis if module == "dermis" else dermis.contact, name)
            if inspect.isclass(thing):
                page += [f".. autoclass:: {module}.{name}", "   :members:",
                         "   :inherited-members: object, dict, BaseException, Exception, RuntimeError, ValueError", ""]
            elif callable(thing):
                page += [f".. autofunction:: {module}.{name}", ""]
    return "\n".join(page)


def write_pages():
    pathlib.Path("python.rst").write_text(page_of_python())
    for name in re.findall(r"^\w+\.h(?:pp)?$", pathlib.Path("index.md").read_text(), re.M):
        title = f"dermis/{name}"
        pathlib.Path(f"{name}.rst").write_text(f"{title}\n{'=' * len(title)}\n\n.. doxygenfile:: {name}\n")


write_pages()


def setup(app):
    def process(app, what, name, thing, options, lines):
        lines[:] = reference(lines)

    app.connect("autodoc-process-docstring", process)
