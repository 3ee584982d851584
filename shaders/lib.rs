//! umbrage's built-in shadow techniques: each one file in Rust beside one of the same name in WGSL. Only public API of
//! `umbrage-core` is used, so a technique of yours can do all that these do.

mod catalogue;
pub mod filtering;
pub mod lanes;
mod preset;
mod settings;
pub mod shading;
pub mod shadow_map;
pub mod techniques;

pub use catalogue::{Entry, Settings, all, find};
pub use filtering::comparison_sampler::WEIGHT_ERROR;
pub use filtering::depth_in_reach::{DepthInReachKernel, DepthInReachUniforms};
pub use filtering::horizon::Horizon;
pub use filtering::least_depth::{LeastDepthKernel, LeastDepthUniforms};
pub use filtering::light_extent::LightExtent;
pub use filtering::sample_pattern::Pattern;
pub use preset::Preset;
pub use shading::blinn_phong::{BlinnPhong, BlinnPhongKernel, BlinnPhongUniforms, Shading};
pub use shadow_map::{
    BetweenKernel, BetweenUniforms, BeyondFar, Bias, Border, Footprint, MapFormat, ShadowMap,
    Surface,
};
pub use techniques::hard::{Hard, HardKernel};
pub use techniques::midpoint::Midpoint;
pub use techniques::pcf::{MAX_RADIUS, Pcf, PcfKernel, PcfUniforms};
pub use techniques::pcf_disc::{MAX_DISC_RADIUS, PcfDisc, PcfDiscKernel, PcfDiscUniforms};
pub use techniques::pcf_dithered::{PcfDithered, PcfDitheredKernel};
pub use techniques::pcf_hardware::{HardwareKernel, HardwareUniforms, PcfHardware};
pub use techniques::pcf_merged::{MergedKernel, MergedUniforms, PcfMerged};
pub use techniques::pcss::{Pcss, PcssKernel, PcssUniforms};
pub use techniques::planar::{
    MAX_PLANES, Planar, PlanarKernel, PlanarUniforms, planar_shadow_matrix,
};
pub use techniques::second_depth::SecondDepth;
pub use techniques::traced::{MAX_SAMPLES, Traced, TracedKernel, TracedUniforms};
pub use techniques::unshadowed::{Unshadowed, UnshadowedKernel, UnshadowedUniforms};
pub use techniques::volumes::{ShadowVolumes, VolumesKernel, VolumesUniforms};

use umbrage_core::Twin;

/// Every pair of functions that the techniques share between the languages, for the lockstep tests.
pub fn twins() -> impl Iterator<Item = &'static Twin> {
    [
        shadow_map::layers::TWINS,
        shadow_map::coord::TWINS,
        shadow_map::texel_compare::TWINS,
        shadow_map::packing::TWINS,
        filtering::bilinear_weights::TWINS,
        shading::interpolation::TWINS,
        shading::lighting::TWINS,
        shading::texture::TWINS,
        filtering::sample_pattern::TWINS,
        filtering::pattern_taps::TWINS,
        filtering::light_extent::TWINS,
        filtering::horizon::TWINS,
        shading::facing::TWINS,
    ]
    .into_iter()
    .flatten()
}
