//! What a comparison finds: plain data, written to `results.json` as it stands.

use crate::footprint::MapUse;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Work,
    metrics::{Agreement, Causes, Errors},
};

/// Version of this data's shape; grows with every change that a reader would notice.
pub const SCHEMA: u32 = 5;

/// A whole comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// [`SCHEMA`] when it was written.
    pub schema: u32,
    /// Where and with what it was made.
    pub environment: Environment,
    /// What the reader must know: a missing adapter, say.
    pub notices: Vec<String>,
    /// One entry a scene, in the order compared.
    pub scenes: Vec<SceneResult>,
}

impl Comparison {
    /// What must not be: decided pixels on which backends differ, and negative controls without effect. One line each.
    pub fn faults(&self) -> Vec<String> {
        self.scenes.iter().flat_map(SceneResult::faults).collect()
    }
}

/// Where and with what a comparison was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Version of umbrage.
    pub version: String,
    /// The working tree's commit, with `+` if files were changed since; none outside a repository.
    pub commit: Option<String>,
    /// Coordinated universal time, `2026-11-21 03:45`; none of a comparison that is to come out the same whenever it is made.
    pub date: Option<String>,
    /// The processor's name.
    pub cpu: String,
    /// Threads used.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The graphics adapter; none if there is none or it wasn't asked for.
    pub adapter: Option<String>,
    /// How it rounds vertices, in words; none without it.
    #[serde(default)]
    pub snapping: Option<String>,
    /// Names of the backends compared.
    pub backends: Vec<String>,
}

/// One scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// The scene's name.
    pub name: String,
    /// One line about it, maybe empty.
    pub summary: String,
    /// Kind of the light compared.
    pub light: String,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Triangles in all.
    pub triangles: u64,
    /// Tells the triangles apart from others, hexadecimal.
    pub fingerprint: String,
    /// How truth was made.
    pub truth: TruthSummary,
    /// RMSE of a mask that is lit everywhere, and of one that is dark everywhere.
    pub rmse_of_none: [f64; 2],
    /// One entry a technique setting and backend.
    pub rows: Vec<Row>,
    /// One entry a backend.
    pub controls: Vec<Control>,
}

impl SceneResult {
    fn faults(&self) -> Vec<String> {
        let mut out = Vec::new();
        for row in &self.rows {
            out.extend(row.measured().and_then(|m| m.agreement).and_then(disagreement).map(|what| {
                let (scene, row) = (&self.name, row.label());
                format!("{scene}: {row}: {what}")
            }));
            let colors = row.measured().and_then(|m| m.color_differing).unwrap_or(0);
            if colors > 0 {
                out.push(format!(
                    "{}: {}: the colours of {colors} pixels differ from the CPU's",
                    self.name,
                    row.label()
                ));
            }
        }
        for c in self.controls.iter().filter(|c| !c.holds) {
            let why = match c.dark_without {
                0 => "the mask stays the same".to_owned(),
                n => format!("{n} pixels of the mask stay dark"),
            };
            out.push(format!("{}: {} {}: without casters {why}", self.name, c.backend, c.technique));
        }
        out
    }
}

/// What is wrong with an agreement, if anything is.
fn disagreement(a: Agreement) -> Option<String> {
    if !a.holds() {
        return Some(format!("{} decided pixels differ from the CPU's", a.violations));
    }
    if !a.is_accurate() {
        return Some(format!("RMSE is {:.4} above that of the CPU's mask at the same pixels", a.excess));
    }
    let (undecided, compared) = (a.undecided, a.compared);
    let why = format!("rounding alone lets {undecided} of {compared} pixels differ from the CPU's: too many");
    (!a.is_decided()).then_some(why)
}

/// How truth was made and how sure it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthSummary {
    /// Rays a receiver; more in penumbra.
    pub samples: u32,
    /// Mean standard error over the pixels that count.
    pub mean_error: f32,
    /// Greatest standard error.
    pub largest_error: f32,
    /// Pixels that count.
    pub counted: u64,
    /// Pixels left out as ambiguous.
    pub ambiguous: u64,
    /// Pixels left out as facing away from the light or outside its cone.
    pub unlit: u64,
    /// Seconds it took; none without times.
    pub seconds: Option<f64>,
}

