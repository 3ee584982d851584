//! Tests that the masks of a set, for renderers that shade from a G-buffer, equal the forward
//! renderer's results.

use bytemuck::cast_slice;
use glam::{Mat4, UVec2, Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Camera, Inputs, Kernel, Module, Receive, ReceiveKernel, Recipe, RecipeError, ShadowTechnique,
    Span, View,
};
use umbrage_techniques::{Bias, Hard, MapFilter as _, ShadowMap};
use umbrage_tests::{
    adapter::device,
    foreign,
    light_program::{Forward, ForwardProgram},
    light_stage::{Stage, camera, hard, spot},
};
use umbrage_wgpu::{
    ApiErrors, DepthBuffer, GBuffer, LightId, LightSet, LightSetOptions, MaskFormat, MaskInputs,
    MaskReceivers, NormalCoding, SetBudget, SetNormals, ShadowedLight,
};
use wgpu::{TextureFormat, TextureView};

const PLACES: [f32; 3] = [-4.0, 0.0, 4.0];

/// Returns the masks of these lights, in their order.
fn masks(
    program: &ForwardProgram,
    set: &mut LightSet,
    receivers: MaskReceivers<'_>,
    lights: &[LightId],
) -> Vec<Vec<f32>> {
    let inputs = MaskInputs {
        size: program.size(),
        receivers,
        lights,
        format: MaskFormat::Float32,
    };
    set.prepare_masks(&inputs).expect("prepares");
    let mut encoder = program.encoder();
    let masks = set
        .encode_masks(&mut encoder)
        .expect("was prepared")
        .clone();
    let texels = foreign::read(program.d, encoder, &masks);
    let pixels = texels.len() / lights.len();
    texels.chunks(pixels).map(<[f32]>::to_vec).collect()
}

fn forward(program: &ForwardProgram, set: &LightSet, light: LightId) -> Vec<f32> {
    let index = set.index_of(light).expect("is there");
    Forward::default().mask(program, set, index)
}

#[test]
fn masks_are_what_the_forward_renderer_sees() {
    let mut stage = Stage::new(SetBudget::default(), &PLACES);
    let lights = PLACES.map(|x| stage.light(x, 1.0));
    stage.frame();
    // Skip the light in the middle, and use another order than that of their indices.
    let requested = [lights[2], lights[0]];
    let expected = requested.map(|id| forward(&stage.program, &stage.set, id));
    assert!(expected.iter().all(|mask| mask.iter().any(|&v| v < 1.0)));
    assert_ne!(expected[0], expected[1]);
    let seen = MaskReceivers::Positions(stage.program.gbuffer());
    let found = masks(&stage.program, &mut stage.set, seen, &requested);
    assert_eq!(found, expected);
}

#[test]
fn lights_that_are_not_served_have_white_masks() {
    let budget = SetBudget {
        bytes: 0,
        ..SetBudget::default()
    };
    let mut stage = Stage::new(budget, &PLACES);
    let light = stage.light(0.0, 1.0);
    stage.frame();
    let seen = MaskReceivers::Positions(stage.program.gbuffer());
    let found = masks(&stage.program, &mut stage.set, seen, &[light]);
    assert!(found[0].iter().all(|&v| v == 1.0));
}

/// A kernel with invalid WGSL.
#[derive(Debug)]
struct Broken;

impl Kernel for Broken {
    fn modules(&self) -> Vec<Module> {
        Vec::from([Module {
            name: "broken",
            text: "fn receive(r: Receiver) -> f32 { return no_such_name; }",
        }])
    }
}

impl ReceiveKernel for Broken {
    fn receive(&self, _: &Inputs<'_>, _: &Span<'_>, out: &mut [f32]) {
        out.fill(1.0);
    }
}

impl ShadowTechnique for Broken {
    fn name(&self) -> &'static str {
        "broken"
    }

    fn recipe(&self, _: &View<'_>) -> Result<Recipe, RecipeError> {
        Ok(Recipe {
            images: Vec::new(),
            tables: Vec::new(),
            casts: Vec::new(),
            filters: Vec::new(),
            receive: Receive {
                kernel: Arc::new(Self),
                inputs: Vec::new(),
                tables: Vec::new(),
            },
            shade: None,
            hierarchy: None,
            keep_images: false,
        })
    }
}

