//! Tests of a frame's cost: nothing without changes, and never more than the budget.

use glam::{Affine3A, UVec2, Vec3};
use std::sync::Arc;
use umbrage_core::{Aabb, Layout, ShadowTechnique};
use umbrage_techniques::{Bias, Evsm, MapFilter as _, Pcf, PcfHardware, ShadowMap};
use umbrage_tests::{
    foreign,
    light_program::Forward,
    light_stage::{LAYER, Stage, camera, hard, spot, translation_along_x},
};
use umbrage_wgpu::{
    CasterMesh, Indices, LightId, LightSet, SetBudget, SetFrame, SetReport, ShadowedLight,
    Unserved, VertexLayout,
};
use wgpu::{BufferUsages, ErrorFilter, IndexFormat};

#[test]
fn a_still_frame_draws_and_writes_nothing() {
    let mut stage = Stage::new(SetBudget::default(), &[-4.0, 0.0, 4.0]);
    for x in [-4.0, 0.0, 4.0] {
        stage.light(x, 1.0);
    }
    let first = stage.frame();
    assert_eq!((first.planned, first.redrawn), (3, 3));
    let made = stage.set.counters();
    assert_eq!(stage.frame(), SetReport::default());
    // A moving camera doesn't cause planning of maps that don't follow it.
    stage.camera = camera(1.0);
    assert_eq!(stage.frame(), SetReport::default());
    // A moved caster is redrawn where it is visible, and nowhere else.
    let middle = stage.casters[1];
    stage
        .set
        .move_caster(middle, translation_along_x(0.1))
        .expect("is there");
    assert_eq!(stage.frame().redrawn, 1);
    stage
        .set
        .move_caster(middle, translation_along_x(0.1))
        .expect("is there");
    assert_eq!(stage.frame().redrawn, 0);
    // Querying the set's support has no cost, either.
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    let checked = stage.set.check(&spot(1.0), &*hard(), &frame);
    assert_eq!(checked, Ok(()));
    assert_eq!(stage.frame(), SetReport::default());
    assert_eq!(stage.set.counters(), made);
}

#[test]
fn lights_beyond_the_bytes_are_lit_and_listed() {
    let budget = SetBudget {
        bytes: 2 * LAYER,
        ..SetBudget::default()
    };
    let mut stage = Stage::new(budget, &[-4.0, 0.0, 4.0]);
    let left = stage.light(-4.0, 1.0);
    let middle = stage.light(0.0, 3.0);
    let right = stage.light(4.0, 2.0);
    stage.frame();
    assert_eq!(stage.unserved_ids(), [left]);
    let lit: Vec<bool> = [left, middle, right]
        .into_iter()
        .map(|id| stage.shadowed_pixels(id) == 0)
        .collect();
    assert_eq!(lit, [true, false, false]);
    assert!(stage.set.map_bytes() <= budget.bytes);
    // The remaining light is served when another is removed or has a lower priority.
    stage.set.set_priority(middle, 0.5).expect("is there");
    stage.frame();
    assert_eq!(stage.unserved_ids(), [middle]);
    assert!(stage.shadowed_pixels(left) > 0 && stage.shadowed_pixels(middle) == 0);
    stage.set.remove_light(right).expect("is there");
    stage.frame();
    assert_eq!(stage.unserved_ids(), []);
    assert!(stage.shadowed_pixels(middle) > 0);
}

#[test]
fn redraws_are_spread_over_frames() {
    let budget = SetBudget {
        redraws: 1,
        ..SetBudget::default()
    };
    let mut stage = Stage::new(budget, &[-4.0, 0.0, 4.0]);
    let lights = [(-4.0, 1.0), (0.0, 3.0), (4.0, 2.0)].map(|(x, p)| stage.light(x, p));
    let first = stage.frame();
    assert_eq!((first.redrawn, first.waiting), (1, 2));
    let waiting: Vec<(LightId, Unserved)> = stage.set.unserved_lights().collect();
    assert!(waiting.contains(&(lights[0], Unserved::Waiting)) && waiting.len() == 2);
    assert!(stage.shadowed_pixels(lights[1]) > 0 && stage.shadowed_pixels(lights[2]) == 0);
    // Priorities grow with waiting time: two frames later, all are served.
    stage.frame();
    stage.frame();
    assert_eq!(stage.unserved_ids(), []);
    assert_eq!(stage.frame(), SetReport::default());
}

