//! The techniques, one a file in Rust beside one of the same name in WGSL.

pub mod evsm;
pub mod exact;
pub mod hard;
pub(crate) mod infinite_far;
pub mod midpoint;
pub mod msm;
pub mod pcf;
pub mod pcf_disc;
pub mod pcf_dithered;
pub mod pcf_hardware;
pub mod pcf_merged;
pub mod pcss;
pub mod planar;
pub mod second_depth;
pub mod soft;
pub mod traced;
pub mod unshadowed;
pub mod volumes;
pub mod vsm;
