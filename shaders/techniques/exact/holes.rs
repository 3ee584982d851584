//! Holes of casters: a ray that meets a caster in one goes on.

use umbrage_core::{
    CutOuts,
    glam::{Vec2, Vec3},
    light_sample::{LightSampler, segment},
};

/// What tells which rays pass through holes.
#[derive(Clone, Copy, Debug)]
pub(super) struct CasterHoles<'a> {
    pub(super) cut_outs: &'a CutOuts,
    /// The light's middle.
    pub(super) light: &'a LightSampler,
    /// Length of rays towards directional lights, metres.
    pub(super) far: f32,
}

impl CasterHoles<'_> {
    /// Returns whether the ray from `o`, which meets a caster, meets it in a hole.
    #[inline(never)]
    pub(super) fn are_met(&self, caster: u32, corners: [Vec3; 3], o: Vec3) -> bool {
        let d = segment(self.light, o, Vec2::ZERO, self.far);
        self.cut_outs.is_hole(caster, corners, o, d)
    }
}