/// Errors of the compiler are returned at once or on request, and the set continues without the
/// light that caused them.
#[test]
fn errors_of_the_compiler_are_reported_at_once_or_later() {
    for when in [ApiErrors::AtOnce, ApiErrors::Later] {
        let mut stage = Stage::new(SetBudget::default(), &PLACES);
        let options = LightSetOptions {
            group: 1,
            errors: when,
            ..LightSetOptions::default()
        };
        stage.set =
            LightSet::new(&stage.program.d.device, &stage.program.d.queue, options).expect("fits");
        let light = ShadowedLight {
            light: spot(0.0),
            technique: Arc::new(Broken),
            priority: 1.0,
        };
        let light = stage.set.add_light(light).expect("valid");
        stage.frame();
        assert_eq!(stage.set.take_error().map(|e| e.to_string()), None);
        let inputs = MaskInputs {
            size: stage.program.size(),
            receivers: MaskReceivers::Positions(stage.program.gbuffer()),
            lights: &[light],
            format: MaskFormat::Unorm8,
        };
        let reported = stage.set.prepare_masks(&inputs).err();
        let requested = stage.set.take_error();
        let (error, other) = match when {
            ApiErrors::AtOnce => (reported, requested),
            ApiErrors::Later => (requested, reported),
        };
        assert_eq!(other.map(|e| e.to_string()), None, "{when:?}");
        let text = error.expect("a name is unknown").to_string();
        assert!(text.contains("no_such_name"), "{text}");
        // With another technique, everything works again.
        stage.set.set_technique(light, hard()).expect("is there");
        stage.frame();
        let seen = MaskReceivers::Positions(stage.program.gbuffer());
        let found = masks(&stage.program, &mut stage.set, seen, &[light]);
        assert!(found[0].iter().all(|&v| v == 1.0), "nothing casts here");
        assert_eq!(stage.set.take_error().map(|e| e.to_string()), None);
    }
}

/// Stripes of any visibility along x, whose mask is drawn or computed.
#[derive(Clone, Copy, Debug)]
struct Stripes {
    in_compute: bool,
    /// Stripes of another width.
    spoilt: bool,
}

impl Kernel for Stripes {
    fn modules(&self) -> Vec<Module> {
        let text = if self.spoilt {
            "fn receive(r: Receiver) -> f32 { return fract(r.position.x * 0.38 + r.normal.y); }"
        } else {
            "fn receive(r: Receiver) -> f32 { return fract(r.position.x * 0.37 + r.normal.y); }"
        };
        let name = "stripes";
        Vec::from([Module { name, text }])
    }
}

impl ReceiveKernel for Stripes {
    fn receive(&self, _: &Inputs<'_>, _: &Span<'_>, out: &mut [f32]) {
        out.fill(1.0);
    }

    fn in_compute(&self) -> bool {
        self.in_compute
    }
}

impl ShadowTechnique for Stripes {
    fn name(&self) -> &'static str {
        "stripes"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let mut recipe = Broken.recipe(view)?;
        recipe.receive.kernel = Arc::new(*self);
        Ok(recipe)
    }
}

/// Returns the bytes of the masks of these lights over a new wavy floor of this size.
fn bytes_of_masks(
    stage: &mut Stage,
    size: UVec2,
    lights: &[LightId],
    format: MaskFormat,
) -> Vec<u8> {
    let floor = WavyFloor::new(&stage.program, size);
    floor.bytes_of_masks(stage, lights, format)
}

/// Receivers of a wavy floor, some of whose pixels don't receive.
struct WavyFloor {
    size: UVec2,
    position: TextureView,
    normal: TextureView,
}

impl WavyFloor {
    fn new(program: &ForwardProgram, size: UVec2) -> Self {
        let d = program.d;
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
        // Floors of different widths differ in all positions.
        let shift = size.x as f32 * 0.013 - 9.0;
        let positions: Vec<[f32; 4]> = pixels
            .map(|(x, y)| {
                let receives = f32::from(u8::from((x * 7 + y * 3) % 11 != 0));
                [x as f32 * 0.731 + shift, 0.0, y as f32 * 0.613, receives]
            })
            .collect();
        let normals: Vec<[f32; 4]> = positions
            .iter()
            .map(|p| [0.0, p[2].cos(), 0.0, 0.0])
            .collect();
        let floats = TextureFormat::Rgba32Float;
        Self {
            size,
            position: foreign::upload(d, size, floats, cast_slice(&positions)),
            normal: foreign::upload(d, size, floats, cast_slice(&normals)),
        }
    }

