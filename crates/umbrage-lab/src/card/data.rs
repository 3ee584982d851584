//! Measurements of a graphics adapter, as plain data.

use crate::compare::Environment;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use umbrage_core::{Backend as _, BackendError, Fusing, Invalid};
use umbrage_plan::cost::CostModel;
use umbrage_scenes::SceneEntry;
use umbrage_wgpu::{Gpu, wgpu::DeviceType};

/// Version of the data format.
pub const SCHEMA: u32 = 1;

/// Measurements of one graphics adapter. `None` means not measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// [`SCHEMA`] when it was written.
    pub schema: u32,
    /// The adapter's name.
    pub adapter: String,
    /// Driver with its version.
    pub driver: String,
    /// The graphics API: `vulkan`, `metal`, `dx12` or `gl`.
    pub api: String,
    /// Whether it is a software adapter.
    pub is_software: bool,
    /// The processor of the CPU backend, and its threads.
    pub cpu: Option<String>,
    /// Date of the measurement, `2026-11-26`.
    pub date: Option<String>,
    /// The repository's commit.
    pub commit: Option<String>,
    /// Name of the person who measured.
    pub measured_by: Option<String>,
    /// Limits of resources.
    pub limits: Option<CardLimits>,
    /// Rounding of vertices and depths in words.
    pub grid: Option<String>,
    /// Operations that it computes with one rounding.
    pub fusing: Option<Fusing>,
    /// Agreement of its masks with the CPU's.
    pub agreement: Option<CardAgreement>,
    /// Times of the representative settings of each technique, after warm-up.
    pub times: Option<Vec<CardTime>>,
    /// Times of umbrage relative to other programs on this adapter, by name of the measurement.
    pub ratios: Option<BTreeMap<String, f64>>,
    /// Prices of work for the planner.
    pub prices: Option<CostModel>,
}

/// Resource limits of an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardLimits {
    /// Maximum side of an image, texels.
    pub image_side: u32,
    /// Maximum number of image layers.
    pub layers: u32,
    /// Maximum size of a table, bytes.
    pub table_bytes: u64,
}

/// Agreement of an adapter's masks with the CPU's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CardAgreement {
    /// Number of pixels, over all scenes and techniques, where both backends see the same triangle.
    pub same_triangle_pixels: Option<u64>,
    /// Number of pixels, over all scenes and techniques, where they see different triangles.
    pub other_triangle_pixels: Option<u64>,
    /// `same_triangle_pixels` by technique. `None` in older files.
    pub compared_pixels: Option<BTreeMap<String, u64>>,
    /// Number of these pixels with different bits, by technique. Techniques without such pixels are
    /// omitted.
    pub differing_bits: BTreeMap<String, u64>,
    /// Number of compared masks of all techniques.
    pub masks: Option<u64>,
    /// Number of their pixels that differ beyond rounding.
    pub decided_pixels_off: Option<u64>,
    /// Faults, one line each.
    pub findings: Vec<String>,
}

/// The time of a setting in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CardTime {
    /// The scene, with its image size.
    pub frame: String,
    /// The technique.
    pub technique: String,
    /// Settings of the technique.
    pub settings: String,
    /// Time at the adapter's full clock, milliseconds. `None` if no yardstick was steady.
    pub milliseconds: Option<f64>,
    /// Measured median time, milliseconds.
    pub measured_milliseconds: f64,
}

impl Card {
    /// Returns the data that an adapter reports, with results of small probes.
    ///
    /// # Errors
    /// Errors if the device fails.
    pub fn of_adapter(gpu: &Gpu) -> Result<Self, BackendError> {
        let info = gpu.adapter_info();
        let limits = gpu.limits();
        let fusing = gpu.fusing()?;
        let here = Environment::of_this_machine(true);
        let day = here
            .date
            .and_then(|date| Some(date.split_once(' ')?.0.to_owned()));
        Ok(Self {
            schema: SCHEMA,
            adapter: info.name,
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            api: info.backend.to_string(),
            is_software: info.device_type == DeviceType::Cpu,
            cpu: Some(format!("{}, {} threads", here.cpu, here.threads)),
            date: day,
            commit: here.commit,
            limits: Some(CardLimits {
                image_side: limits.image_side,
                layers: limits.layers,
                table_bytes: limits.table_bytes,
            }),
            grid: Some(gpu.snapping().to_string()),
            fusing: Some(fusing),
            ..Self::default()
        })
    }

    /// Returns the faults of the adapter or its masks, one line each.
    pub fn findings(&self) -> Vec<String> {
        let fusing = self
            .fusing
            .filter(|fusing| fusing.guarded_product == Some(true));
        let fused = fusing.map(|fusing| format!("masks may be wrong: {fusing}"));
        let found = self.agreement.iter().flat_map(|a| &a.findings);
        fused.into_iter().chain(found.cloned()).collect()
    }
}

/// Returns a built-in scene.
pub(super) fn built_in(name: &str) -> Result<&'static SceneEntry, Invalid> {
    umbrage_scenes::find(name).ok_or_else(|| {
        let help = "use a name that `cargo xtask compare --list` prints";
        Invalid::new(format!("scene `{name}`"), "is not built in", help)
    })
}
