//! Random scenes for property tests: meshes, placements, lights, cameras, techniques.

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use proptest::{collection::vec, prelude::*, strategy::Union};
use umbrage_core::{
    AlphaCutout, AlphaFilter, Camera, Cascades, Cull, Extents, Fit, Instance, Layout, Light,
    MAX_CASCADES, Material, Mesh, RasterBias, Scene, Split, Texture,
};
use umbrage_plan::catalogue::{self, CatalogueEntry, RandomParameter};
use umbrage_techniques::{
    BeyondFar, Bias, Border, MapFormat, Pattern, ShadowMap, Surface, TechniquePreset,
};

/// An input of rendering: one scene, one technique.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene, with one light and one camera.
    pub scene: Scene,
    /// The technique.
    pub technique: TechniquePreset,
}

/// Scenes, some of them alpha-tested, with techniques whose kernels are bit-equal on drivers that
/// keep the order of operations.
pub fn cases() -> impl Strategy<Value = Case> {
    let scenes = prop_oneof![5 => scenes().boxed(), 1 => scenes_with_holes().boxed()];
    (scenes, techniques()).prop_map(|(scene, technique)| Case { scene, technique })
}

/// Scenes like those of [`scenes`], with about half of their objects alpha-tested. Half of the
/// scenes use the hashed filter.
pub fn scenes_with_holes() -> impl Strategy<Value = Scene> {
    let texture = (1..9_u32, 1..9_u32)
        .prop_flat_map(|(width, height)| {
            let alphas = vec(0.0..=1.0_f32, (width * height) as usize);
            (Just(UVec2::new(width, height)), alphas)
        })
        .prop_map(|(size, alphas)| Texture {
            name: "holes".into(),
            size,
            texels: alphas.into_iter().map(|a| [0.5, 0.5, 0.5, a]).collect(),
        });
    let are_cut_out = vec(any::<bool>(), 6);
    (scenes(), texture, 0.2..0.8_f32, -3.0..3.0_f32, are_cut_out).prop_map(
        |(mut scene, texture, cutoff, repeats, are_cut_out)| {
            // Use the last bit as a random one.
            let is_hashed = cutoff.to_bits() & 1 == 1;
            let filter = if is_hashed {
                AlphaFilter::Hashed
            } else {
                AlphaFilter::Nearest
            };
            // Put several texels into a pixel.
            let repeats = if is_hashed { 10.0 * repeats } else { repeats };
            for mesh in &mut scene.meshes {
                // Map across two sides of boxes, so that none is a line of one texel.
                let uv = |p: &Vec3| Vec2::new(p.x + 0.3 * p.y, p.z - 0.7 * p.y) * repeats;
                mesh.uvs = mesh.positions.iter().map(uv).collect();
            }
            scene.textures = vec![texture];
            scene.materials = vec![Material {
                alpha: Some(AlphaCutout {
                    texture: 0,
                    cutoff,
                    filter,
                }),
                ..Material::default()
            }];
            for (instance, is_cut_out) in scene.instances.iter_mut().zip(are_cut_out) {
                instance.material = is_cut_out.then_some(0);
            }
            scene
        },
    )
}

