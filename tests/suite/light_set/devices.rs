//! Tests of a set's requirements for a device, and of its reports.

use std::sync::Arc;
use umbrage_core::{Geometry, ShadowTechnique, View};
use umbrage_techniques::{Exact, MapFilter as _, ShadowMap, Traced, Vsm};
use umbrage_tests::{
    adapter::{TestDevice, open_with},
    foreign,
    light_stage::{LAYER, Stage, spot, translation_along_x},
};
use umbrage_wgpu::{
    FrameGeometry, LightId, LightSet, LightSetOptions, MaskFormat, MaskInputs, MaskReceivers,
    PassCasters, SetBudget, SetFrame, SetPass, SetTimestamps, ShadowedLight, StillLayers,
    TimedPass, Unserved,
};
use wgpu::{BufferUsages, DeviceDescriptor, Features, Limits, PollType};

const PLACES: [f32; 3] = [-4.0, 0.0, 4.0];

fn device(features: Features, limits: Limits) -> &'static TestDevice {
    let desc = DeviceDescriptor {
        required_features: features,
        required_limits: limits,
        ..DeviceDescriptor::default()
    };
    Box::leak(Box::new(open_with(&desc).expect("a device")))
}

/// Tables that a shader can't bind leave their light without shadows, and don't affect the others.
#[test]
fn tables_beyond_a_binding_are_refused() {
    let scene = umbrage_scenes::by_argument("cubes").expect("built in");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Traced { samples: 1 }.recipe(&view).expect("serves a sun");
    // Each of the tables fits, but not all of them together.
    let bytes = recipe.table_bytes();
    let limits = Limits {
        max_storage_buffer_binding_size: bytes - 16,
        ..LightSet::REQUIRED_LIMITS
    };
    let d = device(LightSet::REQUIRED_FEATURES, limits);
    let mut stage = Stage::on_device(d, SetBudget::default(), StillLayers::Auto, &PLACES);
    // A light with a map and without tables.
    stage.light(PLACES[0], 1.0);
    let traced = stage.set.add_light(ShadowedLight {
        light: spot(PLACES[1]),
        technique: Arc::new(Traced { samples: 1 }),
        priority: 2.0,
    });
    let traced = traced.expect("valid");
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: Some(FrameGeometry {
            triangles: &geometry,
            revision: 0,
        }),
    };
    stage.program.update(&mut stage.set, &frame);
    let unserved: Vec<_> = stage.set.unserved_lights().collect();
    let [(id, Unserved::Refused(why))] = &unserved[..] else {
        panic!("{unserved:?}");
    };
    assert_eq!(*id, traced);
    let why = why.to_string();
    assert!(why.contains("max_storage_buffer_binding_size"), "{why}");
}

/// Tables keep some of their memory when casters go. A light that needs it is not refused, neither
/// in a later frame nor in that in which casters or another light go.
#[test]
fn unused_table_memory_refuses_no_light() {
    const MANY: usize = 20_000;
    const FEW: usize = 4_000;
    // The tables of one light with many casters, and less than a second light with few needs.
    let limits = Limits {
        max_storage_buffer_binding_size: 130 * MANY as u64,
        ..Limits::default()
    };
    let d = device(LightSet::REQUIRED_FEATURES, limits);
    for is_later in [true, false] {
        let mut stage = Stage::on_device(d, SetBudget::default(), StillLayers::Auto, &[]);
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX;
        let corners = [[-0.01, 0.0, -0.01], [0.01, 0.0, -0.01], [0.0, 0.0, 0.01]];
        let mesh = foreign::add_triangle(d, &mut stage.set, usage, corners);
        let add_caster = |stage: &mut Stage, i: usize| {
            let at = translation_along_x(1e-4 * i as f32);
            stage.set.add_caster(mesh, at).expect("valid")
        };
        let casters: Vec<_> = (0..MANY).map(|i| add_caster(&mut stage, i)).collect();
        let removed = exact_light(&mut stage);
        stage.frame();
        // A light takes the memory of one that goes in the same frame.
        stage.set.remove_light(removed).expect("is there");
        let first = exact_light(&mut stage);
        stage.frame();
        let unserved: Vec<_> = stage.set.unserved_lights().collect();
        assert!(unserved.is_empty(), "{unserved:?}");
        for &caster in &casters[FEW..] {
            stage.set.remove_caster(caster).expect("is there");
        }
        if is_later {
            stage.frame();
        }
        let lights = [first, exact_light(&mut stage)];
        stage.frame();
        assert_eq!(stage.unserved_ids(), [], "later: {is_later}");
        let shadowed = lights.map(|id| stage.shadowed_pixels(id));
        assert!(
            shadowed[0] > 0 && shadowed[0] == shadowed[1],
            "{shadowed:?}"
        );
        // Negative control: many casters and two lights exceed the limit.
        for i in FEW..MANY {
            add_caster(&mut stage, i);
        }
        stage.frame();
        assert_eq!(stage.unserved_ids().len(), 1);
    }
}

