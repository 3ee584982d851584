//! Shared fixtures: a small scene, a light, and a recipe with every stage.

use std::sync::{Arc, LazyLock};
use umbrage_core::{
    Backend, Camera, Cast, Extents, Filter, FilterKernel, Format, Geometry, ImageDesc, Inputs,
    Instance, Kernel, Light, LightSpace, Mesh, Module, RasterBias, Receive, ReceiveKernel, Recipe,
    Scene, Shadows, Simd, Span, View,
    glam::{Affine3A, UVec2, Vec3},
    light_space::{look_along, orthographic},
};
use umbrage_cpu::{Cpu, CpuOptions};

/// Kernel of two stages. Receive compares depth in the filtered image. Filter averages a texel and
/// its right neighbour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain {
    pub(crate) space: LightSpace,
}

impl Kernel for Plain {
    fn modules(&self) -> Vec<Module> {
        Vec::new()
    }
}

impl ReceiveKernel for Plain {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let map = &inputs.images[0];
        let texture_from_world = self.space.texture_from_world();
        for (i, out) in out.iter_mut().enumerate() {
            let p = texture_from_world.project_point3(span.position(i));
            let texel = (p.truncate() * map.desc.size.as_vec2()).as_ivec2();
            let last = map.desc.size.as_ivec2() - 1;
            let texel = texel.clamp(UVec2::ZERO.as_ivec2(), last);
            let stored = map.texels[map.index(texel.x, texel.y, 0)];
            *out = if p.z - 0.01 <= stored {
                1.0
            } else {
                stored * 0.5
            };
        }
    }
}

impl FilterKernel for Plain {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let image = &inputs.images[0];
        for (i, out) in out.chunks_mut(2).enumerate() {
            let x = start.x as i32 + i as i32;
            let y = start.y as i32;
            let right = (x + 1).min(image.desc.size.x as i32 - 1);
            out[0] = 0.5 * (image.load(x, y, layer) + image.load(right, y, layer));
            out[1] = layer as f32;
        }
    }
}

pub(crate) const SIZE: UVec2 = UVec2::new(97, 61);

/// Returns a bumpy ground with a floating sheet over part of it.
pub(crate) fn geometry() -> Geometry {
    let side = 40_u32;
    let height = |x: u32, z: u32| ((x * 7 + z * 13) % 11) as f32 * 0.02;
    let points = (0..side * side).map(|i| (i % side, i / side));
    let positions = points
        .map(|(x, z)| Vec3::new(x as f32 * 0.1 - 2.0, height(x, z), z as f32 * 0.1 - 2.0))
        .collect();
    let cells = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let triangles = cells
        .flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]])
        .collect();
    let ground = Mesh::new("ground", positions, triangles).unwrap();
    let corners =
        [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]].map(|[x, z]| Vec3::new(x, 0.8, z));
    let sheet = Mesh::new("sheet", corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut instances = [
        Instance::new(0, Affine3A::IDENTITY),
        Instance::new(1, Affine3A::IDENTITY),
    ];
    instances[1].receives = false;
    Geometry::bake(&Scene {
        meshes: vec![ground, sheet],
        instances: instances.into(),
        ..Scene::default()
    })
    .unwrap()
}

/// Returns the view of the scene by the camera, under the light.
pub(crate) fn view() -> View<'static> {
    static STAGE: LazyLock<(Camera, Light, Geometry)> =
        LazyLock::new(|| (camera(), light(), geometry()));
    let (camera, light, geometry) = &*STAGE;
    View::new(camera, light, geometry)
}

fn camera() -> Camera {
    Camera::perspective(
        Vec3::new(2.0, 3.0, 4.0),
        Vec3::ZERO,
        Vec3::Y,
        0.9,
        [0.1, 20.0],
        SIZE,
    )
    .unwrap()
}

fn light() -> Light {
    Light::Directional {
        direction: Vec3::new(0.3, -1.0, 0.2),
        angular_diameter: 0.0,
    }
}

pub(crate) fn space() -> LightSpace {
    let extents = Extents {
        left: -3.0,
        right: 3.0,
        bottom: -3.0,
        top: 3.0,
        near: 0.0,
        far: 10.0,
    };
    let view_from_world = look_along(
        Vec3::new(-1.5, 5.0, -1.0),
        Vec3::new(0.3, -1.0, 0.2),
        Vec3::Y,
    )
    .unwrap();
    LightSpace {
        view_from_world,
        clip_from_view: orthographic(extents).unwrap(),
    }
}

/// Returns a recipe with two depth layers, of which the first is drawn. Both are filtered into two
/// channels and looked up.
pub(crate) fn recipe() -> Recipe {
    let (space, kernel) = (space(), Arc::new(Plain { space: space() }));
    let image = |label, format| ImageDesc {
        label,
        size: UVec2::new(130, 75),
        layers: 2,
        format,
    };
    let bias = RasterBias {
        constant: 3,
        slope: 1.5,
        clamp: 0.0,
    };
    Recipe {
        images: vec![
            image("depth", Format::Depth32),
            image("blurred", Format::Rg32),
        ],
        tables: Vec::new(),
        casts: vec![Cast {
            bias,
            ..Cast::nearest(0, 0, space)
        }],
        filters: vec![Filter {
            kernel: kernel.clone(),
            inputs: vec![0],
            tables: Vec::new(),
            output: 1,
        }],
        receive: Receive {
            kernel,
            inputs: vec![1],
            tables: Vec::new(),
        },
        shade: None,
        hierarchy: None,
        keep_images: true,
    }
}

pub(crate) fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Returns the name of the first field that differs between two results.
pub(crate) fn difference(a: &Shadows, b: &Shadows) -> Option<&'static str> {
    let images = |s: &Shadows| s.images.iter().map(|i| bits(&i.texels)).collect::<Vec<_>>();
    if bits(&a.mask) != bits(&b.mask) {
        return Some("mask");
    }
    if images(a) != images(b) {
        return Some("images");
    }
    if a.receivers != b.receivers {
        return Some("receivers");
    }
    let picture = |s: &Shadows| s.picture.as_ref().map(|p| bits(p.as_flattened()));
    (picture(a) != picture(b)).then_some("picture")
}

pub(crate) fn render(cpu: &mut Cpu) -> Shadows {
    execute_recipe(cpu, &recipe())
}

/// Executes a recipe on a backend.
pub(crate) fn execute_recipe(cpu: &mut Cpu, recipe: &Recipe) -> Shadows {
    cpu.render(&view(), recipe).unwrap()
}

/// Returns the result of a recipe. Panics if threads or instructions change any bit of it.
pub(crate) fn same_on_all_backends(recipe: &Recipe) -> Shadows {
    let expected = execute_recipe(
        &mut Cpu::with_options(&CpuOptions::default().threads(1)).unwrap(),
        recipe,
    );
    for (threads, simd) in [(1, Simd::Baseline), (4, Simd::Native), (3, Simd::Baseline)] {
        let options = CpuOptions::default().threads(threads).simd(simd);
        let found = execute_recipe(&mut Cpu::with_options(&options).unwrap(), recipe);
        assert_eq!(difference(&expected, &found), None, "{options:?}");
    }
    expected
}
