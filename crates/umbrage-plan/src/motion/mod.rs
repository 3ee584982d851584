//! Motion from frame to frame, and the parts of a recipe that must be redrawn as a result.

pub mod pixel_shift;

use glam::{Affine3A, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage_core::{Camera, Cast, Geometry, Recipe, ShadowTechnique, Source, TableId, View};

/// Motion from frame to frame. It decides which work must be repeated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameMotion {
    /// Nothing moves: maps are kept, and each frame looks them up.
    Still,
    /// The camera moves: recipes are rebuilt, and images that follow the camera are redrawn. Other
    /// maps are kept.
    #[default]
    CameraMoves,
    /// Casters, lights and camera move: everything is rebuilt, including the hierarchies over the
    /// triangles.
    AllMoves,
}

impl FrameMotion {
    /// Returns a description for charts and tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Still => "nothing moves",
            Self::CameraMoves => "the camera moves",
            Self::AllMoves => "all moves",
        }
    }

    /// Returns whether the images of a recipe are kept from frame to frame. `kept_as_camera_moves`
    /// is the flag for frames in which only the camera moves, `None` if not evaluated.
    pub fn keeps(self, kept_as_camera_moves: Option<bool>) -> bool {
        match self {
            Self::Still => true,
            Self::CameraMoves => kept_as_camera_moves == Some(true),
            Self::AllMoves => false,
        }
    }
}

/// Returns whether a technique draws other images than `recipe` after the camera moves, by a little
/// or a lot.
pub fn follows_camera(technique: &dyn ShadowTechnique, recipe: &Recipe, view: &View<'_>) -> bool {
    let Some(geometry) = view.geometry else {
        return true;
    };
    if view.receivers.is_some() {
        // A fit to the visible receivers changes with them.
        let unknown = around_same_casters(view, view.camera, geometry);
        let of_unknown = technique.recipe(&unknown);
        if of_unknown.map_or(true, |other| !draw_alike(recipe, &other)) {
            return true;
        }
    }
    CAMERA_MOTIONS.iter().any(|motion| {
        let camera = motion.apply(view.camera, geometry);
        let moved_view = around_same_casters(view, &camera, geometry);
        let moved = technique.recipe(&moved_view);
        moved.map_or(true, |moved| !draw_alike(recipe, &moved))
    })
}

/// Returns the view of another camera without receivers. The box around the casters is kept, since
/// fits depend on it: a light set has a larger one than the casters need.
fn around_same_casters<'a>(
    view: &View<'a>,
    camera: &'a Camera,
    geometry: &'a Geometry,
) -> View<'a> {
    View {
        casters: view.casters,
        ..View::new(camera, view.light, geometry)
    }
}

/// Motion of a camera.
struct CameraMotion {
    /// Distance to the right, up by half of that, and forward, as a share of the scene's diagonal.
    step: f32,
    /// Turn about the camera's own y axis, radians.
    turn: f32,
}

/// Motions for testing what follows the camera: those of one frame, and of a few seconds.
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

/// Returns the cameras of the frames of a pan, starting with the given one. Each moves and turns a
/// little from the previous one.
pub fn pan(camera: &Camera, geometry: &Geometry, frames: u32) -> Vec<Camera> {
    let mut cameras = vec![*camera];
    for _ in 1..frames {
        let last = cameras[cameras.len() - 1];
        cameras.push(CAMERA_MOTIONS[0].apply(&last, geometry));
    }
    cameras
}

/// Returns whether a recipe casts into an image of the camera's size. It then has visibilities only
/// at that camera's pixels.
pub fn draws_the_picture(recipe: &Recipe, camera: &Camera) -> bool {
    recipe
        .casts
        .iter()
        .any(|cast| recipe.images[cast.image].size == camera.size)
}

/// Returns whether two recipes draw the same images: casts and filters, without lookups.
pub fn draw_alike(a: &Recipe, b: &Recipe) -> bool {
    let same_casts = a.casts.len() == b.casts.len()
        && a.casts.iter().zip(&b.casts).all(|(a, b)| cast_alike(a, b));
    let same_filters = a.filters.len() == b.filters.len()
        && a.filters.iter().zip(&b.filters).all(|(of_a, of_b)| {
            of_a.is_like(of_b) && of_a.tables.iter().all(|&table| table_alike(a, b, table))
        });
    a.images == b.images && same_casts && same_filters
}