    fn bytes_of_masks(&self, stage: &mut Stage, lights: &[LightId], format: MaskFormat) -> Vec<u8> {
        let inputs = MaskInputs {
            size: self.size,
            receivers: MaskReceivers::Positions(GBuffer {
                position: &self.position,
                normal: &self.normal,
                triangle: None,
            }),
            lights,
            format,
        };
        stage.set.prepare_masks(&inputs).expect("prepares");
        let mut encoder = stage.program.encoder();
        let masks = stage.set.encode_masks(&mut encoder).expect("was prepared");
        foreign::read_bytes(stage.program.d, encoder, &masks.clone())
    }
}

/// Masks that are computed have the bits of those that are drawn, next to each other, in both
/// formats and in sizes that workgroups don't divide. Another kernel's masks differ.
#[test]
fn computed_masks_are_those_that_are_drawn() {
    let mut stage = Stage::new(SetBudget::default(), &PLACES);
    let map = stage.light(PLACES[1], 1.0);
    let mut add = |in_compute, spoilt| {
        let light = ShadowedLight {
            light: spot(0.0),
            technique: Arc::new(Stripes { in_compute, spoilt }),
            priority: 1.0,
        };
        stage.set.add_light(light).expect("valid")
    };
    let [drawn, computed, spoilt] =
        [(false, false), (true, false), (true, true)].map(|(a, b)| add(a, b));
    stage.frame();
    let lights = [computed, map, drawn, spoilt];
    for size in [(1, 1), (3, 17), (77, 53), (256, 8), (301, 9)] {
        let size = UVec2::from(size);
        for format in [MaskFormat::Unorm8, MaskFormat::Float32] {
            let bytes = bytes_of_masks(&mut stage, size, &lights, format);
            let layers: Vec<&[u8]> = bytes.chunks(bytes.len() / lights.len()).collect();
            assert!(layers[0] == layers[2], "{size} {format:?}");
            if size.x > 3 {
                assert!(layers[0] != layers[3], "{size} {format:?}");
            }
            // Alone, and after the other kind alone, masks are the same.
            for (light, expected) in [(drawn, layers[2]), (computed, layers[0])] {
                let alone = bytes_of_masks(&mut stage, size, &[light], format);
                assert!(alone == expected, "{size} {format:?}: alone");
            }
        }
    }
    // Lights that are switched off have white masks.
    stage.set.set_enabled(computed, false).expect("is there");
    stage.frame();
    let white = bytes_of_masks(
        &mut stage,
        UVec2::new(9, 5),
        &[computed],
        MaskFormat::Unorm8,
    );
    assert!(white.iter().all(|&byte| byte == 255));
}

/// Masks that were not used while the receivers changed have the new receivers afterwards.
#[test]
fn unused_masks_follow_new_receivers() {
    for format in [MaskFormat::Unorm8, MaskFormat::Float32] {
        for first_in_compute in [true, false] {
            let mut stage = Stage::new(SetBudget::default(), &PLACES);
            let mut add = |in_compute, spoilt| {
                let light = ShadowedLight {
                    light: spot(0.0),
                    technique: Arc::new(Stripes { in_compute, spoilt }),
                    priority: 1.0,
                };
                stage.set.add_light(light).expect("valid")
            };
            // They differ, so that one's content is not taken for that of the other.
            let first = add(first_in_compute, true);
            let second = add(!first_in_compute, false);
            stage.frame();
            let large = WavyFloor::new(&stage.program, UVec2::new(77, 53));
            let small = WavyFloor::new(&stage.program, UVec2::new(30, 9));
            let expected = small.bytes_of_masks(&mut stage, &[first], format);
            large.bytes_of_masks(&mut stage, &[first, second], format);
            let other = small.bytes_of_masks(&mut stage, &[second], format);
            let found = small.bytes_of_masks(&mut stage, &[first], format);
            assert!(other != expected, "{format:?}: both are the same");
            assert!(found == expected, "{format:?}, {first_in_compute}");
        }
    }
}

