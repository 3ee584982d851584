//! Tests of stable fits: a moving camera changes no shadow.

use glam::{Affine3A, Mat4, UVec2, Vec2, Vec3};
use umbrage_core::{
    Backend, Camera, Cascades, Fit, Geometry, Instance, Layout, Light, Mesh, Receivers, Scene,
    ShadowTechnique, View, math::transform,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Bias, Hard, MapFilter as _, MapTechnique, ShadowMap};

const SIZE: u32 = 512;
const RANGE: f32 = 40.0;
const FRAMES: i32 = 30;
/// Movement of the camera in a frame. 45 m of ground around the sphere's centre are visible: a
/// texel is about 10 cm, and the camera moves by 1.7 cm.
const STEP: Vec3 = Vec3::new(0.013, 0.0, -0.011);
const SUN: Light = Light::Directional {
    direction: Vec3::new(0.7, -1.0, 0.45),
    angular_diameter: 0.0,
};

/// A sun along a coordinate axis.
const LEVEL_SUN: Light = Light::Directional {
    direction: Vec3::NEG_Z,
    angular_diameter: 0.0,
};

/// Returns the camera of a frame. It pans by less than a texel, and yaws by a tenth of a degree.
fn camera(frame: i32, offset: Vec3) -> Camera {
    let turn = (frame as f32 * 0.1).to_radians();
    let eye = offset + Vec3::new(0.0, 3.0, 0.0) + STEP * frame as f32;
    let ahead = Vec3::new(turn.sin(), -0.15, -turn.cos());
    Camera::perspective(
        eye,
        eye + ahead,
        Vec3::Y,
        1.0,
        [0.1, 200.0],
        UVec2::new(64, 48),
    )
    .expect("a good camera")
}

/// Boxes of half a metre to three on 400 m of ground that doesn't cast, and one that is 300 m up
/// towards the sun.
fn town(offset: Vec3) -> Geometry {
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
    let triangles = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let cube = Mesh::new("cube", (0..8).map(corner).collect(), triangles).expect("a good mesh");
    let place = |scale: Vec3, at: Vec3| {
        Instance::new(
            0,
            Affine3A::from_translation(offset + at) * Affine3A::from_scale(scale),
        )
    };
    let mut instances = Vec::new();
    for i in 0..400 {
        let x = (i % 20) as f32 * 7.0 - 70.0;
        let z = (i / 20) as f32 * -7.0 + 40.0;
        let half_height = 0.5 + (i % 7) as f32 * 0.4;
        let shift = (i as f32 * 2.399).sin();
        let scale = Vec3::new(0.6 + shift * 0.3, half_height, 0.7);
        instances.push(place(scale, Vec3::new(x + shift, half_height, z - shift)));
    }
    let ground = place(Vec3::new(200.0, 0.5, 200.0), Vec3::NEG_Y * 0.5);
    instances.push(Instance {
        casts: false,
        ..ground
    });
    instances.push(place(Vec3::splat(2.0), Vec3::new(-210.0, 300.0, -150.0)));
    let scene = Scene {
        name: "town".into(),
        meshes: vec![cube],
        instances,
        ..Scene::default()
    };
    Geometry::bake(&scene).expect("a good scene")
}

/// Points of the ground that are visible in every frame.
fn ground(offset: Vec3) -> Receivers {
    let size = UVec2::new(64, 48);
    let mut r = Receivers::empty(size);
    for i in 0..r.len() {
        let column = (i % 64) as f32;
        let row = (i / 64) as f32;
        let p = offset + Vec3::new((column - 32.0) * 0.19, 0.0, -4.0 - row * 0.37);
        r.x[i] = p.x;
        r.y[i] = p.y;
        r.z[i] = p.z;
        r.ny[i] = 1.0;
        r.triangle[i] = 0;
        r.receives[i] = true;
    }
    r
}

fn technique(fit: Fit) -> MapTechnique<Hard> {
    Hard {}.on(ShadowMap {
        size: SIZE,
        fit,
        bias: Bias::SLOPE,
        ..ShadowMap::default()
    })
}

/// Returns the positions of the points within their texels, in f32 arithmetic like that of lookups.
fn places(clip_from_world: Mat4, points: &Receivers) -> Vec<Vec2> {
    let mut out = Vec::new();
    for p in points.positions() {
        let clip = transform(clip_from_world, p);
        let texel = Vec2::new(
            (clip.x / clip.w * 0.5 + 0.5) * SIZE as f32,
            (0.5 - clip.y / clip.w * 0.5) * SIZE as f32,
        );
        out.push(texel - texel.floor());
    }
    out
}

