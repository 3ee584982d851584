//! Python module `umbrage_surfaces`: arrays in, arrays out, without the interpreter's lock.

use numpy::{
    IntoPyArray as _, PyArray1, PyArray2, PyArray3, PyArrayMethods as _, PyReadonlyArray1,
    PyReadonlyArray2,
};
use pyo3::{exceptions::PyValueError, prelude::*};
use umbrage_surfaces::{
    Day, Disc, Options, Points, Suns, Up, direction_at,
    glam::{DVec3, dvec3},
    metres_of_unit,
};

/// Returns the error of a value.
fn value_error(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Reads an array of n x 3.
fn vectors(name: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<DVec3>> {
    let view = array.as_array();
    if view.ncols() != 3 {
        let shape = view.shape();
        return Err(value_error(format!(
            "{name} have the shape {shape:?}; pass (n, 3)"
        )));
    }
    let rows = view.rows();
    Ok(rows
        .into_iter()
        .map(|row| dvec3(row[0], row[1], row[2]))
        .collect())
}

/// Returns unit vectors towards suns, float64 (n, 3).
///
/// `azimuths`: degrees clockwise from north, float64 (n,). `heights`: degrees above the horizon,
/// float64 (n,). With `up="z"`, y is north; with `up="y"`, -z is north.
#[pyfunction]
#[pyo3(signature = (azimuths, heights, up = "z"))]
fn directions<'py>(
    py: Python<'py>,
    azimuths: Vec<f64>,
    heights: Vec<f64>,
    up: &str,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let up: Up = up.parse().map_err(value_error)?;
    if azimuths.len() != heights.len() {
        let [a, b] = [azimuths.len(), heights.len()];
        return Err(value_error(format!(
            "{a} azimuths for {b} heights; pass as many"
        )));
    }
    let angles = azimuths.iter().zip(&heights);
    let directions = angles.map(|(&azimuth, &height)| direction_at(azimuth, height, up));
    let numbers: Vec<f64> = directions
        .flat_map(|direction| direction.to_array())
        .collect();
    numbers.into_pyarray(py).reshape([heights.len(), 3])
}

/// Sets the number of threads, once and before the first answer. Answers don't depend on it.
#[pyfunction]
fn set_threads(count: usize) -> PyResult<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(value_error)
}

/// Accuracy of an answer. `str` gives one line.
///
/// `undecided`: answers that may change if a coordinate moves by `margin_m` metres.
/// `undecided_rows`: the first 1,000 as (sun, row). `identity`: greatest relative error of the sum
/// of areas, with `certify`. `step_s`, `bisected_s`: seconds. `hash`: of all numbers of the answer.
#[pyclass(frozen, get_all, module = "umbrage_surfaces")]
#[derive(Clone)]
struct Stated {
    undecided: u64,
    undecided_rows: Vec<(u32, u32)>,
    margin_m: f64,
    identity: Option<f64>,
    step_s: Option<f64>,
    bisected_s: Option<f64>,
    hash: u64,
    text: String,
}

#[pymethods]
impl Stated {
    fn __repr__(&self) -> String {
        self.text.clone()
    }
}

impl From<umbrage_surfaces::Stated> for Stated {
    fn from(stated: umbrage_surfaces::Stated) -> Self {
        Self {
            text: stated.to_string(),
            undecided: stated.undecided,
            undecided_rows: stated.undecided_rows,
            margin_m: stated.margin_m,
            identity: stated.identity,
            step_s: stated.step_s,
            bisected_s: stated.bisected_s,
            hash: stated.hash,
        }
    }
}

/// Lit areas: float64 (suns, facets).
///
/// `fraction`: 0 to 1. `area_m2`, `projected_m2` (as the sun sees it): square metres.
/// `centroid_m`: centres of the lit parts, metres, (suns, facets, 3).
#[pyclass(frozen, get_all, module = "umbrage_surfaces")]
struct LitAreas {
    fraction: Py<PyArray2<f64>>,
    area_m2: Py<PyArray2<f64>>,
    projected_m2: Py<PyArray2<f64>>,
    centroid_m: Py<PyArray3<f64>>,
    stated: Stated,
}

/// Lit points: `is_lit`, bool (suns, points).
#[pyclass(frozen, get_all, module = "umbrage_surfaces")]
struct Lit {
    is_lit: Py<PyArray2<bool>>,
    stated: Stated,
}

