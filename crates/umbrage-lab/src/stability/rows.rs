//! The list of rows, from which command, documentation, matrix and tests are derived.

use super::{
    measure::Measure,
    measures::{band::Band, gap::Contact},
    row::{StabilityCase, StabilityRow},
};
use glam::Vec3;
use umbrage_core::{Cascades, Fit, Layout, Split};
use umbrage_scenes::motion::MovingScene;
use umbrage_techniques::{
    Bias, Evsm, EvsmMoments, Hard, MapFilter as _, MapFormat, Msm, Pcf, Reconstruction, ShadowMap,
    TechniquePreset, Vsm,
};

/// Returns all rows, by number.
pub fn rows() -> &'static [StabilityRow] {
    ROWS
}

/// Returns all cases with their rows.
pub fn cases() -> impl Iterator<Item = (&'static StabilityRow, &'static StabilityCase)> {
    ROWS.iter()
        .flat_map(|row| row.cases.iter().map(move |case| (row, case)))
}

/// Contact of `thin-plate`'s plate with the floor on the side of its shadow, which falls along +z.
///
/// Copied from `thin_plate` in `umbrage-scenes` (`sunlit.rs`), minus 5 cm at each end of the plate;
/// a test compares them.
pub const PLATE: Contact = Contact {
    from: Vec3::new(-0.45, 0.0, 0.001),
    to: Vec3::new(0.45, 0.0, 0.001),
    along: Vec3::Z,
};

/// Centres of `hovering-feet`'s feet on the floor.
///
/// Copied from `hovering_feet` in `umbrage-scenes` (`fine.rs`); a test compares them.
const FEET: [Vec3; 4] = [
    Vec3::new(-0.9, 0.0, 0.2),
    Vec3::new(-0.6, 0.0, 0.0),
    Vec3::new(0.4, 0.0, 0.3),
    Vec3::new(0.7, 0.0, 0.1),
];

/// Greatest radius of a foot of `hovering-feet`, metres; also copied.
const FOOT_RADIUS: f32 = 0.11;
/// Width of the ring around each foot in which leaks are measured, metres.
const RING_WIDTH: f32 = 0.10;
/// Distance from a foot's centre up to which leaks are measured, metres.
const LEAK_RADIUS: f32 = FOOT_RADIUS + RING_WIDTH;

/// Width of the strips on either side of the creases of `room-corner`, metres: about ten texels.
const CREASE_WIDTH: f32 = 0.08;
/// Visible creases of `room-corner`'s walls, from their corner; a test compares them with the
/// scene.
const CREASES: Band = Band::Creases {
    lines: &[
        [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0)],
        [Vec3::ZERO, Vec3::new(0.0, 3.0, 0.0)],
        [Vec3::ZERO, Vec3::new(0.0, 0.0, 4.0)],
    ],
    reach: CREASE_WIDTH,
};
/// The outermost tenth of a spot's cone.
const RIM: Band = Band::ConeRim { share: 0.9 };

const fn still(scene: &'static str, measure: Measure) -> StabilityCase {
    StabilityCase::still(scene, measure)
}

const fn moving_case(moving: MovingScene) -> StabilityCase {
    StabilityCase::moving_case(moving)
}

const fn row(
    number: u8,
    title: &'static str,
    weakness: &'static str,
    cases: &'static [StabilityCase],
) -> StabilityRow {
    StabilityRow {
        number,
        title,
        weakness,
        not_yet: None,
        cases,
    }
}

impl StabilityRow {
    /// Returns the row with techniques that it concerns and that umbrage doesn't have yet.
    const fn not_covered_yet(self, techniques: &'static str) -> Self {
        Self {
            not_yet: Some(techniques),
            ..self
        }
    }
}

/// Returns hard shadows under each of these biases.
fn hard(size: u32, format: MapFormat, biases: &[Bias]) -> Vec<TechniquePreset> {
    let mut out: Vec<TechniquePreset> = Vec::new();
    for &bias in biases {
        let map = ShadowMap {
            size,
            bias,
            format,
            ..ShadowMap::default()
        };
        out.push(TechniquePreset::from(Hard {}.on(map)));
    }
    out
}

