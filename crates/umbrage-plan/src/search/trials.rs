//! Tries settings on the sample, each once.

use super::Setting;
use crate::{
    MeasureError,
    cost::CostModel,
    estimate::{
        error::Estimate,
        sampled_truth::SampledTruth,
        scene::{PlanScene, Price},
        verify::{Contender, Verifier},
    },
    progress::OnStep,
};
use std::collections::HashMap;
use umbrage_core::{BackendError, RecipeError};
use umbrage_techniques::{ShadowMap, TechniquePreset};

/// All that was tried.
pub(super) struct Trials<'a> {
    pub(super) scene: PlanScene<'a>,
    pub(super) sampled: SampledTruth,
    pub(super) verifier: Verifier,
    cost: CostModel,
    /// By the preset's fields in words; none where it isn't supported.
    tried: HashMap<String, Option<Setting>>,
    /// The first sample's estimates of settings that were verified since.
    first_estimates: HashMap<String, Estimate>,
    prices: HashMap<String, Option<Price>>,
}

impl<'a> Trials<'a> {
    pub(super) fn new(
        scene: PlanScene<'a>,
        sampled: SampledTruth,
        verifier: Verifier,
        cost: CostModel,
    ) -> Self {
        Self {
            scene,
            sampled,
            verifier,
            cost,
            tried: HashMap::new(),
            first_estimates: HashMap::new(),
            prices: HashMap::new(),
        }
    }

    /// Forgets what was tried, as if truth were another.
    #[cfg(test)]
    pub(super) fn forget(&mut self) {
        self.tried.clear();
        self.first_estimates.clear();
    }

    /// The number of settings tried.
    pub(super) fn count(&self) -> usize {
        self.tried.len()
    }

    /// Returns all tried settings that are supported, by rising cost.
    pub(super) fn all(&self) -> Vec<&Setting> {
        let mut all: Vec<&Setting> = self.tried.values().flatten().collect();
        all.sort_by(|a, b| {
            (a.milliseconds.total_cmp(&b.milliseconds)).then_with(|| a.settings.cmp(&b.settings))
        });
        all
    }

    /// Returns the tried settings that differ from a setting only in their bias, by rising error.
    pub(super) fn with_other_bias(&self, setting: &Setting) -> Vec<Setting> {
        let Some(map) = setting.preset.map() else {
            return Vec::new();
        };
        let differs_in_bias_alone = |other: &&Setting| {
            let rebiased = other.preset.map().map(|own| ShadowMap {
                bias: map.bias,
                ..*own
            });
            other.preset != setting.preset
                && rebiased.is_some_and(|map| other.preset.with_map(map) == setting.preset)
        };
        let mut others: Vec<Setting> = self
            .tried
            .values()
            .flatten()
            .filter(differs_in_bias_alone)
            .cloned()
            .collect();
        others.sort_by(|a, b| {
            a.estimate
                .error
                .total_cmp(&b.estimate.error)
                .then_with(|| a.settings.cmp(&b.settings))
        });
        others
    }

    /// Returns what a preset costs; none if it isn't supported.
    pub(super) fn price(
        &mut self,
        preset: &TechniquePreset,
    ) -> Result<Option<Price>, MeasureError> {
        let key = format!("{preset:?}");
        if let Some(price) = self.prices.get(&key) {
            return Ok(*price);
        }
        let price = match self.scene.recipe(preset) {
            Ok(recipe) => Some(self.scene.price(&recipe, &self.cost)),
            Err(RecipeError::Unsupported(_)) => None,
            Err(e) => return Err(e.into()),
        };
        self.prices.insert(key, price);
        Ok(price)
    }

    /// Tries a preset on the sample; none if it isn't supported.
    pub(super) fn try_out(
        &mut self,
        preset: &TechniquePreset,
    ) -> Result<Option<Setting>, MeasureError> {
        let key = format!("{preset:?}");
        if let Some(setting) = self.tried.get(&key) {
            return Ok(setting.clone());
        }
        let setting = self.try_new(preset)?;
        self.tried.insert(key, setting.clone());
        Ok(setting)
    }

    fn try_new(&mut self, preset: &TechniquePreset) -> Result<Option<Setting>, MeasureError> {
        let recipe = match self.scene.recipe(preset) {
            Ok(recipe) => recipe,
            Err(RecipeError::Unsupported(_)) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let price = self.scene.price(&recipe, &self.cost);
        match self.sampled.estimate(&mut self.scene, &recipe) {
            Ok(estimate) => Ok(Some(Setting::new(preset.clone(), estimate, &price))),
            // More than the backend holds.
            Err(BackendError::Invalid(_)) => Ok(None),
            Err(e) => Err(e.into()),
        }
    }

    /// Estimates the error of a setting that was tried from second samples, until a bound of the error is decided, if there is
    /// one. What was tried remembers the new estimate.
    pub(super) fn verify(
        &mut self,
        setting: &Setting,
        bound: Option<f64>,
        on_step: &OnStep<'_>,
    ) -> Result<Setting, MeasureError> {
        let recipe = self.scene.recipe(&setting.preset)?;
        let key = format!("{:?}", setting.preset);
        let first = *self
            .first_estimates
            .entry(key.clone())
            .or_insert(setting.estimate);
        let contender = Contender {
            recipe: &recipe,
            first,
            bound,
        };
        let estimate =
            self.verifier
                .estimate(&mut self.scene, &self.sampled, &contender, on_step)?;
        let setting = Setting {
            estimate,
            ..setting.clone()
        };
        self.tried.insert(key, Some(setting.clone()));
        Ok(setting)
    }
}
