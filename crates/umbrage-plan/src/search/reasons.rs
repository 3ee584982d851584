//! Reasons in plain words, built from what was measured.

use super::{
    bounds::Bounds, families::SIZES, outcome::CurvePoint, setting::Setting, trials::Trials,
};
use crate::{
    catalogue::Catalogue,
    error::MeasureError,
    estimate::{
        penumbra::{self, Penumbra},
        sampled_truth::SampledTruth,
        scene::PlanScene,
    },
    footprint,
    truth::TruthOptions,
};
use umbrage_core::metrics::PENUMBRA;
use umbrage_techniques::{Hard, MapFilter as _, ShadowMap, TechniquePreset};

/// What was measured of the scene itself.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facts {
    /// Share of what counts that is not wholly lit, 0..=1.
    shadowed: f64,
    /// Share in penumbra.
    in_penumbra: f64,
    penumbrae: Vec<Penumbra>,
}

/// How many cheaper techniques the reasons name.
const NAMED: usize = 3;
/// What would take at most this share of the chosen time is worth a word.
const WORTHWHILE: f64 = 0.8;

impl Facts {
    pub(super) fn find(trials: &Trials<'_>, options: &TruthOptions) -> Result<Self, MeasureError> {
        let view = &trials.views[0];
        let sampled = &view.sampled;
        Ok(Self {
            shadowed: share(sampled, |visibility| visibility < 1.0),
            in_penumbra: share(sampled, |visibility| {
                (PENUMBRA..=1.0 - PENUMBRA).contains(&visibility)
            }),
            penumbrae: penumbra::find(&view.scene, sampled, options)?,
        })
    }

    /// Why this was chosen, or why nothing was.
    pub(super) fn reasons(
        &self,
        trials: &Trials<'_>,
        catalogue: &Catalogue,
        bounds: &Bounds,
        chosen: Option<&Setting>,
        curve: &[CurvePoint],
    ) -> Result<Vec<String>, MeasureError> {
        let mut out = vec![self.shadows(trials)];
        out.extend(self.widths(trials, chosen)?);
        let Some(chosen) = chosen else { return Ok(out) };
        out.extend(exactness(trials, catalogue, chosen)?);
        let all = trials.all();
        out.extend(map_use(&trials.views[0].scene, chosen, catalogue)?);
        out.extend(smaller_map(&all, chosen));
        out.extend(cheaper(&all, chosen, bounds));
        out.extend(next_bound(&all, chosen));
        out.extend(bias(curve));
        Ok(out)
    }

    fn shadows(&self, trials: &Trials<'_>) -> String {
        if trials.views[0].sampled.truth.is_empty() {
            return "nothing that is seen receives the light".to_owned();
        }
        if self.shadowed == 0.0 {
            return "nothing casts on what is seen".to_owned();
        }
        let shadowed_percent = 100.0 * self.shadowed;
        let softness = if trials.views[0].scene.light.is_ideal() {
            "; the light has no extent, so every edge is sharp".to_owned()
        } else {
            let penumbra_percent = 100.0 * self.in_penumbra;
            format!(", {penumbra_percent:.1} % in penumbra")
        };
        format!("{shadowed_percent:.1} % of what is seen lies in shadow{softness}")
    }

    /// How wide penumbrae are on the chosen map, or on one of 512.
    fn widths(
        &self,
        trials: &Trials<'_>,
        chosen: Option<&Setting>,
    ) -> Result<Option<String>, MeasureError> {
        let map = ShadowMap {
            size: SIZES[3],
            ..ShadowMap::default()
        };
        let own = chosen.map(|c| &c.preset).filter(|p| p.map().is_some());
        let hard = TechniquePreset::from(Hard {}.on(map));
        let preset = own.unwrap_or(&hard);
        let Ok(recipe) = trials.views[0].scene.recipe(preset) else {
            return Ok(None);
        };
        let spaces: Vec<_> = recipe.casts.iter().map(|cast| cast.space).collect();
        let size = preset.map().map_or(map.size, |map| map.size);
        let widths = penumbra::texels(&self.penumbrae, &spaces, size);
        Ok(widths.map(|[narrow, wide]| {
            let whose = if own.is_some() { "this map" } else { "a map" };
            format!(
                "penumbrae are {narrow:.1} to {wide:.1} texels wide on {whose} of {size} (but for a tenth on each side)"
            )
        }))
    }
}

/// Estimates the share of the pixels that count whose visibility meets a condition, 0..=1.
fn share(sampled: &SampledTruth, is_met: impl Fn(f32) -> bool) -> f64 {
    let mut met = 0.0;
    let mut all = 0.0;
    for (truth, chance) in sampled.truth.iter().zip(&sampled.sample.chances) {
        let weight = 1.0 / chance;
        all += weight;
        if is_met(truth.visibility) {
            met += weight;
        }
    }
    met / all.max(f64::MIN_POSITIVE)
}

/// What is known of techniques without a map.
fn exactness(
    trials: &Trials<'_>,
    catalogue: &Catalogue,
    chosen: &Setting,
) -> Result<Option<String>, MeasureError> {
    if chosen.preset.map().is_some() {
        return Ok(None);
    }
    let recipe = trials.views[0].scene.recipe(&chosen.preset)?;
    let entry = catalogue.find(chosen.preset.technique().name());
    Ok(entry.and_then(|entry| (entry.why_chosen)(&chosen.preset, chosen.estimate.error, &recipe)))
}