/// Returns hard shadows from maps of 16 bits under two biases.
fn hard_16_bit(size: u32) -> Vec<TechniquePreset> {
    hard(
        size,
        MapFormat::Depth16,
        &[Bias::POLYGON_OFFSET, Bias::ADAPTIVE],
    )
}

/// Returns hard shadows without bias, under a constant bias and under the normal offset of one
/// comparison: little bias for low suns and long distances.
fn hard_small_bias(size: u32) -> Vec<TechniquePreset> {
    hard(
        size,
        MapFormat::Depth32,
        &[Bias::NONE, Bias::CONSTANT, Bias::NORMAL_OFFSET],
    )
}

/// Returns hard shadows under two biases that let light into rooms and under thin casters.
fn hard_leaky_bias(size: u32) -> Vec<TechniquePreset> {
    hard(
        size,
        MapFormat::Depth32,
        &[Bias::NORMAL_OFFSET, Bias::FRONT_CULL],
    )
}

/// Returns hard and filtered shadows from four cascades that together have the memory of one map:
/// split by the visible receivers, stable, and blended.
fn cascade_presets(size: u32) -> Vec<TechniquePreset> {
    let map = |fit, cascades| ShadowMap {
        size: size / 2,
        fit,
        layout: Layout::Cascades(cascades),
        ..ShadowMap::default()
    };
    let by_receivers = Cascades {
        split: Split::Receivers,
        ..Cascades::default()
    };
    let blended = Cascades {
        blend: 16.0,
        ..Cascades::default()
    };
    let stable = Fit::Stable {
        range: FARTHEST_SEAM,
    };
    vec![
        TechniquePreset::from(Hard {}.on(map(Fit::Tight, by_receivers))),
        TechniquePreset::from(Hard {}.on(map(stable, Cascades::default()))),
        TechniquePreset::from(Pcf::new(1).on(map(stable, blended))),
    ]
}

/// Returns moment maps without light bleeding reduction, one for each reconstruction.
fn unreduced_moments(size: u32) -> Vec<TechniquePreset> {
    let map = ShadowMap {
        size,
        ..ShadowMap::default()
    };
    let mut out: Vec<TechniquePreset> = vec![TechniquePreset::from(
        Vsm {
            bleeding_reduction: 0.0,
            ..Vsm::default()
        }
        .on(map),
    )];
    for moments in [EvsmMoments::Two, EvsmMoments::Four] {
        out.push(TechniquePreset::from(
            Evsm {
                moments,
                bleeding_reduction: 0.0,
                ..Evsm::default()
            }
            .on(map),
        ));
    }
    for reconstruction in [Reconstruction::Hamburger, Reconstruction::Hausdorff] {
        out.push(TechniquePreset::from(
            Msm {
                reconstruction,
                bleeding_reduction: 0.0,
                ..Msm::default()
            }
            .on(map),
        ));
    }
    out
}

/// Range of the stable fits for cascade seams, metres: the farthest visible distance.
const FARTHEST_SEAM: f32 = 320.0;
const FENCE_PAN: StabilityCase = moving_case(MovingScene::FENCE_PAN);
const WIRE_FENCE_PAN: StabilityCase = moving_case(MovingScene::WIRE_FENCE_PAN);
const FOLIAGE_PAN: StabilityCase = moving_case(MovingScene::FOLIAGE_PAN);
const HILLS_PAN: StabilityCase = moving_case(MovingScene::HILLS_PAN);
const HILLS_1E5_PAN: StabilityCase = moving_case(MovingScene::HILLS_1E5_PAN).limits_from("hills");
const HILLS_1E6_PAN: StabilityCase = moving_case(MovingScene::HILLS_1E6_PAN).limits_from("hills");
const HILLS_YAW: StabilityCase = moving_case(MovingScene::HILLS_YAW);
const HILLS_FOV: StabilityCase = moving_case(MovingScene::HILLS_FOV);
const HILLS_SUN: StabilityCase = moving_case(MovingScene::HILLS_SUN);
const HILLS_ENDLESS_PAN: StabilityCase = moving_case(MovingScene::HILLS_ENDLESS_PAN);
const HILLS_CASTERS: StabilityCase = moving_case(MovingScene::HILLS_CASTERS);
const HILLS_JITTER: StabilityCase = moving_case(MovingScene::HILLS_JITTER);

