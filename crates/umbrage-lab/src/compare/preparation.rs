//! What frames cost besides what backends play: making recipes, and what is made once for a scene.

use super::TimingStats;
use glam::{Affine3A, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;
use umbrage_core::{
    Camera, Cast, Filter, Geometry, Invalid, Recipe, RecipeError, Scene, ShadowTechnique, Source,
    View,
};

/// What moves from frame to frame, and so what has to be made anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameMotion {
    /// Nothing: maps are kept, and each frame looks them up.
    Still,
    /// The camera: what is drawn for the camera is drawn again, after the recipe is made again. Maps that do not follow the camera
    /// are kept.
    #[default]
    CameraMoves,
    /// Casters, lights and camera: everything is made again, with the hierarchies over the triangles.
    AllMoves,
}

impl FrameMotion {
    /// Returns what moves, in words for charts and tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Still => "nothing moves",
            Self::CameraMoves => "the camera moves",
            Self::AllMoves => "all moves",
        }
    }
}

/// The times of what comes before a backend plays, for one setting on one scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Once a scene: hierarchies over its triangles, welded edges and the like, milliseconds. It is the time by which the first
    /// recipe of fresh triangles takes longer than later ones.
    pub scene_ms: f64,
    /// Making the recipe: once a change of what it depends on.
    pub recipe: TimingStats,
}

/// How often a recipe is made to be timed.
const RECIPES: u32 = 3;
/// Seconds after which no further recipe is made to be timed.
const MAX_SECONDS: f64 = 0.5;
/// Makes a recipe and times that.
///
/// # Errors
/// Errors if the technique can't make it.
pub(super) fn time_recipe(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
) -> Result<(Recipe, TimingStats), RecipeError> {
    let recipe = technique.recipe(view)?;
    let start = Instant::now();
    let mut times = Vec::new();
    for _ in 0..RECIPES {
        let one = Instant::now();
        technique.recipe(view)?;
        times.push(one.elapsed().as_secs_f64() * 1e3);
        if start.elapsed().as_secs_f64() > MAX_SECONDS {
            break;
        }
    }
    Ok((recipe, TimingStats::of(times).unwrap_or_default()))
}

/// Returns by how many milliseconds a first recipe for the triangles of a scene takes longer than `later_ms`; 0 if the technique
/// doesn't serve it.
///
/// # Errors
/// Errors if the scene is not valid.
pub(super) fn time_of_scene(
    technique: &dyn ShadowTechnique,
    scene: &Scene,
    view: &View<'_>,
    later_ms: f64,
) -> Result<f64, Invalid> {
    let fresh = Geometry::bake(scene)?;
    let view = View {
        geometry: Some(&fresh),
        ..*view
    };
    let start = Instant::now();
    if technique.recipe(&view).is_err() {
        return Ok(0.0);
    }
    let first_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok((first_ms - later_ms).max(0.0))
}

/// Whether a technique draws something else than `recipe` once the camera moves, a little or far.
pub(super) fn follows_camera(
    technique: &dyn ShadowTechnique,
    recipe: &Recipe,
    view: &View<'_>,
) -> bool {
    let Some(geometry) = view.geometry else {
        return true;
    };
    let still_view = View::new(view.camera, view.light, geometry);
    let Ok(still) = technique.recipe(&still_view) else {
        return true;
    };
    // What is fitted to the receivers that are seen changes with them.
    if !draw_alike(recipe, &still) {
        return true;
    }
    CAMERA_MOTIONS.iter().any(|motion| {
        let camera = motion.apply(view.camera, geometry);
        let moved_view = View::new(&camera, view.light, geometry);
        let moved = technique.recipe(&moved_view);
        moved.map_or(true, |moved| !draw_alike(&still, &moved))
    })
}

/// A motion of a camera.
struct CameraMotion {
    /// How far it moves to the right, up by half of that, and forward, as a share of the scene's diagonal.
    step: f32,
    /// How far it turns about its own y axis, radians.
    turn: f32,
}

/// Motions to find out what follows the camera: those of one frame, and of some seconds.
const CAMERA_MOTIONS: [CameraMotion; 2] = [
    CameraMotion {
        step: 0.002,
        turn: 0.02,
    },
    CameraMotion {
        step: 0.05,
        turn: 1.0,
    },
];

impl CameraMotion {
    fn apply(&self, camera: &Camera, geometry: &Geometry) -> Camera {
        let step = self.step * geometry.bounds().diagonal();
        let shift = Vec3::new(step, 0.5 * step, -step);
        let motion = Affine3A::from_rotation_translation(Quat::from_rotation_y(self.turn), shift);
        Camera {
            world_from_view: camera.world_from_view * motion,
            ..*camera
        }
    }
}

/// Whether two recipes draw the same: what is cast and filtered, lookups left out.
pub(super) fn draw_alike(a: &Recipe, b: &Recipe) -> bool {
    let same_casts = a.casts.len() == b.casts.len()
        && a.casts.iter().zip(&b.casts).all(|(a, b)| cast_alike(a, b));
    let same_filters = a.filters.len() == b.filters.len()
        && a.filters
            .iter()
            .zip(&b.filters)
            .all(|(a, b)| filter_alike(a, b));
    format!("{:?}", a.images) == format!("{:?}", b.images) && same_casts && same_filters
}

