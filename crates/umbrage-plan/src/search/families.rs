//! The candidates: every technique with every kernel worth evaluating, on maps from coarse to fine.

use super::{
    bias::{BiasAmounts, BiasKind, bias_amounts},
    resolution,
};
use crate::{
    catalogue::{Candidate, Catalogue, CatalogueEntry, PlannedBiases},
    estimate::scene::PlanScene,
};
use umbrage_core::{Cascades, Fit, Layout, Light, math::transform};
use umbrage_techniques::{MapFormat, ShadowMap, TechniquePreset};

/// Sides of maps, texels. Half a step is hardly visible. A whole step costs four times as much.
pub(super) const SIZES: [u32; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
/// Greatest relative difference of sides that count as equal.
const SAME_SIDE_TOLERANCE: f64 = 0.1;
/// Greatest factor by which a map of twice the side divides the error.
///
/// It halves the area that is wrong along edges, and so divides the error by the root of 2. It does
/// more only where acne or whole casters vanish. Sweeps exceed 2.5 but not this limit.
const MAX_GAIN_OF_MAPS: f64 = 4.0;

/// Technique and kernel without a choice of bias, on maps from coarse to fine or with increasing
/// numbers of rays.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Family {
    /// Candidates, by rising cost.
    pub(super) candidates: Vec<TechniquePreset>,
    /// Greatest factor by which the step from one candidate to the next divides the error.
    pub(super) max_gain: f64,
    /// Biases that its maps may have.
    planned_biases: PlannedBiases,
    /// Reach of its lookups, texels.
    kernel_reach: Option<f32>,
}

impl Family {
    fn new(candidate: Candidate<TechniquePreset>, entry: &CatalogueEntry) -> Self {
        let (candidates, max_gain) = match candidate {
            Candidate::One(preset) if preset.map().is_some() => {
                let maps = SIZES.map(|side| with_map_side(&preset, side));
                (maps.to_vec(), MAX_GAIN_OF_MAPS)
            }
            Candidate::One(preset) => (vec![preset], 1.0),
            Candidate::Series { settings, max_gain } => (settings, max_gain),
        };
        Self {
            kernel_reach: candidates.first().and_then(entry.kernel_reach),
            planned_biases: entry.planned_biases,
            candidates,
            max_gain,
        }
    }

    /// Returns the kinds of bias worth evaluating, with their amounts.
    pub(super) fn bias_amounts(&self) -> Vec<BiasAmounts> {
        bias_amounts(self.kernel_reach, self.planned_biases)
    }

    /// Returns the family with one more map of `side` x `side` texels. Returns it unchanged if it
    /// has a map of about that side or no maps.
    fn with_side(mut self, side: u32) -> Self {
        let preset = self.preset().clone();
        if preset.map().is_none() {
            return self;
        }
        let has_side = self.candidates.iter().any(|candidate| {
            let ratio = f64::from(side) / f64::from(map_side(candidate));
            (ratio - 1.0).abs() <= SAME_SIDE_TOLERANCE
        });
        if !has_side {
            let place = self
                .candidates
                .partition_point(|candidate| map_side(candidate) < side);
            self.candidates.insert(place, with_map_side(&preset, side));
        }
        self
    }

    /// Returns the same family of maps with a stable fit up to a distance, metres. Returns `None`
    /// unless all its maps have a tight fit.
    fn stable(&self, range: f32) -> Option<Self> {
        let has_tight_map =
            |preset: &TechniquePreset| preset.map().is_some_and(|map| map.fit == Fit::Tight);
        if !self.candidates.iter().all(has_tight_map) {
            return None;
        }
        let fit = Fit::Stable { range };
        let stable = |preset: &TechniquePreset| match preset.map() {
            Some(&map) => preset.with_map(ShadowMap { fit, ..map }),
            None => preset.clone(),
        };
        Some(Self {
            candidates: self.candidates.iter().map(stable).collect(),
            ..self.clone()
        })
    }

