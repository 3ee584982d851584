//! umbrage's built-in shadow techniques: each one file in Rust beside one of the same name in WGSL. Only public API of
//! `umbrage-core` is used, so a technique of yours can do all that these do.

mod backdrop;
mod batch;
mod bias;
mod blinn_phong;
mod catalogue;
mod depth_in_reach;
mod endless;
mod extrusion;
pub mod facing;
mod grazing;
mod hard;
mod horizon;
mod interpolation;
mod lane_plane;
mod lanes;
mod least_depth;
mod light_extent;
mod lighting;
pub mod lookup;
mod midpoint;
pub mod packing;
pub mod pattern;
mod pcf;
mod pcf_disc;
mod pcf_dithered;
mod pcf_hardware;
mod pcf_merged;
pub mod pcss;
mod pcss_lanes;
mod planar;
mod planar_flatten;
mod planar_matrix;
mod planar_planes;
mod preset;
mod rounding;
mod sampled;
pub mod sampling;
mod seams;
mod second_depth;
mod settings;
pub mod shadow_map;
mod silhouette;
mod soft_taps;
mod surface;
mod surface_tables;
mod texture;
mod traced;
mod unshadowed;
mod volumes;
mod window;

pub use bias::{Bias, Footprint};
pub use blinn_phong::{BlinnPhong, BlinnPhongKernel, BlinnPhongUniforms, Shading};
pub use catalogue::{Entry, Settings, all, find};
pub use depth_in_reach::{DepthInReachKernel, DepthInReachUniforms};
pub use hard::{Hard, HardKernel};
pub use horizon::Horizon;
pub use least_depth::{LeastDepthKernel, LeastDepthUniforms};
pub use light_extent::LightExtent;
pub use midpoint::{BetweenKernel, BetweenUniforms, Midpoint};
pub use pattern::Pattern;
pub use pcf::{MAX_RADIUS, Pcf, PcfKernel, PcfUniforms};
pub use pcf_disc::{MAX_DISC_RADIUS, PcfDisc, PcfDiscKernel, PcfDiscUniforms};
pub use pcf_dithered::{PcfDithered, PcfDitheredKernel};
pub use pcf_hardware::{HardwareKernel, HardwareUniforms, PcfHardware};
pub use pcf_merged::{MergedKernel, MergedUniforms, PcfMerged};
pub use pcss::{Pcss, PcssKernel, PcssUniforms};
pub use planar::{MAX_PLANES, Planar, PlanarKernel, PlanarUniforms};
pub use planar_matrix::planar_shadow_matrix;
pub use preset::Preset;
pub use sampled::WEIGHT_ERROR;
pub use second_depth::SecondDepth;
pub use shadow_map::{BeyondFar, Border, MapFormat, ShadowMap, Surface};
pub use traced::{MAX_SAMPLES, Traced, TracedKernel, TracedUniforms};
pub use unshadowed::{Unshadowed, UnshadowedKernel, UnshadowedUniforms};
pub use volumes::{ShadowVolumes, VolumesKernel, VolumesUniforms};

use umbrage_core::Twin;

/// Every pair of functions that the techniques share between the languages, for the lockstep tests.
pub fn twins() -> impl Iterator<Item = &'static Twin> {
    [
        lookup::TWINS,
        packing::TWINS,
        sampling::TWINS,
        interpolation::TWINS,
        lighting::TWINS,
        texture::TWINS,
        pattern::TWINS,
        soft_taps::TWINS,
        light_extent::TWINS,
        horizon::TWINS,
        facing::TWINS,
    ]
    .into_iter()
    .flatten()
}