const WARPS: &str = "perspective warps";

#[rustfmt::skip]
const ROWS: &[StabilityRow] = &[
    row(1, "low sun", "a constant bias and a wide kernel are too little bias at grazing light: acne", &[
        still("low-sun-2", Measure::Acne).with_settings(hard_small_bias), still("low-sun-5", Measure::Acne).with_settings(hard_small_bias), still("low-sun-10", Measure::Acne).with_settings(hard_small_bias),
    ]),
    row(2, "near and far", "one bias for receivers at 5 m and at 300 m: acne in one of them", &[
        still("long-plane", Measure::AcneByDistance).with_settings(hard_small_bias), still("long-plane-lamp", Measure::AcneByDistance).with_settings(hard_small_bias),
    ]),
    row(3, "thin contact", "a bias detaches the shadow from a plate of 2 mm; second depth leaks at its base", &[
        still("thin-plate", Measure::Gap(PLATE)).with_settings(hard_leaky_bias),
        still("thin-plate", Measure::ContactLeak(PLATE, 0.05)).with_settings(hard_leaky_bias).with_name("thin-plate-leak"),
    ]),
    row(4, "sealed room", "walls one texel thick: front-face culling, second depth and normal offsets let light in", &[
        still("sealed-room", Measure::Leak).with_settings(hard_leaky_bias),
    ]),
    row(5, "open shells", "leaves, sheets and open boxes have no far side: techniques that need closed casters lose shadow", &[
        still("open-shells", Measure::Wrong),
    ]),
    row(6, "thin slices", "moments of many layers bleed; a bias confuses a slice with the next one", &[
        still("stacked-slices", Measure::Leak),
    ]),
    row(7, "two blockers", "a pole near the light and a wall far from it share one penumbra", &[
        still("two-blockers", Measure::PenumbraRmse),
    ]),
    row(8, "near contact", "feet 1 cm above the floor: light leaks under them", &[
        still("hovering-feet", Measure::LeakAround(&FEET, LEAK_RADIUS)),
    ]),
    row(9, "fine detail", "wires as thin as a texel appear and vanish", &[
        still("fence", Measure::Rmse), FENCE_PAN, FENCE_PAN.stable("fence-pan-stable", MovingScene::FENCE_PAN.range),
        still("wire-fence", Measure::Rmse),
        WIRE_FENCE_PAN, WIRE_FENCE_PAN.stable("wire-fence-pan-stable", MovingScene::WIRE_FENCE_PAN.range),
    ]),
    row(10, "landscape", "nearby texels far larger than pixels; a fit that follows the camera", &[
        still("hills", Measure::Rmse), HILLS_PAN, HILLS_PAN.stable("hills-pan-stable", MovingScene::HILLS_PAN.range),
    ]),
    row(11, "far from the origin", "positions and fits lose precision in 32 bits at 1e5 and 1e6 m", &[
        still("hills-1e5", Measure::Rmse).limits_from("hills"),
        HILLS_1E5_PAN, HILLS_1E5_PAN.stable("hills-1e5-pan-stable", MovingScene::HILLS_1E5_PAN.range),
        still("hills-1e6", Measure::Rmse).limits_from("hills"),
        HILLS_1E6_PAN, HILLS_1E6_PAN.stable("hills-1e6-pan-stable", MovingScene::HILLS_1E6_PAN.range),
    ]),
    row(12, "turning camera", "a fit that isn't stabilised changes with every frame", &[
        HILLS_YAW, HILLS_YAW.stable("hills-yaw-stable", MovingScene::HILLS_YAW.range),
        HILLS_FOV, HILLS_FOV.stable("hills-fov-stable", MovingScene::HILLS_FOV.range),
    ]),
    row(13, "turning sun", "texels turn with the light and crawl along edges, or the shadow lags behind the light", &[
        HILLS_SUN, HILLS_SUN.stable("hills-sun-stable", MovingScene::HILLS_SUN.range),
    ]),
    row(14, "into the light", "looking into the sun: the map is coarse where the image is fine", &[
        still("into-light", Measure::Rmse),
    ]).not_covered_yet(WARPS),
    row(15, "cube seams", "kernels stop at the edges of a cube's faces", &[
        still("lamp-in-room", Measure::Seams),
    ]),
    row(16, "coarse floor", "straight edges between few vertices bend on a curved map", &[
        still("lamp-in-room", Measure::EdgeDisplacement).with_name("lamp-in-room-edges"),
    ]).not_covered_yet("paraboloids"),
    row(17, "rising heights", "each box has a penumbra of its own width", &[
        still("rising-boxes", Measure::PenumbraWidth), still("rising-boxes-disc", Measure::PenumbraWidth),
    ]),
    row(18, "canopy", "leaves and a trunk under a large area light: many penumbrae overlap", &[
        still("canopy", Measure::PenumbraRmse),
    ]),
    row(19, "two lights", "the errors of two lights add up", &[
        StabilityCase { lights: 2, ..still("two-lights", Measure::Rmse) },
    ]),
    row(20, "caster at the light", "a bar 1 cm from the light is in front of the near plane: its shadow is lost", &[
        still("bar-at-lamp", Measure::Leak),
    ]),
    row(21, "eye in an umbra", "the eye is inside a shadow volume that the near plane cuts: wrong counts", &[
        still("eye-in-umbra", Measure::Wrong), still("eye-in-umbra-lamp", Measure::Wrong),
    ]),
    row(22, "broken meshes", "double faces, T-junctions and holes have no clean silhouette", &[
        still("broken-meshes", Measure::Leak), still("broken-meshes-lamp", Measure::Leak),
    ]),
    row(23, "many casters", "the volumes of 10,000 boxes cover the image many times", &[
        still("ten-thousand-boxes", Measure::Fill),
    ]),
    row(24, "stairs", "shadows flattened onto planes: wrong planes, casters across them, casters beyond the light", &[
        still("stairs", Measure::Acne), still("stairs-lamp", Measure::Acne), still("flat-receivers", Measure::Acne),
    ]),
    row(25, "relief", "a bias along the shading normal; relief from normals or a depth pass that the map lacks", &[
        still("displaced-wall", Measure::Acne), still("normal-mapped-wall", Measure::Acne),
        still("relief-without-depth-pass", Measure::Acne),
    ]),
    row(26, "coarse depth", "16 bits over a quarter of a kilometre: depths are quantised", &[
        still("far-range", Measure::Acne).with_settings(hard_16_bit),
    ]),
    row(27, "light along up", "a look-at whose up is the light's direction: the right vector is undefined", &[
        still("sun-above", Measure::Rmse), still("spot-above", Measure::Rmse),
    ]),
    row(28, "scale", "biases in metres in a scene scaled by 1e-3 and 1e4", &[
        still("cubes-tiny", Measure::ScaleDrift("cubes")), still("cubes-huge", Measure::ScaleDrift("cubes")),
    ]),
    row(29, "nothing", "no casters, no receivers or nothing visible: empty fits, divisions by zero", &[
        still("no-casters", Measure::AllLit), still("no-receivers", Measure::AllLit), still("only-sky", Measure::AllLit),
    ]),
    row(30, "caster out of view", "a tower outside the image casts its shadow into it", &[
        still("tower-out-of-view", Measure::Leak),
    ]),
    row(31, "room corners", "kernels and biases reach through the neighbouring wall: dark or bright lines along creases", &[
        still("room-corner", Measure::WrongNear(CREASES)),
    ]),
    row(32, "rim of a cone", "a spot's map ends with its cone: kernels reach beyond it", &[
        still("cone-rim", Measure::WrongNear(RIM)),
    ]),
    row(33, "small light", "a penumbra narrower than a texel: too narrow to search or filter", &[
        still("small-lamp", Measure::Rmse),
    ]),
    row(34, "low-poly terminator", "light grazes whole facets: acne on the last facets towards it, leaks on the first facets away from it", &[
        still("low-poly", Measure::Acne),
    ]),
    row(35, "other projections", "reversed and infinite depth: near and far planes are swapped or infinite", &[
        still("hills-endless", Measure::Rmse),
        HILLS_ENDLESS_PAN, HILLS_ENDLESS_PAN.stable("hills-endless-pan-stable", MovingScene::HILLS_ENDLESS_PAN.range),
    ]),
    row(36, "moving casters", "a fit around the casters moves with them, so all other shadows crawl", &[
        HILLS_CASTERS, HILLS_CASTERS.stable("hills-casters-stable", MovingScene::HILLS_CASTERS.range),
    ]),
    row(37, "jittered projection", "a fit that follows the camera's projection changes with every jitter of temporal antialiasing", &[
        HILLS_JITTER, HILLS_JITTER.stable("hills-jitter-stable", MovingScene::HILLS_JITTER.range),
    ]),
    row(38, "cascade seams", "between one map and the next coarser one: a line across the image, or no shadow at all", &[
        still("hills", Measure::CascadeSeams).with_settings(cascade_presets).with_name("hills-seams"),
        still("far-range", Measure::CascadeSeams).with_settings(cascade_presets).with_name("far-range-seams"),
    ]),
    row(39, "leaf cards", "alpha-tested leaves 5 to 500 m away: holes finer than a texel, a pixel, or both", &[
        still("foliage", Measure::Rmse), FOLIAGE_PAN, FOLIAGE_PAN.stable("foliage-pan-stable", MovingScene::FOLIAGE_PAN.range),
    ]),
    row(40, "light bleeding", "moments of two blockers: light along the upper one's outline within the shadow of the lower one", &[
        still("two-plates", Measure::Leak).with_settings(unreduced_moments),
    ]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Geometry;

    fn vertices(scene: &str) -> Vec<Vec3> {
        let scene = umbrage_scenes::by_argument(scene).expect("built in");
        Geometry::bake(&scene).expect("valid").positions().to_vec()
    }

    #[test]
    fn moving_scenes_are_in_their_rows() {
        for moving in MovingScene::ALL {
            let found: Vec<_> = cases()
                .filter(|(_, case)| case.name == moving.name)
                .collect();
            let [(row, case)] = found[..] else {
                panic!("{} is not in exactly one row", moving.name);
            };
            assert_eq!((row.number, case.motion), (moving.row, moving.motion));
        }
    }

    #[test]
    fn the_plate_is_that_of_its_scene() {
        let plate = vertices("thin-plate");
        for (end, corner_x) in [(PLATE.from, -0.5_f32), (PLATE.to, 0.5)] {
            let corner = Vec3::new(corner_x, end.y, end.z);
            assert!(plate.iter().any(|v| v.distance(corner) < 1e-6), "{corner}");
            assert!(end.x.abs() < corner_x.abs(), "{end} is outside the plate");
        }
    }

    #[test]
    fn the_creases_are_those_of_their_room() {
        let Band::Creases { lines, .. } = CREASES else {
            panic!("creases are lines");
        };
        let room = vertices("room-corner");
        for end in lines.iter().flatten() {
            assert!(room.iter().any(|v| v.distance(*end) < 1e-6), "{end}");
        }
    }

    #[test]
    fn the_feet_are_those_of_their_scene() {
        let feet = vertices("hovering-feet");
        for middle in FEET {
            let radius = feet
                .iter()
                .filter(|v| v.y > 0.0 && v.y < 0.5)
                .map(|v| (*v - middle).with_y(0.0).length())
                // The next foot is farther away.
                .filter(|&distance| distance < 0.14)
                .fold(0.0, f32::max);
            assert!((radius - FOOT_RADIUS).abs() < 1e-4, "{middle}: {radius}");
        }
    }
}
