//! One number turned from too little to too much: bias, light angle, scale, distance from the origin, map size.

mod bias;
mod chart;
mod reach;
mod variants;

use super::{Options, guard};
use crate::{LabError, stability::Ground};
use serde::{Deserialize, Serialize};
use umbrage_core::{Backend, ShadowTechnique};

pub use variants::{moved, scaled, under_sun};

/// A chart's data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// For file names.
    pub name: String,
    /// For people.
    pub title: String,
    /// What is turned, with its unit.
    pub x: String,
    /// What is measured, with its unit.
    pub y: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// The best value of x, where there is one.
    pub best: Option<f64>,
    /// The value of y up to which all is well, where there is one.
    pub limit: Option<f64>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Its name.
    pub label: String,
    /// Points, x growing.
    pub points: Vec<[f64; 2]>,
}

/// Runs all sweeps on one backend.
///
/// # Errors
/// When a scene can't be used, or a technique gives what it must not.
pub fn sweeps(
    options: &Options,
    backend: &mut dyn Backend,
    on_sweep: &mut dyn FnMut(&str),
) -> Result<Vec<Sweep>, LabError> {
    let mut out = Vec::new();
    for kind in bias::ALL {
        on_sweep(kind.name);
        out.push(bias::sweep(kind, options, backend)?);
    }
    for kind in reach::ALL {
        on_sweep(kind.name);
        out.push(reach::sweep(kind, options, backend)?);
    }
    Ok(out)
}

impl Sweep {
    /// The chart as an SVG that opens alone.
    pub fn svg(&self) -> String {
        chart::svg(self)
    }

    /// The curves' points: `curve,x,y`.
    ///
    /// # Errors
    /// When memory runs out.
    pub fn csv(&self) -> Result<Vec<u8>, LabError> {
        let mut out = csv::Writer::from_writer(Vec::new());
        let failed = |source| LabError::Write { path: self.name.clone().into(), source };
        out.write_record(["curve", &self.x, &self.y]).map_err(|e| failed(e.into()))?;
        for curve in &self.curves {
            for [x, y] in &curve.points {
                let record = [curve.label.clone(), x.to_string(), y.to_string()];
                out.write_record(record).map_err(|e| failed(e.into()))?;
            }
        }
        out.into_inner().map_err(|e| failed(e.into_error()))
    }
}

/// A technique's mask under the ground's first light; none where it isn't made for that.
///
/// # Errors
/// When it gives what it must not.
fn mask(
    ground: &Ground,
    technique: &dyn ShadowTechnique,
    backend: &mut dyn Backend,
) -> Result<Option<Vec<f32>>, LabError> {
    let view = ground.view(&ground.lights[0]).with_receivers(&ground.truth.receivers);
    let played = guard::plan(technique, &view).and_then(|recipe| guard::render(backend, &view, &recipe));
    match played {
        Ok(shadows) => Ok(Some(shadows.mask)),
        Err(guard::NoMask::Unsupported(_)) => Ok(None),
        Err(guard::NoMask::Fault(what)) => Err(LabError::NotComparable {
            scene: ground.scene.name.clone(),
            what: format!("{}: {what}", technique.name()),
        }),
    }
}
