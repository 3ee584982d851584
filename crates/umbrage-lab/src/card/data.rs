//! What was measured on a graphics adapter, as plain data.

use crate::compare::Environment;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use umbrage_core::{Backend as _, BackendError, Fusing, Invalid};
use umbrage_plan::cost::CostModel;
use umbrage_scenes::SceneEntry;
use umbrage_wgpu::{Gpu, wgpu::DeviceType};

/// Version of this data's format.
pub const SCHEMA: u32 = 1;

/// What was measured on one graphics adapter. `None` means that nobody measured it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// [`SCHEMA`] when it was written.
    pub schema: u32,
    /// The adapter's name.
    pub adapter: String,
    /// Its driver, with version.
    pub driver: String,
    /// The graphics API: `vulkan`, `metal`, `dx12` or `gl`.
    pub api: String,
    /// Whether the CPU does the adapter's work.
    pub is_software: bool,
    /// The processor that the CPU backend ran on, and its threads.
    pub cpu: Option<String>,
    /// Day of the measurement, `2026-11-26`.
    pub date: Option<String>,
    /// The repository's commit.
    pub commit: Option<String>,
    /// Who measured.
    pub measured_by: Option<String>,
    /// What it can hold.
    pub limits: Option<CardLimits>,
    /// How it rounds vertices and depths, in words.
    pub grid: Option<String>,
    /// What it computes with one rounding.
    pub fusing: Option<Fusing>,
    /// How its masks compare with the CPU's.
    pub agreement: Option<CardAgreement>,
    /// Times of the settings that stand for each technique, warm.
    pub times: Option<Vec<CardTime>>,
    /// Times of umbrage over times of others, on this adapter, by what was timed.
    pub ratios: Option<BTreeMap<String, f64>>,
    /// Prices of work for the planner.
    pub prices: Option<CostModel>,
}

/// What an adapter can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardLimits {
    /// Greatest image side, texels.
    pub image_side: u32,
    /// Most layers of an image.
    pub layers: u32,
    /// Greatest table, bytes.
    pub table_bytes: u64,
}

/// How an adapter's masks compare with the CPU's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CardAgreement {
    /// Pixels, over scenes and techniques, where both backends see the same triangle.
    pub same_triangle_pixels: Option<u64>,
    /// Pixels, over scenes and techniques, where they see different ones.
    pub other_triangle_pixels: Option<u64>,
    /// The former by technique. `None` in files from before it was kept.
    pub compared_pixels: Option<BTreeMap<String, u64>>,
    /// Of these, those whose bits differ, by technique. Techniques without such pixels are left
    /// out.
    pub differing_bits: BTreeMap<String, u64>,
    /// Masks of all techniques that were compared.
    pub masks: Option<u64>,
    /// Pixels of these that differ though no rounding explains it.
    pub decided_pixels_off: Option<u64>,
    /// What is wrong, a line each.
    pub findings: Vec<String>,
}

/// The time of a setting in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CardTime {
    /// The scene, with its image size.
    pub frame: String,
    /// The technique.
    pub technique: String,
    /// Its settings.
    pub settings: String,
    /// Milliseconds at the adapter's full clock. `None` if no yardstick was steady.
    pub milliseconds: Option<f64>,
    /// Median milliseconds as measured.
    pub measured_milliseconds: f64,
}

impl Card {
    /// Returns what an adapter reports of itself, and what small probes find.
    ///
    /// # Errors
    /// Errors if the device fails.
    pub fn of_adapter(gpu: &Gpu) -> Result<Self, BackendError> {
        let info = gpu.adapter_info();
        let limits = gpu.limits();
        let fusing = gpu.fusing()?;
        let here = Environment::here(true);
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

    /// Returns what is wrong with the adapter or its masks, a line each.
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
