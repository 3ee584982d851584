//! Snapshots of light-space matrices: every kind of light, fitted and manual, at all scales, in
//! difficult directions.

use std::fmt::Write as _;
use umbrage_core::{
    Cascades, Extents, Fit, Geometry, Layout, Light, LightSpace, RecipeError, Split, View,
    glam::{Mat4, UVec2, Vec3, Vec4},
};
use umbrage_tests::stage::{camera, geometry};

fn fit(fit: Fit, light: &Light, geometry: &Geometry) -> Result<LightSpace, RecipeError> {
    light.validate().expect("a good light");
    fit.light_space(&View::new(&camera(), light, geometry), 1024, 1.0)
}

/// Formats six significant digits, far coarser than the differences between processors' libraries.
fn number(v: f32) -> String {
    let rounded: f64 = format!("{v:.5e}").parse().expect("a number, printed");
    if rounded == 0.0 {
        "0".to_owned()
    } else {
        format!("{rounded:e}")
    }
}

fn print(name: &str, space: &Result<LightSpace, RecipeError>) -> String {
    let mut out = format!("{name}\n");
    let space = match space {
        Ok(space) => space,
        Err(why) => return format!("{out}  {why}\n\n"),
    };
    for (label, m) in [
        ("view_from_world", space.view_from_world),
        ("clip_from_view", space.clip_from_view),
        ("texture_from_world", space.texture_from_world()),
    ] {
        assert!(m.is_finite(), "{label} of {name} is not finite: {m}");
        writeln!(out, "  {label}").expect("strings take any text");
        (0..4).for_each(|i| writeln!(out, "    {}", row(m.row(i))).expect("strings take any text"));
    }
    out + "\n"
}

/// Formats a row. Rounding errors relative to the other numbers of the row, or to the map's width,
/// become zero.
fn row(r: Vec4) -> String {
    const ROUNDING: f32 = 2e-7;
    let linear = r.truncate().abs().max_element() * ROUNDING;
    let clean = |v: f32, least: f32| if v.abs() <= least { 0.0 } else { v };
    let r = [
        clean(r.x, linear),
        clean(r.y, linear),
        clean(r.z, linear),
        clean(r.w, ROUNDING),
    ];
    r.map(|v| format!("{:>12}", number(v))).join(" ")
}

const FAR_AWAY: Vec3 = Vec3::new(5e4, -2e4, 8e4);

/// Returns lights of every kind around the box at a scale, moved by an offset.
fn lights(scale: f32, offset: Vec3) -> Vec<(&'static str, Light)> {
    let at = |x, y, z| offset + Vec3::new(x, y, z) * scale;
    let down = Vec3::NEG_Y;
    vec![
        (
            "directional",
            Light::Directional {
                direction: Vec3::new(2.0, -4.0, 1.0),
                angular_diameter: 0.0,
            },
        ),
        (
            "directional, straight down",
            Light::Directional {
                direction: down,
                angular_diameter: 0.0093,
            },
        ),
        (
            "directional, straight up",
            Light::Directional {
                direction: Vec3::Y,
                angular_diameter: 0.0,
            },
        ),
        (
            "directional, nearly down",
            Light::Directional {
                direction: Vec3::new(1e-6, -1.0, 0.0),
                angular_diameter: 0.0,
            },
        ),
        (
            "directional, tiny vector",
            Light::Directional {
                direction: Vec3::new(1e-30, -1e-30, 0.0),
                angular_diameter: 0.0,
            },
        ),
        (
            "directional, huge vector",
            Light::Directional {
                direction: Vec3::new(1e30, -1e30, 0.0),
                angular_diameter: 0.0,
            },
        ),
        (
            "spot",
            Light::Spot {
                position: at(-2.0, 6.0, 1.0),
                direction: Vec3::new(2.0, -5.0, -1.0),
                inner: 0.4,
                outer: 0.5,
                radius: 0.0,
            },
        ),
        (
            "spot, straight down",
            Light::Spot {
                position: at(0.0, 6.0, 0.0),
                direction: down,
                inner: 0.0,
                outer: 0.6,
                radius: 0.1,
            },
        ),
        (
            "spot, too wide",
            Light::Spot {
                position: at(0.0, 6.0, 0.0),
                direction: down,
                inner: 1.0,
                outer: 1.5,
                radius: 0.0,
            },
        ),
        (
            "point",
            Light::Point {
                position: at(-2.0, 6.0, 1.0),
                radius: 0.0,
            },
        ),
        (
            "point, right above",
            Light::Point {
                position: at(0.0, 6.0, 0.0),
                radius: 0.2,
            },
        ),
        (
            "point, within the caster",
            Light::Point {
                position: at(0.0, 1.5, 0.0),
                radius: 0.0,
            },
        ),
        (
            "rect",
            Light::Rect {
                center: at(1.0, 5.0, 0.0),
                half_u: Vec3::X,
                half_v: Vec3::Z,
            },
        ),
        (
            "disc",
            Light::Disc {
                center: at(1.0, 5.0, 2.0),
                normal: Vec3::Y,
                radius: 0.5,
            },
        ),
    ]
}

