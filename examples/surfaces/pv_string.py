"""How much of a string of PV modules is lit over a year, behind a row of the same height? Suns by pvlib."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pvlib
import umbrage_surfaces as us
from shapes import grid, join, save

# Two rows of 20 m x 2 m at 30 degrees, 4 m apart, facing south. The second is a string of 10 modules.
TILT = np.radians(30)
slope = [0, 2 * np.cos(TILT), 2 * np.sin(TILT)]
rows = [grid([0, y, 0.5], [20, 0, 0], slope, 10, 1) for y in (0, 4)]
facets = us.Facets(*join(*rows), unit="m", sides="both")
times = pd.date_range("2026-01-01", "2027-01-01", freq="30min", tz="Europe/Berlin")
sun = pvlib.solarposition.get_solarposition(times, 48.1, 11.6)
sun = sun[sun.elevation > 0]
towards = us.directions(sun.azimuth, sun.elevation)
lit = facets.lit_area(towards)
string = lit.fraction[:, 20:].reshape(len(sun), 2, 10).mean(axis=1)  # two triangles a module
in_front = towards @ [0, -np.sin(TILT), np.cos(TILT)] > 0
# The worst module limits a string in series; the mean is that of optimizers.
table = pd.DataFrame({"worst": string.min(axis=1), "mean": string.mean(axis=1)}, index=sun.index)[in_front]
months = table.groupby(table.index.month).mean()
print(months.round(3), f"\nstated: {lit.stated}")
figure, axes = plt.subplots()
months.plot.bar(ax=axes, xlabel="month", ylabel="lit share, sun in front", title="Second row of PV modules, 48.1 N")
save(figure, "pv_string.png")
