"""Draw the architecture from the code: rooms with what their docstrings say, arrows as their modules import.

    python -m docs.make_architecture

Packages stand on what they import, and so do the rooms within a package. Arrows that follow from others aren't drawn,
nor are those to the modules at a package's top, which any of its rooms may import.
"""

import ast
import textwrap
from collections import Counter
from collections.abc import Iterable, Mapping
from graphlib import TopologicalSorter
from html import escape
from pathlib import Path

from tests.helpers.imports import CHAIN, ROOT, TEMPLATES, folder_imports, folder_of, modules_below, package_of

FIGURE = Path(__file__).with_name("architecture.svg")

WIDTH, MARGIN = 960, 16
BOX, HEIGHT, PITCH = 210, 68, 92
"""Width and height of a room, and from one row to the next, in pixels."""
GAP, PASSAGE = 14, 16
"""Between neighbours in a row; the width of an arrow that passes a row."""
TITLE, BASE = 34, 34
"""Heights of a package's name, and of the bar of modules at its top."""
SWEEPS = 4
"""Times that rows are sorted by where the rooms above and below stand."""

Graph = dict[str, set[str]]
Rows = list[list[str]]
Links = list[tuple[str, str]]

_STYLE = """
.package { fill: #f5f5f5; stroke: #999 } .room { fill: #fff; stroke: #333 } .data { stroke-dasharray: 4 3 }
.arrow { fill: none; stroke: #777; marker-end: url(#head) } .chain { stroke: #333; stroke-width: 3 }
text { font: 11px sans-serif; fill: #333; text-anchor: middle } .name { font-size: 13px; font-weight: bold }
.left { text-anchor: start } .passes { marker-end: none }"""


def figure(root: Path) -> str:
    """The architecture of the tree below `root`, as an SVG document."""
    modules = modules_below(root)
    graph = folder_imports(modules)
    for module, path in modules.items():
        # Templates are data, found by their package's name.
        if f'"{TEMPLATES}"' in path.read_text(encoding="utf-8"):
            graph[folder_of(module, modules)].add(TEMPLATES)
    drawn: list[str] = []
    top = MARGIN
    for package in reversed(CHAIN):
        if top > MARGIN:
            drawn.append(_arrow((WIDTH / 2, top), (WIDTH / 2, top + PITCH - HEIGHT), "chain"))
            top += PITCH - HEIGHT
        part, height = _package(package, graph, modules, top)
        drawn += part
        top += height
    height = top + MARGIN
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}">
<title>Rooms and their imports: {" imports ".join(reversed(CHAIN))}</title>
<style>{_STYLE}</style>
<marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto"
 markerUnits="userSpaceOnUse"><path d="M0,0 L8,4 L0,8 z" fill="#555"/></marker>
<rect width="{WIDTH}" height="{height}" fill="#fff"/>
{chr(10).join(drawn)}
</svg>
"""


def _package(package: str, graph: Graph, modules: Mapping[str, Path], top: int) -> tuple[list[str], int]:
    """A package's drawing, and its height."""
    rooms = {name for name in graph if package_of(name) == package and name != package}
    rooms |= {TEMPLATES} & {other for room in rooms for other in graph[room]}
    rows, links = _layers(_reduced({room: graph[room] & rooms for room in rooms}))
    _untangle(rows, links)
    loose = [name for name in modules if folder_of(name, modules) == package and name != package]
    height = TITLE + len(rows) * PITCH + (BASE if loose else 0)
    places = {room: (x, top + TITLE + n * PITCH) for n, row in enumerate(rows) for room, x in _spread(row).items()}
    drawn = [
        _box("package", MARGIN, top, WIDTH - 2 * MARGIN, height),
        _text(f'<tspan class="name">{package}</tspan>: {_idea(modules[package])}', MARGIN + GAP, top + 22, "left"),
    ]
    for room, other in links:
        (x, y), (to_x, to_y) = places[room], places[other]
        drawn.append(_arrow((x, y + HEIGHT), (to_x, to_y), "" if other in rooms else "passes"))
        if other not in rooms:
            drawn.append(f'<path class="arrow passes" d="M{to_x:g},{to_y} v{HEIGHT}"/>')
    for room in sorted(rooms):
        drawn += _room(room, modules, *places[room])
    if loose:
        names = ", ".join(name.rpartition(".")[2] for name in loose)
        drawn.append(_box("room", MARGIN + GAP, top + height - BASE - 10, WIDTH - 2 * (MARGIN + GAP), BASE))
        drawn.append(_text(f"below them all: {names}", WIDTH / 2, top + height - BASE + 11))
    return drawn, height


