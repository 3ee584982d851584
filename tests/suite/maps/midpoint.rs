//! Tests of second depth and midpoints against constant biases, and of their failures.

use super::MapCase;
use umbrage_core::ShadowTechnique;
use umbrage_techniques::{
    Bias, Hard, MapFilter as _, MapTechnique, Midpoint, SecondDepth, ShadowMap,
};

fn map(bias: Bias) -> ShadowMap {
    ShadowMap {
        size: 1024,
        bias,
        ..ShadowMap::default()
    }
}

fn midpoint() -> MapTechnique<Midpoint> {
    Midpoint { radius: 0 }.on(map(Bias::ADAPTIVE))
}

fn second_depth() -> MapTechnique<SecondDepth> {
    SecondDepth { radius: 0 }.on(map(Bias::FRONT_CULL))
}

/// Returns the fraction of wrong pixels, summed over the scenes.
fn wrong(cases: &[MapCase], technique: &dyn ShadowTechnique) -> f64 {
    cases.iter().map(|case| case.errors(technique).mean).sum()
}

/// Closed casters of different thickness under different lights: each has a suitable constant, and
/// none suits all.
#[test]
fn every_constant_is_worse_on_closed_meshes() {
    let cases = [
        "figure",
        "c8-faceted-sphere",
        "c2-sphere-sun",
        "c3-sphere-bulb",
    ]
    .map(MapCase::with_name);
    let midpoint = wrong(&cases, &midpoint());
    let second = wrong(&cases, &second_depth());
    for i in 0..=40 {
        let constant = 10.0_f32.powf(-6.0 + i as f32 / 8.0);
        let other = wrong(
            &cases,
            &Hard {}.on(map(Bias {
                constant,
                ..Bias::NONE
            })),
        );
        assert!(
            midpoint < other && second < other,
            "{constant}: {midpoint} and {second} against {other}"
        );
    }
}

/// Open sheets: second depth loses those that face the light, and a midpoint alone is too close to
/// them.
#[test]
fn open_meshes_defeat_both() {
    let case = [MapCase::with_name("open-shells")];
    let hard = wrong(&case, &Hard {}.on(map(Bias::ADAPTIVE)));
    let bare = Midpoint { radius: 0 }.on(map(Bias::NONE));
    let second = wrong(&case, &second_depth());
    let bare = wrong(&case, &bare);
    assert!(
        second > 10.0 * hard && bare > 1.5 * hard,
        "{second} and {bare} against {hard}"
    );
}

/// Walls one texel thick: light leaks past their far sides, but not past a midpoint or the near
/// sides.
#[test]
fn thin_walls_leak_by_second_depth() {
    let case = MapCase::with_name("sealed-room");
    let light = |technique: &dyn ShadowTechnique| case.errors(technique).false_light;
    assert!(light(&second_depth()) > 0.0);
    assert_eq!(
        [light(&midpoint()), light(&Hard {}.on(map(Bias::ADAPTIVE)))],
        [0.0, 0.0]
    );
}
