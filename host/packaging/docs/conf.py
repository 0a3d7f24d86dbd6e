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
        made.append(re.sub(r" {3,}#", "  #", line) if in_code else re.sub(r"([*|\\]|_\b)", r"\\\1", line.replace("`", "``")))
    return made


PYTHON = {  # the names in the order of use; those that are missing here stand last
    "A skin, press by press": "Skin fingertip Scene",
    "Tables of a scene": "Grid Surface Curvature Material Receptors Sites Load Time Output",
    "Spikes": "Afferents AfferentModel afferent_model",
    "Contacts": "contact.Touch contact.Shapes contact.Pad contact.Contact contact.add_contacts contact.Pose "
                "contact.WorldContact contact.Body contact.fill_depths contact.add_depths contact.add_taxels",
    "Whole runs": "run Result Trace sweep plan Explanation Candidate Impulse Report Figure",
    "Pictures": "plot",
    "Materials from measurements": "fit Fit fit_creep fit_relaxation fit_histories KelvinVoigt Relaxation relaxation_of "
                                  "chain_of",
}


def page_of_python():
    """Every public name: autodoc itself would pass over compiled functions."""
    public = [*dermis.__all__, *(f"contact.{name}" for name in dermis.contact.__all__)]
    groups = {title: names.split() for title, names in PYTHON.items()}
    rest = [name for name in public if name not in " ".join(PYTHON.values()).split()]
    groups["Contacts"] += [name for name in rest if name.startswith("contact.")]
    groups["All else"] = [name for name in rest if not name.startswith("contact.")]
    page = ["Python", "======", "", ".. automodule:: dermis", ""]
    for title, names in groups.items():
        page += [title, "-" * len(title), ""]
        for name in names:
            thing = operator.attrgetter(name)(dermis)
            if inspect.isclass(thing):
                page += [f".. autoclass:: dermis.{name}", "   :members:",
                         "   :inherited-members: object, dict, BaseException, Exception, RuntimeError, ValueError", ""]
            elif callable(thing):
                page += [f".. autofunction:: dermis.{name}", ""]
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

    def shorten(app, what, name, thing, options, arguments, returned):
        return [text and re.sub(r"^\(self(, )?", "(", re.sub(r"\b(collections\.abc|numpy\.typing|dermis\._typing)\.", "", text))
                for text in (arguments, returned)]

    app.connect("autodoc-process-docstring", process)
    app.connect("autodoc-process-signature", shorten)
