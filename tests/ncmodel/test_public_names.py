"""What `import ncmodel` offers, and what type checkers are told of it."""

import ast
from pathlib import Path

import ncmodel

OLDEST = {"Camera", "Drawing", "LineFamily", "Mesh", "Thresholds", "draw_shape", "load_mesh", "load_model", "make_mesh"}
"""Names that programs of others import."""


def test_names_stay() -> None:
    assert set(dir(ncmodel)) >= OLDEST


def test_type_checkers_are_told_every_name_and_where_it_is() -> None:
    stub = ast.parse(Path(ncmodel.__file__ or "").with_suffix(".pyi").read_text(encoding="utf-8"))
    told = {
        str(alias.asname): (node.module, alias.name)
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(told) == set(dir(ncmodel)) == set(ncmodel.__all__)
    for name, (module, inner) in told.items():
        found = getattr(ncmodel, name)
        assert (found.__module__, found.__name__) == (module, inner)