    /// Returns the same family of maps as cascades, each map reduced so that the memory does not
    /// grow. Returns `None` if the family has no maps.
    fn with_cascades(&self, cascades: Cascades) -> Option<Self> {
        let sides = &SIZES[..SIZES.len() - 1];
        let first = self.preset();
        let layout = Layout::Cascades(cascades);
        let map = ShadowMap {
            layout,
            ..*first.map()?
        };
        let on_side = |&side: &u32| with_map_side(&first.with_map(map), side);
        Some(Self {
            candidates: sides.iter().map(on_side).collect(),
            ..self.clone()
        })
    }

    /// Returns whether the error ratio of a candidate to the second before it shows the benefit of
    /// finer maps: its map has at least four times the side. Returns false for rays, which always
    /// gain.
    pub(super) fn saturates(&self, candidate: usize) -> bool {
        let Some(two_before) = candidate.checked_sub(2) else {
            return false;
        };
        match (self.side(two_before), self.side(candidate)) {
            (Some(coarse), Some(fine)) => fine >= 4 * coarse,
            _ => false,
        }
    }

    /// Returns the side of a candidate's map, texels, or `None` without a map.
    fn side(&self, candidate: usize) -> Option<u32> {
        let map = self.candidates.get(candidate)?.map()?;
        Some(map.size)
    }

    /// Returns the first candidate's preset, which has the technique and kernel of all.
    pub(super) fn preset(&self) -> &TechniquePreset {
        &self.candidates[0]
    }

    /// Returns a candidate's preset with this much bias, or unchanged if it has no map.
    pub(super) fn preset_at(
        &self,
        candidate: usize,
        kind: BiasKind,
        texels: f32,
    ) -> TechniquePreset {
        let preset = &self.candidates[candidate];
        let Some(&map) = preset.map() else {
            return preset.clone();
        };
        preset.with_map(ShadowMap {
            bias: kind.bias(texels, map.bias),
            ..map
        })
    }
}

/// Returns the side of a preset's map, texels, or 0 without a map.
fn map_side(preset: &TechniquePreset) -> u32 {
    preset.map().map_or(0, |map| map.size)
}

/// Returns a preset with a map of another side, or unchanged if it has no map.
fn with_map_side(preset: &TechniquePreset, side: u32) -> TechniquePreset {
    match preset.map() {
        Some(&map) => preset.with_map(ShadowMap { size: side, ..map }),
        None => preset.clone(),
    }
}

/// Families needed in addition to those of every plan.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FamilyNeeds {
    /// Maps of 16 bits, which take half the memory.
    pub(super) small: bool,
    /// Maps with a [`Fit::Stable`], which do not shimmer while the camera moves.
    pub(super) stable: bool,
}

/// Factor by which stable maps reach beyond the geometry visible now: a moving camera sees more.
const STABLE_MARGIN: f32 = 1.25;

/// Returns the rising distances of all visible receivers along the camera's view, metres.
fn seen_distances(scene: &PlanScene<'_>) -> Vec<f32> {
    let receivers = &scene.receivers;
    let space = scene.camera.space();
    let mut distances: Vec<f32> = (0..receivers.len())
        .filter(|&i| receivers.receives[i])
        .map(|i| -transform(space.view_from_world, receivers.position(i)).z)
        .collect();
    distances.sort_unstable_by(f32::total_cmp);
    distances
}

/// Returns the distance along the camera's view up to which shadows are needed, metres: slightly
/// more than the distance of nearly all visible receivers.
fn farthest_seen(rising_distances: &[f32]) -> f32 {
    let nearly_all = rising_distances.len() * 99 / 100;
    let farthest = rising_distances.get(nearly_all).copied().unwrap_or(1.0);
    STABLE_MARGIN * farthest.max(f32::MIN_POSITIVE)
}

/// Least ratio of the farthest to the nearest receivers at which cascades are candidates. Without
/// cascades, the map's texels near the camera are too large by this factor, in pixels.
const LEAST_RANGE_OF_CASCADES: f32 = 8.0;

