//! Tests of kinds of maps and lookups against the reference: comparison samplers, midpoints, cubes,
//! coarse and packed depth.

mod cube;
mod formats;
mod hardware;
mod midpoint;
mod small_casters;
mod zenith;

use umbrage_core::{
    Backend, Camera, Geometry, Light, Scene, ShadowTechnique, View,
    metrics::{Errors, Pixel},
};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{Truth, TruthOptions, trace};
use umbrage_scenes::find;

/// A scene with its reference.
struct MapCase {
    scene: Scene,
    geometry: Geometry,
    truth: Truth,
}

impl MapCase {
    /// Returns a built-in scene.
    fn with_name(name: &str) -> Self {
        Self::of_scene((find(name).expect("a built-in scene").build)())
    }

    fn of_scene(scene: Scene) -> Self {
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let options = TruthOptions {
            samples: 64,
            ..TruthOptions::default()
        };
        let camera = &scene.cameras[0];
        let light = &scene.lights[0];
        let mut cpu = Cpu::new();
        let find = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
        let truth = trace(camera, light, &geometry, &options, find, &|_, _| {})
            .expect("built-in scenes are traced");
        Self {
            scene,
            geometry,
            truth,
        }
    }

    fn light(&self) -> &Light {
        &self.scene.lights[0]
    }

    fn view(&self) -> View<'_> {
        View::new(&self.scene.cameras[0], self.light(), &self.geometry)
            .with_receivers(&self.truth.receivers)
    }

    /// Returns the CPU's mask.
    fn mask(&self, technique: &dyn ShadowTechnique) -> Vec<f32> {
        let recipe = technique
            .recipe(&self.view())
            .expect("the technique serves the scene");
        Cpu::new()
            .render(&self.view(), &recipe)
            .expect("built-in scenes render")
            .mask
    }

    fn errors(&self, technique: &dyn ShadowTechnique) -> Errors {
        self.errors_of(&self.mask(technique))
    }

    fn errors_of(&self, mask: &[f32]) -> Errors {
        Errors::measure(
            self.truth.size,
            mask,
            &self.truth.visibility,
            &self.truth.pixels,
        )
        .expect("masks are valid")
    }

    /// Returns the evaluated pixels.
    fn counted_pixels(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.truth.pixels.len()).filter(|&i| self.truth.pixels[i] == Pixel::Counted)
    }
}
