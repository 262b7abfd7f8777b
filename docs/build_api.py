"""Build the API pages from the docstrings, without a network.

python -m docs.build_api [FOLDER]      FOLDER is api unless given
"""

import sys
from pathlib import Path

import pdoc
import pdoc.render

import ncmodel

PACKAGES = ("ncmodel", "dataset_tools", "eval")


def build(folder: Path, *modules: str) -> None:
    """Write a page for each module.

    Args:
        folder: Where to.
        modules: Packages with all that is below them; one that begins with ! is a pattern of what to leave out.
    """
    for name in ncmodel.__all__:
        # pdoc sees what a module holds, not what it would import when asked.
        setattr(ncmodel, name, getattr(ncmodel, name))
    pdoc.render.configure(docformat="google")
    pdoc.pdoc(*modules, output_directory=folder)


if __name__ == "__main__":
    build(Path(*sys.argv[1:] or ["api"]), *PACKAGES)
