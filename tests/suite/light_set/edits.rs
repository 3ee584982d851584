//! Tests that the shadows of a set after any edits equal those of a new set: no kept state is ever
//! stale.

use super::own_casters::Figure;
use bytemuck::cast_slice;
use glam::{Affine3A, DAffine3, DVec3, EulerRot, Quat, UVec2, Vec3};
use proptest::{collection::vec, prelude::*, test_runner::RngSeed};
use std::{cell::RefCell, sync::Arc};
use umbrage_core::{Aabb, Anchor, Camera, Cascades, Fit, Layout, Light, ShadowTechnique};
use umbrage_techniques::{
    Evsm, Exact, Hard, MapFilter as _, Midpoint, MomentPrecision, Pcf, PcfHardware, Pcss, ShadowMap,
};
use umbrage_tests::{
    adapter::device,
    foreign,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{
    CasterId, CasterMesh, Indices, LightId, LightSet, MeshId, OwnCasterId, PositionFormat,
    SetBudget, SetFrame, ShadowedLight, StillLayers, Unserved, VertexLayout,
};
use wgpu::{Buffer, BufferUsages, IndexFormat};

/// A caster: its mesh and its placement.
type Caster = (usize, Affine3A);
/// A light.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    /// Kind of light. 0: sun, 1: spot light, 2: point light.
    kind: usize,
    place: Vec3,
    technique: usize,
    is_enabled: bool,
}

/// An edit of a program's set.
#[derive(Clone, Debug)]
enum Edit {
    AddCaster(Caster),
    MoveCaster(prop::sample::Index, Affine3A),
    RemoveCaster(prop::sample::Index),
    AddLight(Lamp),
    MoveLight(prop::sample::Index, Vec3),
    ChangeTechnique(prop::sample::Index, usize),
    RemoveLight(prop::sample::Index),
    SwitchLight(prop::sample::Index),
    /// Adds or moves the figure that the program draws.
    MoveFigure(Vec3),
    RemoveFigure,
    MoveCamera(f32),
    /// Everything is placed relative to an anchor at this number of steps along x.
    Hop(i32),
    /// A frame that is submitted.
    Frame,
    /// A frame whose encoder is discarded.
    DroppedFrame,
    /// A frame that is prepared and never recorded.
    PreparedFrame,
}

fn placement() -> impl Strategy<Value = Affine3A> {
    let angles = prop::array::uniform3(-3.0_f32..3.0);
    let place = (-6.0_f32..6.0, 0.6_f32..3.0, -5.0_f32..5.0);
    (angles, place, 0.3_f32..1.5).prop_map(|([a, b, c], (x, y, z), scale)| {
        let rotation = Quat::from_euler(EulerRot::XYZ, a, b, c);
        Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, Vec3::new(x, y, z))
    })
}