/// Says how well a chosen map is used; none without one.
fn map_use(
    scene: &PlanScene<'_>,
    chosen: &Setting,
    catalogue: &Catalogue,
) -> Result<Option<String>, MeasureError> {
    let recipe = scene.recipe(&chosen.preset)?;
    let view = scene.played_view();
    let found = footprint::of(&chosen.preset, &view, &recipe, &scene.receivers, catalogue);
    Ok(found.map(|footprint| footprint.total.words()))
}

/// The same kernel on the next coarser map that was tried.
fn smaller_map(all: &[&Setting], chosen: &Setting) -> Option<String> {
    let map = *chosen.preset.map()?;
    // What differs in its map alone, and has a smaller one: its side and the setting.
    let mut smaller: Vec<(u32, &Setting)> = Vec::new();
    for &setting in all {
        let Some(own_map) = setting.preset.map() else {
            continue;
        };
        if own_map.size < map.size && setting.preset.with_map(map) == chosen.preset {
            smaller.push((own_map.size, setting));
        }
    }
    let largest = smaller.iter().map(|(size, _)| *size).max()?;
    let (_, best) = smaller
        .iter()
        .filter(|(size, _)| *size == largest)
        .min_by(|(_, a), (_, b)| a.estimate.error.total_cmp(&b.estimate.error))?;
    Some(format!(
        "on a map of {largest} it errs by {:.4}, on this one of {} by {:.4}",
        best.estimate.error, map.size, chosen.estimate.error
    ))
}

/// The best of each technique that is cheaper and was left out.
fn cheaper(all: &[&Setting], chosen: &Setting, bounds: &Bounds) -> Vec<String> {
    let mut best: Vec<&Setting> = Vec::new();
    let left = all
        .iter()
        .filter(|s| s.milliseconds < chosen.milliseconds && s.technique != chosen.technique);
    for &setting in left {
        match best.iter_mut().find(|b| b.technique == setting.technique) {
            Some(b) if setting.estimate.error < b.estimate.error => *b = setting,
            Some(_) => {}
            None => best.push(setting),
        }
    }
    best.sort_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error));
    best.into_iter()
        .take(NAMED)
        .map(|setting| cheaper_line(setting, bounds))
        .collect()
}

fn cheaper_line(setting: &Setting, bounds: &Bounds) -> String {
    let mut line = format!(
        "{} is cheaper ({:.3} ms) and errs by {:.4}",
        setting.label(),
        setting.milliseconds,
        setting.estimate.error
    );
    if let Some(max_error) = bounds.max_error
        && setting.estimate.high > max_error
    {
        line += &format!(", more than {max_error} with its uncertainty");
    }
    if let (Some(grain), Some(max)) = (setting.grain, bounds.max_grain)
        && grain > max
    {
        line += &format!("; its grain is {grain:.3}, more than {max}");
    }
    line
}

/// What a greater error would save: of the settings that take at most [`WORTHWHILE`] of the time,
/// the one with the least error.
fn next_bound(all: &[&Setting], chosen: &Setting) -> Option<String> {
    let cheaper = all
        .iter()
        .filter(|s| s.milliseconds <= WORTHWHILE * chosen.milliseconds)
        .min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error))?;
    let saved = chosen.milliseconds - cheaper.milliseconds;
    let percent = 100.0 * saved / chosen.milliseconds.max(f64::MIN_POSITIVE);
    Some(format!(
        "a bound of {:.3} instead would save {saved:.2} ms ({percent:.0} %): {}",
        cheaper.estimate.high,
        cheaper.label()
    ))
}

/// What was timed, and how the clock's choice differs from that of the counted costs.
pub(super) fn by_the_clock(chosen: Option<&Setting>, timed: &[Setting]) -> Vec<String> {
    let Some(chosen) = chosen.filter(|_| !timed.is_empty()) else {
        return Vec::new();
    };
    let words = |s: &Setting| format!("{} {:.2} ms", s.label(), s.measured_ms.unwrap_or(f64::NAN));
    let named: Vec<String> = timed.iter().take(NAMED).map(words).collect();
    let counted = timed
        .iter()
        .min_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
    let mut out = vec![format!(
        "{} played in turn by the clock: {}",
        timed.len(),
        named.join("; ")
    )];
    if let Some(counted) = counted.filter(|s| s.technique != chosen.technique) {
        out.push(format!(
            "counted costs alone would have chosen {}",
            words(counted)
        ));
    }
    out
}

/// What less and more bias would do.
fn bias(curve: &[CurvePoint]) -> Option<String> {
    let chosen = curve.iter().find(|p| p.chosen)?;
    let of_kind: Vec<&CurvePoint> = curve.iter().filter(|p| p.kind == chosen.kind).collect();
    let ends: Vec<String> = [of_kind.first()?, of_kind.last()?]
        .into_iter()
        .filter(|end| end.texels != chosen.texels)
        .map(|end| bias_errors(end))
        .collect();
    Some(format!(
        "of all biases tried {} has the least estimated error: {} (others: {})",
        chosen.kind.name(),
        bias_errors(chosen),
        ends.join("; ")
    ))
}

fn bias_errors(point: &CurvePoint) -> String {
    format!(
        "{:.2} texels: {:.4} too dark, {:.4} too light",
        point.texels, point.estimate.too_dark, point.estimate.too_light
    )
}
