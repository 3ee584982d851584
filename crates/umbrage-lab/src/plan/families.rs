//! The candidates: every technique with every kernel worth trying, on maps from coarse to fine.

use super::bias::BiasKind;
use umbrage_core::Light;
use umbrage_techniques::{
    Bias, Hard, MapFormat, Midpoint, Pattern, Pcf, PcfDisc, PcfDithered, PcfHardware, PcfMerged, Pcss, Planar, Preset,
    SecondDepth, ShadowMap, ShadowVolumes, Traced, Unshadowed,
};

/// Sides of maps, texels. Half a size more or less is hardly seen; a whole one costs four times as much.
pub(super) const SIZES: [u32; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// A technique and kernel, open as to its map's size and bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Family {
    /// With a map of any size.
    pub(super) preset: Preset,
}

impl Family {
    /// How many sizes there are: one for techniques without a map.
    pub(super) fn sizes(&self) -> usize {
        if self.preset.map().is_some() { SIZES.len() } else { 1 }
    }

    /// The preset with a size and a bias.
    pub(super) fn at(&self, size: usize, kind: BiasKind, texels: f32) -> Preset {
        let Some(&map) = self.preset.map() else { return self.preset };
        self.preset.with_map(ShadowMap { size: SIZES[size], bias: kind.bias(texels, map.bias), ..map })
    }
}

/// All candidates for a light. `small` asks for maps of 16 bits, too, which take half the memory.
pub(super) fn families(light: &Light, small: bool) -> Vec<Family> {
    let mut presets: Vec<Preset> = vec![Unshadowed::default().into(), Planar::default().into()];
    presets.push(ShadowVolumes::default().into());
    let mut formats = vec![MapFormat::Depth32];
    if small {
        formats.push(MapFormat::Depth16);
    }
    presets.extend(formats.iter().flat_map(|&format| of_map(ShadowMap { format, ..ShadowMap::default() })));
    if !light.is_ideal() {
        presets.extend(formats.iter().flat_map(|&format| soft(ShadowMap { format, ..ShadowMap::default() })));
    }
    let rays: &[u32] = if light.is_ideal() { &[1] } else { &[1, 2, 4, 8, 16, 32, 64, 128, 256] };
    presets.extend(rays.iter().map(|&samples| Preset::from(Traced { samples })));
    presets.into_iter().map(|preset| Family { preset }).collect()
}

/// Kernels of one width.
fn of_map(map: ShadowMap) -> Vec<Preset> {
    let mut out: Vec<Preset> = vec![Hard { map }.into(), PcfDithered { map }.into()];
    let culled = ShadowMap { bias: Bias::FRONT_CULL, ..map };
    out.extend([0, 1].map(|radius| Preset::from(SecondDepth { map: culled, radius })));
    out.extend([0, 1].map(|radius| Preset::from(Midpoint { map, radius })));
    out.extend([1, 2, 3].map(|samples| Preset::from(PcfHardware { map, samples })));
    out.extend([1, 2, 3].map(|radius| Preset::from(PcfMerged { map, radius })));
    out.extend([1, 2, 3, 5].map(|radius| Preset::from(Pcf { map, radius })));
    let disc = PcfDisc { map, rotate: true, pattern: Pattern::Vogel, ..PcfDisc::default() };
    let discs = [(2.0, 8), (4.0, 16), (8.0, 32), (16.0, 32)];
    out.extend(discs.map(|(radius, taps)| Preset::from(PcfDisc { radius, taps, ..disc })));
    out
}

/// Kernels that tell wide penumbrae from narrow ones.
fn soft(map: ShadowMap) -> Vec<Preset> {
    let taps = [(4, 8), (8, 16), (16, 32), (32, 64)];
    let pcss = |(blocker_taps, filter_taps)| Pcss { map, blocker_taps, filter_taps, ..Pcss::default() }.into();
    taps.map(pcss).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use umbrage_core::glam::Vec3;

    /// A technique that is added to the catalogue must be a candidate, too.
    #[test]
    fn every_technique_is_a_candidate() {
        let lamp = Light::Disc { center: Vec3::Y, normal: -Vec3::Y, radius: 0.1 };
        let names: HashSet<_> = families(&lamp, false).iter().map(|f| f.preset.technique().name()).collect();
        for entry in umbrage_techniques::all() {
            assert!(names.contains(entry.name), "{} is never tried", entry.name);
        }
    }

    #[test]
    fn ideal_lights_need_no_penumbrae() {
        let bulb = Light::Point { position: Vec3::Y, radius: 0.0 };
        let names: HashSet<_> = families(&bulb, true).iter().map(|f| f.preset.technique().name()).collect();
        assert!(!names.contains("pcss") && names.contains("hard"));
    }
}