fn any_above() -> impl Strategy<Value = Vec3> {
    (-4.0_f32..4.0, 4.0_f32..9.0, -4.0_f32..4.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn any_low() -> impl Strategy<Value = Vec3> {
    (-4.0_f32..4.0, 1.0_f32..3.0, -4.0_f32..4.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn edit() -> impl Strategy<Value = Edit> {
    let any = any::<prop::sample::Index>;
    prop_oneof![
        3 => (0..3_usize, placement()).prop_map(Edit::AddCaster),
        4 => (any(), placement()).prop_map(|(i, to)| Edit::MoveCaster(i, to)),
        1 => any().prop_map(Edit::RemoveCaster),
        2 => (0..3_usize, any_above(), 0..TECHNIQUES).prop_map(|(kind, place, technique)| {
            Edit::AddLight(Lamp { kind, place, technique, is_enabled: true })
        }),
        2 => (any(), any_above()).prop_map(|(i, to)| Edit::MoveLight(i, to)),
        1 => (any(), 0..TECHNIQUES).prop_map(|(i, to)| Edit::ChangeTechnique(i, to)),
        1 => any().prop_map(Edit::RemoveLight),
        1 => any().prop_map(Edit::SwitchLight),
        2 => any_low().prop_map(Edit::MoveFigure),
        1 => Just(Edit::RemoveFigure),
        1 => (-1.0_f32..1.0).prop_map(Edit::MoveCamera),
        1 => (-1..2).prop_map(Edit::Hop),
        3 => Just(Edit::Frame),
        1 => Just(Edit::DroppedFrame),
        1 => Just(Edit::PreparedFrame),
    ]
}

const TECHNIQUES: usize = 9;
/// The initial light of a model.
const FIRST_LAMP: Lamp = Lamp {
    kind: 1,
    place: Vec3::new(1.0, 8.0, 0.5),
    technique: 0,
    is_enabled: true,
};

/// Returns techniques with various maps: of two sizes, filtered, compared by the sampler, 16-bit
/// moments with blur and mipmaps, cascades for suns that follow the camera, and hierarchies from
/// the device.
fn technique(lamp: &Lamp) -> Arc<dyn ShadowTechnique> {
    let map = |size| ShadowMap {
        size,
        ..ShadowMap::default()
    };
    let is_sun = lamp.kind == 0;
    let cascades = |fit: Fit| ShadowMap {
        fit,
        layout: Layout::Cascades(Cascades {
            count: 3,
            blend: 4.0,
            ..Cascades::default()
        }),
        ..map(64)
    };
    let blurred = |map| {
        Evsm {
            blur: 2,
            mipmaps: 2,
            precision: MomentPrecision::Bits16,
            ..Evsm::default()
        }
        .on(map)
    };
    match lamp.technique {
        0 => Arc::new(Hard {}.on(map(96))),
        1 => Arc::new(Pcf::unrolled(2).on(map(64))),
        2 => Arc::new(PcfHardware::default().on(map(96))),
        3 => Arc::new(Midpoint::default().on(map(64))),
        6 => Arc::new(Exact::default()),
        4 if is_sun => Arc::new(Pcf::new(1).on(cascades(Fit::Stable { range: 30.0 }))),
        5 if is_sun => Arc::new(Pcf::new(1).on(cascades(Fit::AroundCamera { range: 30.0 }))),
        8 if is_sun => Arc::new(blurred(cascades(Fit::Stable { range: 30.0 }))),
        8 => Arc::new(blurred(map(96))),
        _ => Arc::new(Pcss::default().on(map(96))),
    }
}

fn light(lamp: &Lamp, anchor: Anchor) -> Light {
    let place = lamp.place;
    let position = anchor.position(place.as_dvec3());
    match lamp.kind {
        0 => Light::Directional {
            direction: -place,
            angular_diameter: 0.02,
        },
        1 => Light::Spot {
            position,
            direction: Vec3::new(-0.1 * place.x, -1.0, -0.1 * place.z),
            inner: 0.5,
            outer: 0.7,
            radius: 0.1,
        },
        _ => Light::Point {
            position,
            radius: 0.1,
        },
    }
}

/// The meshes' buffers, in three formats, and the program's figure.
struct Meshes {
    figure: RefCell<Figure>,
    floats: Buffer,
    halves: Buffer,
    snorms: Buffer,
    indices: Buffer,
}

impl Meshes {
    fn new(program: &ForwardProgram) -> Self {
        let d = program.d;
        let vertex = BufferUsages::VERTEX | BufferUsages::STORAGE;
        // A tetrahedron, as four triangles.
        let corners = [
            [1.0_f32, 1.0, 1.0],
            [-1.0, -1.0, 1.0],
            [-1.0, 1.0, -1.0],
            [1.0, -1.0, -1.0],
        ];
        let faces = [0_u16, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];
        let floats: Vec<[f32; 3]> = faces.iter().map(|&i| corners[usize::from(i)]).collect();
        // 1 and -1 in 16-bit floats and in integers, after two skipped vertices.
        let half = |v: f32| if v > 0.0 { 0x3c00_u16 } else { 0xbc00 };
        let snorm = |v: f32| if v > 0.0 { 0x7fff_u16 } else { 0x8001 };
        let packed = |word: fn(f32) -> u16| -> Vec<[u16; 4]> {
            let skipped = [[0x1234; 4]; 2];
            let real = corners
                .iter()
                .map(|c| [word(c[0]), word(c[1]), word(c[2]), 0]);
            skipped.into_iter().chain(real).collect()
        };
        Self {
            figure: RefCell::new(Figure::new(false)),
            // A test writes to it.
            floats: foreign::buffer(d, vertex | BufferUsages::COPY_DST, cast_slice(&floats)),
            halves: foreign::buffer(d, vertex, cast_slice(&packed(half))),
            snorms: foreign::buffer(d, vertex, cast_slice(&packed(snorm))),
            indices: foreign::buffer(
                d,
                BufferUsages::INDEX | BufferUsages::STORAGE,
                cast_slice(&faces),
            ),
        }
    }

    fn add(&self, set: &mut LightSet) -> [MeshId; 3] {
        let bounds = Aabb {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        let plain = CasterMesh {
            label: "floats",
            vertices: &self.floats,
            layout: VertexLayout::PACKED,
            indices: None,
            range: 0..12,
            base_vertex: 0,
            bounds,
        };
        let packed = |label, vertices, format| CasterMesh {
            label,
            vertices,
            layout: VertexLayout {
                format,
                stride: 8,
                position_offset: 0,
            },
            indices: Some(Indices {
                buffer: &self.indices,
                format: IndexFormat::Uint16,
            }),
            base_vertex: 2,
            ..plain.clone()
        };
        let halves = packed("halves", &self.halves, PositionFormat::Float16x4);
        let snorms = packed("snorms", &self.snorms, PositionFormat::Snorm16x4);
        [plain.clone(), halves, snorms].map(|mesh| set.add_mesh(&mesh).expect("valid"))
    }
}

/// A set, and the program's record of its contents.
struct Model<'a> {
    program: &'a ForwardProgram,
    meshes: &'a Meshes,
    set: LightSet,
    mesh_ids: [MeshId; 3],
    casters: Vec<(CasterId, Caster)>,
    lights: Vec<(LightId, Lamp)>,
    /// The figure that the program draws, and the world-space position of its centre.
    figure: Option<(OwnCasterId, Vec3)>,
    turn: f32,
    /// The anchor of the set's positions.
    anchor: Anchor,
}

fn camera(turn: f32, anchor: Anchor) -> Camera {
    let eye = anchor.position(DVec3::new(6.0 * f64::from(turn), 5.0, 12.0));
    let target = anchor.position(DVec3::ZERO);
    let size = UVec2::new(64, 48);
    Camera::perspective(eye, target, Vec3::Y, 0.9, [0.1, 100.0], size).expect("valid")
}

fn relative(place: &Affine3A, anchor: Anchor) -> Affine3A {
    let world_from_local = DAffine3 {
        matrix3: place.matrix3.as_dmat3(),
        translation: place.translation.as_dvec3(),
    };
    anchor.placement(&world_from_local)
}

/// Two casters at fixed corners of the box around all casters. Without them, every move would
/// change the box and all maps.
const CORNERS: [Vec3; 2] = [Vec3::new(-9.0, -2.0, -8.0), Vec3::new(9.0, 6.0, 8.0)];

impl<'a> Model<'a> {
    fn new(program: &'a ForwardProgram, meshes: &'a Meshes, still_layers: StillLayers) -> Self {
        // Some lights wait for their redraws.
        let redraws = if still_layers == StillLayers::Never {
            u32::MAX
        } else {
            2
        };
        let budget = SetBudget {
            redraws,
            ..SetBudget::default()
        };
        let mut set = program.set(budget, still_layers);
        let mesh_ids = meshes.add(&mut set);
        let mut model = Self {
            program,
            meshes,
            set,
            mesh_ids,
            casters: Vec::new(),
            lights: Vec::new(),
            figure: None,
            turn: 0.0,
            anchor: Anchor::ORIGIN,
        };
        for corner in CORNERS {
            model.add_caster((0, Affine3A::from_translation(corner)));
        }
        model
    }

    fn add_caster(&mut self, caster: Caster) {
        let (mesh, place) = caster;
        let place = relative(&place, self.anchor);
        let id = self.set.add_caster(self.mesh_ids[mesh], place);
        self.casters.push((id.expect("valid"), caster));
    }

    fn add_light(&mut self, lamp: Lamp) {
        let id = self.set.add_light(ShadowedLight {
            light: light(&lamp, self.anchor),
            technique: technique(&lamp),
            priority: 1.0,
        });
        let id = id.expect("valid");
        self.set.set_enabled(id, lamp.is_enabled).expect("is there");
        self.lights.push((id, lamp));
    }

    /// Moves the figure, and returns its box.
    fn pose_figure(&self, center: Vec3) -> Aabb {
        let center = self.anchor.position(center.as_dvec3());
        self.meshes.figure.borrow().pose(center)
    }

    fn move_figure(&mut self, center: Vec3) {
        let bounds = self.pose_figure(center);
        let id = if let Some((id, _)) = self.figure {
            self.set.move_own_caster(id, bounds).expect("is there");
            id
        } else {
            self.set.add_own_caster(bounds).expect("valid")
        };
        self.figure = Some((id, center));
    }

    fn edit(&mut self, edit: &Edit) {
        match edit {
            Edit::AddCaster(caster) => self.add_caster(*caster),
            Edit::MoveCaster(i, to) if self.casters.len() > CORNERS.len() => {
                let (id, caster) = i.get_mut(&mut self.casters[CORNERS.len()..]);
                caster.1 = *to;
                let place = relative(to, self.anchor);
                self.set.move_caster(*id, place).expect("is there");
            }
            Edit::RemoveCaster(i) if self.casters.len() > CORNERS.len() => {
                let index = CORNERS.len() + i.index(self.casters.len() - CORNERS.len());
                let (id, _) = self.casters.remove(index);
                self.set.remove_caster(id).expect("is there");
            }
            Edit::AddLight(lamp) if self.lights.len() < 6 => self.add_light(*lamp),
            Edit::MoveLight(i, to) if !self.lights.is_empty() => {
                let (id, lamp) = i.get_mut(&mut self.lights);
                lamp.place = *to;
                let light = light(lamp, self.anchor);
                self.set.set_light(*id, light).expect("is there");
            }
            Edit::ChangeTechnique(i, to) if !self.lights.is_empty() => {
                let (id, lamp) = i.get_mut(&mut self.lights);
                lamp.technique = *to;
                self.set
                    .set_technique(*id, technique(lamp))
                    .expect("is there");
            }
            Edit::RemoveLight(i) if !self.lights.is_empty() => {
                let (id, _) = self.lights.remove(i.index(self.lights.len()));
                self.set.remove_light(id).expect("is there");
            }
            Edit::SwitchLight(i) if !self.lights.is_empty() => {
                let (id, lamp) = i.get_mut(&mut self.lights);
                lamp.is_enabled ^= true;
                self.set
                    .set_enabled(*id, lamp.is_enabled)
                    .expect("is there");
            }
            Edit::MoveFigure(center) => self.move_figure(*center),
            Edit::RemoveFigure => {
                if let Some((id, _)) = self.figure.take() {
                    self.set.remove_own_caster(id).expect("is there");
                }
            }
            Edit::MoveCamera(turn) => self.turn = *turn,
            Edit::Hop(steps) => self.hop(*steps),
            Edit::Frame => self.frame(),
            Edit::DroppedFrame => {
                self.prepare();
                self.encode();
            }
            Edit::PreparedFrame => self.prepare(),
            _ => {}
        }
    }

    fn hop(&mut self, steps: i32) {
        let eye = DVec3::new(f64::from(steps) * Anchor::STEP, 0.0, 0.0);
        self.anchor = Anchor::nearest_to(eye).expect("valid");
        for (id, (_, place)) in &self.casters {
            let place = relative(place, self.anchor);
            self.set.rebase_caster(*id, place).expect("is there");
        }
        for (id, lamp) in &self.lights {
            let light = light(lamp, self.anchor);
            self.set.set_light(*id, light).expect("is there");
        }
        if let Some((id, center)) = self.figure {
            let bounds = self.pose_figure(center);
            self.set.rebase_own_caster(id, bounds).expect("is there");
        }
    }

    fn prepare(&mut self) {
        let frame = SetFrame {
            camera: &camera(self.turn, self.anchor),
            geometry: None,
        };
        self.set.prepare(&frame).expect("prepares");
    }

    fn encode(&mut self) -> wgpu::CommandEncoder {
        let mut encoder = self.program.encoder();
        let layout = self.set.cast_layout().clone();
        let mut figure = self.meshes.figure.borrow_mut();
        self.set
            .encode_with(&mut encoder, |pass, target, ids| {
                assert_eq!(
                    Some(ids),
                    self.figure.map(|(id, _)| [id]).as_ref().map(|ids| &ids[..])
                );
                figure.draw(&layout, pass, target);
            })
            .expect("was prepared");
        encoder
    }

    /// Renders a frame, whose text was known beforehand.
    fn frame(&mut self) {
        let frame = SetFrame {
            camera: &camera(self.turn, self.anchor),
            geometry: None,
        };
        let expected = self.set.text_with(&frame, &[]).expect("no technique");
        self.prepare();
        let other = self
            .set
            .wgsl()
            .lines()
            .zip(expected.wgsl.lines())
            .find(|(a, b)| a != b);
        assert_eq!(other, None, "lines of the text and of the expected one");
        assert!(self.set.wgsl() == expected.wgsl, "another length of text");
        assert_eq!(self.set.wgsl_revision(), expected.revision);
        let encoder = self.encode();
        self.program.d.queue.submit([encoder.finish()]);
    }

    /// Returns a new set with the same contents, relative to the origin.
    fn rebuilt_set(&self) -> Self {
        let mut other = Self::new(self.program, self.meshes, StillLayers::Never);
        other.turn = self.turn;
        for &(_, caster) in &self.casters[CORNERS.len()..] {
            other.add_caster(caster);
        }
        for &(_, lamp) in &self.lights {
            other.add_light(lamp);
        }
        if let Some((_, center)) = self.figure {
            other.move_figure(center);
        }
        other
    }

    /// Returns the mask of each light, on the floor around the anchor.
    fn masks(&mut self) -> Vec<Vec<f32>> {
        self.frame();
        while self.set.report().waiting > 0 {
            self.frame();
        }
        for (id, reason) in self.set.unserved_lights() {
            // Hierarchies of a device can't contain the figure.
            let lamp = self.lights.iter().find(|(other, _)| *other == id);
            let is_exact = lamp.is_some_and(|(_, lamp)| lamp.technique == 6);
            let is_refused = matches!(reason, Unserved::Refused(_));
            assert!(
                is_refused && is_exact && self.figure.is_some(),
                "{reason:?}"
            );
        }
        let mut forward = Forward::default();
        let mut masks = Vec::new();
        for (id, _) in &self.lights {
            let index = self.set.index_of(*id).expect("is there");
            masks.push(forward.mask(self.program, &self.set, index));
        }
        masks
    }
}

/// Random edits, with frames in between that are submitted, dropped, or never recorded.
#[test]
fn a_set_never_shows_what_is_stale() {
    let program = ForwardProgram::floor(device(), UVec2::new(64, 48));
    let meshes = Meshes::new(&program);
    let config = ProptestConfig {
        cases: 28,
        max_shrink_iters: 200,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let in_shadow = std::cell::Cell::new(0);
    proptest!(config, |(edits in vec(edit(), 8..40), always in any::<bool>())| {
        let still_layers = if always { StillLayers::Always } else { StillLayers::Auto };
        let mut model = Model::new(&program, &meshes, still_layers);
        model.add_caster((0, Affine3A::from_translation(Vec3::new(0.0, 2.0, 0.0))));
        model.add_light(FIRST_LAMP);
        for edit in &edits {
            model.edit(edit);
        }
        // The tested floor is around the origin.
        if model.anchor != Anchor::ORIGIN {
            model.hop(0);
        }
        let kept = model.masks();
        let fresh = model.rebuilt_set().masks();
        for (i, (kept, fresh)) in kept.iter().zip(&fresh).enumerate() {
            let differing = kept.iter().zip(fresh).filter(|(a, b)| a.to_bits() != b.to_bits());
            prop_assert_eq!(differing.count(), 0, "light {} of {:?}", i, model.lights);
            in_shadow.set(in_shadow.get() + kept.iter().filter(|&&v| v < 1.0).count());
        }
    });
    let in_shadow = in_shadow.get();
    assert!(
        in_shadow > 10_000,
        "only {in_shadow} pixels in shadow: masks that are lit can't differ"
    );
}

/// Negative control of the comparison above: a set without notice of a change has stale shadows.
#[test]
fn a_change_that_the_set_is_not_notified_of_is_seen() {
    let program = ForwardProgram::floor(device(), UVec2::new(64, 48));
    let meshes = Meshes::new(&program);
    let mut model = Model::new(&program, &meshes, StillLayers::Auto);
    model.add_caster((0, Affine3A::from_translation(Vec3::new(0.0, 2.0, 0.0))));
    model.add_light(FIRST_LAMP);
    let before = model.masks();
    // Shrink the vertices without notice to the set.
    let small: Vec<[f32; 3]> = vec![[0.0; 3]; 12];
    program
        .d
        .queue
        .write_buffer(&meshes.floats, 0, cast_slice(&small));
    assert_eq!(model.masks(), before);
    let around = Aabb {
        min: Vec3::new(-2.0, 0.0, -2.0),
        max: Vec3::new(2.0, 4.0, 2.0),
    };
    model.set.touch(&around).expect("finite");
    assert_ne!(model.masks(), before);
}
