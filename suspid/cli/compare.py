"""The command that compares two results: springs, dampers, grip and wear, or springs and dampers alone, or modes."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from suspid.cli.measured import checked_picture, save_picture
from suspid.cli.option_groups import Grouped
from suspid.cli.output import check_apart, said_warnings, say
from suspid.cli.quantities import Positive
from suspid.cli.streams import FILE, FOUND, JSON_FILE
from suspid.errors import InputError
from suspid.files import naming, parsed_json, read_text, replacing
from suspid.text_tables import TERMINAL, text_table
from suspid.toml import parsed_toml
from suspid.values import listed
from suspid.words import count

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from suspid.greybox import Estimate
    from suspid.identification import Described
    from suspid.model import Comparison, FoundParameters, ModalSet
    from suspid.performance import Grip, WearRule
    from suspid.words import Remark

    Compared: TypeAlias = ModalSet | Estimate | FoundParameters

# What files hold by the start of their format; all others are read as modes.
HELD_BY_FORMAT = {
    "suspid estimate": "an estimate",
    "suspid drive": "an estimate",
    "suspid car": "a reconstruction",
    "suspid ride": "a ride",
    "suspid grip": "a grip",
    "suspid tune": "a tuning",
    "suspid damper": "the curve of a damper",
    "suspid compare": "a comparison",
}
# Kinds whose springs and dampers are compared with each other.
SPRINGS = {"an estimate", "a reconstruction"}


@click.command("compare", cls=Grouped)
@click.argument("before", type=FOUND, nargs=-1, required=True, metavar="BEFORE...")
@click.argument("after", type=FOUND)
@click.option(
    "--damper-std",
    type=Positive("share"),
    metavar="SHARE",
    help="Standard deviation of one damper from drive to drive. [0.03]",
)
@click.option("--load-std", type=Positive("share"), metavar="SHARE", help="Standard deviation of the load. [0.1]")
@click.option(
    "--nominal-std",
    type=Positive("share"),
    metavar="SHARE",
    help="Relative standard deviation of springs and dampers that were not estimated, such as those of tires.",
)
@click.option("--plot", type=FILE, metavar="FILE", help="Write a picture of before and after (.png, .svg, .pdf).")
@click.option("--json", "json_file", type=JSON_FILE, metavar="FILE", help="Write changes, grip and verdicts as JSON.")
def compare_command(
    before: tuple[Path, ...],
    after: Path,
    damper_std: float | None,
    load_std: float | None,
    nominal_std: float | None,
    plot: Path | None,
    json_file: Path | None,
) -> None:
    """Compare the result AFTER with the result BEFORE.

    Both are the JSON of `suspid estimate` or `suspid drive`: shows the change of every spring and damper, the grip
    before and after, and whether each damper is good, to be watched, or worn. Several BEFORE, in order of time, are a
    history: with six or more, their own scatter is used. With the JSON of `suspid reconstruct` it shows which springs
    and dampers differ by more than their intervals, with that of `suspid identify` which modes, and with that of
    `suspid report` both. --plot draws the intervals of both.
    """
    from suspid.identification import to_json
    from suspid.model import compare
    from suspid.reporting import comparison_to_dict

    check_apart([*before, after], [plot, json_file])
    with (
        replacing(checked_picture(plot)) if plot else nullcontext() as figure_draft,
        replacing(json_file) if json_file else nullcontext() as json_draft,
        said_warnings(),
    ):
        kind = _kind(after)
        for path in before:
            if _kind(path) != kind and {_kind(path), kind} != SPRINGS:
                raise InputError(f"{path} holds {_kind(path)} and {after} {kind}: compare results of one kind")
        if kind not in (*SPRINGS, "modes"):
            raise InputError(
                f"{after} and {before[0]} each hold {kind}; give results of suspid estimate, drive, reconstruct or "
                f"identify"
            )
        if kind == "an estimate" and all(_kind(path) == kind for path in before):
            from suspid.performance import wear
            from suspid.reporting import read_curves, read_estimate, wear_to_dict

            rule = _rule(damper_std, load_std)
            earlier = [read_estimate(path) for path in before]
            found = wear(
                read_estimate(after),
                before=earlier,
                curves=read_curves(after),
                curves_before=[read_curves(path) for path in before],
                rule=rule,
                nominal_std=nominal_std,
            )
            text, content = str(found), wear_to_dict(found)
            if figure_draft:
                save_picture(partial(_draw_estimates, earlier[-1], read_estimate(after), found.after), figure_draft)
        else:
            what, stated = (
                ("modes", "modes, which have") if kind == "modes" else ("reconstructions", "values that have")
            )
            if len(before) > 1:
                raise click.UsageError(f"Compare the {what} of two results at a time.")
            unused = {"--damper-std": damper_std, "--load-std": load_std, "--nominal-std": nominal_std}
            if given := [name for name, value in unused.items() if value is not None]:
                raise click.UsageError(
                    f"{after} and {before[0]} hold {stated} their own standard deviations; leave out "
                    f"{listed(given)}, meant for estimates from drives."
                )
            sides, remarks = _sides(after, before[0])
            compared = replace(compare(*sides), remarks=remarks)
            reported = [_reported(path) for path in (after, before[0])] if kind == "modes" else []
            if len(reported) == 2 and reported[0] is not None and reported[1] is not None:
                springs = compare(reported[0], reported[1])
                compared = replace(compared, table=(*compared.table, *springs.table))
            text, content = changes_in_words(compared), comparison_to_dict(compared)
            if figure_draft:
                # Half a page [inch].
                save_picture(partial(_draw, sides), figure_draft, size=(8.27, 5.8))
        if json_draft:
            json_draft.write_text(to_json(content), encoding="utf-8")
    say(text)


def _draw_estimates(before: Estimate, after: Estimate, grip: Grip | None, figure: Figure) -> None:
    """Draw springs and dampers before and after, and below them the grip after of a car with wheels."""
    from suspid.reporting import plot_comparison, plot_grip

    if grip is None:
        plot_comparison(before, after, figure)
        return
    # Subfigures draw as figures do; matplotlib has no common type for them.
    parts: Any = figure.subfigures(2, 1, height_ratios=[2, 3])
    upper, lower = parts
    plot_comparison(before, after, upper)
    plot_grip(grip, lower)
    lower.suptitle("grip after", x=0.02, ha="left", fontsize="medium")


def _draw(sides: tuple[Compared, Compared], figure: Figure) -> None:
    from suspid.reporting import plot_comparison

    plot_comparison(sides[1], sides[0], figure)


def _sides(after: Path, before: Path) -> tuple[tuple[Compared, Compared], tuple[Remark, ...]]:
    """Return what two files are compared by; modes that depend on their amplitude at one that both met."""
    from suspid.identification import at_common_amplitudes

    if _kind(after) == _kind(before) == "modes":
        *modes, remarks = at_common_amplitudes(_described(after), _described(before))
        return (modes[0], modes[1]), remarks
    return (_springs(after), _springs(before)), ()


def _described(path: Path) -> Described:
    from suspid.identification import described_from_dict, read_content

    with naming(path):
        return described_from_dict(read_content(path))


def _springs(path: Path) -> Estimate | FoundParameters:
    """Return the springs and dampers of a file."""
    from suspid.reconstruction import parameters_from_dict
    from suspid.reporting import read_estimate

    if _kind(path) == "a reconstruction":
        with naming(path):
            return parameters_from_dict(parsed_json(read_text(path)))
    return read_estimate(path)


def _reported(path: Path) -> Estimate | FoundParameters | None:
    """Return the springs and dampers beside the modes of a report; None where it has none."""
    from suspid.reconstruction import parameters_from_dict
    from suspid.reporting import estimate_from_dict

    if path.suffix.lower() == ".toml":
        return None
    with naming(path):
        content = parsed_json(read_text(path))
        for name, read in (("estimate", estimate_from_dict), ("reconstruction", parameters_from_dict)):
            found = content.get(name)
            if isinstance(found, dict):
                return read(found)
    return None


def _kind(path: Path) -> str:
    """Return what a file has, by its format; the files themselves are checked by their readers."""
    with naming(path):
        if path.suffix.lower() == ".toml":
            if {"masses", "quarter_car", "half_car", "full_car"} & set(parsed_toml(read_text(path))):
                raise InputError("is a car, not a result: write its modes with `suspid modes CAR --json FILE`")
            return "modes"
        text = read_text(path)
        try:
            form = parsed_json(text).get("format")
        except InputError as error:
            way = "" if path.suffix.lower() == ".json" else ", as `suspid identify RECORD --json FILE` does"
            raise InputError(f"{error.message}{way}") from None
    return next((kind for start, kind in HELD_BY_FORMAT.items() if str(form).startswith(start)), "modes")


def _rule(damper_std: float | None, load_std: float | None) -> WearRule:
    from suspid.performance import WearRule

    given = {"damper_std": damper_std, "load_std": load_std}
    return replace(WearRule(), **{name: value for name, value in given.items() if value is not None})


def changes_in_words(found: Comparison) -> str:
    """Return what changed between two results, of which one came before the other, as a table.

    Examples
    --------
    >>> from suspid import ModalSet, compare
    >>> before, after = ModalSet.from_wn_zeta([10.0], [0.6]), ModalSet.from_wn_zeta([10.0], [0.8])
    >>> print(changes_in_words(compare(after, before, rtol=0.01)))
    1 of 2 values changed (no change: within 0.01 relative)
              quantity    before    after    change    by chance ±    changed
    ------  ----------  --------  -------  --------  -------------  ---------
    mode 1  wn [rad/s]        10       10        +0            0.1         no
    mode 1    zeta [1]       0.6      0.8      +0.2          0.006        yes
    """
    said = {"ok": "no", "off": "yes", "missing": "gone", "extra": "new"}
    rows = found.table
    number = sum(row.verdict != "ok" for row in rows)
    columns = {
        "": [row.item.replace("found", "new") for row in rows],
        "quantity": [f"{row.quantity} [{row.unit}]" for row in rows],
        "before": ["" if row.expected is None else f"{row.expected:.8g}" for row in rows],
        "after": ["" if row.found is None else f"{row.found:.8g}" for row in rows],
        "change": ["" if row.error is None else f"{row.error:+.2g}" for row in rows],
        "by chance ±": ["" if row.error is None else f"{row.allowed:.2g}" for row in rows],
        "changed": [said[row.verdict] for row in rows],
    }
    changed = f"{number} of {count(len(rows), 'value')} changed" if number else "no value changed"
    parts = [
        f"{changed} (no change: within {found.rule.removeprefix('allowed: ')})",
        text_table(columns, widest=TERMINAL),
    ]
    if found.mac is not None:
        parts.append(f"MAC of each mode before with its partner after: {', '.join(f'{m:.6f}' for m in found.mac)}")
    return "\n".join([*parts, *map(str, found.remarks)])
