//! Tests that each light of a set has the bits of its recipe alone.

use bytemuck::cast_slice;
use glam::{Affine3A, UVec2};
use std::sync::Arc;
use umbrage_core::{
    Aabb, AlphaFilter, Backend, Cascades, Geometry, Layout, Receivers, Recipe, Scene,
    ShadowTechnique, Shadows, View,
    metrics::{Agreement, MAX_UNDECIDED_SHARE},
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Evsm, MapFilter as _, MomentPrecision, Msm, ShadowMap, TechniqueEntry, TechniquePreset, Vsm,
};
use umbrage_tests::{
    agreed::check_agreement,
    driver_model::is_chosen,
    foreign,
    gpu::gpu,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{
    CasterId, CasterMesh, CutOutBuffers, FrameGeometry, Indices, LightId, LightSet, MeshId,
    SetBudget, SetFrame, ShadowedLight, StillLayers, Unserved, VertexLayout,
};
use wgpu::{BufferUsages, IndexFormat};

/// Scenes with suns, and with point and spot lights.
const SCENES: [&str; 5] = [
    "cubes",
    "teapot-lamp",
    "lamp-in-room",
    "two-blockers",
    FENCE,
];
/// A scene with alpha-tested casters.
const FENCE: &str = "wire-fence";
/// Techniques that a set can't execute, since they draw from the camera.
const REFUSED: [&str; 2] = ["planar", "volumes"];

/// A scene whose casters are one mesh of a set.
pub(super) struct World {
    pub(super) scene: Scene,
    pub(super) geometry: Geometry,
    pub(super) receivers: Receivers,
    pub(super) program: ForwardProgram,
}

impl World {
    pub(super) fn new(name: &str) -> Self {
        Self::of_scene((umbrage_scenes::find(name)
            .expect("a built-in scene")
            .build)())
    }

    pub(super) fn of_scene(scene: Scene) -> Self {
        Self::of_size(scene, UVec2::new(160, 120))
    }

    pub(super) fn of_size(mut scene: Scene, size: UVec2) -> Self {
        scene.cameras[0] = scene.cameras[0].with_size(size);
        let geometry = Geometry::bake(&scene).expect("valid");
        let receivers = Cpu::new()
            .receivers(&scene.cameras[0], &geometry)
            .expect("sees");
        let program = ForwardProgram::new(&receivers);
        Self {
            scene,
            geometry,
            receivers,
            program,
        }
    }

    pub(super) fn frame(&self) -> SetFrame<'_> {
        SetFrame {
            camera: &self.scene.cameras[0],
            geometry: Some(FrameGeometry {
                triangles: &self.geometry,
                revision: 0,
            }),
        }
    }

    pub(super) fn set(&self) -> LightSet {
        let mut set = self.empty_set();
        self.add_casters(&mut set);
        set
    }

    pub(super) fn empty_set(&self) -> LightSet {
        self.program.set(SetBudget::default(), StillLayers::Auto)
    }

    /// Adds the scene's casters to a set. Returns those of meshes, without the alpha-tested ones.
    pub(super) fn add_casters(&self, set: &mut LightSet) -> Vec<(MeshId, CasterId)> {
        let meshes = self.meshes(set);
        let mut add = |mesh| set.add_caster(mesh, Affine3A::IDENTITY).expect("valid");
        let casters = meshes.into_iter().map(|mesh| (mesh, add(mesh))).collect();
        let cut_outs = self.cut_outs();
        set.set_cut_outs(cut_outs.as_ref()).expect("valid");
        casters
    }

    /// Adds the scene's casters to a set as meshes, which cast nothing yet, except alpha-tested
    /// ones.
    pub(super) fn meshes(&self, set: &mut LightSet) -> Vec<MeshId> {
        let d = self.program.d;
        let positions: Vec<[f32; 3]> = self
            .geometry
            .positions()
            .iter()
            .map(|p| p.to_array())
            .collect();
        // Compute shaders build the lists.
        let storage = BufferUsages::STORAGE;
        let casters = self.geometry.run(&self.geometry.casters());
        let vertices = foreign::buffer(d, storage | BufferUsages::VERTEX, cast_slice(&positions));
        let indices = foreign::buffer(d, storage | BufferUsages::INDEX, cast_slice(casters));
        let first = self.geometry.casters().start;
        let mut meshes = Vec::new();
        for run in self.geometry.casters_without_holes() {
            let mesh = CasterMesh {
                label: "casters",
                vertices: &vertices,
                layout: VertexLayout::PACKED,
                indices: Some(Indices {
                    buffer: &indices,
                    format: IndexFormat::Uint32,
                }),
                range: 3 * (run.start - first)..3 * (run.end - first),
                base_vertex: 0,
                bounds: Aabb::from_points(self.geometry.vertices_of(run)),
            };
            meshes.push(set.add_mesh(&mesh).expect("valid"));
        }
        meshes
    }

    fn cut_outs(&self) -> Option<CutOutBuffers> {
        let d = self.program.d;
        CutOutBuffers::new(&d.device, &d.queue, &self.geometry).expect("valid")
    }

    /// Returns a light's shadows with a technique that is executed alone.
    fn render_alone(&self, technique: &dyn ShadowTechnique, set: &LightSet) -> Alone<'_> {
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
        let view = seen.with_receivers(&self.receivers);
        Alone {
            on_gpu: gpu().render(&view, &recipe).expect("renders").mask,
            on_cpu: Cpu::new().render(&view, &recipe).expect("renders"),
            view,
            recipe,
        }
    }
}