/// A budget never lets shaders read maps that were not drawn. A prepared but discarded frame is
/// made up for at once.
#[test]
fn thrown_away_redraws_are_not_put_off() {
    let budget = SetBudget {
        redraws: 1,
        ..SetBudget::default()
    };
    for is_recorded in [false, true] {
        let mut stage = Stage::new(budget, &[-4.0, 0.0]);
        let first = stage.light(-4.0, 2.0);
        let second = stage.light(0.0, 100.0);
        stage.frame();
        stage.frame();
        stage.set.set_light(first, spot(0.4)).expect("is there");
        let frame = SetFrame {
            camera: &stage.camera,
            geometry: None,
        };
        stage.set.prepare(&frame).expect("prepares");
        if is_recorded {
            let mut encoder = stage.program.encoder();
            stage.set.encode(&mut encoder).expect("was prepared");
        }
        // A light of higher priority uses the whole budget.
        stage.set.set_light(second, spot(-0.4)).expect("is there");
        stage.frame();
        let at_once = stage.shadowed_pixels(first);
        assert!(at_once > 0 && stage.shadowed_pixels(second) > 0);
        // When no light waits, the shadows are up to date.
        stage.frame();
        stage.frame();
        assert_eq!(at_once, stage.shadowed_pixels(first));
    }
}

/// 256 lights fit WebGPU's default limits, which the tests' device has.
#[test]
fn two_hundred_and_fifty_six_lights_fit() {
    let places: Vec<f32> = (0..8).map(|i| i as f32 * 2.0 - 7.0).collect();
    let mut stage = Stage::new(SetBudget::default(), &places);
    let light = |stage: &mut Stage, i: usize| stage.light(places[i % 8] + 0.001 * i as f32, 1.0);
    let mut lights: Vec<LightId> = Vec::new();
    let mut revisions = Vec::new();
    // Few lights are in a uniform buffer, many in a storage buffer. Both must have the same result.
    for count in [1, 40, 256] {
        while lights.len() < count {
            let i = lights.len();
            lights.push(light(&mut stage, i));
        }
        stage.frame();
        assert_eq!(stage.unserved_ids(), []);
        let is_uniform = stage.set.wgsl().contains("var<uniform> shadow_set");
        assert_eq!(is_uniform, count <= 40, "{count} lights");
        revisions.push((stage.set.wgsl_revision(), stage.shadowed_pixels(lights[0])));
    }
    assert_eq!(revisions[0], revisions[1], "lights have room that is left");
    assert_eq!(revisions[1].1, revisions[2].1);
    assert!(revisions[1].0 < revisions[2].0);
    for id in [lights[0], lights[100], lights[255]] {
        assert!(stage.shadowed_pixels(id) > 0);
    }
    assert_eq!(stage.frame(), SetReport::default());
}

#[test]
fn what_can_not_be_used_is_refused_by_name() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let caster = stage.casters[0];
    // The mesh is flat, so that some numbers are multiplied by 0.
    for i in 0..12 {
        for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut columns = Affine3A::IDENTITY.to_cols_array();
            columns[i] = number;
            let nowhere = Affine3A::from_cols_array(&columns);
            let moved = stage.set.move_caster(caster, nowhere);
            let error = moved.expect_err("not finite").to_string();
            assert!(error.contains("caster of mesh `triangle`"), "{error}");
            assert!(error.contains("world from local"), "{error}");
        }
    }
    let d = stage.program.d;
    let buffer = foreign::buffer(d, BufferUsages::INDEX, &[0; 36]);
    let mesh = CasterMesh {
        label: "crate",
        vertices: &buffer,
        layout: VertexLayout::PACKED,
        indices: None,
        range: 0..3,
        base_vertex: 0,
        bounds: Aabb::from_points([Vec3::ZERO]),
    };
    let error = stage.set.add_mesh(&mesh).expect_err("no vertex buffer");
    let text = error.to_string();
    assert!(
        text.contains("mesh `crate`") && text.contains("VERTEX"),
        "{text}"
    );
    let vertices = foreign::buffer(d, BufferUsages::VERTEX, &[0; 12 * 64]);
    let indices = foreign::buffer(d, BufferUsages::INDEX, &[0; 2 * 36]);
    let indexed = CasterMesh {
        vertices: &vertices,
        indices: Some(Indices {
            buffer: &indices,
            format: IndexFormat::Uint16,
        }),
        range: 0..36,
        ..mesh
    };
    for (range, base_vertex, needed) in [
        (0..35, 0, "multiple of three"),
        (0..36, 64, "holds 64 vertices"),
        (0..36, -70_000, "at most 65535"),
    ] {
        let mesh = CasterMesh {
            range,
            base_vertex,
            ..indexed.clone()
        };
        let error = stage.set.add_mesh(&mesh).expect_err("no triangles");
        assert!(error.to_string().contains(needed), "{error}");
    }
    stage.set.add_mesh(&indexed).expect("valid");
    stage.set.remove_caster(caster).expect("is there");
    let error = stage.set.remove_caster(caster).expect_err("is gone");
    assert!(error.to_string().contains("removed"), "{error}");
    let light = ShadowedLight {
        light: spot(f32::INFINITY),
        technique: hard(),
        priority: 1.0,
    };
    assert!(stage.set.add_light(light).is_err());
    let id = stage.light(0.0, 1.0);
    for priority in [-1.0, f32::NAN] {
        let error = stage
            .set
            .set_priority(id, priority)
            .expect_err("no priority");
        assert!(error.to_string().contains("use 0 or more"), "{error}");
    }
}