/// One technique setting on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The technique's name.
    pub technique: String,
    /// Its settings in words.
    pub settings: String,
    /// A file name's stem that no other row of this technique has: `pcf` or `pcf-3x3-1024-slope`.
    pub slug: String,
    /// Kind of backend, `cpu` or `wgpu`.
    pub backend: String,
    /// What came of it.
    pub outcome: Outcome,
}

impl Row {
    /// The figures, if there are any.
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(m) => Some(m),
            Outcome::Unsupported { .. } => None,
        }
    }

    /// A file name's stem that no other row of its scene has.
    pub fn stem(&self) -> String {
        format!("{}.{}", self.slug, self.backend)
    }

    /// For people: `pcf (3x3, 1024, slope) on wgpu`.
    pub fn label(&self) -> String {
        format!("{} ({}) on {}", self.technique, self.settings, self.backend)
    }
}

/// What came of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was rendered and measured.
    Measured(Box<Measured>),
    /// The technique or the backend isn't made for this.
    Unsupported {
        /// Why.
        reason: String,
    },
}

/// A row's figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Against truth.
    pub errors: Errors,
    /// What the errors come from.
    pub causes: Causes,
    /// Times, without compilation, upload and read-back; none if they weren't asked for.
    pub times: Option<Times>,
    /// What the recipe takes, counted.
    pub work: Work,
    /// What that costs by the [prices](crate::cost::CostModel::of) of this kind of backend, milliseconds: the same on every
    /// run.
    pub cost_ms: f64,
    /// Bytes held for images, tables and receivers.
    pub bytes: u64,
    /// Against the CPU's mask; none on the CPU or without it.
    pub agreement: Option<Agreement>,
    /// Pixels whose colour differs from the first backend's by more than a step of 255 though the masks agree; none
    /// without colours, and for the first backend.
    pub color_differing: Option<u64>,
    /// How the maps are used: the same on every backend; none without maps.
    pub maps: Option<MapUse>,
}

impl Measured {
    /// The median of the times, milliseconds, or the cost; none if it wasn't measured.
    pub fn milliseconds(&self, clock: Clock) -> Option<f64> {
        match clock {
            Clock::Wall => self.times.map(|t| t.total.median),
            Clock::Cost => Some(self.cost_ms),
        }
    }
}

/// Two ways to tell what a row takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Clock {
    /// Measured: true of this machine at that moment.
    Wall,
    /// Counted and priced: the same on every run.
    Cost,
}

/// How long the stages took; none where a stage is not played or not measurable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// All casts.
    pub cast: Option<Spread>,
    /// All filters.
    pub filter: Option<Spread>,
    /// The lookup.
    pub receive: Option<Spread>,
    /// Casts, filters and lookup of each run together.
    pub total: Spread,
}

/// Times of several runs, milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half of the runs took longer.
    pub median: f64,
    /// The quickest run.
    pub least: f64,
    /// The slowest run.
    pub greatest: f64,
    /// How many runs.
    pub runs: u32,
}

impl Spread {
    /// Of times in milliseconds; none of no times.
    pub fn of(mut times: Vec<f64>) -> Option<Self> {
        times.sort_by(f64::total_cmp);
        let n = times.len();
        let (least, greatest) = (*times.first()?, *times.last()?);
        Some(Self { median: (times[(n - 1) / 2] + times[n / 2]) / 2.0, least, greatest, runs: n as u32 })
    }
}

/// The negative control of one backend: with the casters removed, the mask must change wherever it was dark.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Kind of backend.
    pub backend: String,
    /// The technique that was played.
    pub technique: String,
    /// Counted pixels from which casters hide more than a quarter of the light, says truth.
    pub shadowed: u64,
    /// Those of them whose mask brightened by more than a quarter when the casters were removed.
    pub changed: u64,
    /// Counted pixels that are dark without casters: not fully lit in a map's mask, darker by half than what their own
    /// horizon leaves in a traced one. Must be 0.
    pub dark_without: u64,
    /// Whether the control did what it must: something changed if truth has a shadow, and nothing is left dark.
    pub holds: bool,
}
