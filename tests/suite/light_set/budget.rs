//! What a frame costs: nothing where nothing changed, and never more than the budget.

use super::program::{Forward, Program};
use bytemuck::cast_slice;
use glam::{Affine3A, UVec2, Vec3};
use std::sync::Arc;
use umbrage_core::{Aabb, Camera, Light};
use umbrage_techniques::{Hard, ShadowMap};
use umbrage_tests::foreign;
use umbrage_wgpu::{
    CasterId, LightId, LightSet, LightSetOptions, Mesh, SetBudget, SetErrors, SetFrame, SetLight,
    SetReport, Unserved, VertexLayout,
};
use wgpu::BufferUsages;

const SIDE: u32 = 64;
/// Bytes of a layer.
const LAYER: u64 = 4 * SIDE as u64 * SIDE as u64;

fn hard() -> Arc<Hard> {
    let map = ShadowMap {
        size: SIDE,
        ..ShadowMap::default()
    };
    Arc::new(Hard { map })
}

/// A spot that shines down on the floor around `x`.
fn spot(x: f32) -> Light {
    Light::Spot {
        position: Vec3::new(x, 6.0, 0.0),
        direction: Vec3::NEG_Y,
        inner: 0.2,
        outer: 0.25,
        radius: 0.0,
    }
}

fn camera(x: f32) -> Camera {
    let size = UVec2::new(64, 48);
    let eye = Vec3::new(x, 5.0, 12.0);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.9, [0.1, 100.0], size).expect("valid")
}

struct Stage {
    program: Program,
    set: LightSet,
    casters: Vec<CasterId>,
    camera: Camera,
}

impl Stage {
    /// A set with a triangle above the floor at each of these places.
    fn new(budget: SetBudget, places: &[f32]) -> Self {
        let program = Program::floor(UVec2::new(64, 48));
        let options = LightSetOptions {
            group: 1,
            errors: SetErrors::AtOnce,
            budget,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(&program.d.device, options).expect("fits");
        let corners = [[-0.5_f32, 0.0, -0.5], [0.5, 0.0, -0.5], [0.0, 0.0, 0.5]];
        let vertices = foreign::buffer(program.d, BufferUsages::VERTEX, cast_slice(&corners));
        let mesh = Mesh {
            label: "triangle",
            vertices: &vertices,
            layout: VertexLayout::PACKED,
            indices: None,
            range: 0..3,
            base_vertex: 0,
            bounds: Aabb::around(corners.map(Vec3::from_array)),
        };
        let mesh = set.add_mesh(&mesh).expect("valid");
        let casters = places
            .iter()
            .map(|&x| set.add_caster(mesh, at(x)).expect("valid"))
            .collect();
        Self {
            program,
            set,
            casters,
            camera: camera(0.0),
        }
    }

    fn light(&mut self, x: f32, priority: f32) -> LightId {
        let light = SetLight {
            light: spot(x),
            technique: hard(),
            priority,
        };
        self.set.add_light(light).expect("valid")
    }

    fn frame(&mut self) -> SetReport {
        let frame = SetFrame {
            camera: &self.camera,
            geometry: None,
        };
        self.program.update(&mut self.set, &frame);
        *self.set.report()
    }

    fn unserved(&self) -> Vec<LightId> {
        self.set.unserved().map(|(id, _)| id).collect()
    }

    fn shadowed(&self, id: LightId) -> usize {
        let index = self.set.index_of(id).expect("is there");
        let mask = Forward::new().mask(&self.program, &self.set, index);
        mask.iter().filter(|&&v| v < 1.0).count()
    }
}

fn at(x: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, 2.0, 0.0))
}

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
    // A camera that moves makes plans, which turn out to be the same.
    stage.camera = camera(1.0);
    let turned = stage.frame();
    assert_eq!((turned.redrawn, turned.uploaded), (0, 0));
    // A caster that moves is drawn again where it shows, and nowhere else.
    let middle = stage.casters[1];
    stage.set.move_caster(middle, at(0.1)).expect("is there");
    assert_eq!(stage.frame().redrawn, 1);
    stage.set.move_caster(middle, at(0.1)).expect("is there");
    assert_eq!(stage.frame().redrawn, 0);
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
    assert_eq!(stage.unserved(), [left]);
    let lit: Vec<bool> = [left, middle, right]
        .into_iter()
        .map(|id| stage.shadowed(id) == 0)
        .collect();
    assert_eq!(lit, [true, false, false]);
    assert!(stage.set.map_bytes() <= budget.bytes);
    // The light that is left over gets its turn when another leaves or counts less.
    stage.set.set_priority(middle, 0.5).expect("is there");
    stage.frame();
    assert_eq!(stage.unserved(), [middle]);
    assert!(stage.shadowed(left) > 0 && stage.shadowed(middle) == 0);
    stage.set.remove_light(right).expect("is there");
    stage.frame();
    assert_eq!(stage.unserved(), []);
    assert!(stage.shadowed(middle) > 0);
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
    let waiting: Vec<(LightId, Unserved)> = stage.set.unserved().collect();
    assert!(waiting.contains(&(lights[0], Unserved::Waiting)) && waiting.len() == 2);
    assert!(stage.shadowed(lights[1]) > 0 && stage.shadowed(lights[2]) == 0);
    // Whoever waits gets more urgent: two frames later all are served.
    stage.frame();
    stage.frame();
    assert_eq!(stage.unserved(), []);
    assert_eq!(stage.frame(), SetReport::default());
}

/// 256 lights in WebGPU's own limits, which the tests' device has.
#[test]
fn two_hundred_and_fifty_six_lights_fit() {
    let places: Vec<f32> = (0..8).map(|i| i as f32 * 2.0 - 7.0).collect();
    let mut stage = Stage::new(SetBudget::default(), &places);
    let lights: Vec<LightId> = (0..256)
        .map(|i| stage.light(places[i % 8] + 0.001 * i as f32, 1.0))
        .collect();
    assert_eq!(stage.frame().redrawn, 256);
    assert_eq!(stage.unserved(), []);
    for id in [lights[0], lights[100], lights[255]] {
        assert!(stage.shadowed(id) > 0);
    }
    assert_eq!(stage.frame(), SetReport::default());
}

#[test]
fn what_can_not_be_used_is_refused_by_name() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let nowhere = Affine3A::from_translation(Vec3::new(f32::NAN, 0.0, 0.0));
    let caster = stage.casters[0];
    let moved = stage.set.move_caster(caster, nowhere).expect_err("NaN");
    assert!(
        moved.to_string().contains("caster of mesh `triangle`"),
        "{moved}"
    );
    let d = stage.program.d;
    let buffer = foreign::buffer(d, BufferUsages::INDEX, &[0; 36]);
    let mesh = Mesh {
        label: "crate",
        vertices: &buffer,
        layout: VertexLayout::PACKED,
        indices: None,
        range: 0..3,
        base_vertex: 0,
        bounds: Aabb::around([Vec3::ZERO]),
    };
    let error = stage.set.add_mesh(&mesh).expect_err("no vertex buffer");
    let text = error.to_string();
    assert!(
        text.contains("mesh `crate`") && text.contains("VERTEX"),
        "{text}"
    );
    stage.set.remove_caster(caster).expect("is there");
    let error = stage.set.remove_caster(caster).expect_err("is gone");
    assert!(error.to_string().contains("removed"), "{error}");
    let light = SetLight {
        light: spot(f32::INFINITY),
        technique: hard(),
        priority: 1.0,
    };
    assert!(stage.set.add_light(light).is_err());
}