/// A technique of another kind has another text, and so has an unrolled radius. A pipeline with the
/// text of before must not draw with the bind group of now.
#[test]
fn pipelines_of_past_revisions_are_refused() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let id = stage.light(0.0, 1.0);
    stage.frame();
    let index = stage.set.index_of(id).expect("is there");
    let device = &stage.program.d.device;
    let mut forward = Forward::default();
    forward.keeps_stale_pipelines = true;
    let mut draw = |set: &LightSet| {
        let scope = device.push_error_scope(ErrorFilter::Validation);
        forward.mask(&stage.program, set, index);
        pollster::block_on(scope.pop()).map(|error| error.to_string())
    };
    assert_eq!(draw(&stage.set), None);
    let map = hard().map;
    for filter in [Pcf::new(1), Pcf::unrolled(2)] {
        let technique = Arc::new(filter.on(map));
        stage.set.set_technique(id, technique).expect("is there");
        let frame = SetFrame {
            camera: &stage.camera,
            geometry: None,
        };
        stage.program.update(&mut stage.set, &frame);
        let error = draw(&stage.set).expect("a stale pipeline");
        assert!(error.contains("layout"), "{error}");
    }
    forward.keeps_stale_pipelines = false;
    let index = stage.set.index_of(id).expect("is there");
    forward.mask(&stage.program, &stage.set, index);
}

/// A program can have the text of other techniques before it sets them, and returns to a text of
/// before without new pipelines.
#[test]
fn texts_are_known_beforehand() {
    let mut stage = Stage::new(SetBudget::default(), &[-4.0, 4.0]);
    let lights = [-4.0, 4.0].map(|x| stage.light(x, 1.0));
    stage.frame();
    let map = hard().map;
    let small = ShadowMap { size: 32, ..map };
    let several = ShadowMap {
        layout: Layout::Cube,
        ..map
    };
    let techniques: [Arc<dyn ShadowTechnique>; 6] = [
        Arc::new(Pcf::new(1).on(map)),
        Arc::new(Pcf::new(1).on(small)),
        Arc::new(Pcf::new(2).on(several)),
        Arc::new(PcfHardware::default().on(map)),
        Arc::new(Evsm::default().on(map)),
        Arc::new(Pcf::unrolled(2).on(small)),
    ];
    let mut revisions = Vec::new();
    for technique in &techniques {
        let frame = SetFrame {
            camera: &stage.camera,
            geometry: None,
        };
        let before = stage.set.wgsl_revision();
        let change = [(lights[1], technique.clone())];
        let expected = stage.set.text_with(&frame, &change).expect("supported");
        // Nothing changed yet.
        assert_eq!(stage.set.wgsl_revision(), before);
        assert_eq!(stage.frame(), SetReport::default());
        stage
            .set
            .set_technique(lights[1], technique.clone())
            .expect("is there");
        stage.frame();
        assert_eq!(stage.unserved_ids(), []);
        let (_, layout) = stage.set.bind_group().expect("is prepared");
        assert!(stage.set.wgsl() == expected.wgsl, "{technique:?}");
        assert_eq!(*layout, expected.layout);
        assert_eq!(stage.set.wgsl_revision(), expected.revision);
        assert!(!revisions.contains(&expected.revision), "{technique:?}");
        assert!(stage.shadowed_pixels(lights[1]) > 0);
        revisions.push(expected.revision);
    }
    // An earlier text keeps its number.
    let again = techniques[0].clone();
    stage.set.set_technique(lights[1], again).expect("is there");
    stage.frame();
    assert_eq!(stage.set.wgsl_revision(), revisions[0]);
    assert!(stage.shadowed_pixels(lights[1]) > 0);
}