fn exact_light(stage: &mut Stage) -> LightId {
    let light = ShadowedLight {
        light: spot(PLACES[1]),
        technique: Arc::new(Exact::default()),
        priority: 1.0,
    };
    stage.set.add_light(light).expect("valid")
}

/// The required limits suffice for few lights in a uniform buffer, and for many.
#[test]
fn the_required_limits_are_enough() {
    let d = device(LightSet::REQUIRED_FEATURES, LightSet::REQUIRED_LIMITS);
    let mut stage = Stage::on_device(d, SetBudget::default(), StillLayers::Auto, &PLACES);
    let mut lights = Vec::new();
    for count in [3, 30] {
        while lights.len() < count {
            lights.push(stage.light(PLACES[lights.len() % 3], 1.0));
        }
        stage.frame();
        assert_eq!(stage.unserved_ids(), []);
        let shadowed = lights.iter().map(|&id| stage.shadowed_pixels(id));
        assert!(shadowed.into_iter().all(|count| count > 0));
    }
    assert!(stage.set.wgsl().contains("var<storage> shadow_set"));
    // Compute passes filter the moment map and write masks of rays.
    let moments = Vsm::default().on(ShadowMap {
        size: 64,
        ..ShadowMap::default()
    });
    let techniques: [Arc<dyn ShadowTechnique>; 2] =
        [Arc::new(moments), Arc::new(Traced { samples: 1 })];
    for technique in techniques {
        let light = ShadowedLight {
            light: spot(PLACES[1]),
            technique,
            priority: 2.0,
        };
        lights.push(stage.set.add_light(light).expect("valid"));
    }
    let scene = umbrage_scenes::by_argument("cubes").expect("built in");
    let geometry = Geometry::bake(&scene).expect("valid");
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: Some(FrameGeometry {
            triangles: &geometry,
            revision: 0,
        }),
    };
    stage.program.update(&mut stage.set, &frame);
    assert_eq!(stage.unserved_ids(), []);
    for format in [MaskFormat::Unorm8, MaskFormat::Float32] {
        let inputs = MaskInputs {
            size: stage.program.size(),
            receivers: MaskReceivers::Positions(stage.program.gbuffer()),
            lights: &lights[28..],
            format,
        };
        stage.set.prepare_masks(&inputs).expect("the masks, too");
        let mut encoder = stage.program.encoder();
        stage.set.encode_masks(&mut encoder).expect("was prepared");
        stage.program.d.queue.submit([encoder.finish()]);
    }
}

#[test]
fn less_than_the_required_limits_is_not_enough() {
    let limits = Limits {
        max_storage_buffers_per_shader_stage: 0,
        ..LightSet::REQUIRED_LIMITS
    };
    let d = device(Features::empty(), limits);
    let error = LightSet::new(&d.device, &d.queue, LightSetOptions::default())
        .expect_err("no tables can be bound")
        .to_string();
    assert!(
        error.contains("max_storage_buffers_per_shader_stage"),
        "{error}"
    );
    assert!(error.contains("REQUIRED_LIMITS"), "{error}");
}

const TIMESTAMPS: Features =
    Features::TIMESTAMP_QUERY.union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