/// Movements on a map while the camera moves.
struct Drift {
    /// Greatest movement of a point within its texel, texels.
    within_texel: f32,
    /// Movement of the map, texels.
    of_map: f32,
}

fn drift(fit: Fit, offset: Vec3, geometry: &Geometry) -> Drift {
    let points = ground(offset);
    let mut cpu = Cpu::new();
    let first = fit_matrix(fit, 0, offset, geometry, &mut cpu);
    let start = places(first, &points);
    let mut drift = Drift {
        within_texel: 0.0,
        of_map: 0.0,
    };
    for frame in 1..FRAMES {
        let now = fit_matrix(fit, frame, offset, geometry, &mut cpu);
        for (a, b) in start.iter().zip(places(now, &points)) {
            let distance = (*a - b).abs();
            // Wrap around the texel: 0.99 and 0.01 are 0.02 apart.
            let wrapped = distance.min(1.0 - distance).max_element();
            drift.within_texel = drift.within_texel.max(wrapped);
        }
        let shift = (now.w_axis - first.w_axis).truncate().truncate();
        let texels = shift.abs().max_element() * 0.5 * SIZE as f32;
        drift.of_map = drift.of_map.max(texels);
    }
    drift
}

/// Returns the clip-from-world matrix of the map that is fitted in a frame.
fn fit_matrix(fit: Fit, frame: i32, offset: Vec3, geometry: &Geometry, cpu: &mut Cpu) -> Mat4 {
    let camera = camera(frame, offset);
    let seen = cpu.receivers(&camera, geometry).expect("a good camera");
    let view = View::new(&camera, &SUN, geometry).with_receivers(&seen);
    let space = fit.light_space(&view, SIZE, 0.0).expect("it fits");
    space.clip_from_world()
}

/// Near the origin, coordinates of about 10 half sides have an error of 2^-20 of a map's side,
/// .0005 texels. Farther out, sums are exact, since both operands are multiples of a coarse unit.
const ROUNDING: f32 = 2e-3;

#[test]
fn world_points_keep_their_place_within_a_texel() {
    for offset in [
        Vec3::ZERO,
        Vec3::new(1e5, 0.0, -1e5),
        Vec3::new(1e6, 0.0, 1e6),
    ] {
        let geometry = town(offset);
        let stable = drift(Fit::Stable { range: RANGE }, offset, &geometry);
        let within_texel = stable.within_texel;
        assert!(
            within_texel <= ROUNDING,
            "points drift by {within_texel} texels, {offset} from the origin"
        );
        let moved = stable.of_map;
        assert!(
            moved >= 2.0,
            "the map moved by only {moved} texels: a fit that never moves proves nothing"
        );
        let tight = drift(Fit::Tight, offset, &geometry).within_texel;
        assert!(
            tight > 0.3,
            "a tight fit is expected to crawl, but drifts by only {tight} texels"
        );
    }
}

/// Returns the number of changes of points between neighbouring frames, and the number of dark
/// points in the last frame.
fn shimmer(fit: Fit, offset: Vec3) -> (usize, usize) {
    let geometry = town(offset);
    let points = ground(offset);
    let mut cpu = Cpu::new();
    let mut last: Option<Vec<f32>> = None;
    let mut changes = 0;
    let mut dark = 0;
    for frame in 0..FRAMES {
        let camera = camera(frame, offset);
        let seen = cpu.receivers(&camera, &geometry).expect("a good camera");
        let view = View::new(&camera, &SUN, &geometry);
        let recipe = technique(fit)
            .recipe(&view.with_receivers(&seen))
            .expect("it plans");
        let mask = cpu
            .render(&view.with_receivers(&points), &recipe)
            .expect("it renders")
            .mask;
        changes += last.map_or(0, |last| {
            last.iter().zip(&mask).filter(|(a, b)| a != b).count()
        });
        dark = mask.iter().filter(|&&v| v == 0.0).count();
        last = Some(mask);
    }
    (changes, dark)
}

/// Hard shadows at points of the ground, while the camera pans and yaws over it.
#[test]
fn stable_shadows_do_not_shimmer() {
    for offset in [Vec3::ZERO, Vec3::new(1e5, 0.0, -1e5)] {
        let (stable, dark) = shimmer(Fit::Stable { range: RANGE }, offset);
        assert!(dark > 100, "only {dark} points are in shadow");
        assert_eq!(
            stable, 0,
            "{stable} answers changed, {offset} from the origin"
        );
        let (tight, _) = shimmer(Fit::Tight, offset);
        assert!(
            tight > 100,
            "a tight fit is expected to shimmer, but only {tight} results changed"
        );
    }
}

