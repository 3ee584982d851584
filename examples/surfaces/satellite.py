"""Drag area of a satellite with two panels, and the lever of its centre, as it turns in the stream."""

import matplotlib.pyplot as plt
import numpy as np
import umbrage_surfaces as us
from shapes import box, join, save

# A body of 1 x 1 x 2 m and two panels, one of which is half open. Any direction is a "sun": here that of flight.
panels = [box(0.9, -0.01, -0.75, 3, 0.02, 1.5), box(-2.4, -0.01, -0.75, 1.5, 0.02, 1.5)]
facets = us.Facets(*join(box(-0.5, -0.5, -1, 1, 1, 2), *panels), unit="m", sides="front", certify=True)
turns = np.linspace(0, 360, 181)
figure, axes = plt.subplots()
for height in (0, 30, 60):
    flight = us.directions(turns, np.full(len(turns), height))
    answer = facets.lit_area(flight)
    area = answer.projected_m2.sum(axis=1)
    centre = (answer.projected_m2[..., None] * answer.centroid_m).sum(axis=1) / area[:, None]
    # The torque of free molecules is the pressure times area times this lever, across the flight.
    lever = np.linalg.norm(np.cross(centre, flight), axis=1)
    axes.plot(turns, area, label=f"{height} degrees up")
    print(f"{height:2} up: area {area.min():.4f} to {area.max():.4f} m2, lever at most {lever.max():.2e} m")
    print(f"  stated: {answer.stated}")
axes.set(xlabel="yaw, degrees", ylabel="drag area, m2", title="Satellite with two panels")
axes.legend()
save(figure, "satellite.png")