def _reduced(graph: Graph) -> Graph:
    """The graph without imports that follow from others."""
    reached: Graph = {}
    for room in TopologicalSorter(graph).static_order():
        reached[room] = graph[room].union(*(reached[other] for other in graph[room]))
    return {room: others - set().union(*(reached[other] for other in others)) for room, others in graph.items()}


def _layers(graph: Graph) -> tuple[Rows, Links]:
    """Rooms in rows, below all that import them and as near to these as can be; arrows pass the rows between."""
    row_of = dict.fromkeys(sorted(graph), 0)
    for room in reversed(list(TopologicalSorter(graph).static_order())):
        for other in graph[room]:
            row_of[other] = max(row_of[other], row_of[room] + 1)
    # What nobody imports stands right on what it imports, or where there is room: the top row would leave the page.
    for room in sorted(set(row_of) - {other for others in graph.values() for other in others}):
        counts = Counter(row_of.values())
        emptiest = min(range(max(row_of.values()) + 1), key=lambda n: counts[n])
        row_of[room] = min(row_of[other] for other in graph[room]) - 1 if graph[room] else emptiest
    rows: Rows = [[room for room in row_of if row_of[room] == n] for n in range(max(row_of.values()) + 1)]
    links: Links = []
    for room in row_of:
        for other in sorted(graph[room]):
            steps = [room]
            for n in range(row_of[room] + 1, row_of[other]):
                steps.append(f"{room} > {other} {n}")
                rows[n].append(steps[-1])
            links += zip(steps, [*steps[1:], other], strict=True)
    return rows, links


def _untangle(rows: Rows, links: Links) -> None:
    """Sort each row by the middle of what its members are linked with, so that fewer arrows cross."""
    for _ in range(SWEEPS):
        for row in [*rows, *reversed(rows)]:
            x = {name: place for other in rows for name, place in _spread(other).items()}
            linked = {name: [x[b if a == name else a] for a, b in links if name in (a, b)] for name in row}
            row.sort(key=lambda name: (sum(linked[name]) / len(linked[name]) if linked[name] else x[name], name))


def _spread(row: Iterable[str]) -> dict[str, float]:
    """Where the middles of a row's members are, from left to right."""
    widths = {name: PASSAGE if ">" in name else BOX for name in row}
    x = (WIDTH - sum(widths.values()) - GAP * (len(widths) - 1)) / 2
    places = {}
    for name, width in widths.items():
        places[name] = x + width / 2
        x += width + GAP
    return places


def _room(room: str, modules: Mapping[str, Path], x: float, y: int) -> list[str]:
    lines = textwrap.wrap(_idea(modules[room]), 35)
    kind = "room data" if room == TEMPLATES else "room"
    return [
        _box(kind, x - BOX / 2, y, BOX, HEIGHT),
        _text(room.rpartition(".")[2], x, y + 17, "name"),
        *(_text(line, x, y + 33 + 13 * n) for n, line in enumerate(lines)),
    ]


def _idea(path: Path) -> str:
    """The first sentence of a package's docstring."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return escape(text.partition("\n")[0].replace("`", "").rstrip("."), quote=False)


def _box(kind: str, x: float, y: float, width: float, height: float) -> str:
    return f'<rect class="{kind}" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="5"/>'


def _text(text: str, x: float, y: float, kind: str = "") -> str:
    return f'<text class="{kind}" x="{x:g}" y="{y:g}">{text}</text>'


def _arrow(start: tuple[float, float], end: tuple[float, float], kind: str) -> str:
    (x, y), (to_x, to_y) = start, end
    middle = (y + to_y) / 2
    return f'<path class="arrow {kind}" d="M{x:g},{y:g} C{x:g},{middle:g} {to_x:g},{middle:g} {to_x:g},{to_y:g}"/>'


if __name__ == "__main__":
    FIGURE.write_text(figure(ROOT), encoding="utf-8")