/// All visible points are on the map, with all their possible casters, and with a margin for a
/// kernel, too.
#[test]
fn all_that_matters_is_on_the_map() {
    let geometry = town(Vec3::ZERO);
    for (frame, margin) in [(0, 0.0), (17, 3.0), (900, 40.0)] {
        let camera = camera(frame, Vec3::ZERO);
        let view = View::new(&camera, &SUN, &geometry);
        let fitted = Fit::Stable { range: RANGE }
            .light_space(&view, SIZE, margin)
            .expect("it fits")
            .clip_from_world();
        let seen = Cpu::new()
            .receivers(&camera, &geometry)
            .expect("a good camera");
        let view_from_world = camera.space().view_from_world;
        let room = 1.0 - 2.0 * margin / SIZE as f32;
        for p in seen
            .positions()
            .filter(|p| -transform(view_from_world, *p).z <= RANGE)
        {
            let clip = transform(fitted, p);
            assert!(
                clip.x.abs().max(clip.y.abs()) <= room && clip.z <= 1.0,
                "{p} falls on {clip}"
            );
        }
        for p in geometry.vertices_of(geometry.casters()) {
            let clip = transform(fitted, p);
            let adjacent = clip.x.abs().max(clip.y.abs()) > 1.0;
            assert!(
                adjacent || clip.z >= 0.0,
                "the caster at {p} is clipped by the near plane: {clip}"
            );
        }
    }
    // One of them is far up, so that the near plane had to be moved back.
    let camera = camera(0, Vec3::ZERO);
    let space = Fit::Stable { range: RANGE }
        .light_space(&View::new(&camera, &SUN, &geometry), SIZE, 0.0)
        .expect("it fits");
    let high_box = Vec3::new(-210.0, 300.0, -150.0);
    let high = transform(space.clip_from_world(), high_box);
    assert!(
        high.truncate().truncate().abs().max_element() < 1.0,
        "the high box is not over the map: {high}"
    );
}

/// A camera at a fixed position with any direction.
fn turned_camera(eye: Vec3, yaw: f32, pitch: f32) -> Camera {
    let ahead = Vec3::new(
        yaw.sin() * pitch.cos(),
        pitch.sin(),
        -yaw.cos() * pitch.cos(),
    );
    Camera::perspective(
        eye,
        eye + ahead,
        Vec3::Y,
        1.0,
        [0.1, 200.0],
        UVec2::new(64, 48),
    )
    .expect("a good camera")
}

/// Maps around the camera don't move while it turns, regardless of rounding of its position. Others
/// move.
#[test]
fn a_camera_that_turns_moves_no_map_around_it() {
    let geometry = town(Vec3::ZERO);
    let cascades = Layout::Cascades(Cascades {
        count: 3,
        blend: 4.0,
        ..Cascades::default()
    });
    let mut moved = 0;
    for place in 0..40 {
        let n = place as f32;
        let (sun, eye) = match place % 4 {
            0 => (SUN, Vec3::new(n, 3.0, -n)),
            1 => (SUN, Vec3::new(0.37 * n, 1.7 + 0.01 * n, 3.1 * n - 50.0)),
            2 => (SUN, Vec3::new(1e4 + n, 2.5, -3e4 - 0.77 * n)),
            // Put it between two steps of the near plane, so that the last bits of the camera's
            // position decide.
            _ => (LEVEL_SUN, Vec3::new(0.37 * n + 1.3, 1.7, 0.0)),
        };
        for layout in [Layout::Single, cascades] {
            let spaces = |fit: Fit, camera: &Camera| {
                let view = View::new(camera, &sun, &geometry);
                fit.light_spaces(layout, &view, SIZE, 1.0).expect("it fits")
            };
            let around = Fit::AroundCamera { range: RANGE };
            let stable = Fit::Stable { range: RANGE };
            let ahead = turned_camera(eye, 0.0, 0.0);
            for turn in 1..8 {
                let pitch = 0.2 * (turn % 5) as f32 - 0.4;
                let camera = turned_camera(eye, 0.9 * turn as f32, pitch);
                assert_eq!(
                    spaces(around, &ahead),
                    spaces(around, &camera),
                    "turned {turn} times at {eye}"
                );
                moved += u32::from(spaces(stable, &ahead) != spaces(stable, &camera));
            }
        }
    }
    assert!(moved > 400, "a stable fit moved only {moved} times of 560");
}

