//! Tests of error messages.

use crate::{
    kernels::Broken,
    scene::{BackendScene, gpu},
};
use glam::{UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{Backend, BackendError, Format, ImageDesc, View};
use umbrage_wgpu::{AdapterChoice, Gpu, Software};

#[test]
fn broken_wgsl_names_the_fault_and_does_no_harm() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let broken = stage.recipe_with(16, Arc::new(Broken(stage.numbers(Vec4::ZERO))));
    let error = gpu
        .render(&stage.view(), &broken)
        .expect_err("the kernel is broken");
    assert!(matches!(error, BackendError::Validation(_)), "{error:?}");
    assert!(error.to_string().contains("no_such_name"), "{error}");
    assert!(gpu.render(&stage.view(), &stage.recipe(16)).is_ok());
}

#[test]
fn maps_beyond_the_limit_are_refused() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let most = gpu.limits().image_side;
    let error = gpu
        .render(&stage.view(), &stage.recipe(most + 1))
        .expect_err("it is too large");
    assert!(
        error
            .to_string()
            .contains(&format!("use 1 to {most} on each side")),
        "{error}"
    );
}

#[test]
fn memory_that_is_not_there_is_an_error_and_does_no_harm() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let limits = gpu.limits();
    let mut recipe = stage.recipe(16);
    // Requests terabytes, within every limit of the API.
    let size = UVec2::splat(limits.image_side);
    let layers = limits.layers;
    recipe.images.push(ImageDesc {
        label: "vast",
        size,
        layers,
        format: Format::Rgba32,
    });
    let error = gpu
        .render(&stage.view(), &recipe)
        .expect_err("no device has that much");
    assert!(matches!(error, BackendError::OutOfMemory(_)), "{error:?}");
    assert!(error.to_string().contains("vast"), "{error}");
    assert!(gpu.render(&stage.view(), &stage.recipe(16)).is_ok());
}

#[test]
fn no_adapter_says_what_there_is_and_what_to_install() {
    let choice = AdapterChoice {
        name: Some("no such card".to_owned()),
        ..AdapterChoice::default()
    };
    let error = Gpu::new(&choice).expect_err("no card has that name");
    let BackendError::NoAdapter {
        wanted,
        found,
        help,
    } = &error
    else {
        panic!("{error:?}")
    };
    assert!(wanted.contains("no such card"), "{wanted}");
    assert!(!found.is_empty());
    assert!(
        help.contains("apt-get install mesa-vulkan-drivers libvulkan1"),
        "{help}"
    );
}

#[test]
fn a_name_in_any_case_finds_the_adapter() {
    let name = gpu().adapter_info().name;
    let choice = AdapterChoice {
        name: Some(name.to_uppercase()),
        ..AdapterChoice::default()
    };
    assert_eq!(
        Gpu::new(&choice).expect("it was there").adapter_info().name,
        name
    );
}

#[test]
fn hardware_only_never_gives_a_software_driver() {
    let choice = AdapterChoice {
        software: Software::Never,
        ..AdapterChoice::default()
    };
    match Gpu::new(&choice) {
        Ok(gpu) => assert_ne!(
            gpu.adapter_info().device_type,
            umbrage_wgpu::wgpu::DeviceType::Cpu
        ),
        Err(error) => assert!(matches!(error, BackendError::NoAdapter { .. }), "{error}"),
    }
}

#[test]
fn a_view_without_anything_to_see_is_refused() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let view = View {
        geometry: None,
        ..stage.view()
    };
    let mut recipe = stage.recipe(16);
    let error = gpu
        .render(&view, &recipe)
        .expect_err("there is nothing to cast");
    assert!(
        error
            .to_string()
            .contains("has no geometry, but the recipe casts"),
        "{error}"
    );
    recipe.casts.clear();
    let error = gpu
        .render(&view, &recipe)
        .expect_err("there is nothing to receive");
    assert!(
        error.to_string().contains("neither geometry nor receivers"),
        "{error}"
    );
}

#[test]
fn receivers_of_another_size_are_refused() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let receivers = umbrage_core::Receivers::empty(UVec2::new(3, 4));
    let error = gpu
        .render(&stage.view().with_receivers(&receivers), &stage.recipe(16))
        .expect_err("3 x 4");
    assert!(error.to_string().contains("3 x 4"), "{error}");
    let mut receivers = umbrage_core::Receivers::empty(stage.camera.size);
    assert!(
        gpu.render(&stage.view().with_receivers(&receivers), &stage.recipe(16))
            .is_ok()
    );
    receivers.nz.pop();
    let error = gpu
        .render(&stage.view().with_receivers(&receivers), &stage.recipe(16))
        .expect_err("one is missing");
    assert!(
        error.to_string().contains("an array has another length"),
        "{error}"
    );
}

#[test]
fn the_name_tells_adapter_and_api() {
    let gpu = gpu();
    assert_eq!(gpu.kind(), "wgpu");
    assert!(
        gpu.name().contains(&gpu.adapter_info().name),
        "{}",
        gpu.name()
    );
}

#[test]
fn a_lost_device_is_an_error_from_then_on() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    stage.render(&mut gpu, &stage.recipe(16));
    gpu.device().0.destroy();
    for _ in 0..2 {
        let error = gpu
            .render(&stage.view(), &stage.recipe(16))
            .expect_err("its device is gone");
        assert!(matches!(error, BackendError::DeviceLost(_)), "{error:?}");
    }
}