/// The camera's view of the floor: positions for one renderer, depths for another.
struct SeenFloor {
    positions: Vec<[f32; 4]>,
    depths: Vec<f32>,
    world_from_clip: Mat4,
}

impl SeenFloor {
    fn new(camera: &Camera) -> Self {
        let clip_from_world = camera.space().clip_from_world();
        let world_from_clip = clip_from_world.as_dmat4().inverse();
        let size = camera.size;
        let mut positions = Vec::new();
        let mut depths = Vec::new();
        for y in 0..size.y {
            for x in 0..size.x {
                let u = (f64::from(x) + 0.5) / f64::from(size.x);
                let v = (f64::from(y) + 0.5) / f64::from(size.y);
                let at = |z: f64| {
                    let clip = glam::DVec3::new(2.0 * u - 1.0, 1.0 - 2.0 * v, z);
                    world_from_clip.project_point3(clip)
                };
                let near = at(0.0);
                let direction = at(1.0) - near;
                let t = -near.y / direction.y;
                if !(0.0..1.0).contains(&t) {
                    positions.push([0.0; 4]);
                    depths.push(1.0);
                    continue;
                }
                let p = (near + direction * t).as_vec3();
                positions.push([p.x, 0.0, p.z, 1.0]);
                let clip: Vec4 = clip_from_world * Vec3::new(p.x, 0.0, p.z).extend(1.0);
                depths.push(clip.z / clip.w);
            }
        }
        Self {
            positions,
            depths,
            world_from_clip: world_from_clip.as_mat4(),
        }
    }
}

/// Returns textures of one normal, (0, 1, 0), with their encoding.
fn normals(program: &ForwardProgram) -> [(TextureView, NormalCoding); 3] {
    let size = program.size();
    let count = (size.x * size.y) as usize;
    let d = program.d;
    // 1 and -1 in 16-bit floats.
    let one = 0x3c00_u16;
    let components = vec![[0, one, 0, 0]; count];
    let octahedral = vec![[0, one]; count];
    let halved = vec![[128_u8, 255, 128, 0]; count];
    [
        (
            foreign::upload(d, size, TextureFormat::Rgba16Float, cast_slice(&components)),
            NormalCoding::Components,
        ),
        (
            foreign::upload(d, size, TextureFormat::Rg16Float, cast_slice(&octahedral)),
            NormalCoding::Octahedral,
        ),
        (
            foreign::upload(d, size, TextureFormat::Rgba8Unorm, cast_slice(&halved)),
            NormalCoding::Halved,
        ),
    ]
}

/// Masks from a depth buffer, with normals in three formats and without. A few pixels at edges may
/// differ, since positions are rounded differently.
#[test]
fn masks_come_from_depth_and_normals_of_any_format() {
    let mut stage = Stage::new(SetBudget::default(), &PLACES);
    let lights = PLACES.map(|x| stage.light(x, 1.0));
    for light in lights {
        // Receivers move along their normals by some texels, so that a wrong normal moves shadows.
        let map = ShadowMap {
            bias: Bias {
                normal_offset: 8.0,
                ..Bias::NONE
            },
            ..hard().map
        };
        let moved = Arc::new(Hard {}.on(map));
        stage.set.set_technique(light, moved).expect("is there");
    }
    stage.frame();
    let camera = camera(0.5).with_size(UVec2::new(160, 120));
    let floor = SeenFloor::new(&camera);
    let up = vec![Vec3::Y.extend(0.0).to_array(); floor.positions.len()];
    let ids = vec![u32::MAX; floor.positions.len()];
    let program = ForwardProgram::of_texels(device(), camera.size, &floor.positions, &up, &ids);
    let exact = MaskReceivers::Positions(program.gbuffer());
    let expected = masks(&program, &mut stage.set, exact, &lights);
    let shadowed = expected.iter().flatten().filter(|&&v| v < 1.0).count();
    assert!(shadowed > 80, "{shadowed}");
    let texture = foreign::upload(
        program.d,
        camera.size,
        TextureFormat::R32Float,
        cast_slice(&floor.depths),
    );
    let depth = DepthBuffer {
        depth: &texture,
        world_from_clip: floor.world_from_clip,
        empty: 1.0,
    };
    let held = normals(&program);
    let mut ways: Vec<Option<SetNormals<'_>>> = vec![None];
    ways.extend(held.iter().map(|(texture, coding)| {
        Some(SetNormals {
            texture,
            coding: *coding,
        })
    }));
    for normals in ways {
        let seen = MaskReceivers::Depth { depth, normals };
        let found = masks(&program, &mut stage.set, seen, &lights);
        let pairs = found.iter().flatten().zip(expected.iter().flatten());
        let differing = pairs.filter(|(a, b)| (*a - *b).abs() > 0.01).count();
        assert!(
            differing * 20 <= shadowed,
            "{differing} of {shadowed}: {normals:?}"
        );
    }
    // Negative control: another camera's matrix results in other positions.
    let shifted_camera = umbrage_tests::light_stage::camera(1.5);
    let wrong = DepthBuffer {
        world_from_clip: SeenFloor::new(&shifted_camera).world_from_clip,
        ..depth
    };
    let seen = MaskReceivers::Depth {
        depth: wrong,
        normals: None,
    };
    let found = masks(&program, &mut stage.set, seen, &lights);
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    assert!(pairs.filter(|(a, b)| (*a - *b).abs() > 0.01).count() > 40);
}

