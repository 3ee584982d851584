//! Tests of cube maps: no seams, and no face drawn in vain.
//!
//! A pixel is in the **seam band** if it is at most two texels from the edge of a cube's face. It
//! is **unexplained** if its mask is wrong (by more than a quarter) although the reference is
//! constant within the kernel's radius, plus two texels, around it: an error that no true shadow
//! edge explains.

use super::MapCase;
use glam::{UVec2, Vec2, Vec3};
use umbrage_core::{
    Backend, Camera, Instance, Layout, Mesh, Recipe, Scene, ShadowTechnique,
    metrics::{ERROR_THRESHOLD, Pixel},
};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{ReceiverPoint, TruthOptions, trace_points};
use umbrage_techniques::{Bias, Hard, MapFilter as _, Midpoint, Pcf, ShadowMap, TechniquePreset};

const SIZE: u32 = 512;

fn map(bias: Bias) -> ShadowMap {
    ShadowMap {
        size: SIZE,
        bias,
        layout: Layout::Cube,
        ..ShadowMap::default()
    }
}

/// Techniques with the radii of their kernels, texels.
fn techniques() -> [(TechniquePreset, f32); 4] {
    let pcf = |radius: u32| Pcf::new(radius).on(map(Bias::ADAPTIVE));
    [
        (TechniquePreset::from(Hard {}.on(map(Bias::ADAPTIVE))), 0.5),
        (TechniquePreset::from(pcf(1)), 1.5),
        (TechniquePreset::from(pcf(3)), 3.5),
        (
            TechniquePreset::from(Midpoint { radius: 0 }.on(map(Bias::ADAPTIVE))),
            0.5,
        ),
    ]
}

/// Position of a point on a face of the light's cube: distance along the face's axis, and texels
/// from the face's centre.
struct OnFace {
    axes: [Vec3; 3],
    distance: f32,
    texel: Vec2,
}

impl OnFace {
    /// Computes the position. Texels are those of faces of exactly 90 degrees; true ones are
    /// slightly larger.
    fn of_direction(d: Vec3) -> Self {
        let unit = [Vec3::X, Vec3::Y, Vec3::Z];
        let major = (0..3)
            .max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs()))
            .expect("three axes");
        let axes = [
            unit[major] * d[major].signum(),
            unit[(major + 1) % 3],
            unit[(major + 2) % 3],
        ];
        let distance = d.dot(axes[0]);
        let texel = Vec2::new(d.dot(axes[1]), d.dot(axes[2])) / distance * (SIZE as f32 / 2.0);
        Self {
            axes,
            distance,
            texel,
        }
    }

    /// Returns the distance to the nearest edge of the face, texels.
    fn to_edge(&self) -> f32 {
        SIZE as f32 / 2.0 - self.texel.abs().max_element()
    }

    /// Returns the ray from the light through a position `step` texels away from this one.
    fn ray_at_offset(&self, step: Vec2) -> Vec3 {
        let t = (self.texel + step) / (SIZE as f32 / 2.0);
        (self.axes[0] + self.axes[1] * t.x + self.axes[2] * t.y) * self.distance
    }
}

fn lamp(case: &MapCase) -> Vec3 {
    case.light().position().expect("a light with a position")
}

fn on_face(case: &MapCase, pixel: usize) -> OnFace {
    OnFace::of_direction(case.truth.receivers.position(pixel) - lamp(case))
}

/// Reports whether the reference changes within `texels` around a pixel, on the plane of its
/// surface.
fn is_near_edge(case: &MapCase, pixel: usize, texels: f32) -> bool {
    let lamp = lamp(case);
    let receivers = &case.truth.receivers;
    let p = receivers.position(pixel);
    let n = receivers.normal(pixel);
    let face = on_face(case, pixel);
    let rings = (1..=8).flat_map(|ring| {
        (0..24).map(move |k| (ring as f32 / 8.0, k as f32 * std::f32::consts::TAU / 24.0))
    });
    let rays = rings.map(|(r, turn)| {
        face.ray_at_offset(Vec2::from_angle(turn) * r * texels * std::f32::consts::SQRT_2)
    });
    let on_plane = rays.map(|ray| lamp + ray * ((p - lamp).dot(n) / ray.dot(n)));
    let points: Vec<ReceiverPoint> = on_plane
        .map(|q| ReceiverPoint {
            triangle: receivers.triangle[pixel],
            ..ReceiverPoint::new(q, n, &case.geometry)
        })
        .collect();
    let seen = trace_points(
        &case.geometry,
        case.light(),
        &points,
        &TruthOptions::default(),
    )
    .expect("valid points");
    seen.iter()
        .any(|s| s.visibility != case.truth.visibility[pixel])
}

/// Wrong pixels in the seam band and elsewhere.
fn false_pixels(case: &MapCase, mask: &[f32]) -> [Vec<usize>; 2] {
    let wrong = |&i: &usize| (mask[i] - case.truth.visibility[i]).abs() > ERROR_THRESHOLD;
    let (band, elsewhere) = case
        .counted_pixels()
        .filter(wrong)
        .partition(|&i| on_face(case, i).to_edge() <= 2.0);
    [band, elsewhere]
}

