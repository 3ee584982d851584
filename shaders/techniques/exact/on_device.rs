//! Lists that a device makes itself, from vertices that only it holds: by the passes in
//! `on_device/`.
//!
//! The same tables, for the same shader. What differs: every tile has as many cells, and as many as
//! have room; receivers are not known beforehand, so that rays are lifted off them, and margins
//! widened, for all within a few times the casters' distance; and a caster's edges are in 32 bits,
//! with wider margins.

use super::{
    ExactKernel, ITEM_KEY,
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

/// Tiles along a sun's longer side; a lamp has half as many on each of its six faces. They are all
/// alike, so that few will do.
const TILES: u32 = 8;

/// How far receivers are taken to be from the camera at most: this many times the farthest casters.
const RECEIVERS_REACH: f32 = 4.0;

/// Cells along a tile's side, as a power of two: 256 along a sun's longer side, and 128 on each
/// face of a lamp. On lavapipe, in four frames, making and asking lists takes .7 to .9 of what it
/// does with twice as many, where all casters move.
const SIDE_LOG2: u32 = 5;

uniforms! {
    /// Where the grid of a device's lists lies. Twin of `ListsGrid` in touch.wgsl.
    pub struct ListsGrid {
        /// World position of frame space's origin; w: what the triangle test is wrong by.
        pub origin: Vec4,
        /// First row of the matrix from the world, less the origin, to frame space; w: the least
        /// margin.
        pub across: Vec4,
        /// The second row; w: the margin in depth.
        pub down: Vec4,
        /// The third row; w: what is subtracted from a sun's depth.
        pub away: Vec4,
        /// Half the size of a face, across and down; tiles a unit of a direction; distance from a
        /// lamp within which casters may be anywhere.
        pub face: Vec4,
        /// Tiles of a face, across and down; whether the light is a lamp; cells along a tile's side
        /// as a power of two.
        pub tiles: UVec4,
    }
}

/// Returns the recipe for casters of which only the box is known.
pub(super) fn device_recipe(view: &View<'_>) -> Result<DeviceRecipe, RecipeError> {
    view.validate()?;
    let reach = reach_around(view);
    let center = if view.casters.is_empty() {
        Vec3::ZERO
    } else {
        view.casters.center()
    };
    // A cube whose diagonal is the reach.
    let half = Vec3::splat(0.5 * reach / 3.0_f32.sqrt());
    let everything = Aabb {
        min: center - half,
        max: center + half,
    };
    let casters = view.casters.union(&Aabb::around([center]));
    let frame = LightFrame::around(view.light, &casters, &everything, TILES);
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

/// Returns a distance that two points of the scene are surely apart at most, metres: a power of
/// two, so that it stays the same while camera and casters move a little.
fn reach_around(view: &View<'_>) -> f32 {
    let around = view.casters.union(&Aabb::around([view.camera.eye()]));
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