/// Formats that can't hold the normals of a coding are refused by name.
#[test]
fn formats_of_normals_that_can_not_be_right_are_refused() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let light = stage.light(0.0, 1.0);
    stage.frame();
    let size = UVec2::new(8, 8);
    let d = stage.program.d;
    let depth = foreign::upload(d, size, TextureFormat::R32Float, &[0; 4 * 64]);
    for (format, coding, needed) in [
        (
            TextureFormat::Rgba8Unorm,
            NormalCoding::Components,
            "NormalCoding::Halved",
        ),
        (
            TextureFormat::Rgba8Unorm,
            NormalCoding::Octahedral,
            "NormalCoding::OctahedralHalved",
        ),
        (
            TextureFormat::Rgba8Uint,
            NormalCoding::Halved,
            "not read as floats",
        ),
        (
            TextureFormat::Rg16Float,
            NormalCoding::Components,
            "at least 3 channels",
        ),
        (
            TextureFormat::Rgba8UnormSrgb,
            NormalCoding::Halved,
            "linear format",
        ),
    ] {
        let texture = foreign::upload(d, size, format, &[0; 4 * 64]);
        let inputs = MaskInputs {
            size,
            receivers: MaskReceivers::Depth {
                depth: DepthBuffer {
                    depth: &depth,
                    world_from_clip: Mat4::IDENTITY,
                    empty: 1.0,
                },
                normals: Some(SetNormals {
                    texture: &texture,
                    coding,
                }),
            },
            lights: &[light],
            format: MaskFormat::Unorm8,
        };
        let error = stage.set.prepare_masks(&inputs).expect_err("no normals");
        assert!(error.to_string().contains(needed), "{error}");
    }
}

/// A view of depth and stencil together can't be bound; the error says which one can.
#[test]
fn a_view_of_both_aspects_is_refused_with_advice() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let light = stage.light(0.0, 1.0);
    stage.frame();
    let size = UVec2::new(8, 8);
    let d = stage.program.d;
    let texture = d.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Depth24PlusStencil8,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let mut prepare = |aspect| {
        let depth = texture.create_view(&wgpu::TextureViewDescriptor {
            aspect,
            ..wgpu::TextureViewDescriptor::default()
        });
        stage.set.prepare_masks(&MaskInputs {
            size,
            receivers: MaskReceivers::Depth {
                depth: DepthBuffer {
                    depth: &depth,
                    world_from_clip: Mat4::IDENTITY,
                    empty: 1.0,
                },
                normals: None,
            },
            lights: &[light],
            format: MaskFormat::Unorm8,
        })
    };
    let error = prepare(wgpu::TextureAspect::All).expect_err("both aspects");
    assert!(error.to_string().contains("DepthOnly"), "{error}");
    prepare(wgpu::TextureAspect::DepthOnly).expect("depth alone");
}