/// Returns cascades for a view, or `None` if all visible receivers have similar distances.
fn cascades_for(rising_distances: &[f32]) -> Option<Cascades> {
    let nearest = rising_distances.get(rising_distances.len() / 100)?;
    let farthest = rising_distances.get(rising_distances.len() * 99 / 100)?;
    let is_deep = *nearest > 0.0 && *farthest >= LEAST_RANGE_OF_CASCADES * nearest;
    is_deep.then(|| Cascades {
        nearest: two_digits(*nearest),
        ..Cascades::default()
    })
}

/// Returns a positive number rounded down to two digits, to keep presets readable.
fn two_digits(value: f32) -> f32 {
    let unit = 10.0_f64.powf(f64::from(value).log10().floor() - 1.0);
    ((f64::from(value) / unit).floor() * unit) as f32
}

/// Returns all candidates for a view: those for its light, with one more map side that matches the
/// view's pixels in each family.
pub(super) fn families_for(
    catalogue: &Catalogue,
    scene: &PlanScene<'_>,
    needs: FamilyNeeds,
) -> Vec<Family> {
    let side = resolution::side(scene).map(|side| side.clamp(SIZES[0], SIZES[SIZES.len() - 1]));
    let mut families = families(catalogue, scene.light, needs.small);
    let is_sun = matches!(scene.light, Light::Directional { .. });
    // Derive cascades from the range of distances.
    let distances = seen_distances(scene);
    let cascades = cascades_for(&distances).filter(|_| is_sun);
    // The side that matches the view's pixels applies to families with one map only.
    let mut cascaded: Vec<Family> = Vec::new();
    if let Some(cascades) = cascades {
        cascaded.extend(families.iter().filter_map(|f| f.with_cascades(cascades)));
    }
    // Add stable variants.
    if needs.stable && is_sun {
        let range = farthest_seen(&distances);
        let stable_cascades: Vec<Family> =
            cascaded.iter().filter_map(|f| f.stable(range)).collect();
        cascaded.extend(stable_cascades);
        let stable: Vec<Family> = families.iter().filter_map(|f| f.stable(range)).collect();
        families.extend(stable);
    }
    // Add the side that matches the pixels.
    if let Some(side) = side {
        let with_side = |family: Family| family.with_side(side);
        families = families.into_iter().map(with_side).collect();
    }
    families.extend(cascaded);
    families
}

/// Returns all candidates for a light, in the order in which equally cheap ones are evaluated:
/// single settings without a map, maps, then series without a map. `small` adds maps of 16 bits,
/// which take half the memory.
pub(super) fn families(catalogue: &Catalogue, light: &Light, small: bool) -> Vec<Family> {
    let without_map = families_of(catalogue, light, MapFormat::Depth32, false);
    let (single, series): (Vec<Family>, Vec<Family>) = without_map
        .into_iter()
        .partition(|family| family.candidates.len() == 1 && family.max_gain == 1.0);
    let mut out = single;
    out.extend(families_of(catalogue, light, MapFormat::Depth32, true));
    if small {
        out.extend(families_of(catalogue, light, MapFormat::Depth16, true));
    }
    out.extend(series);
    out
}