/// Scenes with a floor or without, of one to five objects.
pub fn scenes() -> impl Strategy<Value = Scene> {
    (
        vec(meshes(), 1..5),
        vec(placements(), 1..6),
        lights(),
        cameras(),
        any::<bool>(),
    )
        .prop_map(|(mut meshes, placements, light, camera, floor)| {
            let mut instances: Vec<Instance> = placements
                .into_iter()
                .enumerate()
                .map(|(i, (world_from_local, casts, receives))| Instance {
                    casts,
                    receives,
                    ..Instance::new(i % meshes.len(), world_from_local)
                })
                .collect();
            if floor {
                let scale = Affine3A::from_scale(Vec3::new(6.0, 1.0, 6.0));
                instances.push(Instance::new(meshes.len(), scale));
                meshes.push(quad());
            }
            let (name, lights, cameras) = ("random".into(), vec![light], vec![camera]);
            Scene {
                name,
                meshes,
                instances,
                lights,
                cameras,
                ..Scene::default()
            }
        })
}

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: "random".into(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

fn quad() -> Mesh {
    let corner = |x, z| Vec3::new(x, 0.0, z);
    mesh(
        vec![
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
        ],
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

/// A closed box, counter-clockwise seen from outside.
fn cuboid() -> Mesh {
    let corner =
        |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    mesh(
        (0..8).map(corner).collect(),
        sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    )
}

/// Arbitrary triangles that intersect, touch, repeat and degenerate.
fn soup() -> impl Strategy<Value = Mesh> {
    vec((vec3(-1.0..1.0), vec3(-1.0..1.0), vec3(-1.0..1.0)), 1..30).prop_map(|corners| {
        let positions: Vec<Vec3> = corners
            .into_iter()
            .flat_map(|(a, b, c)| [a, b, c])
            .collect();
        let triangles = (0..positions.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        mesh(positions, triangles)
    })
}

fn meshes() -> impl Strategy<Value = Mesh> {
    prop_oneof![Just(cuboid()), Just(quad()), soup()]
}

fn placements() -> impl Strategy<Value = (Affine3A, bool, bool)> {
    let scale = (
        0.05..2.0_f32,
        0.05..2.0_f32,
        0.05..2.0_f32,
        prop_oneof![4 => Just(1.0), 1 => Just(-1.0)],
    );
    (
        scale,
        rotations(),
        vec3(-2.5..2.5),
        prop_oneof![5 => Just(true), 1 => Just(false)],
        prop_oneof![5 => Just(true), 1 => Just(false)],
    )
        .prop_map(
            |((x, y, z, mirror), rotation, translation, casts, receives)| {
                let scale = Vec3::new(x * mirror, y, z);
                (
                    Affine3A::from_scale_rotation_translation(scale, rotation, translation),
                    casts,
                    receives,
                )
            },
        )
}

/// Rotations, many of them axis-aligned, which cause ties.
fn rotations() -> impl Strategy<Value = Quat> {
    prop_oneof![
        Just(Quat::IDENTITY),
        (vec3(-1.0..1.0), -3.2..3.2_f32)
            .prop_map(|(axis, angle)| Quat::from_axis_angle(axis.normalize_or(Vec3::Y), angle)),
    ]
}

fn vec3(range: std::ops::Range<f32>) -> impl Strategy<Value = Vec3> {
    (range.clone(), range.clone(), range).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn directions() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        1 => Just(Vec3::NEG_Y),
        6 => (vec3(-1.0..1.0), 0.05..1.5_f32).prop_map(|(v, down)| Vec3::new(v.x, -down, v.z)),
    ]
}

fn lights() -> impl Strategy<Value = Light> {
    let above = || (vec3(-3.0..3.0), 3.0..9.0_f32).prop_map(|(v, y)| Vec3::new(v.x, y, v.z));
    prop_oneof![
        3 => directions().prop_map(|direction| Light::Directional { direction, angular_diameter: 0.0 }),
        1 => directions().prop_map(|direction| Light::Directional { direction, angular_diameter: 0.1 }),
        2 => (above(), 0.2..1.2_f32, vec3(-0.5..0.5), radii()).prop_map(|(position, outer, target, radius)| Light::Spot {
            position,
            direction: target - position,
            inner: outer * 0.5,
            outer,
            radius,
        }),
        1 => (above(), radii()).prop_map(|(position, radius)| Light::Point { position, radius }),
        // Among the objects, so that only a cube can cover its surroundings.
        2 => (vec3(-1.5..1.5), radii()).prop_map(|(position, radius)| Light::Point { position, radius }),
        1 => above().prop_map(|center| Light::Rect { center, half_u: Vec3::X * 0.4, half_v: Vec3::Z * 0.3 }),
        1 => above().prop_map(|center| Light::Disc { center, normal: Vec3::NEG_Y, radius: 0.5 }),
    ]
}

/// Radii of lights without extent, and of area lights.
fn radii() -> impl Strategy<Value = f32> {
    prop_oneof![2 => Just(0.0), 1 => 0.01..0.6_f32]
}

fn cameras() -> impl Strategy<Value = Camera> {
    let eyes = (0.0..6.3_f32, 0.1..1.5_f32, 2.0..12.0_f32);
    (
        eyes,
        vec3(-1.0..1.0),
        20.0..100.0_f32,
        1..97_u32,
        1..70_u32,
        prop_oneof![4 => Just(false), 1 => Just(true)],
    )
        .prop_map(
            |((turn, height, distance), target, fov, width, rows, flat)| {
                let around = Vec3::new(
                    turn.cos() * height.cos(),
                    height.sin(),
                    turn.sin() * height.cos(),
                );
                let (eye, size) = (target + around * distance, UVec2::new(width, rows));
                let camera = if flat {
                    let extents = Extents {
                        left: -4.0,
                        right: 4.0,
                        bottom: -3.0,
                        top: 3.0,
                        near: 0.0,
                        far: 30.0,
                    };
                    Camera::orthographic(eye, target, Vec3::Y, extents, size)
                } else {
                    Camera::perspective(eye, target, Vec3::Y, fov.to_radians(), [0.5, 40.0], size)
                };
                camera.expect("the ranges above are valid")
            },
        )
}

/// Built-in techniques, weighted by their rows of the catalogue, with settings from random numbers.
fn techniques() -> impl Strategy<Value = TechniquePreset> {
    let weighted = catalogue::all()
        .iter()
        .map(|entry| (entry.random_weight, random(entry)))
        .collect();
    Union::new_weighted(weighted)
}

fn random(entry: &'static CatalogueEntry) -> BoxedStrategy<TechniquePreset> {
    let maps = if entry.technique.has_map {
        maps().boxed()
    } else {
        Just(ShadowMap::default()).boxed()
    };
    let parameters = (entry.random_parameters)();
    let numbers: Vec<BoxedStrategy<f32>> = parameters.into_iter().map(number).collect();
    (maps, numbers)
        .prop_map(|(map, numbers)| (entry.random)(map, &numbers))
        .boxed()
}

fn number(parameter: RandomParameter) -> BoxedStrategy<f32> {
    match parameter {
        RandomParameter::Count(range) => range.prop_map(|n| n as f32).boxed(),
        RandomParameter::Length(range) => range.boxed(),
        RandomParameter::Pattern => {
            let places = (0..Pattern::ALL.len()).map(|place| Just(place as f32));
            Union::new(places).boxed()
        }
        RandomParameter::Switch => any::<bool>().prop_map(|on| f32::from(u8::from(on))).boxed(),
    }
}

fn maps() -> impl Strategy<Value = ShadowMap> {
    let surfaces = prop_oneof![5 => Just(Surface::Nearest), 1 => Just(Surface::Midpoint)];
    (
        1..200_u32,
        biases(),
        fits_and_layouts(),
        surfaces,
        formats(),
        any_outside(),
    )
        .prop_map(
            |(size, bias, (fit, layout), surface, format, (border, beyond_far))| ShadowMap {
                size,
                fit,
                bias,
                layout,
                surface,
                format,
                border,
                beyond_far,
            },
        )
}

/// Fits and layouts. Cascades follow the camera, which not all fits do.
fn fits_and_layouts() -> impl Strategy<Value = (Fit, Layout)> {
    let layouts =
        prop_oneof![4 => Just(Layout::Auto), 1 => Just(Layout::Single), 1 => Just(Layout::Cube)];
    let stable = (1.0..20.0_f32).prop_map(|range| Fit::Stable { range });
    let cascaded = (
        prop_oneof![Just(Fit::Tight), stable],
        cascades().prop_map(Layout::Cascades),
    );
    prop_oneof![9 => (fits(), layouts), 2 => cascaded]
}

fn cascades() -> impl Strategy<Value = Cascades> {
    let splits = prop_oneof![
        Just(Split::Log),
        (0.0..=1.0_f32).prop_map(|lambda| Split::Practical { lambda }),
        Just(Split::Receivers),
    ];
    let blends = prop_oneof![Just(0.0), 0.5..30.0_f32];
    (1..=MAX_CASCADES as u32, splits, 0.0..6.0_f32, blends).prop_map(
        |(count, split, nearest, blend)| Cascades {
            count,
            split,
            nearest,
            blend,
        },
    )
}

fn any_outside() -> impl Strategy<Value = (Border, BeyondFar)> {
    let borders = prop_oneof![4 => Just(Border::Lit), 1 => Just(Border::Clamp)];
    let beyond_far = prop_oneof![4 => Just(BeyondFar::Clamped), 1 => Just(BeyondFar::Compared)];
    // A third value of `beyond_far` would change all later draws of a seed.
    (borders, beyond_far).prop_map(|outside| match outside {
        (Border::Clamp, BeyondFar::Compared) => (Border::Lit, BeyondFar::Lit),
        other => other,
    })
}

fn formats() -> impl Strategy<Value = MapFormat> {
    prop_oneof![4 => Just(MapFormat::Depth32), 1 => Just(MapFormat::Depth16), 1 => Just(MapFormat::Rgba8)]
}

/// Fits. Manual ones clip casters and receivers, also in depth.
fn fits() -> impl Strategy<Value = Fit> {
    let manual = (vec3(-3.0..3.0), 0.5..5.0_f32, 0.1..4.0_f32, 1.0..12.0_f32).prop_map(
        |(eye, half, near, depth)| {
            let extents = Extents {
                left: -half,
                right: half,
                bottom: -half,
                top: half,
                near,
                far: near + depth,
            };
            Fit::Manual {
                eye: eye + Vec3::Y * 4.0,
                extents,
            }
        },
    );
    let stable = (1.0..20.0_f32).prop_map(|range| Fit::Stable { range });
    prop_oneof![4 => Just(Fit::Tight), 1 => Just(Fit::Whole), 1 => stable, 1 => manual]
}

/// Biases: the presets, and random combinations.
fn biases() -> impl Strategy<Value = Bias> {
    let presets = (0..Bias::PRESETS.len()).prop_map(|i| Bias::PRESETS[i].1);
    let culls = prop_oneof![Just(Cull::None), Just(Cull::Front), Just(Cull::Back)];
    let rasters = (
        -5000..5000_i32,
        -3.0..3.0_f32,
        prop_oneof![Just(0.0), -0.01..0.01_f32],
    )
        .prop_map(|(constant, slope, clamp)| RasterBias {
            constant,
            slope,
            clamp,
        });
    let planes = (0.0..0.2_f32, any::<bool>());
    let mixed = (
        -0.01..0.01_f32,
        0.0..0.1_f32,
        0.0..0.01_f32,
        rasters,
        -2.0..2.0_f32,
        planes,
        culls,
    )
        .prop_map(
            |(
                constant,
                slope,
                slope_min,
                raster,
                normal_offset,
                (receiver_plane, adaptive),
                cull,
            )| Bias {
                constant,
                slope,
                slope_min,
                raster,
                normal_offset,
                receiver_plane,
                adaptive,
                cull,
            },
        );
    prop_oneof![presets, mixed]
}
