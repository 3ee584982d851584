//! Tests of truth and its ambiguous pixels against a 64-bit oracle that tests every triangle.

use super::super::{oracle::Oracle, *};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use rayon::prelude::*;
use umbrage_core::{
    AlphaCutout, AlphaFilter, Extents, Instance, Light, Material, Mesh, Scene, Texture,
    light_sample::hash,
};
use umbrage_cpu::Cpu;

/// Triangles with a camera and a light.
struct AmbiguityCase {
    name: &'static str,
    corners: Vec<[Vec3; 3]>,
    camera: Camera,
    light: Light,
}

/// Returns a number in 0..1, the same for the same argument.
fn random(i: u32) -> f32 {
    hash(i) as f32 / 4_294_967_296.0
}

fn random_vector(i: u32) -> Vec3 {
    Vec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2))
}

fn quad(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [[Vec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn floor(side: f32) -> Vec<[Vec3; 3]> {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z) * side;
    quad(
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    )
    .to_vec()
}

fn cuboid(at: Affine3A) -> Vec<[Vec3; 3]> {
    let corner = |i: u32| {
        at.transform_point3(
            Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0,
        )
    };
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    sides
        .iter()
        .flat_map(|s| quad(corner(s[0]), corner(s[1]), corner(s[2]), corner(s[3])))
        .collect()
}

/// Returns boxes in many orientations, some through the floor.
fn boxes() -> Vec<[Vec3; 3]> {
    let mut out = floor(4.0);
    for i in 0..8 {
        let turn = Quat::from_euler(
            EulerRot::XYZ,
            random(7 * i) * 3.0,
            random(7 * i + 1) * 3.0,
            0.4,
        );
        let place = (random_vector(100 + i) * 2.0 - 1.0) * Vec3::new(2.5, 0.5, 2.5) + Vec3::Y * 0.5;
        out.extend(cuboid(Affine3A::from_scale_rotation_translation(
            random_vector(200 + i) * 0.6 + 0.05,
            turn,
            place,
        )));
    }
    out
}

/// Returns upright, level and slanted wires with widths from a thousandth of a pixel to a tenth.
fn wires() -> Vec<[Vec3; 3]> {
    let mut out = floor(6.0);
    for i in 0..60 {
        let foot = Vec3::new(
            random(3 * i) * 8.0 - 4.0,
            0.0,
            random(3 * i + 1) * 8.0 - 4.0,
        );
        let along = [Vec3::Y, Vec3::new(2.0, 0.4, 1.0), Vec3::new(-0.7, 1.0, 0.3)][i as usize % 3];
        let across = Vec3::new(random(i + 500) - 0.5, 0.1, random(i + 600) - 0.5).normalize() * 0.2
            / 4.0_f32.powi(i as i32 % 6);
        out.push([foot, foot + along, foot + along + across]);
        out.push([foot, foot + along + across, foot + across]);
    }
    out
}

/// Returns boxes on the floor, and plates from a ten-millionth of a metre to a centimetre above it.
fn contacts() -> Vec<[Vec3; 3]> {
    let mut out = floor(4.0);
    for i in 0..10 {
        let place = Vec3::new(
            random(5 * i) * 6.0 - 3.0,
            0.0,
            random(5 * i + 1) * 6.0 - 3.0,
        );
        let turn = Quat::from_rotation_y(random(5 * i + 2) * 3.0);
        if i % 2 == 0 {
            let half = Vec3::new(0.3, 0.4, 0.2);
            out.extend(cuboid(Affine3A::from_scale_rotation_translation(
                half,
                turn,
                place + Vec3::Y * half.y,
            )));
        } else {
            let corner = |x: f32, z: f32| {
                place + turn * Vec3::new(x, 0.0, z) + Vec3::Y * 10.0_f32.powi(i as i32 / 2 - 6)
            };
            out.extend(quad(
                corner(-0.5, -0.5),
                corner(-0.5, 0.5),
                corner(0.5, 0.5),
                corner(0.5, -0.5),
            ));
        }
    }
    out
}

/// Returns a finely tessellated sphere above the floor, with shared edges everywhere.
fn ball() -> Vec<[Vec3; 3]> {
    let at = |ring: u32, side: u32| {
        let (s, c) = (ring as f32 / 16.0 * std::f32::consts::PI).sin_cos();
        let (sk, ck) = (side as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
        Vec3::new(0.2, 1.1, 0.0) + Vec3::new(s * ck, c, s * sk)
    };
    let sides = (0..16).flat_map(|ring| (0..24).map(move |side| (ring, side)));
    floor(4.0)
        .into_iter()
        .chain(
            sides.flat_map(|(r, k)| quad(at(r, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k))),
        )
        .collect()
}

fn cases() -> Vec<AmbiguityCase> {
    let sun = |x: f32, y: f32, z: f32| Light::Directional {
        direction: Vec3::new(x, y, z),
        angular_diameter: 0.0,
    };
    let low_sun = sun(-0.8, -0.03, -0.5);
    let bulb = Light::Point {
        position: Vec3::new(-1.5, 2.7, 1.0),
        radius: 0.0,
    };
    let spot = Light::Spot {
        position: Vec3::new(2.0, 4.0, 2.0),
        direction: Vec3::new(-0.5, -1.0, -0.6),
        inner: 0.3,
        outer: 0.6,
        radius: 0.0,
    };
    let shapes = [
        ("boxes", boxes()),
        ("wires", wires()),
        ("contacts", contacts()),
        ("ball", ball()),
    ];
    let lights = [sun(-0.5, -0.7, -0.3), low_sun, bulb, spot];
    let mut out = Vec::new();
    for (name, shape) in shapes {
        for (k, light) in lights.into_iter().enumerate() {
            out.push(AmbiguityCase {
                name,
                corners: shape.clone(),
                camera: camera(Vec3::ZERO, k == 2),
                light,
            });
        }
    }
    out
}

/// Returns boxes this far from the origin, with rounded corners.
fn far_case(metres: f32) -> AmbiguityCase {
    let at = Vec3::new(1.0, 0.0, 0.9) * metres;
    let corners = boxes().into_iter().map(|t| t.map(|c| c + at)).collect();
    let light = Light::Directional {
        direction: Vec3::new(-0.5, -0.7, -0.3),
        angular_diameter: 0.0,
    };
    AmbiguityCase {
        name: "boxes far away",
        corners,
        camera: camera(at, false),
        light,
    }
}

/// Returns boxes and plates on a ground of 200 km that rises by this angle along x, radians. Lights
/// are a high and a low sun, and a rectangle. One camera is 10 cm above the ground.
fn giant_cases(slope: f32) -> Vec<AmbiguityCase> {
    let turn = Affine3A::from_rotation_z(slope);
    let sun = |x: f32, y: f32, z: f32| Light::Directional {
        direction: Vec3::new(x, y, z),
        angular_diameter: 0.0,
    };
    let high_sun = sun(-0.5, -0.7, -0.3);
    let rect = Light::Rect {
        center: Vec3::new(-1.5, 3.5, 1.0),
        half_u: Vec3::new(0.5, 0.0, 0.1),
        half_v: Vec3::new(0.0, 0.1, 0.4),
    };
    let high = camera(Vec3::ZERO, false);
    let eye = turn.transform_point3(Vec3::new(3.0, 0.1, 4.0));
    let target = turn.transform_point3(Vec3::Y * 0.1);
    let low = Camera::perspective(eye, target, Vec3::Y, 0.7, [0.1, 1e6], high.size);
    let low = low.expect("a good camera");
    let views = [
        (high, high_sun),
        (high, sun(-0.8, -0.05, -0.5)),
        (high, rect),
        (low, high_sun),
    ];
    let mut out = Vec::new();
    for (name, shape) in [("boxes", boxes()), ("contacts", contacts())] {
        // The first two triangles are the small floor.
        let on_giant = floor(1e5).into_iter().chain(shape.into_iter().skip(2));
        let corners: Vec<_> = on_giant
            .map(|t| t.map(|c| turn.transform_point3(c)))
            .collect();
        for (camera, light) in views {
            out.push(AmbiguityCase {
                name,
                corners: corners.clone(),
                camera,
                light,
            });
        }
    }
    out
}

fn camera(at: Vec3, parallel: bool) -> Camera {
    let (eye, size) = (at + Vec3::new(4.0, 3.5, 6.0), UVec2::new(96, 64));
    if parallel {
        let extents = Extents {
            left: -4.2,
            right: 4.2,
            bottom: -2.8,
            top: 2.8,
            near: 0.5,
            far: 30.0,
        };
        return Camera::orthographic(eye, at, Vec3::Y, extents, size).expect("a good camera");
    }
    Camera::perspective(eye, at, Vec3::Y, 0.7, [0.5, 50.0], size).expect("a good camera")
}

/// Returns the truth of a valid scene.
fn truth_of_scene(scene: &Scene, camera: &Camera, light: &Light) -> (Geometry, Truth) {
    let geometry = Geometry::bake(scene).expect("a good scene");
    let mut cpu = Cpu::new();
    let mut find = |camera: &_, geometry: &_| cpu.receivers(camera, geometry);
    let options = TruthOptions::default();
    let truth = trace(camera, light, &geometry, &options, &mut find, &|_, _| {}).expect("valid");
    (geometry, truth)
}

fn truth_of(case: &AmbiguityCase) -> (Geometry, Truth) {
    let positions = case.corners.iter().flatten().copied().collect();
    let triangles = (0..case.corners.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let mesh = Mesh::new(case.name, positions, triangles).expect("a good mesh");
    let instances = vec![Instance::new(0, Affine3A::IDENTITY)];
    let scene = Scene {
        meshes: vec![mesh],
        instances,
        ..Scene::default()
    };
    truth_of_scene(&scene, &case.camera, &case.light)
}

/// Pixel, the triangle that it shows, and its truth.
type TruthRequest = ([u32; 2], Option<u32>, f64);

/// Returns the number of pixels that the oracle contradicts and the total, among the pixels that
/// are marked, or those that aren't.
fn contradicted_pixels(
    case: &AmbiguityCase,
    marked: bool,
    contradicts: impl Fn(&Oracle<'_>, TruthRequest) -> bool + Sync,
) -> [usize; 2] {
    let (geometry, truth) = truth_of(case);
    let oracle = Oracle::new(&geometry, &case.camera, &case.light);
    let pixels: Vec<usize> = (0..truth.pixels.len())
        .filter(|&i| truth.ambiguous[i] == marked)
        .collect();
    let is_wrong = |&&i: &&usize| {
        let value = if truth.pixels[i] == Pixel::Unlit {
            0.0
        } else {
            truth.visibility[i]
        };
        let pixel = [i as u32 % truth.size.x, i as u32 / truth.size.x];
        let shown = truth.receivers.receives[i].then_some(truth.receivers.triangle[i]);
        let wrong = contradicts(&oracle, (pixel, shown, f64::from(value)));
        if wrong {
            println!(
                "{} under {:?}: pixel {pixel:?}, {:?}, {value}",
                case.name, case.light, truth.pixels[i]
            );
        }
        wrong
    };
    [pixels.par_iter().filter(is_wrong).count(), pixels.len()]
}

/// Unmarked pixels agree with the oracle, also wherever rounding may move them on the visible
/// surface.
#[test]
fn answers_that_are_not_ambiguous_are_right() {
    for case in cases() {
        // The vicinity contains a circle of cos(pi / 16) times its radius.
        let [wrong, pixels] = contradicted_pixels(&case, false, |oracle, (pixel, shown, value)| {
            oracle.answer(pixel, None) != value
                || shown.is_some() && oracle.changes(pixel, shown, 0.0196, 1.0, 24)
        });
        assert_eq!(
            wrong, 0,
            "of {pixels} of {} under {:?}",
            case.name, case.light
        );
    }
}

/// Far from the origin, a camera's matrix is rounded so that images move by several pixels, the
/// same in all backends. The results are right for the triangles that are shown.
#[test]
fn answers_far_from_the_origin_are_right_where_they_are_not_ambiguous() {
    for (metres, least) in [(1e3, 6_000), (1e4, 5_000), (1e5, 3_000), (1e6, 1_000)] {
        let [wrong, pixels] =
            contradicted_pixels(&far_case(metres), false, |oracle, (pixel, shown, value)| {
                oracle.answer(pixel, shown) != value
            });
        assert!(
            wrong == 0 && pixels >= least,
            "{wrong} of {pixels} at {metres} m"
        );
    }
}

/// Tolerance for visible shares of area lights. The oracle's points misplace a straight edge by half
/// a cell of their grid, 1/64 of the light's side, and shadows here have at most four in the light.
const AREA_TOLERANCE: f64 = 4.0 / 64.0;

/// On giant ground, depths are interpolated so far that the wrong one of two surfaces may be shown
/// next to their intersection. The results are right for the triangles that are shown, also
/// wherever rounding near the point may move them. Few pixels are marked. With a
/// [`GIANT`](super::super::points::GIANT) of 1e9, these tests fail, and with one of 1 those of marks.
#[test]
fn answers_on_giant_ground_are_right_where_they_are_not_ambiguous() {
    for case in [0.0, 0.2].into_iter().flat_map(giant_cases) {
        let is_ideal = case.light.is_ideal();
        let tolerance = if is_ideal { 0.0 } else { AREA_TOLERANCE };
        let [wrong, pixels] = contradicted_pixels(&case, false, |oracle, (pixel, shown, value)| {
            // A quarter of the pixels is enough for area lights, which take a thousand rays each.
            let is_tested = is_ideal || (pixel[0] + pixel[1]).is_multiple_of(4);
            shown.is_some()
                && is_tested
                && ((oracle.answer(pixel, shown) - value).abs() > tolerance
                    || is_ideal && oracle.changes(pixel, shown, 0.0196, 1.0, 24))
        });
        assert!(
            wrong == 0 && pixels > 6_000,
            "{wrong} of {pixels} under {:?}",
            case.light
        );
    }
}

/// Marked pixels change within the limits of rounding, or slightly beyond: the corners of the
/// limits are too small for samples.
#[test]
fn ambiguous_answers_change_within_rounding() {
    let mut marked = 0;
    let giant = giant_cases(0.0)
        .into_iter()
        .filter(|case| case.name == "contacts" && case.light.is_ideal());
    for case in cases().into_iter().chain(giant) {
        let [firm, pixels] = contradicted_pixels(&case, true, |oracle, (pixel, shown, _)| {
            let [found, given] = [None, shown].map(|shown| oracle.answer(pixel, shown));
            let changes = |shown| oracle.changes(pixel, shown, 0.0215, 1.1, 4_000);
            // Rounding alone may show another surface than the exact ray meets.
            found == given && !changes(None) && !changes(shown)
        });
        assert_eq!(
            firm, 0,
            "of {pixels} of {} under {:?}",
            case.name, case.light
        );
        marked += pixels;
    }
    assert!(marked > 200, "too few marked pixels: {marked}");
}

/// Truth of a box's shadow is the same on a ground of 200 km as on one of 20 m, and as certain.
#[test]
fn the_size_of_the_ground_leaves_out_no_shadow() {
    let light = Light::Directional {
        direction: Vec3::new(-1.0, -1.2, -0.5),
        angular_diameter: 0.0,
    };
    let block = cuboid(Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.5),
        Quat::IDENTITY,
        Vec3::Y * 0.5,
    ));
    let truth_on = |half: f32| {
        let (eye, target) = (Vec3::new(3.0, 2.5, 4.0), Vec3::Y * 0.5);
        let size = UVec2::new(320, 240);
        let camera = Camera::perspective(eye, target, Vec3::Y, 0.7, [0.1, 1e6], size);
        let case = AmbiguityCase {
            name: "box",
            corners: floor(half).into_iter().chain(block.clone()).collect(),
            camera: camera.expect("a good camera"),
            light,
        };
        truth_of(&case).1
    };
    let near = truth_on(10.0);
    for half in [1e3, 1e5, 1e7] {
        let giant = truth_on(half);
        let mut shadow = 0;
        let mut left_out = 0;
        for i in 0..near.pixels.len() {
            // Giant triangles are rasterised less accurately: compare where both show the ground,
            // whose triangles come first.
            let shows_ground =
                |truth: &Truth| truth.receivers.receives[i] && truth.receivers.triangle[i] < 2;
            if !shows_ground(&near) || !shows_ground(&giant) {
                continue;
            }
            if giant.pixels[i] == Pixel::Ambiguous {
                left_out += 1;
            } else if near.pixels[i] == Pixel::Counted {
                assert_eq!(near.visibility[i], giant.visibility[i], "{half}: {i}");
                shadow += usize::from(giant.visibility[i] == 0.0);
            }
        }
        assert!(
            shadow > 150 && left_out <= 8,
            "{half}: {shadow}, {left_out}"
        );
    }
}

/// Light through the holes of a roof of 200 km, whose texture covers 1 m, falls on the ground where a
/// formula says. With uvs interpolated in 32 bits, 34 of 3,624 pixels were wrong.
#[test]
fn holes_of_giant_triangles_are_in_place() {
    const HALF: f32 = 1e5;
    const HEIGHT: f32 = 5.0;
    const SIDE: u32 = 8;
    let is_there = |texel: u32| !hash(texel).is_multiple_of(3);
    let direction = Vec3::new(-0.5, -0.7, -0.3);
    let light = Light::Directional {
        direction,
        angular_diameter: 0.0,
    };
    let camera = camera(Vec3::ZERO, false);
    // Texture coordinates are 0 in the middle, or at a corner. There, 32-bit programs misplace holes by
    // most of a texel, so that most pixels are marked.
    for (uv_of_middle, least) in [(0.0, 3_500), (HALF, 200)] {
        let mesh = |name: &str, half: f32, height: f32| {
            let corners = floor(half).into_iter().flatten();
            let positions: Vec<Vec3> = corners.map(|c| c + Vec3::Y * height).collect();
            let uv = |p: &Vec3| glam::Vec2::new(p.x, p.z) + uv_of_middle;
            let uvs = positions.iter().map(uv).collect();
            let mesh = Mesh::new(name, positions, vec![[0, 1, 2], [3, 4, 5]]);
            Mesh {
                uvs,
                ..mesh.expect("a good mesh")
            }
        };
        let alpha = AlphaCutout {
            texture: 0,
            cutoff: 0.5,
            filter: AlphaFilter::Nearest,
        };
        let texels = (0..SIDE * SIDE).map(|i| [f32::from(u8::from(is_there(i))); 4]);
        let roof = Instance {
            material: Some(0),
            ..Instance::new(1, Affine3A::IDENTITY)
        };
        let scene = Scene {
            meshes: vec![mesh("ground", 4.0, 0.0), mesh("roof", HALF, HEIGHT)],
            instances: vec![Instance::new(0, Affine3A::IDENTITY), roof],
            materials: vec![Material {
                alpha: Some(alpha),
                ..Material::default()
            }],
            textures: vec![Texture {
                name: "holes".to_owned(),
                size: UVec2::splat(SIDE),
                texels: texels.collect(),
            }],
            ..Scene::default()
        };
        let (_, truth) = truth_of_scene(&scene, &camera, &light);
        let [mut tested, mut wrong] = [0, 0];
        for i in (0..truth.pixels.len()).filter(|&i| truth.pixels[i] == Pixel::Counted) {
            let ground = truth.receivers.position(i).as_dvec3();
            let to_sun = -direction.as_dvec3();
            let on_roof = ground + to_sun * (f64::from(HEIGHT) / to_sun.y);
            let texel = |t: f64| ((t - t.floor()) * f64::from(SIDE)) as u32;
            let is_lit = !is_there(texel(on_roof.z) * SIDE + texel(on_roof.x));
            tested += 1;
            wrong += u32::from(truth.visibility[i] != f32::from(u8::from(is_lit)));
        }
        assert!(
            wrong == 0 && tested > least,
            "{uv_of_middle}: {wrong} of {tested}"
        );
    }
}
