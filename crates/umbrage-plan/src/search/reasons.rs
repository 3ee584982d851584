//! Reasons for a plan in plain words, built from measurements.

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

/// Measurements of the scene itself.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facts {
    /// Share of the counted pixels that are not fully lit, 0..=1.
    shadowed: f64,
    /// Share of the counted pixels in penumbra, 0..=1.
    in_penumbra: f64,
    penumbrae: Vec<Penumbra>,
}

/// Greatest number of cheaper techniques in the reasons.
const NAMED: usize = 3;
/// Greatest share of the chosen time at which a cheaper setting is mentioned.
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

    /// Returns the reasons why this setting was chosen, or why none was.
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
            return "no visible surface receives the light".to_owned();
        }
        if self.shadowed == 0.0 {
            return "nothing casts on visible surfaces".to_owned();
        }
        let shadowed_percent = 100.0 * self.shadowed;
        let softness = if trials.views[0].scene.light.is_ideal() {
            "; the light has no extent, so every edge is sharp".to_owned()
        } else {
            let penumbra_percent = 100.0 * self.in_penumbra;
            format!(", {penumbra_percent:.1} % in penumbra")
        };
        format!("{shadowed_percent:.1} % of the visible receivers are in shadow{softness}")
    }

    /// Returns the widths of penumbrae on the chosen map, or on one of 512 texels.
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
                "penumbrae are {narrow:.1} to {wide:.1} texels wide (10 % to 90 %) on {whose} of {size}"
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

/// Returns the reason for a chosen technique without a map.
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

/// Returns how well a chosen map is used, or `None` without a map.
fn map_use(
    scene: &PlanScene<'_>,
    chosen: &Setting,
    catalogue: &Catalogue,
) -> Result<Option<String>, MeasureError> {
    let recipe = scene.recipe(&chosen.preset)?;
    let view = scene.rendered_view();
    let found =
        footprint::recipe_footprint(&chosen.preset, &view, &recipe, &scene.receivers, catalogue);
    Ok(found.map(|footprint| footprint.total.words()))
}

/// Returns the error of the same kernel on the next coarser map that was evaluated.
fn smaller_map(all: &[&Setting], chosen: &Setting) -> Option<String> {
    let map = *chosen.preset.map()?;
    // Collect the settings that differ only in a smaller map, with its side.
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
        "its error is {:.4} on a map of {largest}, and on this one of {} it is {:.4}",
        best.estimate.error, map.size, chosen.estimate.error
    ))
}

/// Returns the best setting of each technique that is cheaper and was rejected.
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
        "{} is cheaper ({:.3} ms) with an error of {:.4}",
        setting.label(),
        setting.milliseconds,
        setting.estimate.error
    );
    if let Some(max_error) = bounds.max_error
        && setting.estimate.high > max_error
    {
        line += &format!(", above {max_error} including its uncertainty");
    }
    if let (Some(grain), Some(max)) = (setting.grain, bounds.max_grain)
        && grain > max
    {
        line += &format!("; its grain of {grain:.3} is above {max}");
    }
    line
}

/// Returns the saving of a greater error bound: among the settings that take at most [`WORTHWHILE`]
/// of the time, the one with the least error.
fn next_bound(all: &[&Setting], chosen: &Setting) -> Option<String> {
    let cheaper = all
        .iter()
        .filter(|s| s.milliseconds <= WORTHWHILE * chosen.milliseconds)
        .min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error))?;
    let saved = chosen.milliseconds - cheaper.milliseconds;
    let percent = 100.0 * saved / chosen.milliseconds.max(f64::MIN_POSITIVE);
    Some(format!(
        "an error bound of {:.3} would save {saved:.2} ms ({percent:.0} %): {}",
        cheaper.estimate.high,
        cheaper.label()
    ))
}

/// Returns the measured times, and how their choice differs from that of the counted costs.
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
        "{} candidates were timed: {}",
        timed.len(),
        named.join("; ")
    )];
    if let Some(counted) = counted.filter(|s| s.technique != chosen.technique) {
        out.push(format!(
            "by estimated costs the choice would be {}",
            words(counted)
        ));
    }
    out
}

/// Returns the errors with the least and the greatest bias.
fn bias(curve: &[CurvePoint]) -> Option<String> {
    let chosen = curve.iter().find(|p| p.chosen)?;
    let of_kind: Vec<&CurvePoint> = curve.iter().filter(|p| p.kind == chosen.kind).collect();
    let ends: Vec<String> = [of_kind.first()?, of_kind.last()?]
        .into_iter()
        .filter(|end| end.texels != chosen.texels)
        .map(|end| bias_errors(end))
        .collect();
    Some(format!(
        "least estimated error of all biases: {}, {} (others: {})",
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
