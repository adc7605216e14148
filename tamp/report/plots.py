"""Plots as SVG text that stands in a page: no files, no network, the same bytes for the same data."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tamp.report.comparison import Comparison, Row

COLORS = ("#2f6f9f", "#d97b29", "#4f9f5f", "#b0524f", "#7f6fae", "#8c6d4f", "#5b5b5b", "#c7a93c", "#4fa3a5", "#a35b8c")


def svg(draw: Callable[[Figure], None], height: float) -> str:
    """An SVG element.

    Args:
        draw: puts the data on the figure.
        height: of the picture, 8 inches wide at 72 dots an inch.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    # A fixed salt keeps the ids within the picture the same from run to run; text stays text.
    with rc_context({"svg.hashsalt": "tamp", "svg.fonttype": "none", "font.size": 9, "font.family": "sans-serif"}):
        figure = Figure(figsize=(8.0, height), layout="constrained", facecolor="none")
        draw(figure)
        file = io.StringIO()
        figure.savefig(file, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    text = file.getvalue()
    return text[text.index("<svg") :]


def plot(draw: Callable[[Axes], None], height: float = 3.0) -> str:
    """An SVG element with one pair of axes."""

    def on(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.spines[["top", "right"]].set_visible(False)
        draw(axes)

    return svg(on, height)


def survival(times: Mapping[str, Sequence[float]], total: Mapping[str, int]) -> str:
    """Share solved over planning time; one step line a series.

    Args:
        times: series -> planning times of what was solved [s].
        total: series -> how many were tried.
    """

    def draw(axes: Axes) -> None:
        end = 1.03 * max((value for values in times.values() for value in values), default=1.0)
        for color, (name, values) in zip(COLORS * 9, times.items(), strict=False):
            ordered = sorted(values)
            shares = [100.0 * (i + 1) / total[name] for i in range(len(ordered))]
            axes.step(
                [0.0, *ordered, end], [0.0, *shares, (shares or [0.0])[-1]], where="post", label=name, color=color
            )
        axes.set(xlabel="planning time [s]", ylabel="solved [%]", ylim=(0, 103))
        axes.set_xlim(0, end)
        if len(times) > 1:
            axes.legend(frameon=False)

    return plot(draw)


def boxes(groups: Mapping[str, Sequence[float]], label: str) -> str:
    """One box a group, with every value as a point."""

    def draw(axes: Axes) -> None:
        values = [list(group) for group in groups.values()]
        axes.boxplot(values, orientation="horizontal", showfliers=False, medianprops={"color": COLORS[1]})
        for row, group in enumerate(values, start=1):
            axes.plot(group, [row] * len(group), "o", color=COLORS[0], alpha=0.5, markersize=3)
        axes.set_yticks(range(1, len(groups) + 1), list(groups))
        axes.set(xlabel=label)
        axes.set_xlim(left=0)

    return plot(draw, height=0.9 + 0.28 * len(groups))


def bars(values: Mapping[str, float], label: str) -> str:
    """Horizontal bars, the first on top."""

    def draw(axes: Axes) -> None:
        rows = range(len(values))
        axes.barh(list(rows), list(values.values()), color=COLORS[0])
        axes.set_yticks(list(rows), list(values))
        axes.invert_yaxis()
        axes.set(xlabel=label)

    return plot(draw, height=0.9 + 0.22 * len(values))


def differences(comparisons: Sequence[Comparison]) -> str:
    """Each measure's difference from the first one with its interval, beside a line at no difference."""
    measures = list(dict.fromkeys(row.measure.name for c in comparisons for row in c.rows if row.difference.count))

    def draw(figure: Figure) -> None:
        for place, name in enumerate(measures, start=1):
            axes = figure.add_subplot(len(measures), 1, place)
            axes.spines[["top", "right", "left"]].set_visible(False)
            _draw_differences(axes, {c.other: row for c in comparisons for row in c.rows if row.measure.name == name})
            axes.set_title(name, loc="left", fontsize=9)

    return svg(draw, height=len(measures) * (0.75 + 0.2 * len(comparisons)))


def _draw_differences(axes: Axes, rows: Mapping[str, Row]) -> None:
    for place, row in enumerate(rows.values()):
        color = {"better": COLORS[2], "worse": COLORS[3]}.get(row.verdict, COLORS[6])
        axes.plot([row.difference.lower, row.difference.upper], [place, place], color=color, linewidth=2)
        axes.plot([row.difference.mean], [place], "o", color=color)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_ylim(len(rows) - 0.5, -0.5)
