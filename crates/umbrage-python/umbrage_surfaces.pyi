"""Sunlight of triangles as numbers, each answer with its stated error."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

def directions(azimuths: Floats, heights: Floats, up: Literal["y", "z"] = "z") -> Floats: ...
def set_threads(count: int) -> None: ...

class Facets:
    def __init__(
        self,
        vertices: Floats,
        triangles: NDArray[np.uint32],
        *,
        up: Literal["y", "z"] = "z",
        unit: str | None = None,
        sides: Literal["front", "both"] = "both",
        max_error_m: float = 1e-5,
        certify: bool = False,
    ) -> None: ...
    def __len__(self) -> int: ...
    @property
    def areas_m2(self) -> Floats: ...
    @property
    def margin_m(self) -> float: ...
    def lit_area(self, suns: Floats) -> LitAreas: ...
    def lit(self, suns: Floats, points: Floats | None = None, normals: Floats | None = None) -> Lit: ...
    def sun_hours(
        self,
        seconds: Floats,
        suns: Floats,
        points: Floats | None = None,
        normals: Floats | None = None,
        *,
        step_s: float = 60.0,
        bisect_s: float = 1.0,
        windows: list[tuple[float, float]] | None = None,
        half_disc: bool = False,
        refraction: bool = False,
    ) -> SunHours: ...

class Stated:
    undecided: int
    undecided_rows: list[tuple[int, int]]
    margin_m: float
    identity: float | None
    step_s: float | None
    bisected_s: float | None
    hash: int
    text: str

class LitAreas:
    fraction: Floats
    area_m2: Floats
    projected_m2: Floats
    centroid_m: Floats
    stated: Stated

class Lit:
    is_lit: NDArray[np.bool_]
    stated: Stated

class SunHours:
    minutes: Floats
    longest_minutes: Floats
    spans_s: list[list[list[float]]]
    stated: Stated