/// Returns whether the tables of two recipes at one index have the same rows.
pub fn table_alike(a: &Recipe, b: &Recipe, index: TableId) -> bool {
    match (a.tables.get(index), b.tables.get(index)) {
        (Some(a), Some(b)) => Arc::ptr_eq(a.rows(), b.rows()) || a.rows() == b.rows(),
        _ => false,
    }
}

fn cast_alike(a: &Cast, b: &Cast) -> bool {
    // Destructure by name, so that a new field can't be missed.
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::{Cascades, Fit, Layout, Table, TableRows};
    use umbrage_cpu::Cpu;
    use umbrage_techniques::{
        Hard, MapFilter as _, MapTechnique, ShadowMap, ShadowVolumes, Traced, Vsm,
    };

    fn hard(fit: Fit) -> MapTechnique<Hard> {
        let map = ShadowMap {
            fit,
            size: 64,
            ..ShadowMap::default()
        };
        Hard {}.on(map)
    }

    fn follows(technique: &dyn ShadowTechnique) -> bool {
        follows_when(technique, false)
    }

    #[test]
    fn a_larger_box_around_the_casters_follows_no_camera() {
        let scene = umbrage_scenes::by_argument("street").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(32, 18));
        let mut view = View::new(&camera, &scene.lights[0], &geometry);
        view.casters.max += Vec3::new(1.0, 2.0, 3.0);
        let technique = hard(Fit::Tight);
        let recipe = technique.recipe(&view).expect("served");
        assert!(!follows_camera(&technique, &recipe, &view));
    }

    /// Returns whether a technique follows the camera, with or without receivers.
    fn follows_when(technique: &dyn ShadowTechnique, knows_receivers: bool) -> bool {
        let scene = umbrage_scenes::by_argument("street").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(32, 18));
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
    fn cascades_follow_the_camera() {
        for fit in [Fit::Tight, Fit::Stable { range: 60.0 }] {
            let one = hard(fit).map;
            let map = ShadowMap {
                layout: Layout::Cascades(Cascades::default()),
                ..one
            };
            assert!(follows(&Hard {}.on(map)), "{}", map.label());
        }
    }

    /// A map as large as the image is not the camera's image.
    #[test]
    fn a_map_of_the_pictures_size_need_not_follow_the_camera() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::splat(64));
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let technique = hard(Fit::Whole);
        let recipe = technique.recipe(&view).expect("served");
        assert!(!follows_camera(&technique, &recipe, &view));
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

    /// Returns the recipe of a map with a blur. The fit of the whole scene is the same for any
    /// width.
    fn blurred_recipe(blur: u32) -> Recipe {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let map = ShadowMap {
            fit: Fit::Whole,
            size: 64,
            ..ShadowMap::default()
        };
        let technique = Vsm {
            blur,
            ..Vsm::default()
        }
        .on(map);
        technique.recipe(&view).expect("serves the sun")
    }

    /// Filters of the same inputs with different parameters draw different images.
    #[test]
    fn filters_that_differ_are_distinguished() {
        let [narrow, same, mut wide] = [2, 2, 3].map(blurred_recipe);
        assert!(draw_alike(&narrow, &same));
        wide.casts.clone_from(&narrow.casts);
        assert!(!draw_alike(&narrow, &wide));
    }

    /// Filters that read other rows from a table of the same index draw different images.
    #[test]
    fn tables_are_compared_by_their_rows() {
        let with_rows = |word: u32| {
            let mut recipe = blurred_recipe(2);
            recipe.filters[0].tables.push(recipe.tables.len());
            recipe.tables.push(Table {
                label: "test",
                rows: TableRows::on_first_use(move || Arc::from([[word; 4]])),
            });
            recipe
        };
        let [one, same, other] = [1, 1, 2].map(with_rows);
        assert!(draw_alike(&one, &same));
        assert!(!draw_alike(&one, &other));
    }
}
