//! Lists that a device builds from vertices that only it has, by the passes in `on_device/`.
//!
//! The tables have the same layout, for the same shader. There are three differences:
//!
//! - Every tile has the same number of cells, which is limited by capacity.
//! - Receivers are not known beforehand. Rays are lifted off them, and margins widened, for all
//!   receivers within a few times the casters' distance.
//! - Edges of casters use 32 bits, with wider margins.

use super::{
    ExactKernel,
    item_key::ITEM_KEY,
    light_frame::{LEAST_MARGIN, LightFrame},
    lists::KeptLists,
    recipe_of,
};
use std::sync::Arc;
use umbrage_core::{
    Aabb, DeviceLists, DeviceRecipe, MATH, Module, RecipeError, Uniforms, View,
    glam::{UVec4, Vec3, Vec4},
    uniforms,
};

/// Number of tiles along a directional light's longer side; a point light has half as many on each
/// of its six faces. All tiles have the same cells, so few are enough.
const TILES: u32 = 8;

/// Greatest distance of receivers from the camera, as a multiple of that of the farthest casters.
const RECEIVERS_REACH: f32 = 4.0;

/// Number of cells along a tile's side, as a power of two. A directional light has 256 cells along
/// its longer side, and a point light 128 on each face. On lavapipe, in four frames with all
/// casters moving, building and querying lists takes .7 to .9 of the time with twice as many.
const SIDE_LOG2: u32 = 5;

uniforms! {
    /// Grid of a device's lists. Twin of `ListsGrid` in touch.wgsl.
    pub struct ListsGrid {
        /// World position of frame space's origin; w: error of the triangle test.
        pub origin: Vec4,
        /// First row of the matrix from the world, relative to the origin, to frame space; w: the
        /// least margin.
        pub across: Vec4,
        /// Second row; w: the margin in depth.
        pub down: Vec4,
        /// Third row; w: value subtracted from a directional light's depth.
        pub away: Vec4,
        /// Half the size of a face, across and down; tiles per unit of a direction; distance from a
        /// point light within which casters may be anywhere.
        pub face: Vec4,
        /// Number of tiles of a face, across and down; 1 if the light has a position; number of
        /// cells along a tile's side as a power of two.
        pub tiles: UVec4,
    }
}

/// Returns the recipe for casters of which only the bounding box is known.
pub(super) fn device_recipe(view: &View<'_>) -> Result<DeviceRecipe, RecipeError> {
    view.validate()?;
    let reach = reach_around(view);
    let center = if view.casters.is_empty() {
        Vec3::ZERO
    } else {
        view.casters.center()
    };
    // Use a cube whose diagonal is the reach.
    let half = Vec3::splat(0.5 * reach / 3.0_f32.sqrt());
    let everything = Aabb {
        min: center - half,
        max: center + half,
    };
    let casters = view.casters.union(&Aabb::from_points([center]));
    let frame = LightFrame::around_casters(view.light, &casters, &everything, TILES);
    let grid = grid_of(&frame);
    let lists = DeviceLists {
        modules: modules(),
        uniforms_name: ListsGrid::NAME,
        uniforms: grid.to_bytes(),
        tiles: frame.tile_count() as u32,
        side_log2: SIDE_LOG2,
        faces: frame.faces(),
    };
    let none = Arc::new(KeptLists::without_casters(frame));
    let kernel = ExactKernel::of_lists(view, none.clone(), reach, 2.0 * reach).on_device();
    Ok(DeviceRecipe {
        recipe: recipe_of(kernel),
        lists,
    })
}

/// Returns an upper bound of the distance between two points of the scene, metres. It is a power of
/// two, so that it stays the same while camera and casters move a little.
fn reach_around(view: &View<'_>) -> f32 {
    let around = view.casters.union(&Aabb::from_points([view.camera.eye()]));
    let farthest = RECEIVERS_REACH * around.diagonal();
    farthest.max(1e-3).log2().ceil().exp2().min(1e18)
}

fn grid_of(frame: &LightFrame) -> ListsGrid {
    let [across, down, away] = frame.rows;
    ListsGrid {
        origin: frame.origin.extend(frame.rounding),
        across: across.extend(LEAST_MARGIN),
        down: down.extend(frame.depth_margin()),
        away: away.extend(frame.nearest),
        face: Vec4::new(
            frame.half.x,
            frame.half.y,
            frame.tiles_a_unit,
            frame.at_lamp(),
        ),
        tiles: UVec4::new(
            frame.tiles.x,
            frame.tiles.y,
            u32::from(frame.is_lamp),
            SIDE_LOG2,
        ),
    }
}

fn modules() -> Vec<Module> {
    let module = |name, text| Module { name, text };
    vec![
        MATH,
        ITEM_KEY,
        module("touch", include_str!("on_device/touch.wgsl")),
        module("edges", include_str!("on_device/edges.wgsl")),
        module("lists", include_str!("on_device/lists.wgsl")),
        module("kept_touches", include_str!("on_device/kept_touches.wgsl")),
        module("visits", include_str!("on_device/visits.wgsl")),
        module("order", include_str!("on_device/order.wgsl")),
        module("items", include_str!("on_device/items.wgsl")),
    ]
}
