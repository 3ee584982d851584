//! Candidates tried on the sample, each once.

use super::{
    Setting,
    bias::{BiasKind, Scale, scales},
    families::Family,
};
use crate::{
    MeasureError,
    cost::CostModel,
    estimate::{
        error::Estimate,
        scene::{Known, Look, Price},
        verify::{Suspect, Verifier},
    },
    progress::OnStep,
};
use std::collections::HashMap;
use umbrage_core::{BackendError, PlanError};
use umbrage_techniques::{Preset, ShadowMap};

/// All that was tried.
pub(super) struct Trial<'a> {
    pub(super) look: Look<'a>,
    pub(super) known: Known,
    pub(super) verifier: Verifier,
    pub(super) cost: CostModel,
    /// By the preset's fields in words; none where it isn't supported.
    tried: HashMap<String, Option<Setting>>,
    /// What the first sample said of those that were verified since.
    firsts: HashMap<String, Estimate>,
    prices: HashMap<String, Option<Price>>,
}

/// The goal of a search for a bias: stop at what meets it, and don't search where it is out of reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    /// Greatest [`Estimate::high`].
    pub(super) error: f64,
}

/// Beyond this many times the goal after the first try of each kind, a better amount of bias will not mend it.
const OUT_OF_REACH: f64 = 1.7;
/// The same for kinds of bias other than the one that was best at once.
const OUT_OF_REACH_OF_OTHERS: f64 = 1.3;

impl<'a> Trial<'a> {
    pub(super) fn new(look: Look<'a>, known: Known, verifier: Verifier, cost: CostModel) -> Self {
        Self {
            look,
            known,
            verifier,
            cost,
            tried: HashMap::new(),
            firsts: HashMap::new(),
            prices: HashMap::new(),
        }
    }

    /// Forgets what was tried, as if truth were another.
    #[cfg(test)]
    pub(super) fn forget(&mut self) {
        self.tried.clear();
        self.firsts.clear();
    }

    /// How many settings were played.
    pub(super) fn played(&self) -> usize {
        self.tried.len()
    }

    /// All that was tried and is supported, by rising cost.
    pub(super) fn all(&self) -> Vec<&Setting> {
        let mut all: Vec<&Setting> = self.tried.values().flatten().collect();
        all.sort_by(|a, b| {
            (a.milliseconds.total_cmp(&b.milliseconds)).then_with(|| a.settings.cmp(&b.settings))
        });
        all
    }

    /// What was tried that differs from a setting in its bias alone, by rising error.
    pub(super) fn alike(&self, setting: &Setting) -> Vec<Setting> {
        let Some(map) = setting.preset.map() else {
            return Vec::new();
        };
        let but_for_bias = |s: &&Setting| {
            let own = s.preset.map().map(|own| ShadowMap {
                bias: map.bias,
                ..*own
            });
            s.preset != setting.preset
                && own.is_some_and(|own| s.preset.with_map(own) == setting.preset)
        };
        let mut alike: Vec<Setting> = self
            .tried
            .values()
            .flatten()
            .filter(but_for_bias)
            .cloned()
            .collect();
        alike.sort_by(|a, b| {
            a.estimate
                .error
                .total_cmp(&b.estimate.error)
                .then_with(|| a.settings.cmp(&b.settings))
        });
        alike
    }

    /// What a preset costs; none if it isn't supported.
    pub(super) fn price(&mut self, preset: &Preset) -> Result<Option<Price>, MeasureError> {
        let key = format!("{preset:?}");
        if let Some(price) = self.prices.get(&key) {
            return Ok(*price);
        }
        let price = match self.look.recipe(preset) {
            Ok(recipe) => Some(self.look.price(&recipe, &self.cost)),
            Err(PlanError::Unsupported(_)) => None,
            Err(e) => return Err(e.into()),
        };
        self.prices.insert(key, price);
        Ok(price)
    }

    /// Plays a preset on the sample; none if it isn't supported.
    pub(super) fn play(&mut self, preset: &Preset) -> Result<Option<Setting>, MeasureError> {
        let key = format!("{preset:?}");
        if let Some(setting) = self.tried.get(&key) {
            return Ok(setting.clone());
        }
        let setting = self.play_new(preset)?;
        self.tried.insert(key, setting.clone());
        Ok(setting)
    }