fn suite(scale: f32, offset: Vec3) -> String {
    let geometry = geometry(scale, offset);
    lights(scale, offset)
        .iter()
        .map(|(name, light)| print(name, &fit(Fit::Tight, light, &geometry)))
        .collect()
}

#[test]
fn fitted_matrices_are_unchanged() {
    insta::assert_snapshot!("fitted_scale_1", suite(1.0, Vec3::ZERO));
    insta::assert_snapshot!("fitted_scale_1e-3", suite(1e-3, Vec3::ZERO));
    insta::assert_snapshot!("fitted_scale_1e4", suite(1e4, Vec3::ZERO));
    insta::assert_snapshot!("fitted_far_away", suite(1.0, FAR_AWAY));
}

/// Fits for a camera with a range of 20 m, and for one that is moved with the scene. Directional
/// lights have separate matrices, other lights those of the whole scene.
#[test]
fn matrices_of_stable_fits_are_unchanged() {
    let suite = |offset: Vec3| -> String {
        let geometry = geometry(1.0, offset);
        let mut camera = camera();
        camera.world_from_view.translation += glam::Vec3A::from(offset);
        let fitted = |light: &Light| {
            Fit::Stable { range: 20.0 }.light_space(
                &View::new(&camera, light, &geometry),
                1024,
                1.0,
            )
        };
        lights(1.0, offset)
            .iter()
            .map(|(name, light)| print(name, &fitted(light)))
            .collect()
    };
    insta::assert_snapshot!("stable_at_the_origin", suite(Vec3::ZERO));
    insta::assert_snapshot!("stable_far_away", suite(FAR_AWAY));
}

/// The six spaces of a cube, for a kernel of radius 3 texels.
#[test]
fn matrices_of_a_cube_are_unchanged() {
    let geometry = geometry(1.0, Vec3::ZERO);
    let light = Light::Point {
        position: Vec3::new(0.5, 4.0, 1.0),
        radius: 0.0,
    };
    let camera = camera();
    let view = View::new(&camera, &light, &geometry);
    let spaces = Fit::Tight
        .light_spaces(Layout::Cube, &view, 256, 3.0)
        .expect("bulbs have a place");
    let axes = ["+x", "-x", "+y", "-y", "+z", "-z"];
    let mut text = String::new();
    for (layer, axis) in axes.iter().enumerate() {
        let needed = spaces.is_needed(layer);
        let space = spaces.spaces[layer];
        text += &print(&format!("{axis}, needed: {needed}"), &Ok(space));
    }
    insta::assert_snapshot!("cube", text);
}

/// Four cascades of a sun along the view and of one across it: stable, tight around possible
/// receivers, and split by actual receivers.
#[test]
fn matrices_of_cascades_are_unchanged() {
    let geometry = geometry(1.0, Vec3::ZERO);
    let camera = camera();
    let seen = umbrage_cpu::Cpu::new()
        .receivers(&camera, &geometry)
        .expect("a good camera");
    let log = Cascades {
        nearest: 1.0,
        ..Cascades::default()
    };
    let by_receivers = Cascades {
        split: Split::Receivers,
        ..log
    };
    let mut text = String::new();
    for (name, light) in lights(1.0, Vec3::ZERO) {
        if !matches!(light, Light::Directional { .. }) {
            continue;
        }
        let view = View::new(&camera, &light, &geometry);
        for (fit, cascades, view) in [
            (Fit::Stable { range: 20.0 }, log, view),
            (Fit::Tight, log, view),
            (Fit::Tight, by_receivers, view.with_receivers(&seen)),
        ] {
            let ends = fit.slice_ends(&cascades, &view).expect("slices");
            let spaces = fit
                .light_spaces(Layout::Cascades(cascades), &view, 256, 3.0)
                .expect("suns have cascades");
            text += &format!(
                "{name}: {}, {} to {ends:.3?}\n",
                fit.label(),
                cascades.label()
            );
            for (layer, &space) in spaces.spaces.iter().enumerate() {
                let is_needed = spaces.is_needed(layer);
                text += &print(&format!("cascade {layer}, needed: {is_needed}"), &Ok(space));
            }
        }
    }
    insta::assert_snapshot!("cascades", text);
}