/// Times of sun: `minutes`, `longest_minutes`, float64 (points,); `spans_s`, a list of
/// [first, last] seconds for each point.
#[pyclass(frozen, get_all, module = "umbrage_surfaces")]
struct SunHours {
    minutes: Py<PyArray1<f64>>,
    longest_minutes: Py<PyArray1<f64>>,
    spans_s: Vec<Vec<[f64; 2]>>,
    stated: Stated,
}

/// Triangles that receive and cast.
///
/// `vertices`: float64 (v, 3), any origin. `triangles`: uint32 (f, 3), rows of `vertices`.
/// `up`: "z" or "y". `unit`: "m", "cm", "mm", "km", "ft", "in", or the metres of one unit as text;
/// without it, sizes that metres make improbable are an error. `sides`: "front" needs closed
/// bodies, whose triangles are counter-clockwise from outside; "both" takes any mesh.
/// `max_error_m`: greatest accepted margin, metres. `certify`: compute `stated.identity`.
///
/// Raises ValueError, which names rows, for what has no answer.
#[pyclass(frozen, module = "umbrage_surfaces")]
struct Facets(umbrage_surfaces::Facets);

impl Facets {
    /// Returns points, or the facets' centres.
    fn points(
        &self,
        points: Option<PyReadonlyArray2<'_, f64>>,
        normals: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Points> {
        let normals = match &normals {
            Some(normals) => Some(vectors("normals", normals)?),
            None => None,
        };
        match points {
            Some(points) => {
                let points = vectors("points", &points)?;
                Points::new(&self.0, &points, normals.as_deref()).map_err(value_error)
            }
            None if normals.is_some() => Err(value_error("normals need points; pass both")),
            None => Ok(Points::centres_of(&self.0)),
        }
    }
}

#[pymethods]
impl Facets {
    #[new]
    #[pyo3(signature = (vertices, triangles, *, up = "z", unit = None, sides = "both", max_error_m = 1e-5, certify = false))]
    // One parameter for each of Python's.
    #[expect(
        clippy::too_many_arguments,
        reason = "one for each of Python's keywords"
    )]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, u32>,
        up: &str,
        unit: Option<&str>,
        sides: &str,
        max_error_m: f64,
        certify: bool,
    ) -> PyResult<Self> {
        let vertices = vectors("vertices", &vertices)?;
        let view = triangles.as_array();
        if view.ncols() != 3 {
            let shape = view.shape();
            return Err(value_error(format!(
                "triangles have the shape {shape:?}; pass (n, 3)"
            )));
        }
        let rows = view.rows().into_iter();
        let triangles: Vec<[u32; 3]> = rows.map(|row| [row[0], row[1], row[2]]).collect();
        let options = Options {
            up: up.parse().map_err(value_error)?,
            unit_m: unit.map(metres_of_unit).transpose().map_err(value_error)?,
            sides: sides.parse().map_err(value_error)?,
            max_error_m,
            certify,
        };
        let facets = py.detach(|| umbrage_surfaces::Facets::new(&vertices, &triangles, &options));
        Ok(Self(facets.map_err(value_error)?))
    }

    fn __len__(&self) -> usize {
        self.0.count()
    }

    /// Areas of the facets, square metres, float64 (f,).
    #[getter]
    fn areas_m2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let areas = (0..self.0.count()).map(|row| self.0.area_m2(row));
        areas.collect::<Vec<_>>().into_pyarray(py)
    }

    /// Greatest change of a coordinate that answers allow for, metres.
    #[getter]
    fn margin_m(&self) -> f64 {
        self.0.margin_m()
    }

    /// Returns the exact lit areas towards suns, float64 (n, 3) of any length.
    fn lit_area(&self, py: Python<'_>, suns: PyReadonlyArray2<'_, f64>) -> PyResult<LitAreas> {
        let suns = Suns::new(&vectors("suns", &suns)?).map_err(value_error)?;
        let shape = [suns.directions().len(), self.0.count()];
        let count = shape[0] * shape[1];
        let [mut fraction, mut area, mut projected] = [(); 3].map(|()| Vec::with_capacity(count));
        let mut centroid = Vec::with_capacity(3 * count);
        let stated = py.detach(|| {
            self.0.lit_area(&suns, |_, areas| {
                fraction.extend(areas.iter().map(|lit| lit.fraction));
                area.extend(areas.iter().map(|lit| lit.area));
                projected.extend(areas.iter().map(|lit| lit.projected));
                centroid.extend(areas.iter().flat_map(|lit| lit.centroid.to_array()));
            })
        });
        let table = |numbers: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
            Ok(numbers.into_pyarray(py).reshape(shape)?.unbind())
        };
        let centroid = centroid.into_pyarray(py);
        Ok(LitAreas {
            fraction: table(fraction)?,
            area_m2: table(area)?,
            projected_m2: table(projected)?,
            centroid_m: centroid.reshape([shape[0], shape[1], 3])?.unbind(),
            stated: stated.into(),
        })
    }

    /// Returns which points suns light.
    ///
    /// `suns`: float64 (s, 3). `points`: float64 (n, 3); by default the facets' centres.
    /// `normals`: float64 (n, 3); without them, light from both sides counts.
    #[pyo3(signature = (suns, points = None, normals = None))]
    fn lit(
        &self,
        py: Python<'_>,
        suns: PyReadonlyArray2<'_, f64>,
        points: Option<PyReadonlyArray2<'_, f64>>,
        normals: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Lit> {
        let suns = Suns::new(&vectors("suns", &suns)?).map_err(value_error)?;
        let points = self.points(points, normals)?;
        let lit = py.detach(|| self.0.lit(&points, &suns, |_| ()));
        let shape = [suns.directions().len(), points.count()];
        let mut bits = Vec::with_capacity(shape[0] * shape[1]);
        for sun in 0..shape[0] {
            bits.extend((0..shape[1]).map(|row| lit.is_lit(sun, row)));
        }
        Ok(Lit {
            is_lit: bits.into_pyarray(py).reshape(shape)?.unbind(),
            stated: lit.stated.into(),
        })
    }

    /// Returns the times at which points are lit.
    ///
    /// `seconds`: rising times, float64 (t,). `suns`: the Sun's directions at these times, float64
    /// (t, 3), between which it moves evenly. `points`, `normals`: as in `lit`. `step_s`: greatest
    /// distance of samples. `bisect_s`: error of times between samples that differ. `windows`: list
    /// of (first, last) seconds outside which light doesn't count. `half_disc`: lit is who sees half
    /// of the Sun's disc. `refraction`: whether `suns` include it, which is stated in the answer.
    #[pyo3(signature = (seconds, suns, points = None, normals = None, *, step_s = 60.0, bisect_s = 1.0, windows = None, half_disc = false, refraction = false))]
    #[expect(
        clippy::too_many_arguments,
        reason = "one for each of Python's keywords"
    )]
    fn sun_hours(
        &self,
        py: Python<'_>,
        seconds: PyReadonlyArray1<'_, f64>,
        suns: PyReadonlyArray2<'_, f64>,
        points: Option<PyReadonlyArray2<'_, f64>>,
        normals: Option<PyReadonlyArray2<'_, f64>>,
        step_s: f64,
        bisect_s: f64,
        windows: Option<Vec<[f64; 2]>>,
        half_disc: bool,
        refraction: bool,
    ) -> PyResult<SunHours> {
        let seconds = seconds.as_array().to_vec();
        let suns = vectors("suns", &suns)?;
        let is_rising = seconds.windows(2).all(|pair| pair[0] < pair[1]);
        if seconds.len() != suns.len() || seconds.len() < 2 || !is_rising {
            let help = "pass rising seconds, at least 2, and a direction for each";
            return Err(value_error(help));
        }
        let day = Day {
            start_s: seconds[0],
            end_s: seconds[seconds.len() - 1],
            step_s,
            bisect_s,
            windows: windows.unwrap_or_default(),
            half_of: half_disc.then(Disc::default),
            refraction,
        };
        let path = |second: f64| {
            // Interpolate between the two directions around the time.
            let next = seconds.partition_point(|&other| other <= second);
            let next = next.clamp(1, seconds.len() - 1);
            let [start, end] = [seconds[next - 1], seconds[next]];
            let share = (second - start) / (end - start);
            suns[next - 1].lerp(suns[next], share)
        };
        let points = self.points(points, normals)?;
        let hours = py.detach(|| self.0.sun_hours(&points, &path, &day, |_| ()));
        let hours = hours.map_err(value_error)?;
        let rows = 0..points.count();
        let minutes: Vec<f64> = rows.clone().map(|row| hours.minutes(row)).collect();
        let longest: Vec<f64> = rows.clone().map(|row| hours.longest_minutes(row)).collect();
        Ok(SunHours {
            minutes: minutes.into_pyarray(py).unbind(),
            longest_minutes: longest.into_pyarray(py).unbind(),
            spans_s: rows.map(|row| hours.spans(row).to_vec()).collect(),
            stated: hours.stated.into(),
        })
    }
}

/// Sunlight of triangles as numbers, each answer with its stated error.
#[pymodule(name = "umbrage_surfaces")]
mod python_module {
    #[pymodule_export]
    use super::{Facets, Lit, LitAreas, Stated, SunHours, directions, set_threads};
}