/// The result of a technique alone for a view.
struct Alone<'a> {
    view: View<'a>,
    recipe: Recipe,
    on_gpu: Vec<f32>,
    on_cpu: Shadows,
}

impl Alone<'_> {
    /// Compares a set's mask with the CPU's, and on the pinned driver with that of the technique
    /// alone. Other drivers may round the two shaders differently.
    fn check(&self, label: &str, mask: &[f32]) -> Result<Agreement, String> {
        let differing = count_differing(mask, &self.on_gpu);
        if gpu().promises_bits() && differing > 0 {
            return Err(format!(
                "{label}: {differing} pixels differ from those of the technique alone"
            ));
        }
        self.compare_with_cpu(label, mask)
    }

    /// Compares a set's mask with the CPU's.
    fn compare_with_cpu(&self, label: &str, mask: &[f32]) -> Result<Agreement, String> {
        let of_set = Shadows {
            mask: mask.to_vec(),
            ..self.on_cpu.clone()
        };
        check_agreement(
            &gpu(),
            label,
            &self.view,
            &self.recipe,
            &self.on_cpu,
            &of_set,
        )
    }
}

fn small(entry: &TechniqueEntry) -> Arc<dyn ShadowTechnique> {
    let preset = (entry.preset)();
    let map = preset.map().map(|map| ShadowMap { size: 192, ..*map });
    let preset: TechniquePreset = map.map_or(preset.clone(), |map| preset.with_map(map));
    preset.technique()
}

pub(super) fn count_differing(a: &[f32], b: &[f32]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .filter(|(a, b)| a.to_bits() != b.to_bits())
        .count()
}

/// All built-in techniques in one set at the same time, on each scene.
#[test]
fn each_light_of_a_set_gives_the_bits_that_it_gives_alone() {
    let [mut undecided, mut compared] = [0, 0];
    for (_, name) in SCENES.iter().enumerate().filter(|(i, _)| is_chosen(*i)) {
        let world = World::new(name);
        let mut set = world.set();
        let light = world.scene.lights[0];
        let mut ids: Vec<(LightId, &TechniqueEntry)> = Vec::new();
        for entry in umbrage_techniques::all() {
            let added = set.add_light(ShadowedLight {
                light,
                technique: small(entry),
                priority: 1.0,
            });
            ids.push((added.expect("valid"), entry));
        }
        world.program.update(&mut set, &world.frame());
        let unserved: Vec<(LightId, Unserved)> = set.unserved_lights().collect();
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
            let alone = world.render_alone(&*small(entry), &set);
            let agreement = alone.check(&what, &mask).expect("the set agrees");
            undecided += agreement.undecided;
            compared += agreement.compared;
            let shadowed = mask.iter().filter(|&&v| v < 1.0).count();
            assert!(shadowed > 100, "{what}: only {shadowed} pixels in shadow");
        }
    }
    assert!(
        undecided as f64 <= MAX_UNDECIDED_SHARE * compared as f64,
        "{undecided} of {compared} pixels are undecided"
    );
}

