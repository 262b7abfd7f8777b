"""Plots as inline SVG: they scale, take the page's text colour in light and dark, and need no file beside the page."""

import hashlib
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a")
"""Okabe and Ito's colours, told apart with any colour vision, readable on white and on dark."""

MARKERS = "o^sD"
"""Where there are more lines than colours, those of the second lap have other markers."""

LEGEND_INSIDE = 5
"""A legend of more entries stands beside the plot."""

_TEXT = "#010203"
"""Stands for the page's text colour while matplotlib draws; no line of a plot may use it."""

_STYLE: Any = {
    "svg.fonttype": "none",
    # Without a salt, identifiers are random and no two runs give the same bytes.
    "svg.hashsalt": "neural-contours",
    "font.family": "sans-serif",
    "text.parse_math": False,
    "font.size": 9,
    "text.color": _TEXT,
    "axes.edgecolor": _TEXT,
    "axes.labelcolor": _TEXT,
    "xtick.color": _TEXT,
    "ytick.color": _TEXT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#88888840",
}
"""matplotlib's settings for every plot."""

Scale = Literal["linear", "log"]


@dataclass(frozen=True)
class Plot:
    """A finished plot.

    Attributes:
        svg: One `<svg>` element.
        caption: A line below it.
        alt: What it shows, for those who can't see it.
    """

    kind: ClassVar[str] = "plot"
    svg: str
    caption: str = ""
    alt: str = ""


@dataclass(frozen=True)
class Series:
    """One line of a plot.

    Attributes:
        name: In the legend; "" for none.
        x: Positions, ascending for a line to make sense.
        y: Values, as many as `x`.
        band: Lower and upper ends of a shaded band around the line, as many as `x` each.
        style: "line", "points" or both ("line+points").
        dashed: Draw the line dashed (a reference, a goal).
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    band: tuple[Sequence[float], Sequence[float]] | None = None
    style: Literal["line", "points", "line+points"] = "line"
    dashed: bool = False

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y):
            raise ValueError(f"series {self.name!r} has {len(self.x)} x and {len(self.y)} y, expected as many")


@dataclass(frozen=True)
class Axis:
    """An axis: its label, with the unit, and its scale."""

    label: str = ""
    scale: Scale = "linear"


def line_plot(
    series: Sequence[Series],
    x: Axis | None = None,
    y: Axis | None = None,
    caption: str = "",
    size: tuple[float, float] = (6.4, 3.6),
) -> Plot:
    """Lines over a common x axis.

    Args:
        series: The lines, in the order of `PALETTE`.
        x: The horizontal axis.
        y: The vertical axis.
        caption: A line below the plot.
        size: Width and height in inches of 72 CSS points; the page scales the plot to its column.
    """
    x, y = x or Axis(), y or Axis()

    def draw(axes: "Axes") -> None:
        for number, line in enumerate(series):
            _draw_series(axes, line, number)
        for axis, scale in ((axes.xaxis, x.scale), (axes.yaxis, y.scale)):
            if scale == "log":
                axes.set(**{f"{axis.axis_name}scale": "log"})
                axis.set_major_formatter(lambda value, _: short_number(value))
        if any(line.name for line in series):
            _add_legend(axes, len(series))

    names = ", ".join(line.name for line in series if line.name)
    return _plot(draw, x.label, y.label, caption, size, f"{y.label} over {x.label}: {names}")


def bar_plot(
    labels: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[tuple[float, float]] | None = None,
    y_label: str = "",
    caption: str = "",
    size: tuple[float, float] = (6.4, 3.2),
) -> Plot:
    """One bar a label, with the ends of its interval as whiskers if given."""
    if len(labels) != len(values):
        raise ValueError(f"{len(labels)} labels for {len(values)} values, expected as many")

    def draw(axes: "Axes") -> None:
        places = range(len(labels))
        axes.bar(places, values, color=PALETTE[0], width=0.7)
        if intervals is not None:
            below = [max(0.0, value - low) for value, (low, _) in zip(values, intervals, strict=True)]
            above = [max(0.0, high - value) for value, (_, high) in zip(values, intervals, strict=True)]
            axes.errorbar(places, values, (below, above), fmt="none", ecolor=_TEXT, capsize=3, linewidth=1)
        steep = max((len(label) for label in labels), default=0) * len(labels) > 80
        axes.set_xticks(places, labels, rotation=35 if steep else 0, ha="right" if steep else "center")

    pairs = ", ".join(f"{label} {value:.4g}" for label, value in zip(labels, values, strict=True))
    return _plot(draw, "", y_label, caption, size, f"{y_label}: {pairs}")


def short_number(value: float) -> str:
    """A number for an axis: 0.1, 20, 10k, 3M."""
    for scale, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(value) >= scale:
            return f"{value / scale:g}{letter}"
    return f"{value:g}"


def _add_legend(axes: "Axes", entries: int) -> None:
    """Among the lines while there are few, beside the plot when they would hide them."""
    if entries <= LEGEND_INSIDE:
        axes.legend(frameon=False, labelcolor=_TEXT)
    else:
        axes.legend(frameon=False, labelcolor=_TEXT, loc="center left", bbox_to_anchor=(1.01, 0.5))


def _draw_series(axes: "Axes", series: Series, number: int) -> None:
    colour, lap = PALETTE[number % len(PALETTE)], number // len(PALETTE)
    axes.plot(
        series.x,
        series.y,
        color=colour,
        label=series.name or None,
        linestyle="" if series.style == "points" else "--" if series.dashed else "-",
        marker="" if series.style == "line" else MARKERS[lap % len(MARKERS)],
        markersize=4,
        linewidth=1.6,
    )
    if series.band is not None:
        axes.fill_between(series.x, *series.band, color=colour, alpha=0.18, linewidth=0)


def _plot(
    draw: "Callable[[Axes], None]", x_label: str, y_label: str, caption: str, size: tuple[float, float], alt: str
) -> Plot:
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.add_subplot()
        axes.set_axisbelow(True)
        draw(axes)
        axes.set(xlabel=x_label, ylabel=y_label)
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    return Plot(_inline(text.getvalue()), caption, caption or alt)


def _inline(document: str) -> str:
    """The `<svg>` element of an SVG document, fit for a page: its identifiers can't clash with another plot's."""
    element = document[document.index("<svg") :]
    element = re.sub(r"<metadata>.*?</metadata>", "", element, flags=re.DOTALL)
    element = element.replace(_TEXT, "currentColor")
    key = f"p{hashlib.sha256(element.encode()).hexdigest()[:8]}-"
    return re.sub(r'(\bid="|url\(#|href="#)', lambda found: found[0] + key, element).strip()