/// Unexplained pixels in the seam band and elsewhere.
fn unexplained_pixels(case: &MapCase, mask: &[f32], reach: f32) -> [usize; 2] {
    false_pixels(case, mask).map(|wrong| {
        wrong
            .into_iter()
            .filter(|&i| !is_near_edge(case, i, reach + 2.0))
            .count()
    })
}

/// Evaluated pixels in the seam band.
fn band(case: &MapCase) -> usize {
    case.counted_pixels()
        .filter(|&i| on_face(case, i).to_edge() <= 2.0)
        .count()
}

#[test]
fn faces_meet_without_seams() {
    let case = MapCase::with_name("lamp-in-room");
    let shadowed = case
        .counted_pixels()
        .filter(|&i| on_face(&case, i).to_edge() <= 2.0 && case.truth.visibility[i] == 0.0);
    assert!(
        band(&case) > 400 && shadowed.count() > 40,
        "too few pixels are at seams: {}",
        band(&case)
    );
    for (technique, reach) in techniques() {
        let mask = case.mask(&technique);
        assert_eq!(
            unexplained_pixels(&case, &mask, reach),
            [0, 0],
            "{} {}",
            technique.name(),
            technique.settings()
        );
    }
}

fn render(case: &MapCase, recipe: &Recipe) -> Vec<f32> {
    Cpu::new()
        .render(&case.view(), recipe)
        .expect("renders")
        .mask
}

/// Negative control: a face that is turned by a few texels must be detected as a seam.
#[test]
fn a_turned_face_is_caught() {
    let case = MapCase::with_name("lamp-in-room");
    let technique = Hard {}.on(map(Bias::NORMAL_OFFSET));
    let mut recipe = technique.recipe(&case.view()).expect("cubes serve bulbs");
    for cast in &mut recipe.casts {
        cast.space = cast
            .space
            .nudge_by(Vec2::splat(6.0), 0.0, UVec2::splat(SIZE));
    }
    let [count, _] = unexplained_pixels(&case, &render(&case, &recipe), 0.5);
    assert!(count > 5, "only {count} pixels show the turned faces");
}

/// Only faces with casters and visible receivers are drawn, and each of them matters.
#[test]
fn faces_are_drawn_if_they_are_needed() {
    let case = MapCase::of_scene(one_octant());
    let recipe = Hard {}
        .on(map(Bias::NORMAL_OFFSET))
        .recipe(&case.view())
        .expect("cubes serve bulbs");
    let drawn: Vec<u32> = recipe.casts.iter().map(|cast| cast.layer).collect();
    assert_eq!(drawn, [0, 3, 4], "+x, -y and +z alone hold casters");
    let whole = render(&case, &recipe);
    assert!(case.errors_of(&whole).acne == 0.0 && whole.contains(&0.0));
    for (left_out, layer) in drawn.iter().enumerate() {
        let mut less = recipe.clone();
        less.casts.remove(left_out);
        assert_ne!(render(&case, &less), whole, "layer {layer} does not matter");
    }
}

/// A point light over a floor, and three balls in the octant +x, -y, +z of the light, one in front
/// of each of its faces.
fn one_octant() -> Scene {
    let mut scene = (umbrage_scenes::find("lamp-in-room")
        .expect("built in")
        .build)();
    let floor = Mesh::new(
        "floor",
        [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)]
            .map(|(x, z)| Vec3::new(x, 0.0, z))
            .to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
    )
    .expect("valid");
    let tetrahedron = |center: Vec3, name: &str| {
        let corners = [
            (1.0, 1.0, 1.0),
            (1.0, -1.0, -1.0),
            (-1.0, 1.0, -1.0),
            (-1.0, -1.0, 1.0),
        ];
        let at = corners
            .map(|(x, y, z)| center + Vec3::new(x, y, z) * 0.15)
            .to_vec();
        Mesh::new(name, at, vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]).expect("valid")
    };
    let lamp = Vec3::Y * 2.0;
    let casters = [
        Vec3::new(1.5, -0.6, 0.5),
        Vec3::new(0.4, -1.2, 0.4),
        Vec3::new(0.5, -0.6, 1.5),
    ];
    scene.meshes = vec![floor];
    scene
        .meshes
        .extend(casters.map(|at| tetrahedron(lamp + at, "caster")));
    scene.instances = (0..4)
        .map(|i| Instance {
            casts: i > 0,
            ..Instance::new(i, glam::Affine3A::IDENTITY)
        })
        .collect();
    scene.lights = vec![umbrage_core::Light::Point {
        position: lamp,
        radius: 0.0,
    }];
    let camera = Camera::perspective(
        Vec3::new(9.0, 8.0, 9.0),
        Vec3::new(2.0, 0.0, 2.0),
        Vec3::Y,
        1.0,
        [0.1, 99.0],
        UVec2::new(200, 150),
    );
    scene.cameras = vec![camera.expect("valid")];
    scene
}

#[test]
fn unseen_pixels_do_not_count() {
    let case = MapCase::of_scene(one_octant());
    assert!(case.truth.pixels.contains(&Pixel::Empty) && case.counted_pixels().count() > 1000);
}
