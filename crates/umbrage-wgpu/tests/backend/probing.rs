//! Tests of the probe with drivers of known rounding.

use crate::scene::gpu;
use umbrage_core::{Backend, Snapping};
use umbrage_wgpu::probe_snapping;

#[test]
fn known_drivers_round_as_is_known() {
    let gpu = gpu();
    let info = gpu.adapter_info();
    let found = gpu.snapping();
    println!("{} ({}): {found}", info.name, info.driver_info);
    found.validate().expect("one of those known");
    if info.name.contains("llvmpipe") {
        assert_eq!(found, Snapping::default());
    }
    if info.name.contains("SwiftShader") {
        assert_eq!(found, Snapping::COARSEST);
    }
}

#[test]
fn probing_again_finds_the_same() {
    let gpu = gpu();
    let (device, queue) = gpu.device();
    assert_eq!(
        probe_snapping(device, queue).expect("the device works"),
        gpu.snapping()
    );
}
