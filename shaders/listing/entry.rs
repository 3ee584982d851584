//! A row of a list of techniques.

use super::{
    Candidate, ClosedFormDemand, ConfiguredTechniques, ListedTechnique, PlannedBiases,
    RandomParameter, TechniquePreset,
};
use crate::shadow_map::ShadowMap;
use std::{
    fmt::{self, Debug, Formatter},
    sync::Arc,
};
use umbrage_core::{Fit, Light, ShadowTechnique};

/// A technique of a list: what its [`ListedTechnique`] says, whatever its type.
#[derive(Clone, Copy)]
pub struct TechniqueEntry {
    /// Its name, as [`ShadowTechnique::name`] gives it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Whether it looks up a shadow map.
    pub has_map: bool,
    /// Its default settings.
    pub preset: fn() -> TechniquePreset,
    /// The settings worth comparing, for the given map sides (texels) and fit: [`ListedTechnique::compared`].
    pub settings: fn(map_sizes: &[u32], fit: Fit) -> ConfiguredTechniques,
    /// The few settings that stand for it, for the given map sides (texels) and fit: [`ListedTechnique::headline`].
    pub headline: fn(map_sizes: &[u32], fit: Fit) -> ConfiguredTechniques,
    /// As [`ListedTechnique::MAX_COMPARED_TRIANGLES`].
    pub max_compared_triangles: Option<usize>,
    /// Every setting that differs in code path, at one map side (texels): [`ListedTechnique::exhaustive`].
    pub exhaustive: fn(map_size: u32) -> ConfiguredTechniques,
    /// What a planner tries: [`ListedTechnique::candidates`].
    pub candidates: fn(map: ShadowMap, light: &Light) -> Vec<Candidate<TechniquePreset>>,
    /// Which biases a planner may give to its maps.
    pub planned_biases: PlannedBiases,
    /// What closed forms demand of it: [`ListedTechnique::closed_form`].
    pub closed_form: fn(map: ShadowMap) -> Option<ClosedFormDemand<TechniquePreset>>,
    /// How often random scenes are played with it, relative to a technique with 1.
    pub random_weight: u32,
    /// The ranges of the numbers that [`TechniqueEntry::random`] takes.
    pub random_parameters: fn() -> Vec<RandomParameter>,
    /// Random settings: [`ListedTechnique::random`].
    pub random: fn(map: ShadowMap, numbers: &[f32]) -> TechniquePreset,
    /// Whether any of its shaders branches on a uniform.
    pub branches_on_uniforms: bool,
    /// As [`ListedTechnique::IS_PREVIEWED`].
    pub is_previewed: bool,
    /// Reads its settings.
    pub(super) read: fn(toml::Table) -> Result<TechniquePreset, toml::de::Error>,
}

/// Its name alone: addresses of functions differ from run to run.
impl Debug for TechniqueEntry {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)
    }
}

impl TechniqueEntry {
    /// The row of a technique.
    pub fn of<T: ListedTechnique>() -> Self {
        let default = T::default();
        Self {
            name: default.name(),
            summary: T::SUMMARY,
            has_map: default.map().is_some(),
            preset: || TechniquePreset::from(T::default()),
            settings: |map_sizes, fit| erased(T::compared(map_sizes, fit)),
            headline: |map_sizes, fit| erased(T::headline(map_sizes, fit)),
            max_compared_triangles: T::MAX_COMPARED_TRIANGLES,
            exhaustive: |map_size| erased(T::exhaustive(map_size)),
            candidates: |map, light| {
                let candidates = T::candidates(map, light).into_iter();
                candidates.map(|c| c.map(TechniquePreset::from)).collect()
            },
            planned_biases: T::PLANNED_BIASES,
            closed_form: |map| {
                let demand = T::closed_form(map)?;
                Some(ClosedFormDemand {
                    technique: TechniquePreset::from(demand.technique),
                    reach: demand.reach,
                    tolerance: demand.tolerance,
                    closed_bodies: demand.closed_bodies,
                })
            },
            random_weight: T::RANDOM_WEIGHT,
            random_parameters: T::random_parameters,
            random: |map, numbers| TechniquePreset::from(T::random(map, numbers)),
            branches_on_uniforms: T::BRANCHES_ON_UNIFORMS,
            is_previewed: T::IS_PREVIEWED,
            read: |table| T::deserialize(table).map(TechniquePreset::from),
        }
    }
}

fn erased<T: ListedTechnique>(settings: Vec<T>) -> ConfiguredTechniques {
    settings
        .into_iter()
        .map(|technique| Arc::new(technique) as Arc<dyn ShadowTechnique>)
        .collect()
}
