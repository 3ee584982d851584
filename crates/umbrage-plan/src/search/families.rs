//! The candidates: every technique with every kernel worth trying, on maps from coarse to fine.

use super::{bias::BiasKind, resolution};
use crate::estimate::scene::PlanScene;
use umbrage_core::Light;
use umbrage_techniques::{Candidate, MapFormat, Preset, ShadowMap, Techniques};

/// Sides of maps, texels. Half a size more or less is hardly seen; a whole one costs four times as much.
pub(super) const SIZES: [u32; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
/// Sides that differ by no more than this share do not differ.
const SAME_SIDE_TOLERANCE: f64 = 0.1;
/// Doubling a map's side halves the area that is wrong along edges, and so divides the error by the root of 2. It does
/// more only where acne or whole casters vanish: not more than this, as sweeps show (2.5 was too little).
const GAIN_OF_MAPS: f64 = 4.0;
/// A technique and kernel, open as to its bias, from coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Family {
    /// Rising in cost.
    pub(super) candidates: Vec<Preset>,
    /// By what one step divides the error at most.
    pub(super) most_gain: f64,
}

impl Family {
    fn new(candidate: Candidate<Preset>) -> Self {
        match candidate {
            Candidate::One(preset) if preset.map().is_some() => Self::of_maps(preset),
            Candidate::One(preset) => Self::single(preset),
            Candidate::Series { settings, max_gain } => Self {
                candidates: settings,
                most_gain: max_gain,
            },
        }
    }

    fn single(preset: Preset) -> Self {
        Self {
            candidates: vec![preset],
            most_gain: 1.0,
        }
    }

    /// With one map more, of a side that no other is within [`SAME_SIDE_TOLERANCE`] of.
    fn with_side(mut self, side: u32) -> Self {
        let preset = self.preset().clone();
        let Some(&map) = preset.map() else {
            return self;
        };
        let size = |p: &Preset| p.map().map_or(0, |map| map.size);
        if self.candidates.iter().all(|candidate| {
            (f64::from(side) / f64::from(size(candidate)) - 1.0).abs() > SAME_SIDE_TOLERANCE
        }) {
            let at = self
                .candidates
                .partition_point(|candidate| size(candidate) < side);
            self.candidates
                .insert(at, preset.with_map(ShadowMap { size: side, ..map }));
        }
        self
    }

    fn of_maps(preset: Preset) -> Self {
        let at = |size| match preset.map() {
            Some(&map) => preset.with_map(ShadowMap { size, ..map }),
            None => preset.clone(),
        };
        Self {
            candidates: SIZES.map(at).to_vec(),
            most_gain: GAIN_OF_MAPS,
        }
    }

    /// Whether a candidate tells what finer maps are worth: two doublings lie between it and the one before the last. Rays
    /// always gain.
    pub(super) fn saturates(&self, candidate: usize) -> bool {
        let side = |candidate: usize| {
            self.candidates
                .get(candidate)
                .and_then(|preset| Some(preset.map()?.size))
        };
        let before = candidate.checked_sub(2).and_then(side);
        before
            .zip(side(candidate))
            .is_some_and(|(coarse, fine)| fine >= 4 * coarse)
    }

    /// Any of it.
    pub(super) fn preset(&self) -> &Preset {
        &self.candidates[0]
    }

    /// A candidate's preset with a bias.
    pub(super) fn at(&self, candidate: usize, kind: BiasKind, texels: f32) -> Preset {
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

/// All candidates for a view: those for its light, with a map more of the side that its pixels ask for.
pub(super) fn families_for(
    techniques: &Techniques,
    scene: &PlanScene<'_>,
    small: bool,
) -> Vec<Family> {
    let side = resolution::side(scene).map(|side| side.clamp(SIZES[0], SIZES[SIZES.len() - 1]));
    let with_side = |family: Family| match side {
        Some(side) => family.with_side(side),
        None => family,
    };
    families(techniques, scene.light, small)
        .into_iter()
        .map(with_side)
        .collect()
}

/// All candidates for a light, in the order in which equally cheap ones are tried: single settings without a map, maps,
/// then series without a map. `small` asks for maps of 16 bits, too, which take half the memory.
pub(super) fn families(techniques: &Techniques, light: &Light, small: bool) -> Vec<Family> {
    let of_format = |format, has_map: bool| {
        let map = ShadowMap {
            format,
            ..ShadowMap::default()
        };
        let entries = techniques
            .all()
            .iter()
            .filter(move |e| e.has_map == has_map);
        entries.flat_map(move |entry| (entry.candidates)(map, light))
    };
    let formats = [MapFormat::Depth32, MapFormat::Depth16];
    let without_map: Vec<Family> = of_format(formats[0], false).map(Family::new).collect();
    let (single, series): (Vec<Family>, Vec<Family>) = without_map
        .into_iter()
        .partition(|family| family.candidates.len() == 1 && family.most_gain == 1.0);
    let mut out = single;
    for &format in &formats[..if small { 2 } else { 1 }] {
        out.extend(of_format(format, true).map(Family::new));
    }
    out.extend(series);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use umbrage_core::glam::Vec3;
    use umbrage_techniques::{Hard, Traced};

    /// A technique that is added to the registry must be a candidate, too.
    #[test]
    fn every_technique_is_a_candidate() {
        let lamp = Light::Disc {
            center: Vec3::Y,
            normal: -Vec3::Y,
            radius: 0.1,
        };
        let names: HashSet<_> = families(&Techniques::built_in(), &lamp, false)
            .iter()
            .map(|f| f.preset().technique().name())
            .collect();
        for entry in umbrage_techniques::all() {
            assert!(names.contains(entry.name), "{} is never tried", entry.name);
        }
    }

    #[test]
    fn one_more_side_stands_in_its_place() {
        let family = Family::of_maps(Hard::default().into());
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
        let rays = Family::single(Traced::default().into());
        assert_eq!(rays.clone().with_side(704), rays);
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
        let names: HashSet<_> = families(&Techniques::built_in(), &bulb, true)
            .iter()
            .map(|f| f.preset().technique().name())
            .collect();
        assert!(!names.contains("pcss") && names.contains("hard"));
    }
}
