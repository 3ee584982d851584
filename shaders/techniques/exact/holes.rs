//! Alpha test of casters: a ray that hits a transparent texel continues.

use umbrage_core::{
    CutOuts,
    glam::{Vec2, Vec3},
    light_sample::{LightSampler, segment},
};

/// Data for the alpha test of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct CasterHoles<'a> {
    pub(super) cut_outs: &'a CutOuts,
    /// Centre of the light.
    pub(super) light: &'a LightSampler,
    /// Length of rays towards directional lights, metres.
    pub(super) far: f32,
}

impl CasterHoles<'_> {
    /// Returns whether the ray from `o`, which hits a caster, hits it at a transparent texel.
    #[inline(never)]
    pub(super) fn are_met(&self, caster: u32, corners: [Vec3; 3], o: Vec3) -> bool {
        let d = segment(self.light, o, Vec2::ZERO, self.far);
        self.cut_outs.is_hole(caster, corners, o, d)
    }
}
