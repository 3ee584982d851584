//! Built-in shadow techniques of umbrage. Each is one Rust file with a WGSL file of the same name.
//! They use only the public API of `umbrage-core`, so external techniques have the same
//! capabilities.

pub mod filtering;
pub mod lanes;
pub mod listing;
pub mod registry;
pub mod shading;
pub mod shadow_map;
pub mod techniques;

pub use filtering::comparison_sampler::{WEIGHT_ERROR, sampler_tolerance};
pub use filtering::depth_in_reach::{DepthInReachKernel, DepthInReachUniforms};
pub use filtering::horizon::Horizon;
pub use filtering::least_depth::{LeastDepthKernel, LeastDepthUniforms};
pub use filtering::light_extent::LightExtent;
pub use filtering::moments::blur::{MomentMapKernel, MomentMapUniforms};
pub use filtering::moments::halve::{HalveKernel, HalveUniforms};
pub use filtering::moments::map::{MAX_BLEEDING_REDUCTION, MAX_BLUR};
pub use filtering::moments::mipmaps::MAX_MIPMAPS;
pub use filtering::moments::stored::MomentPrecision;
pub use filtering::sample_pattern::Pattern;
pub use listing::{
    FrameRules, LightPreset, ListedTechnique, TechniqueEntry, TechniquePreset, Update,
};
pub use registry::*;
pub use shading::blinn_phong::{BlinnPhong, BlinnPhongKernel, BlinnPhongUniforms, Shading};
pub use shadow_map::{
    BetweenKernel, BeyondFar, Bias, Border, CompareMethod, MapFormat, ShadowMap, Surface,
};
pub use techniques::evsm::{EvsmKernel, EvsmMoments, EvsmUniforms, MAX_EVSM_EXPONENT};
pub use techniques::exact::{
    ExactKernel, ExactStructure, ExactUniforms, HierarchyKernel, LightView, QueriedCell,
};
pub use techniques::hard::HardKernel;
pub use techniques::map_technique::{MapFilter, MapTechnique};
pub use techniques::msm::{MsmKernel, MsmUniforms, Reconstruction};
pub use techniques::pcf::{MAX_RADIUS, MAX_UNROLLED_RADIUS, PcfKernel, PcfUniforms};
pub use techniques::pcf_disc::{MAX_DISC_RADIUS, PcfDiscKernel, PcfDiscUniforms};
pub use techniques::pcf_dithered::PcfDitheredKernel;
pub use techniques::pcf_hardware::{HardwareKernel, HardwareUniforms};
pub use techniques::pcf_merged::{MergedKernel, MergedUniforms};
pub use techniques::pcss::{PcssKernel, PcssUniforms};
pub use techniques::planar::{MAX_PLANES, PlanarKernel, PlanarUniforms, planar_shadow_matrix};
#[cfg(feature = "rays")]
pub use techniques::soft::{MAX_SUN_DEGREES, SOFT_ERRORS, SoftKernel, SoftUniforms};
#[cfg(feature = "rays")]
pub use techniques::traced::{MAX_SAMPLES, TracedKernel, TracedUniforms};
pub use techniques::unshadowed::{UnshadowedKernel, UnshadowedUniforms};
pub use techniques::volumes::{VolumesKernel, VolumesUniforms};
pub use techniques::vsm::{VsmKernel, VsmUniforms};

/// Returns all pairs of Rust and WGSL functions that the techniques share, for the lockstep tests.
#[cfg(feature = "testing")]
pub fn twins() -> impl Iterator<Item = &'static umbrage_core::Twin> {
    [
        shadow_map::layers::TWINS,
        shadow_map::coord::TWINS,
        shadow_map::cascades::TWINS,
        shadow_map::texel_compare::TWINS,
        shadow_map::packing::TWINS,
        filtering::bilinear_weights::TWINS,
        shading::interpolation::TWINS,
        shading::lighting::TWINS,
        shading::texture::TWINS,
        filtering::moments::exp2::TWINS,
        filtering::moments::of_depth::TWINS,
        filtering::moments::bounds::TWINS,
        filtering::moments::mipmaps::TWINS,
        filtering::moments::stored::TWINS,
        filtering::moments::hamburger::TWINS,
        filtering::moments::hausdorff::TWINS,
        filtering::sample_pattern::TWINS,
        filtering::light_extent::TWINS,
        filtering::horizon::TWINS,
        shading::facing::TWINS,
    ]
    .into_iter()
    .flatten()
}
