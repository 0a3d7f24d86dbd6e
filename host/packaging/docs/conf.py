# SPDX-License-Identifier: MIT
"""The site of `./run docs`: pages, public headers and the Python package, by Sphinx. It reads a copy of the tree, so that
links between pages and to other files lead somewhere."""
import inspect
import operator
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
maximum_signature_line_length = 90
python_use_unqualified_type_names = True
autoclass_content = "both"
highlight_language = "text"
# Doxygen repeats a namespace in each file, and knows a struct of C by its tag and by its name.
suppress_warnings = ["duplicate_declaration.cpp"]
toc_object_entries_show_parents = "hide"


def reference(app, what, name, thing, options, lines):
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
        made.append(re.sub(r" {3,}#", "  #", line) if in_code else re.sub(r"([*|\\]|_\b)", r"\\\1", line.replace("`", "``")))
    lines[:] = made


def page_of_python():
    """python.rst, with entries for the names in its lists, then for all others: autodoc passes over compiled functions."""
    def entry(name):
        thing = operator.attrgetter(name)(dermis)
        if inspect.isclass(thing):
            return (f".. autoclass:: dermis.{name}\n   :members:\n   :inherited-members: object, dict, BaseException, "
                    "Exception, RuntimeError, ValueError\n\n")
        return f".. autofunction:: dermis.{name}\n\n" if callable(thing) else ""

    page = pathlib.Path("python.rst").read_text()
    public = [*dermis.__all__, *(f"contact.{name}" for name in dermis.contact.__all__)]
    page += "* " + " ".join(name for name in public if name not in page.split())
    return re.sub(r"^\* (.*)", lambda names: "".join(map(entry, names[1].split())), page, flags=re.M)


def write_pages():
    pathlib.Path("python.rst").write_text(page_of_python())
    for name in re.findall(r"^\w+\.h(?:pp)?$", pathlib.Path("index.md").read_text(), re.M):
        title = f"dermis/{name}"
        pathlib.Path(f"{name}.rst").write_text(f"{title}\n{'=' * len(title)}\n\n.. doxygenfile:: {name}\n")


write_pages()


def setup(app):
    def shorten(app, what, name, thing, options, arguments, returned):
        return [text and re.sub(r"^\(self(, )?", "(", re.sub(r"\b(collections\.abc|numpy\.typing|dermis\._typing)\.", "", text))
                for text in (arguments, returned)]

    app.connect("autodoc-process-docstring", reference)
    app.connect("autodoc-process-signature", shorten)