/// Settings that are uniforms change neither text nor layout.
#[test]
fn a_radius_a_bias_and_a_size_change_no_text() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let id = stage.light(0.0, 1.0);
    let map = ShadowMap {
        bias: Bias::CONSTANT,
        ..hard().map
    };
    let bias = Bias {
        constant: 2.0 * map.bias.constant,
        ..map.bias
    };
    let mut texts = Vec::new();
    for technique in [
        Pcf::new(1).on(map),
        Pcf::new(2).on(map),
        Pcf::new(3).on(map),
        Pcf::new(3).on(ShadowMap { bias, ..map }),
        Pcf::new(3).on(ShadowMap { size: 96, ..map }),
    ] {
        stage
            .set
            .set_technique(id, Arc::new(technique))
            .expect("is there");
        stage.frame();
        assert!(stage.shadowed_pixels(id) > 0);
        texts.push(stage.set.wgsl_revision());
    }
    assert!(texts.iter().all(|text| *text == texts[0]), "{texts:?}");
}

/// A light that is off costs nothing and is lit; afterwards, it has the shadows of a new set.
#[test]
fn lights_are_switched_off_and_on() {
    let mut stage = Stage::new(SetBudget::default(), &[-4.0, 4.0]);
    let lights = [-4.0, 4.0].map(|x| stage.light(x, 1.0));
    stage.frame();
    let shadowed = stage.shadowed_pixels(lights[1]);
    assert!(shadowed > 0);
    let revision = stage.set.wgsl_revision();
    stage.set.set_enabled(lights[1], false).expect("is there");
    // Move a caster within the light that is off, and back.
    for x in [3.9, 4.0] {
        let place = translation_along_x(x);
        let caster = stage.casters[1];
        stage.set.move_caster(caster, place).expect("is there");
        assert_eq!(stage.frame().redrawn, 0);
        assert_eq!(stage.shadowed_pixels(lights[1]), 0);
        assert!(stage.shadowed_pixels(lights[0]) > 0);
    }
    assert_eq!(stage.set.unserved_lights().count(), 0);
    stage.set.set_enabled(lights[1], true).expect("is there");
    assert_eq!(stage.frame().redrawn, 1);
    assert_eq!(stage.shadowed_pixels(lights[1]), shadowed);
    assert_eq!(stage.set.wgsl_revision(), revision);
    assert_eq!(stage.frame(), SetReport::default());
}

/// Passes of a light that was removed after `prepare` are skipped.
#[test]
fn lights_may_be_removed_between_prepare_and_encode() {
    let mut stage = Stage::new(SetBudget::default(), &[-4.0, 4.0]);
    let lights = [-4.0, 4.0].map(|x| stage.light(x, 1.0));
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    stage.set.remove_light(lights[0]).expect("is there");
    let mut encoder = stage.program.encoder();
    stage.set.encode(&mut encoder).expect("was prepared");
    stage.program.d.queue.submit([encoder.finish()]);
    assert!(stage.shadowed_pixels(lights[1]) > 0);
    assert_eq!(stage.frame().redrawn, 0);
    assert!(stage.shadowed_pixels(lights[1]) > 0);
}

/// An encoder that lives, but is not submitted before the next frame.
#[test]
fn frames_that_are_not_submitted_are_drawn_again() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let id = stage.light(0.0, 1.0);
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    let mut kept = stage.program.encoder();
    stage.set.encode(&mut kept).expect("was prepared");
    assert_eq!(stage.frame().redrawn, 1);
    assert!(stage.shadowed_pixels(id) > 0);
    let away = translation_along_x(8.0);
    stage
        .set
        .move_caster(stage.casters[0], away)
        .expect("is there");
    assert_eq!(stage.frame().redrawn, 1);
    assert_eq!(stage.shadowed_pixels(id), 0);
    // The encoder of the first frame overwrites the layer.
    stage.program.d.queue.submit([kept.finish()]);
    assert_eq!(stage.frame().redrawn, 1);
    assert_eq!(stage.shadowed_pixels(id), 0);
    assert_eq!(stage.frame().redrawn, 0);
}

