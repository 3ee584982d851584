//! Tight maps of a sun that crosses the zenith. The map's roll jumps there (see `look_along`), but
//! its error doesn't: a turn by 180 degrees changes no extent, and any other turn changes the width
//! of a texel by at most the root of 2.

use super::MapCase;
use umbrage_core::{
    Camera, Fit, Light, Scene,
    glam::{UVec2, Vec2, Vec3},
    metrics::Pixel,
};
use umbrage_techniques::{Hard, MapFilter as _, ShadowMap};

/// Tilts of the sun against the zenith, from one side to the other.
const TILTS: [f32; 13] = [
    -0.02, -0.01, -0.005, -1e-3, -1e-5, -1e-7, 0.0, 1e-7, 1e-5, 1e-3, 0.005, 0.01, 0.02,
];

/// Least y of the normals of evaluated pixels. Walls are lit on one side of the zenith only, at
/// grazing light, so their error does jump.
const LEAST_UP: f32 = 0.5;

/// Greatest ratio of two errors of one crossing. Wrong pixels grow with the width of a texel, which
/// differs by up to the root of 2, and the error is the root of their share.
const GREATEST_RATIO: f64 = 1.3;

/// Returns the error of a tight map for each tilt of the sun towards this azimuth, radians.
fn errors_towards(azimuth: f32) -> Vec<f64> {
    let scene = (umbrage_scenes::find("cubes").expect("built in").build)();
    let camera = Camera {
        size: UVec2::new(320, 180),
        ..scene.cameras[0]
    };
    let technique = Hard {}.on(ShadowMap {
        size: 512,
        fit: Fit::Tight,
        ..ShadowMap::default()
    });
    let error = |tilt: f32| {
        let aside = Vec2::from_angle(azimuth) * tilt;
        let light = Light::Directional {
            direction: Vec3::new(aside.x, -1.0, aside.y),
            angular_diameter: 0.0,
        };
        let mut case = MapCase::of_scene(Scene {
            cameras: vec![camera],
            lights: vec![light],
            ..scene.clone()
        });
        for i in 0..case.truth.pixels.len() {
            if case.truth.receivers.normal(i).y < LEAST_UP {
                case.truth.pixels[i] = Pixel::Empty;
            }
        }
        case.errors(&technique).rmse
    };
    TILTS.map(error).to_vec()
}

#[test]
fn the_error_does_not_jump_as_the_sun_crosses_the_zenith() {
    for quarter in 0..4_u8 {
        let azimuth = f32::from(quarter) * std::f32::consts::FRAC_PI_4;
        let errors = errors_towards(azimuth);
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = errors.iter().copied().fold(0.0, f64::max);
        assert!(
            least > 0.0 && greatest < GREATEST_RATIO * least,
            "{azimuth}: {errors:.4?}"
        );
    }
}
