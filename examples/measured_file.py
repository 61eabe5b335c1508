"""
From a file to modes and pictures
=================================

From a file to a table of modes and a page of pictures.

Run it as ``python examples/measured_file.py RECORD PICTURE.png``. Without names it reads the record beside
this script and draws to the temporary folder.
"""

import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from suspid import identify, plot_identification, read_record

given = sys.argv[1:]
path = Path(given[0]) if given else Path(__file__).with_name("quarter_car.csv")
picture = Path(given[1]) if len(given) > 1 else Path(tempfile.mkdtemp(), f"{path.stem}.png")

# The column of time is found by its name; all other columns are channels and are used together.
record = read_record(path)

# How many modes there are is left open: those that stand out above the noise are found.
identification = identify(record)
print(identification)

# A fit that explains little says that the record is no free decay, or that modes are missing.
worst = identification.explained.min()
print(
    f"\nat least {100 * worst:.1f} % of every channel is explained" + ("" if worst > 0.9 else ": look at the picture")
)

page = plot_identification(identification, Figure(figsize=(8.27, 11.69)))
page.savefig(picture, dpi=120)
print(f"drawn to {picture}")