/// Moment maps with mipmaps, in a set with one without, have the same bits as alone and on the CPU.
/// Mipmaps change some bits.
#[test]
fn moment_maps_of_a_set_have_mipmaps() {
    let world = World::new("far-range");
    let mut set = world.set();
    let light = world.scene.lights[0];
    let map = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    let cascades = ShadowMap {
        size: 128,
        layout: Layout::Cascades(Cascades {
            count: 2,
            blend: 4.0,
            ..Cascades::default()
        }),
        ..map
    };
    let plain = Vsm::default().on(map);
    let techniques: [TechniquePreset; 5] = [
        plain.into(),
        TechniquePreset::from(
            Vsm {
                mipmaps: 4,
                ..plain.filter
            }
            .on(plain.map),
        ),
        TechniquePreset::from(
            Evsm {
                mipmaps: 2,
                ..Evsm::default()
            }
            .on(cascades),
        ),
        TechniquePreset::from(
            Evsm {
                mipmaps: 3,
                precision: MomentPrecision::Bits16,
                ..Evsm::default()
            }
            .on(map),
        ),
        TechniquePreset::from(
            Msm {
                mipmaps: 3,
                ..Msm::default()
            }
            .on(cascades),
        ),
    ];
    let ids = techniques.clone().map(|technique| {
        let light = ShadowedLight {
            light,
            technique: technique.technique(),
            priority: 1.0,
        };
        set.add_light(light).expect("valid")
    });
    world.program.update(&mut set, &world.frame());
    let mut forward = Forward::default();
    let masks: Vec<Vec<f32>> = ids
        .iter()
        .zip(&techniques)
        .map(|(&id, technique)| {
            let index = set.index_of(id).expect("is there");
            let mask = forward.mask(&world.program, &set, index);
            let alone = world.render_alone(technique, &set);
            let agreed = alone.check(&technique.settings(), &mask);
            agreed.expect("the set agrees");
            mask
        })
        .collect();
    let changed = count_differing(&masks[0], &masks[1]);
    assert!(changed > 100, "mipmaps change {changed} pixels");
}

/// Negative control of the comparison above: a displaced map has other bits.
#[test]
fn another_map_gives_other_bits() {
    let world = World::new("cubes");
    let mut set = world.set();
    let hard = umbrage_techniques::find("hard").expect("built in");
    let id = set
        .add_light(ShadowedLight {
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
    let alone = world.render_alone(&*other.technique(), &set);
    assert!(count_differing(&mask, &alone.on_gpu) > 10);
    assert!(alone.compare_with_cpu("spoilt", &mask).is_err());
}

/// Alpha-tested casters are added and removed with [`LightSet::set_cut_outs`], and so are their
/// shadows.
#[test]
fn casters_with_holes_come_and_go() {
    come_and_go(&World::new(FENCE));
}

/// Mipmapped and hashed alpha textures are added and removed in the same way.
#[test]
fn casters_with_hashed_holes_come_and_go() {
    let fence = umbrage_scenes::find(FENCE).expect("a built-in scene");
    let mut scene = (fence.build)();
    for holes in scene.materials.iter_mut().filter_map(|m| m.alpha.as_mut()) {
        holes.filter = AlphaFilter::Hashed;
    }
    come_and_go(&World::of_scene(scene));
}

fn come_and_go(world: &World) {
    let mut set = world.set();
    let light = world.scene.lights[0];
    let technique = small(umbrage_techniques::find("hard").expect("built in"));
    let id = set
        .add_light(ShadowedLight {
            light,
            technique: technique.clone(),
            priority: 1.0,
        })
        .expect("valid");
    let index = set.index_of(id).expect("is there");
    let mut forward = Forward::default();
    let mut mask = |set: &mut LightSet| {
        world.program.update(set, &world.frame());
        forward.mask(&world.program, set, index)
    };
    let with = mask(&mut set);
    let alone = world.render_alone(&*technique, &set);
    assert_eq!(count_differing(&with, &alone.on_gpu), 0);
    let before = set.casters_box();
    set.set_cut_outs(None).expect("valid");
    let without = mask(&mut set);
    let gone = with.iter().zip(&without).filter(|(a, b)| a < b).count();
    assert!(gone > 100, "the netting's shadow stays: {gone}");
    assert!(
        alone.compare_with_cpu("without", &without).is_err(),
        "the comparison can't fail"
    );
    set.set_cut_outs(world.cut_outs().as_ref()).expect("valid");
    assert_eq!(count_differing(&mask(&mut set), &with), 0);
    assert_eq!(set.casters_box(), before);
}
