//! Each light of a set gives the bits that its recipe gives alone.

use bytemuck::cast_slice;
use glam::{Affine3A, UVec2};
use std::sync::Arc;
use umbrage_core::{Backend, Geometry, Scene, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_techniques::{ShadowMap, TechniqueEntry, TechniquePreset};
use umbrage_tests::{
    foreign,
    gpu::gpu,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{
    CasterMesh, FrameGeometry, Indices, LightId, LightSet, SetBudget, SetFrame, SetLight,
    StillLayers, Unserved, VertexLayout,
};
use wgpu::{BufferUsages, IndexFormat};

/// Scenes with suns and lamps, within a cone and around.
const SCENES: [&str; 4] = ["cubes", "teapot-lamp", "lamp-in-room", "two-blockers"];
/// What a set can't play: it draws from the camera.
const REFUSED: [&str; 2] = ["planar", "volumes"];

/// A scene whose casters are one mesh of a set.
struct World {
    scene: Scene,
    geometry: Geometry,
    program: ForwardProgram,
}

impl World {
    fn new(name: &str) -> Self {
        let mut scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        scene.cameras[0] = scene.cameras[0].resized(UVec2::new(160, 120));
        let geometry = Geometry::bake(&scene).expect("valid");
        let receivers = Cpu::new()
            .receivers(&scene.cameras[0], &geometry)
            .expect("sees");
        let program = ForwardProgram::new(&receivers);
        Self {
            scene,
            geometry,
            program,
        }
    }

    fn frame(&self) -> SetFrame<'_> {
        SetFrame {
            camera: &self.scene.cameras[0],
            geometry: Some(FrameGeometry {
                triangles: &self.geometry,
                revision: 0,
            }),
        }
    }

    fn set(&self) -> LightSet {
        let d = self.program.d;
        let mut set = self.program.set(SetBudget::default(), StillLayers::Auto);
        let positions: Vec<[f32; 3]> = self
            .geometry
            .positions()
            .iter()
            .map(|p| p.to_array())
            .collect();
        let casters = self.geometry.run(&self.geometry.casters());
        let vertices = foreign::buffer(d, BufferUsages::VERTEX, cast_slice(&positions));
        let indices = foreign::buffer(d, BufferUsages::INDEX, cast_slice(casters));
        let mesh = CasterMesh {
            label: "casters",
            vertices: &vertices,
            layout: VertexLayout::PACKED,
            indices: Some(Indices {
                buffer: &indices,
                format: IndexFormat::Uint32,
            }),
            range: 0..3 * casters.len() as u32,
            base_vertex: 0,
            bounds: self.geometry.caster_bounds(),
        };
        let mesh = set.add_mesh(&mesh).expect("valid");
        set.add_caster(mesh, Affine3A::IDENTITY).expect("valid");
        set
    }

    /// Returns the mask of a technique that plays alone: on the GPU, and on the CPU.
    fn alone(&self, technique: &dyn ShadowTechnique, set: &LightSet) -> [Vec<f32>; 2] {
        let seen = View::new(
            &self.scene.cameras[0],
            &self.scene.lights[0],
            &self.geometry,
        );
        let planned = View {
            casters: set.casters_box(),
            ..seen
        };
        let recipe = technique.recipe(&planned).expect("serves the light");
        [
            gpu().render(&seen, &recipe).expect("plays").mask,
            Cpu::new().render(&seen, &recipe).expect("plays").mask,
        ]
    }
}

fn small(entry: &TechniqueEntry) -> Arc<dyn ShadowTechnique> {
    let preset = (entry.preset)();
    let map = preset.map().map(|map| ShadowMap { size: 192, ..*map });
    let preset: TechniquePreset = map.map_or(preset.clone(), |map| preset.with_map(map));
    preset.technique()
}

fn differing(a: &[f32], b: &[f32]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .filter(|(a, b)| a.to_bits() != b.to_bits())
        .count()
}

/// Every built-in technique, all in one set at the same time, on each scene.
#[test]
fn each_light_of_a_set_gives_the_bits_that_it_gives_alone() {
    for name in SCENES {
        let world = World::new(name);
        let mut set = world.set();
        let light = world.scene.lights[0];
        let mut ids: Vec<(LightId, &TechniqueEntry)> = Vec::new();
        // Six at a time: each kind of kernel takes one of the eight storage buffers that WebGPU gives to a stage.
        for entries in umbrage_techniques::all().chunks(6) {
            for (id, _) in ids.drain(..) {
                set.remove_light(id).expect("is there");
            }
            for entry in entries {
                let added = set.add_light(SetLight {
                    light,
                    technique: small(entry),
                    priority: 1.0,
                });
                ids.push((added.expect("valid"), entry));
            }
            world.program.update(&mut set, &world.frame());
            let unserved: Vec<(LightId, Unserved)> = set.unserved().collect();
            let mut forward = Forward::default();
            for &(id, entry) in &ids {
                let index = set.index_of(id).expect("is there");
                let mask = forward.mask(&world.program, &set, index);
                let why = unserved.iter().find(|(other, _)| *other == id);
                let checked = set.check(&light, &*small(entry), &world.frame());
                let refusal = checked.map_err(Unserved::Refused).err();
                assert_eq!(refusal.as_ref(), why.map(|(_, why)| why), "{}", entry.name);
                if REFUSED.contains(&entry.name) {
                    let is_refused = matches!(why, Some((_, Unserved::Refused(_))));
                    assert!(is_refused, "{}: {why:?}", entry.name);
                    assert!(mask.iter().all(|&v| v == 1.0), "{} is lit", entry.name);
                    continue;
                }
                let what = format!("{} in {name}", entry.name);
                assert!(
                    unserved.iter().all(|(other, _)| *other != id),
                    "{what}: {unserved:?}"
                );
                let [on_gpu, on_cpu] = world.alone(&*small(entry), &set);
                assert_eq!(differing(&mask, &on_gpu), 0, "{what}: other than alone");
                assert_eq!(
                    differing(&mask, &on_cpu),
                    0,
                    "{what}: other than on the CPU"
                );
                let shadowed = mask.iter().filter(|&&v| v < 1.0).count();
                assert!(shadowed > 100, "{what}: only {shadowed} pixels in shadow");
            }
        }
    }
}

/// The comparison above can fail: a map that lies elsewhere gives other bits.
#[test]
fn another_map_gives_other_bits() {
    let world = World::new("cubes");
    let mut set = world.set();
    let hard = umbrage_techniques::find("hard").expect("built in");
    let id = set
        .add_light(SetLight {
            light: world.scene.lights[0],
            technique: small(hard),
            priority: 1.0,
        })
        .expect("valid");
    world.program.update(&mut set, &world.frame());
    let index = set.index_of(id).expect("is there");
    let mask = Forward::default().mask(&world.program, &set, index);
    let preset = (hard.preset)();
    let other = preset.with_map(ShadowMap {
        size: 191,
        ..ShadowMap::default()
    });
    let [on_gpu, _] = world.alone(&*other.technique(), &set);
    assert!(differing(&mask, &on_gpu) > 10);
}