#[test]
fn each_pass_is_timed() {
    let d = device(TIMESTAMPS, Limits::default());
    let mut stage = Stage::on_device(d, SetBudget::default(), StillLayers::Auto, &PLACES);
    let lights = PLACES.map(|x| stage.light(x, 1.0));
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    let queries = d.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: None,
        ty: wgpu::QueryType::Timestamp,
        count: 16,
    });
    let mut encoder = stage.program.encoder();
    let mut casts: Vec<TimedPass> = Vec::new();
    let stamps = SetTimestamps {
        queries: &queries,
        range: 1..6,
    };
    stage
        .set
        .encode_timed(&mut encoder, |_, _, _| (), &stamps, &mut casts)
        .expect("was prepared");
    let cast = SetPass::Cast {
        layer: 0,
        casters: PassCasters::All,
    };
    // Five queries suffice for two of the three passes.
    assert_eq!(casts.len(), 2);
    for (timed, begin) in casts.iter().zip([1, 3]) {
        assert_eq!((timed.pass, timed.begin), (cast, begin));
        assert!(lights.contains(&timed.light));
    }
    let inputs = MaskInputs {
        size: stage.program.size(),
        receivers: MaskReceivers::Positions(stage.program.gbuffer()),
        lights: &lights,
        format: MaskFormat::Unorm8,
    };
    stage.set.prepare_masks(&inputs).expect("prepares");
    let mut masks: Vec<TimedPass> = Vec::new();
    let stamps = SetTimestamps {
        queries: &queries,
        range: 6..16,
    };
    stage
        .set
        .encode_masks_timed(&mut encoder, &stamps, &mut masks)
        .expect("was prepared");
    let of_lights: Vec<_> = masks
        .iter()
        .map(|timed| (timed.light, timed.pass))
        .collect();
    assert_eq!(of_lights, lights.map(|id| (id, SetPass::Mask)));
    // The queries of all listed passes are written, in order.
    let resolved = foreign::buffer(
        d,
        BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
        &[0; 512],
    );
    let read = foreign::buffer(
        d,
        BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        &[0; 512],
    );
    encoder.resolve_query_set(&queries, 1..5, &resolved, 0);
    encoder.resolve_query_set(&queries, 6..12, &resolved, 256);
    encoder.copy_buffer_to_buffer(&resolved, 0, &read, 0, 512);
    d.queue.submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |_| ());
    d.device
        .poll(PollType::wait_indefinitely())
        .expect("the device is there");
    let bytes = read.get_mapped_range(..).expect("mapped").to_vec();
    let ticks: &[u64] = bytemuck::cast_slice(&bytes);
    for pair in ticks[..4].chunks(2).chain(ticks[32..38].chunks(2)) {
        assert!(0 < pair[0] && pair[0] <= pair[1], "{pair:?}");
    }
}

/// Two triangles in one light's layer, of which one moves in each frame.
fn moving_stage(d: &'static TestDevice, still_layers: StillLayers) -> Stage {
    let mut stage = Stage::on_device(d, SetBudget::default(), still_layers, &[0.0, 0.3]);
    stage.light(0.0, 1.0);
    stage
}

fn run_frames(stage: &mut Stage, frames: std::ops::Range<u32>) {
    for i in frames {
        let caster = stage.casters[1];
        let x = 0.31 + 0.01 * (i % 5) as f32;
        stage
            .set
            .move_caster(caster, translation_along_x(x))
            .expect("is there");
        assert!(stage.frame().redrawn > 0);
    }
}

/// The measured time of copies decides whether still casters have a separate layer, when prices
/// change in either direction. Shadows stay the same.
#[test]
fn still_layers_go_where_copies_take_longer() {
    let mut stage = moving_stage(umbrage_tests::adapter::device(), StillLayers::Auto);
    // The first light has index 0.
    let index = 0;
    let mut forward = umbrage_tests::light_program::Forward::default();
    let mut masks = Vec::new();
    for (triangle, texel, layers) in [(1.0, 1e-9, 2), (1e-9, 1.0, 1), (1.0, 1e-9, 2)] {
        stage.set.assume_prices(triangle, texel);
        run_frames(&mut stage, 0..5);
        assert_eq!(
            stage.set.map_bytes(),
            layers * LAYER,
            "a triangle takes {triangle} s and a texel {texel} s"
        );
        masks.push(forward.mask(&stage.program, &stage.set, index));
    }
    assert!(masks[0].iter().any(|&v| v < 1.0));
    assert!(masks.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn prices_are_measured_where_there_are_timestamps() {
    let d = device(TIMESTAMPS, Limits::default());
    let mut stage = moving_stage(d, StillLayers::Always);
    assert_eq!(stage.set.measured_prices(), [None, None]);
    for i in 0..20 {
        run_frames(&mut stage, i..i + 1);
        d.device
            .poll(PollType::wait_indefinitely())
            .expect("the device is there");
    }
    let seen = stage.set.measured_prices();
    let is_plausible = |price: &Option<f64>| price.is_some_and(|s| (0.0..10.0).contains(&s));
    assert!(seen.iter().all(is_plausible), "{seen:?}");
    // Without timestamps, no time is known.
    let plain = umbrage_tests::adapter::device();
    let mut without = moving_stage(plain, StillLayers::Always);
    run_frames(&mut without, 0..3);
    assert_eq!(without.set.measured_prices(), [None, None]);
}
