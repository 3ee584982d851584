//! Tests of numbers that are not finite: every entry point of a plan or a backend refuses them, and
//! names their position.

use glam::{Affine3A, Mat4, Vec3};
use umbrage_core::{
    Aabb, Backend, Camera, Extents, Fit, Geometry, Layout, Light, Receivers, Recipe, RecipeError,
    ShadowTechnique, View,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Bias, Hard, MapFilter as _, MapTechnique, ShadowMap};
use umbrage_tests::{gpu::gpu, stage};

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

/// A point light over the stage, which all techniques support.
const BULB: Light = Light::Point {
    position: Vec3::new(0.5, 4.0, 1.0),
    radius: 0.0,
};
const SUN: Light = Light::Directional {
    direction: Vec3::new(0.3, -1.0, 0.2),
    angular_diameter: 0.0,
};

/// Plans with all techniques, one setting each. The error must contain `words`.
fn check_refused(view: &View<'_>, words: &str) {
    for entry in umbrage_plan::catalogue::all() {
        let technique = &(entry.settings)(&[64], Fit::Tight)[0];
        match technique.recipe(view) {
            Err(RecipeError::Invalid(why)) => {
                assert!(
                    why.to_string().contains(words),
                    "{}: {why}",
                    entry.technique.name
                )
            }
            Err(RecipeError::Unsupported(why)) => {
                panic!(
                    "{}: `{words}` should be at fault, not: {why}",
                    entry.technique.name
                )
            }
            Ok(_) => panic!("{} plans with a bad {words}", entry.technique.name),
        }
    }
}

#[test]
fn techniques_refuse_cameras() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let good = stage::camera();
    for bad in BAD {
        let mut camera = good;
        camera.world_from_view.translation.y = bad;
        check_refused(
            &View::new(&camera, &BULB, &geometry),
            "camera matrix: holds",
        );
        let mut camera = good;
        camera.clip_from_view.y_axis.y = bad;
        check_refused(
            &View::new(&camera, &BULB, &geometry),
            "camera projection: holds",
        );
    }
    let flat = Camera {
        world_from_view: Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)),
        ..good
    };
    check_refused(
        &View::new(&flat, &BULB, &geometry),
        "camera matrix: is singular",
    );
    let flat = Camera {
        clip_from_view: Mat4::ZERO,
        ..good
    };
    check_refused(
        &View::new(&flat, &BULB, &geometry),
        "camera projection: is singular",
    );
}

#[test]
fn techniques_refuse_lights() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    for bad in BAD {
        let light = Light::Point {
            position: Vec3::new(0.0, bad, 0.0),
            radius: 0.0,
        };
        check_refused(
            &View::new(&camera, &light, &geometry),
            "point light, position: holds",
        );
    }
}

#[test]
fn techniques_refuse_boxes() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    for bad in BAD {
        let casters = Aabb::from_points([Vec3::ONE, Vec3::new(0.0, bad, 0.0), Vec3::NEG_ONE]);
        check_refused(
            &View {
                casters,
                ..View::new(&camera, &BULB, &geometry)
            },
            "view's casters, box's m",
        );
    }
}

/// Receivers of the stage, one of which is replaced.
fn spoilt_receivers(geometry: &Geometry, spoil: impl Fn(&mut Receivers, usize)) -> Receivers {
    let mut receivers = Cpu::new()
        .receivers(&stage::camera(), geometry)
        .expect("a good camera");
    let seen = receivers
        .receives
        .iter()
        .position(|&r| r)
        .expect("the floor is seen");
    spoil(&mut receivers, seen);
    receivers
}

