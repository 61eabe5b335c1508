"""Configuration of the manual: `.ci/manual` builds it into build/manual.

Its sources are the docstrings, the scripts and notebooks in examples/, the README's sections and the reports of
`python -m validation`; the pages beside this file only put them together.
"""

from __future__ import annotations

import builtins
import os
import re
import shutil
import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = next(folder for folder in HERE.parents if (folder / "pyproject.toml").exists())
sys.path[:0] = [str(ROOT), str(HERE)]

import click  # noqa: E402 - after the path of this folder

from suspid import performance  # noqa: E402 - from this folder
from suspid.cli import main  # noqa: E402
from suspid.cli.option_groups import by_group  # noqa: E402

# Notebooks draw in their cells, whatever backend the shell that builds the manual has.
os.environ.pop("MPLBACKEND", None)
# Examples find the record beside them by their own place, which the gallery does not tell them.
vars(builtins)["__file__"] = str(ROOT / "examples" / "example.py")

project, author, copyright = "suspid", "the suspid developers", "the suspid developers"
version = release = version_of("suspid")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx_click",
    "sphinx_gallery.gen_gallery",
]
html_static_path, html_css_files = ["_static"], ["manual.css"]
html_theme, html_title = "furo", f"suspid {release}"
default_role = "any"
nitpicky = False
suppress_warnings = ["config.cache", "ref.any"]
autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
myst_enable_extensions = ["dollarmath"]
# Two hyphens stay what they are: options begin with them.
smartquotes_action = "qe"
# Objects of other libraries are linked where the links are tried: `.ci/manual links`.
intersphinx_mapping: dict[str, tuple[str, None]] = {}
if os.environ.get("SUSPID_LINKS"):
    intersphinx_mapping = {
        "control": ("https://python-control.readthedocs.io/en/stable/", None),
        "numpy": ("https://numpy.org/doc/stable/", None),
    }
exclude_patterns = ["gallery/*.ipynb", "gallery/*.py", "gallery/*.md5", "gallery/*.zip", "gallery/*.json"]


sphinx_gallery_conf = {
    "examples_dirs": [str(ROOT / "examples")],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r".*\.py",
    "ignore_pattern": r"__init__\.py",
    "image_scrapers": ("figures_of_examples",),
    "download_all_examples": False,
    "show_memory": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "plot_gallery": True,
    "abort_on_example_error": True,
    "capture_repr": (),
    "within_subsection_order": "FileNameSortKey",
    "nested_sections": False,
    "copyfile_regex": r"GALLERY_HEADER\.rst",
}


def _public_names() -> str:
    """Return the page of all public names, in the groups of ``suspid.__all__``."""
    text = (ROOT / "suspid" / "__init__.py").read_text(encoding="utf-8")
    first = text.index("\n__all__ = [") + 1
    listed = text[first : text.index("\n]", first)]
    figures = " ".join(f'"{name}"' for name in performance.__all__)
    listed += f"\n    # figures that a car is judged by\n    {figures}"
    parts = [
        "Public names",
        "============",
        "",
        "Every name can be imported from ``suspid``.",
        "",
        ".. currentmodule:: suspid",
        "",
    ]
    for line in listed.splitlines()[1:]:
        if line.strip().startswith("#"):
            heading = line.strip("# ").strip()
            heading = heading[:1].upper() + heading[1:]
            parts += ["", heading, "-" * len(heading), "", ".. autosummary::", "   :toctree: api", ""]
        parts += [f"   {name}" for name in re.findall(r'"(\w+)"', line)]
    return "\n".join(parts) + "\n"


def _options() -> str:
    """Return the page of all options by what they are for, each with the commands that have it."""
    every: dict[str, list[tuple[str, click.Option]]] = {}
    for name, command in main.commands.items():
        for option in command.params:
            if isinstance(option, click.Option):
                every.setdefault(option.opts[-1], []).append((name, option))
    parts = ["# Options", "", "By what they are for, with the commands that have them."]
    for heading, some in by_group([uses[0][1] for uses in every.values()]).items():
        parts += ["", f"## {heading}", ""]
        for option in some:
            meanings: dict[tuple[str, str], list[str]] = {}
            for name, one in every[option.opts[-1]]:
                command = main.commands[name]
                record = one.get_help_record(click.Context(command, info_name=name))
                meanings.setdefault(record or ("", ""), []).append(f"[{name}](commands.rst)")
            parts += [f"- `{called}`: {said} {', '.join(names)}" for (called, said), names in meanings.items()]
    return "\n".join(parts) + "\n"


def _section(title: str) -> str:
    """Return a section of the README without its heading; links to files of the repository are left as text."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise ValueError(f"README.md has no section {title!r}")
    body = re.sub(r"<!--.*?-->\n?", "", found[1])
    body = re.sub(r"!\[[^\]]*\]\([^)]*\)\n?", "", body)
    body = re.sub(r"^###", "##", body, flags=re.MULTILINE)
    return re.sub(r"\[([^\]]+)\]\((?!https?:)[^)]*\)", r"\1", body)


def _indexed(table: str) -> str:
    """Return entries of the index for the names in the first column of a table, so that the search shows them first."""
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    names = dict.fromkeys(name for cell in cells for name in re.findall(r"`(\w+)", cell))
    return "\n```{index} " + ", ".join(f"{name} (MATLAB)" for name in names) + "\n```\n"


def _make_pages(source: Path) -> None:
    """Write the pages that are made from the README, the reports and the names, beside the others."""
    (source / "names.rst").write_text(_public_names(), encoding="utf-8")
    (source / "options.md").write_text(_options(), encoding="utf-8")
    for name, title, heading in (
        ("conventions", "Conventions", "Conventions"),
        ("measured", "Measured", "How the figures were measured"),
        ("matlab", "Coming from MATLAB", "Coming from MATLAB"),
        ("changes", "Changelog", "Changes"),
        ("developers", "Working on suspid", "Working on suspid"),
    ):
        body = _section(title)
        if name == "measured":
            body += "\n## Reports\n\nWhat `python -m validation` wrote:\n\n"
            body += "```{toctree}\n:glob:\n:maxdepth: 1\n\nreports/*\n```\n"
        if name == "matlab":
            body += (source / "more_of_matlab.inc").read_text(encoding="utf-8")
            body = _indexed(body) + body
        (source / f"{name}.md").write_text(f"# {heading}\n{body}", encoding="utf-8")
    reports = source / "reports"
    reports.mkdir(exist_ok=True)
    for report in sorted((ROOT / "validation" / "report").glob("*.md")):
        text = report.read_text(encoding="utf-8")
        pictures = set(re.findall(r"\]\(([\w.-]+\.(?:png|svg))\)", text))
        for picture in pictures:
            shutil.copy(report.with_name(picture), reports / picture)
        links = re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:)[^)]*\)", r"\1", text)
        (reports / report.name).write_text(links, encoding="utf-8")
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        shutil.copy(notebook, source / notebook.name)
    for record in ("quarter_car.csv", "nominal_car.toml", "car.toml", "hatchback.toml"):
        shutil.copy(ROOT / "examples" / record, source / record)


if HERE != ROOT / ".manual":
    _make_pages(HERE)
