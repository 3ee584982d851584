//! Triangles above a floor with spot lights above them: the scene of the tests of light sets.

use crate::{
    adapter::{TestDevice, device},
    foreign,
    light_program::{Forward, ForwardProgram},
};
use glam::{Affine3A, UVec2, Vec3};
use std::sync::Arc;
use umbrage_core::{Camera, Light};
use umbrage_techniques::{Hard, MapFilter as _, MapTechnique, ShadowMap};
use umbrage_wgpu::{
    CasterId, LightId, LightSet, SetBudget, SetFrame, SetReport, ShadowedLight, StillLayers,
};
use wgpu::BufferUsages;

/// Side of the maps, texels.
pub const SIDE: u32 = 64;
/// Bytes of a map.
pub const LAYER: u64 = 4 * SIDE as u64 * SIDE as u64;

/// One comparison on a small map.
pub fn hard() -> Arc<MapTechnique<Hard>> {
    let map = ShadowMap {
        size: SIDE,
        ..ShadowMap::default()
    };
    Arc::new(Hard {}.on(map))
}

/// Returns a spot light above the floor at `x` that points down.
pub fn spot(x: f32) -> Light {
    Light::Spot {
        position: Vec3::new(x, 6.0, 0.0),
        direction: Vec3::NEG_Y,
        inner: 0.2,
        outer: 0.25,
        radius: 0.0,
    }
}

/// Returns a camera moved to the right by `x` metres.
///
/// # Panics
/// Panics if `x` is not finite.
pub fn camera(x: f32) -> Camera {
    let size = UVec2::new(64, 48);
    let eye = Vec3::new(x, 5.0, 12.0);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.9, [0.1, 100.0], size).expect("valid")
}

/// A set, and the program that uses it.
#[derive(Debug)]
pub struct Stage {
    /// The program.
    pub program: ForwardProgram,
    /// The set.
    pub set: LightSet,
    /// The triangles.
    pub casters: Vec<CasterId>,
    /// The camera for which the set is prepared.
    pub camera: Camera,
}

impl Stage {
    /// Returns a set with a triangle above the floor at each of these positions.
    ///
    /// # Panics
    /// Panics if a position is not finite.
    pub fn new(budget: SetBudget, places: &[f32]) -> Self {
        Self::on_device(device(), budget, StillLayers::Auto, places)
    }

    /// Returns a set like that of [`Stage::new`] on another device.
    ///
    /// # Panics
    /// Panics if a position is not finite.
    pub fn on_device(
        d: &'static TestDevice,
        budget: SetBudget,
        still_layers: StillLayers,
        places: &[f32],
    ) -> Self {
        let program = ForwardProgram::floor(d, UVec2::new(64, 48));
        let mut set = program.set(budget, still_layers);
        let corners = [[-0.5_f32, 0.0, -0.5], [0.5, 0.0, -0.5], [0.0, 0.0, 0.5]];
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX;
        let mesh = foreign::add_triangle(program.d, &mut set, usage, corners);
        let casters = places
            .iter()
            .map(|&x| set.add_caster(mesh, translation_along_x(x)).expect("valid"))
            .collect();
        Self {
            program,
            set,
            casters,
            camera: camera(0.0),
        }
    }

    /// Adds a spot light that points down at `x`.
    ///
    /// # Panics
    /// Panics if a number is not finite.
    pub fn light(&mut self, x: f32, priority: f32) -> LightId {
        let light = ShadowedLight {
            light: spot(x),
            technique: hard(),
            priority,
        };
        self.set.add_light(light).expect("valid")
    }

    /// Runs a frame, and returns its report.
    pub fn frame(&mut self) -> SetReport {
        let frame = SetFrame {
            camera: &self.camera,
            geometry: None,
        };
        self.program.update(&mut self.set, &frame);
        *self.set.report()
    }

    /// Returns the lights that cast no shadows.
    pub fn unserved_ids(&self) -> Vec<LightId> {
        self.set.unserved_lights().map(|(id, _)| id).collect()
    }

    /// Returns the number of receivers in a light's shadow.
    ///
    /// # Panics
    /// Panics if there is no such light.
    pub fn shadowed_pixels(&self, id: LightId) -> usize {
        let index = self.set.index_of(id).expect("is there");
        let mask = Forward::default().mask(&self.program, &self.set, index);
        mask.iter().filter(|&&v| v < 1.0).count()
    }
}

/// Returns the placement of a triangle.
pub fn translation_along_x(x: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, 2.0, 0.0))
}