/// The cost that docs/cascades.md states: texels are 1.5 times as wide.
#[test]
fn maps_around_the_camera_have_larger_texels() {
    let geometry = town(Vec3::ZERO);
    let eye = Vec3::new(0.0, 3.0, 0.0);
    let size = UVec2::new(1280, 720);
    let ahead = eye + Vec3::NEG_Z;
    let camera = Camera::perspective(eye, ahead, Vec3::Y, 0.9, [0.1, 200.0], size);
    let camera = camera.expect("a good camera");
    let view = View::new(&camera, &SUN, &geometry);
    let texel = |fit: Fit| {
        let space = fit.light_space(&view, 1024, 0.0).expect("it fits");
        1.0 / space.clip_from_view.x_axis.x
    };
    let around = texel(Fit::AroundCamera { range: RANGE });
    let ratio = around / texel(Fit::Stable { range: RANGE });
    assert!((1.45..1.5).contains(&ratio), "{ratio}");
}

/// A map around the camera moves in large steps, and contains all visible points.
#[test]
fn a_camera_that_walks_seldom_moves_the_map_around_it() {
    let geometry = town(Vec3::ZERO);
    let fit = Fit::AroundCamera { range: RANGE };
    let mut maps: Vec<Mat4> = Vec::new();
    for frame in 0..400 {
        let eye = Vec3::new(0.05 * frame as f32, 3.0, 0.0);
        let camera = turned_camera(eye, 0.3 * frame as f32, -0.2);
        let view = View::new(&camera, &SUN, &geometry);
        let space = fit.light_space(&view, SIZE, 2.0).expect("it fits");
        let fitted = space.clip_from_world();
        if maps.last() != Some(&fitted) {
            maps.push(fitted);
        }
        let seen = Cpu::new()
            .receivers(&camera, &geometry)
            .expect("a good camera");
        let view_from_world = camera.space().view_from_world;
        let room = 1.0 - 2.0 * 2.0 / SIZE as f32;
        let within = |p: &Vec3| -transform(view_from_world, *p).z <= RANGE;
        for p in seen.positions().filter(within) {
            let clip = transform(fitted, p);
            let is_held = clip.x.abs().max(clip.y.abs()) <= room && clip.z <= 1.0;
            assert!(is_held, "{p} falls on {clip} in frame {frame}");
        }
    }
    // The map is 100 m wide, with steps of 3 m, on a path of 20 m across two axes.
    assert!((3..=20).contains(&maps.len()), "{} maps", maps.len());
}

/// Stable fits of point and spot lights don't depend on the view; tight ones do.
#[test]
fn lamps_stand_still() {
    let geometry = town(Vec3::ZERO);
    let lamp = Light::Spot {
        position: Vec3::new(0.0, 30.0, 0.0),
        direction: Vec3::new(0.0, -1.0, -0.5),
        inner: 0.3,
        outer: 0.6,
        radius: 0.0,
    };
    let bulb = Light::Point {
        position: Vec3::new(0.0, 60.0, -20.0),
        radius: 0.0,
    };
    for light in [lamp, bulb] {
        let spaces = |fit: Fit, frame: i32| {
            let camera = camera(frame, Vec3::ZERO);
            let seen = Cpu::new()
                .receivers(&camera, &geometry)
                .expect("a good camera");
            let view = View::new(&camera, &light, &geometry).with_receivers(&seen);
            fit.light_spaces(Default::default(), &view, SIZE, 1.0)
                .expect("it fits")
        };
        let stable = Fit::Stable { range: RANGE };
        assert_eq!(spaces(stable, 0), spaces(stable, 500), "{}", light.kind());
        assert_ne!(
            spaces(Fit::Tight, 0),
            spaces(Fit::Tight, 500),
            "{}",
            light.kind()
        );
    }
}

#[test]
fn it_reads_and_writes_as_the_others() {
    let fit = Fit::Stable { range: 50.0 };
    let json = serde_json::to_string(&fit).expect("it writes");
    assert_eq!(json, r#"{"stable":{"range":50.0}}"#);
    assert_eq!(serde_json::from_str::<Fit>(&json).expect("it reads"), fit);
    assert_eq!(
        serde_json::from_str::<Fit>("\"whole\"").expect("it reads"),
        Fit::Whole
    );
    assert!(serde_json::from_str::<Fit>(r#"{"stable":{"reach":50.0}}"#).is_err());
    let map = ShadowMap {
        fit,
        ..ShadowMap::default()
    };
    assert!(
        map.label().contains("stable fit to 50 m"),
        "{}",
        map.label()
    );
}