/// Whether two recipes are the same, so that their masks are.
pub(super) fn play_alike(a: &Recipe, b: &Recipe) -> bool {
    let of_lookup = |recipe: &Recipe| {
        let receive = &recipe.receive;
        format!(
            "{:?} {:?} {:?}",
            receive.kernel, receive.inputs, receive.tables
        )
    };
    let same_tables = a.tables.len() == b.tables.len()
        && a.tables
            .iter()
            .zip(&b.tables)
            .all(|(a, b)| Arc::ptr_eq(&a.rows, &b.rows) || a.rows == b.rows);
    draw_alike(a, b) && same_tables && of_lookup(a) == of_lookup(b)
}

fn cast_alike(a: &Cast, b: &Cast) -> bool {
    // By name, so that a new field can't be forgotten here.
    let Cast {
        image,
        layer,
        space,
        source,
        mode,
        cull,
        bias,
    } = a;
    *image == b.image
        && *layer == b.layer
        && *space == b.space
        && *mode == b.mode
        && *cull == b.cull
        && *bias == b.bias
        && source_alike(source, &b.source)
}

fn source_alike(a: &Source, b: &Source) -> bool {
    match (a, b) {
        (Source::Casters, Source::Casters) | (Source::Everything, Source::Everything) => true,
        (Source::SomeCasters(a), Source::SomeCasters(b)) => a == b,
        (Source::Faces(a), Source::Faces(b)) => a == b,
        _ => false,
    }
}

fn filter_alike(a: &Filter, b: &Filter) -> bool {
    let words = |filter: &Filter| format!("{filter:?}");
    words(a) == words(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::{Fit, Light};
    use umbrage_cpu::Cpu;
    use umbrage_techniques::{Bias, Hard, Pcss, ShadowMap, ShadowVolumes, Traced};

    fn hard(fit: Fit) -> Hard {
        let map = ShadowMap {
            fit,
            size: 64,
            ..ShadowMap::default()
        };
        Hard { map }
    }

    fn follows(technique: &dyn ShadowTechnique) -> bool {
        follows_when(technique, false)
    }

    /// Whether a technique follows the camera where receivers are known, or where they aren't.
    fn follows_when(technique: &dyn ShadowTechnique, knows_receivers: bool) -> bool {
        let scene = umbrage_scenes::by_argument("street").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].resized(UVec2::new(32, 18));
        let receivers = Cpu::new().receivers(&camera, &geometry).expect("valid");
        let mut view = View::new(&camera, &scene.lights[0], &geometry);
        if knows_receivers {
            view = view.with_receivers(&receivers);
        }
        let recipe = technique.recipe(&view).expect("served");
        follows_camera(technique, &recipe, &view)
    }

    #[test]
    fn a_fit_to_what_is_seen_follows_the_camera() {
        assert!(follows_when(&hard(Fit::Tight), true));
        assert!(!follows_when(&hard(Fit::Whole), true));
        assert!(
            !follows_when(&hard(Fit::Tight), false),
            "it goes around all that receives"
        );
    }

    #[test]
    fn what_follows_the_camera_is_found_out() {
        assert!(follows(&hard(Fit::Stable { range: 20.0 })));
        assert!(
            follows(&ShadowVolumes::default()),
            "it counts in the camera's image"
        );
        assert!(!follows(&hard(Fit::Whole)));
        assert!(!follows(&Traced::default()));
    }

    #[test]
    fn the_same_recipe_is_known_under_another_name() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let recipe = |technique: &dyn ShadowTechnique, light: &Light| {
            let view = View::new(&scene.cameras[0], light, &geometry);
            technique.recipe(&view).expect("served")
        };
        let sun = scene.lights[0];
        let map = ShadowMap::default();
        let hard = Hard { map };
        let pcss = Pcss {
            map,
            ..Pcss::default()
        };
        assert!(play_alike(&recipe(&hard, &sun), &recipe(&pcss, &sun)));
        // Under a wide light, with another bias or on another map they differ.
        let lamp = umbrage_scenes::by_argument("teapot-lamp")
            .expect("built in")
            .lights[0];
        assert!(!play_alike(&recipe(&hard, &lamp), &recipe(&pcss, &lamp)));
        for other in [
            ShadowMap {
                bias: Bias::SLOPE,
                ..map
            },
            ShadowMap { size: 512, ..map },
        ] {
            let other = Hard { map: other };
            assert!(!play_alike(&recipe(&hard, &sun), &recipe(&other, &sun)));
        }
        let few = Traced { samples: 1 };
        let many = Traced { samples: 4 };
        assert!(play_alike(&recipe(&few, &sun), &recipe(&many, &sun)));
        assert!(!play_alike(&recipe(&few, &lamp), &recipe(&many, &lamp)));
    }
}