    fn play_new(&mut self, preset: &Preset) -> Result<Option<Setting>, MeasureError> {
        let recipe = match self.look.recipe(preset) {
            Ok(recipe) => recipe,
            Err(PlanError::Unsupported(_)) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let price = self.look.price(&recipe, &self.cost);
        match self.known.ask(&mut self.look, &recipe) {
            Ok(estimate) => Ok(Some(Setting::new(*preset, estimate, &price))),
            // More than the backend holds.
            Err(BackendError::Invalid(_)) => Ok(None),
            Err(e) => Err(e.into()),
        }
    }

    /// What samples of its own say of a setting that was tried, until a bound of the error is decided, if there is one.
    pub(super) fn verify(
        &mut self,
        setting: &Setting,
        bound: Option<f64>,
        on_step: &OnStep<'_>,
    ) -> Result<Setting, MeasureError> {
        let recipe = self.look.recipe(&setting.preset)?;
        let key = format!("{:?}", setting.preset);
        let first = *self.firsts.entry(key.clone()).or_insert(setting.estimate);
        let suspect = Suspect {
            recipe: &recipe,
            first,
            bound,
        };
        let estimate = self
            .verifier
            .estimate(&mut self.look, &self.known, &suspect, on_step)?;
        let setting = Setting {
            estimate,
            ..setting.clone()
        };
        self.tried.insert(key, Some(setting.clone()));
        Ok(setting)
    }

    /// The best bias of a family at a map size: the first amount of each kind, then, from the best kind on, more or less of
    /// it as long as that is better. None if nothing is supported.
    pub(super) fn settle(
        &mut self,
        family: &Family,
        size: usize,
        goal: Option<Goal>,
    ) -> Result<Option<Setting>, MeasureError> {
        let met = |setting: &Setting| goal.is_some_and(|goal| setting.estimate.high <= goal.error);
        let scales = scales(&family.preset());
        let mut firsts: Vec<(&Scale, Setting)> = Vec::new();
        for scale in &scales {
            let preset = family.at(size, scale.kind, scale.texels[scale.first]);
            let Some(setting) = self.play(&preset)? else {
                continue;
            };
            if met(&setting) {
                return Ok(Some(setting));
            }
            firsts.push((scale, setting));
        }
        firsts.sort_by(|(_, a), (_, b)| a.estimate.error.total_cmp(&b.estimate.error));
        let Some((_, mut best)) = firsts.first().cloned() else {
            return Ok(None);
        };
        let aim = goal.map_or(best.estimate.error, |goal| goal.error);
        for (i, (scale, first)) in firsts.into_iter().enumerate() {
            let reach = if i == 0 {
                OUT_OF_REACH
            } else {
                OUT_OF_REACH_OF_OTHERS
            };
            if first.estimate.error > reach * aim {
                break;
            }
            let at = |k: usize| family.at(size, scale.kind, scale.texels[k]);
            let setting = self.climb(first, at, scale.first, scale.texels.len())?;
            if setting.estimate.error < best.estimate.error {
                best = setting;
            }
            if met(&best) {
                break;
            }
        }
        Ok(Some(best))
    }

    /// From amount `first` of `count`, goes down as long as that is better; if it never is, up.
    fn climb(
        &mut self,
        first_try: Setting,
        preset: impl Fn(usize) -> Preset,
        first: usize,
        count: usize,
    ) -> Result<Setting, MeasureError> {
        let mut best = first_try;
        let (down, up): (Vec<usize>, Vec<usize>) =
            ((0..first).rev().collect(), (first + 1..count).collect());
        for way in [down, up] {
            let mut better = false;
            for k in way {
                let Some(setting) = self.play(&preset(k))? else {
                    break;
                };
                if setting.estimate.error >= best.estimate.error {
                    break;
                }
                (best, better) = (setting, true);
            }
            if better {
                break;
            }
        }
        Ok(best)
    }

    /// Every amount of every kind of bias of a family at a map size: kind, texels, and what came of it.
    pub(super) fn curve(
        &mut self,
        family: &Family,
        size: usize,
    ) -> Result<Vec<(BiasKind, f32, Setting)>, MeasureError> {
        let mut out = Vec::new();
        for scale in scales(&family.preset()) {
            for texels in scale.texels {
                let setting = self.play(&family.at(size, scale.kind, texels))?;
                out.extend(setting.map(|setting| (scale.kind, texels, setting)));
            }
        }
        Ok(out)
    }
}