/// Returns the families of the techniques with maps of this format, or of those without maps.
fn families_of(
    catalogue: &Catalogue,
    light: &Light,
    format: MapFormat,
    has_map: bool,
) -> Vec<Family> {
    let map = ShadowMap {
        format,
        ..ShadowMap::default()
    };
    catalogue
        .all()
        .iter()
        .filter(|entry| entry.technique.has_map == has_map)
        .flat_map(|entry| {
            let candidates = (entry.candidates)(map, light).into_iter();
            candidates.map(|candidate| Family::new(candidate, entry))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::CataloguedTechnique;
    use std::collections::HashSet;
    use umbrage_core::glam::Vec3;
    use umbrage_techniques::{Hard, MapTechnique, Traced};

    fn family_of<T: CataloguedTechnique>(technique: T) -> Family {
        let candidate = Candidate::One(TechniquePreset::from(technique));
        Family::new(candidate, &CatalogueEntry::for_technique::<T>())
    }

    /// A technique that is added to the catalogue must also be a candidate.
    #[test]
    fn every_technique_is_a_candidate() {
        let lamp = Light::Disc {
            center: Vec3::Y,
            normal: -Vec3::Y,
            radius: 0.1,
        };
        let names: HashSet<_> = families(&Catalogue::built_in(), &lamp, false)
            .iter()
            .map(|f| f.preset().technique().name())
            .collect();
        for entry in umbrage_techniques::all() {
            assert!(names.contains(entry.name), "{} is no candidate", entry.name);
        }
    }

    #[test]
    fn one_more_side_stands_in_its_place() {
        let family = family_of(MapTechnique::<Hard>::default());
        let sides = |side| {
            let candidates = family.clone().with_side(side).candidates;
            candidates
                .iter()
                .map(|candidate| candidate.map().unwrap().size)
                .collect::<Vec<_>>()
        };
        assert_eq!(sides(704), [64, 128, 256, 512, 704, 1024, 2048, 4096]);
        for near in [64, 480, 560, 1024, 4096] {
            assert_eq!(sides(near), SIZES, "{near}");
        }
        let rays = family_of(Traced::default());
        assert_eq!(rays.clone().with_side(704), rays);
    }

    #[test]
    fn stable_families_differ_in_their_fit_alone() {
        let hard = family_of(MapTechnique::<Hard>::default());
        let stable = hard.stable(20.0).expect("has maps");
        let map = stable.candidates[0].map().expect("a map");
        assert_eq!(map.fit, Fit::Stable { range: 20.0 });
        let tight = ShadowMap {
            fit: Fit::Tight,
            ..*map
        };
        assert_eq!(stable.candidates[0].with_map(tight), hard.candidates[0]);
        assert_eq!(family_of(Traced::default()).stable(20.0), None);
    }

    #[test]
    fn cascaded_families_take_no_more_memory() {
        let hard = family_of(MapTechnique::<Hard>::default());
        let cascaded = hard.with_cascades(Cascades::default()).expect("has maps");
        let largest = |family: &Family| map_side(family.candidates.last().expect("some"));
        assert_eq!(2 * largest(&cascaded), largest(&hard));
        let label = cascaded.candidates[0].settings();
        assert!(label.contains("4 cascades"), "{label}");
        let stable = cascaded.stable(50.0).expect("tight");
        assert_eq!(
            stable.candidates[0].map().expect("a map").layout,
            Layout::Cascades(Cascades::default())
        );
        assert_eq!(
            family_of(Traced::default()).with_cascades(Cascades::default()),
            None
        );
    }

    #[test]
    fn views_that_are_near_and_far_get_cascades() {
        let evenly: Vec<f32> = (0..200).map(|i| 10.0 + 0.1 * i as f32).collect();
        assert_eq!(cascades_for(&evenly), None);
        assert_eq!(cascades_for(&[]), None);
        let deep: Vec<f32> = (0..200).map(|i| 2.66 + i as f32).collect();
        let cascades = cascades_for(&deep).expect("near and far");
        assert_eq!(cascades.nearest, 4.6);
        for (value, expected) in [(4.66, 4.6), (123.4, 120.0), (0.0199, 0.019)] {
            assert!(
                (two_digits(value) - expected).abs() < 1e-6 * expected,
                "{value}"
            );
        }
    }

    #[test]
    fn sizes_rise() {
        assert!(SIZES.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn ideal_lights_need_no_penumbrae() {
        let bulb = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        let names: HashSet<_> = families(&Catalogue::built_in(), &bulb, true)
            .iter()
            .map(|f| f.preset().technique().name())
            .collect();
        assert!(!names.contains("pcss") && names.contains("hard"));
    }
}
