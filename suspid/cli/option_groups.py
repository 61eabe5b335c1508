"""Options by what they are for: the headings of long helps and of the manual's page of options."""

from __future__ import annotations

from collections.abc import Iterable

import click

# What options are for, in the order of the work, and their names without the two lines.
GROUPS = {
    "Record": "time fs dbc test channel without rename scale vertical si",
    "Part of the record": "from to decay",
    "Modes": "modes method band",
    "Car": (
        "car given added free-mass fixed bound tie constraint nominal-std gain delay mount noisy linearise "
        "tolerance no-search"
    ),
    "Road and drive": (
        "road speed speed-unit wheel-radius behind longitudinal lateral least-speed most-braking most-cornering "
        "shortest"
    ),
    "Simulation": "duration impulse initial sweep step input snr seed digits",
    "Ride, grip and tuning": "weighting clearance sensitivities load amplitude parameter objective limit points robust",
    "Limits and comparison": "limits before damper-std load-std",
    "Fleet": "drives table vehicle-from summary workers scheduler time-limit chunk",
    "Output": "output page format plot json csv level title date",
}
# Options that are read at a glance: a help with more has headings.
MOST_TOGETHER = 10


def by_group(options: Iterable[click.Option]) -> dict[str, list[click.Option]]:
    """Return options by what they are for; those of none, such as --help, stand last, below an empty heading.

    Examples
    --------
    >>> found = by_group([click.Option(["--json"]), click.Option(["--fs"]), click.Option(["--help"])])
    >>> [(heading, [option.opts[0] for option in some]) for heading, some in found.items()]
    [('Record', ['--fs']), ('Output', ['--json']), ('', ['--help'])]
    """
    headings = {f"--{name}": heading for heading, names in GROUPS.items() for name in names.split()}
    found: dict[str, list[click.Option]] = {heading: [] for heading in (*GROUPS, "")}
    for option in options:
        found[headings.get(option.opts[-1], "")].append(option)
    return {heading: some for heading, some in found.items() if some}


class Grouped(click.Command):
    """A command whose help has its options by what they are for, where they are many."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options."""
        options = [one for one in self.get_params(ctx) if isinstance(one, click.Option)]
        if len(options) <= MOST_TOGETHER:
            super().format_options(ctx, formatter)
            return
        for heading, some in by_group(options).items():
            lines = [line for option in some if (line := option.get_help_record(ctx)) is not None]
            with formatter.section(heading or "Help"):
                formatter.write_dl(lines)