/// The placements of a frame that was dropped are those of the next one.
#[test]
fn moves_of_a_dropped_frame_are_not_lost() {
    let mut stage = Stage::new(SetBudget::default(), &[8.0]);
    let id = stage.light(0.0, 1.0);
    stage.frame();
    assert_eq!(stage.shadowed_pixels(id), 0);
    let below = translation_along_x(0.0);
    stage
        .set
        .move_caster(stage.casters[0], below)
        .expect("is there");
    let frame = SetFrame {
        camera: &stage.camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    let mut dropped = stage.program.encoder();
    stage.set.encode(&mut dropped).expect("was prepared");
    drop(dropped);
    assert_eq!(stage.frame().redrawn, 1);
    assert!(stage.shadowed_pixels(id) > 0);
}

/// Before the first frame, and after one that failed, nothing waits for a budget.
#[test]
fn lights_of_a_frame_that_failed_are_not_prepared() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    stage.light(0.0, 1.0);
    let reasons = |set: &LightSet| -> Vec<Unserved> {
        set.unserved_lights().map(|(_, reason)| reason).collect()
    };
    assert_eq!(reasons(&stage.set), [Unserved::NotPrepared]);
    let camera = stage.camera.with_size(UVec2::ZERO);
    let frame = SetFrame {
        camera: &camera,
        geometry: None,
    };
    assert!(stage.set.prepare(&frame).is_err());
    assert_eq!(reasons(&stage.set), [Unserved::NotPrepared]);
    stage.frame();
    assert_eq!(reasons(&stage.set), []);
    stage.light(0.0, 1.0);
    assert_eq!(reasons(&stage.set), [Unserved::NotPrepared]);
}

/// A budget of one layer a frame doesn't show a light that was switched on as it was before.
#[test]
fn lights_switched_on_show_their_new_shadows_at_once() {
    let budget = SetBudget {
        redraws: 1,
        ..SetBudget::default()
    };
    let mut stage = Stage::new(budget, &[-4.0, 4.0]);
    // The first light is more urgent, and its caster moves in every frame.
    let lights = [stage.light(-4.0, 100.0), stage.light(4.0, 1.0)];
    stage.frame();
    stage.frame();
    assert!(stage.shadowed_pixels(lights[1]) > 0);
    stage.set.set_enabled(lights[1], false).expect("is there");
    let away = translation_along_x(8.0);
    stage
        .set
        .move_caster(stage.casters[1], away)
        .expect("is there");
    stage.frame();
    let place = translation_along_x(-3.9);
    stage
        .set
        .move_caster(stage.casters[0], place)
        .expect("is there");
    stage.set.set_enabled(lights[1], true).expect("is there");
    assert_eq!(stage.frame().redrawn, 2);
    assert_eq!(stage.shadowed_pixels(lights[1]), 0);
}

/// Ids look alike in two sets with the same parts.
#[test]
fn ids_of_another_set_are_refused() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let mut other = Stage::new(SetBudget::default(), &[0.0]);
    let own = stage.light(0.0, 1.0);
    let foreign_id = other.light(0.0, 1.0);
    assert_ne!(own, foreign_id);
    let bounds = Aabb {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    };
    let figure = other.set.add_own_caster(bounds).expect("valid");
    let d = other.program.d;
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = foreign::add_triangle(d, &mut other.set, BufferUsages::VERTEX, corners);
    let refusals = [
        stage.set.remove_light(foreign_id).err(),
        stage.set.set_priority(foreign_id, 2.0).err(),
        stage.set.index_of(foreign_id).err(),
        stage.set.remove_caster(other.casters[0]).err(),
        stage.set.remove_own_caster(figure).err(),
        stage.set.move_own_caster(figure, bounds).err(),
        stage.set.remove_mesh(mesh).err(),
        stage.set.add_caster(mesh, Affine3A::IDENTITY).err(),
    ];
    for refusal in refusals {
        let text = refusal.expect("an id of another set").to_string();
        assert!(text.contains("another light set"), "{text}");
    }
    stage.frame();
    assert!(stage.shadowed_pixels(own) > 0);
}