#[test]
fn techniques_and_backends_refuse_receivers() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let view = View::new(&camera, &SUN, &geometry);
    let recipe = MapTechnique::<Hard>::default()
        .recipe(&view)
        .expect("it plans");
    for bad in BAD {
        for receivers in [
            spoilt_receivers(&geometry, |r, i| r.z[i] = bad),
            spoilt_receivers(&geometry, |r, i| r.nx[i] = bad),
        ] {
            let view = view.with_receivers(&receivers);
            check_refused(&view, "receiver at pixel (");
            for why in render_messages(&view, &recipe) {
                assert!(why.contains("receiver at pixel ("), "{why}");
            }
        }
    }
    // Positions without receivers may have any values.
    let receivers = spoilt_receivers(&geometry, |r, i| {
        (r.x[i], r.receives[i]) = (f32::NAN, false)
    });
    assert!(
        MapTechnique::<Hard>::default()
            .recipe(&view.with_receivers(&receivers))
            .is_ok()
    );
    let short = spoilt_receivers(&geometry, |r, _| r.ny.truncate(1));
    check_refused(&view.with_receivers(&short), "an array has another length");
}

/// Returns the errors of both backends.
fn render_messages(view: &View<'_>, recipe: &Recipe) -> [String; 2] {
    let cpu = Cpu::new()
        .render(view, recipe)
        .expect_err("the CPU refuses it");
    let wgpu = gpu().render(view, recipe).expect_err("the GPU refuses it");
    [cpu.to_string(), wgpu.to_string()]
}

#[test]
fn manual_fits_name_the_field() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let good = Extents {
        left: -4.0,
        right: 4.0,
        bottom: -4.0,
        top: 4.0,
        near: 1.0,
        far: 9.0,
    };
    for bad in BAD {
        let cases = [
            ("left", Extents { left: bad, ..good }),
            ("right", Extents { right: bad, ..good }),
            (
                "bottom",
                Extents {
                    bottom: bad,
                    ..good
                },
            ),
            ("top", Extents { top: bad, ..good }),
            ("near", Extents { near: bad, ..good }),
            ("far", Extents { far: bad, ..good }),
        ];
        for light in [SUN, BULB] {
            let view = View::new(&camera, &light, &geometry);
            for layout in [Layout::Single, Layout::Auto] {
                for (name, extents) in cases {
                    let fit = Fit::Manual {
                        eye: Vec3::Y,
                        extents,
                    };
                    let why = fit
                        .light_spaces(layout, &view, 64, 0.0)
                        .expect_err(name)
                        .to_string();
                    assert!(
                        why.contains(&format!("manual fit's {name}: holds")),
                        "{why}"
                    );
                }
            }
            let fit = Fit::Manual {
                eye: Vec3::new(bad, 0.0, 0.0),
                extents: good,
            };
            let why = fit
                .light_space(&view, 64, 0.0)
                .expect_err("eye")
                .to_string();
            assert!(why.contains("manual fit's eye: holds"), "{why}");
        }
    }
}

#[test]
fn backends_refuse_casts() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let view = View::new(&camera, &SUN, &geometry);
    let bias = Bias {
        raster: umbrage_core::RasterBias {
            slope: 1.0,
            ..Default::default()
        },
        ..Bias::NONE
    };
    let map = ShadowMap {
        bias,
        ..ShadowMap::default()
    };
    let good = Hard {}.on(map).recipe(&view).expect("it plans");
    let spoilt = |spoil: &dyn Fn(&mut umbrage_core::Cast)| {
        let mut recipe = good.clone();
        spoil(&mut recipe.casts[0]);
        render_messages(&view, &recipe)
    };
    for bad in BAD {
        for why in spoilt(&|cast| cast.space.view_from_world.w_axis.x = bad) {
            assert!(why.contains("cast 0, view from world: holds"), "{why}");
        }
        for why in spoilt(&|cast| cast.space.clip_from_view.z_axis.z = bad) {
            assert!(why.contains("cast 0, clip from view: holds"), "{why}");
        }
        for why in spoilt(&|cast| cast.bias.slope = bad) {
            assert!(why.contains("cast 0, bias: holds"), "{why}");
        }
    }
    for why in spoilt(&|cast| {
        cast.space.view_from_world *= 1e30;
        cast.space.clip_from_view *= 1e30;
    }) {
        assert!(why.contains("cast 0, clip from world: holds"), "{why}");
    }
    assert!(Cpu::new().render(&view, &good).is_ok());
}