#[test]
fn matrices_of_manual_fits_are_unchanged() {
    let extents = Extents {
        left: -10.0,
        right: 10.0,
        bottom: -10.0,
        top: 10.0,
        near: 1.0,
        far: 7.5,
    };
    let manual = Fit::Manual {
        eye: Vec3::new(-2.0, 4.0, -1.0),
        extents,
    };
    let geometry = geometry(1.0, Vec3::ZERO);
    let out: String = lights(1.0, Vec3::ZERO)
        .iter()
        .map(|(name, light)| print(name, &fit(manual, light, &geometry)))
        .collect();
    insta::assert_snapshot!("by_hand", out);
}

#[test]
fn matrices_without_casters_are_unchanged() {
    let geometry = geometry(1.0, Vec3::ZERO).without_casters();
    let lights = lights(1.0, Vec3::ZERO);
    insta::assert_snapshot!(
        "nothing_casts",
        lights
            .iter()
            .map(|(name, light)| print(name, &fit(Fit::Tight, light, &geometry)))
            .collect::<String>()
    );
}

#[test]
fn bad_projections_say_how_to_fix_them() {
    let good = Extents {
        left: -1.0,
        right: 1.0,
        bottom: -1.0,
        top: 1.0,
        near: 1.0,
        far: 2.0,
    };
    let light = Light::Directional {
        direction: Vec3::NEG_Y,
        angular_diameter: 0.0,
    };
    let geometry = geometry(1.0, Vec3::ZERO);
    let out: String = [
        ("near beyond far", Extents { near: 3.0, ..good }),
        ("no width", Extents { left: 1.0, ..good }),
        (
            "not a number",
            Extents {
                top: f32::NAN,
                ..good
            },
        ),
    ]
    .into_iter()
    .map(|(name, extents)| {
        print(
            name,
            &fit(
                Fit::Manual {
                    eye: Vec3::ZERO,
                    extents,
                },
                &light,
                &geometry,
            ),
        )
    })
    .collect();
    let nowhere = fit(Fit::Stable { range: 0.0 }, &light, &geometry);
    let out = out + &print("seen up to nowhere", &nowhere);
    insta::assert_snapshot!(out);
}

/// Reports whether every point is on the map, at a depth from 0 to 1.
fn holds(space: &LightSpace, points: impl Iterator<Item = Vec3>) -> bool {
    let clip_from_world: Mat4 = space.clip_from_world();
    points
        .map(|p| clip_from_world * p.extend(1.0))
        .all(|c| c.x.abs() <= c.w && c.y.abs() <= c.w && c.z >= 0.0 && c.z <= c.w)
}

#[test]
fn a_fitted_map_holds_every_caster() {
    for (scale, offset) in [
        (1.0, Vec3::ZERO),
        (1e-3, Vec3::ZERO),
        (1e4, Vec3::ZERO),
        (1.0, FAR_AWAY),
    ] {
        let geometry = geometry(scale, offset);
        let casters = || geometry.vertices_of(geometry.casters());
        // Exclude light from below, which meets the floor first: casters behind it need no position
        // on the map.
        let lights = lights(scale, offset)
            .into_iter()
            .filter(|(name, _)| !name.ends_with("up"));
        for (name, light) in lights {
            let Ok(space) = fit(Fit::Tight, &light, &geometry) else {
                continue;
            };
            assert!(
                holds(&space, casters()),
                "{name} at scale {scale}: {space:?}"
            );
            let nudged = space.nudge_by(Vec3::splat(600.0).truncate(), 0.0, UVec2::splat(1024));
            assert!(
                !holds(&nudged, casters()),
                "{name}: a map moved by half its size must not hold them"
            );
        }
    }
}
