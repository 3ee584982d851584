//! A hierarchy over the light's view that a device builds from vertices that only it has, by the
//! passes in `on_device/`, and its lookup.
//!
//! A receiver is a point over the light's view. Leaves are rectangles with a least depth, around
//! casters or strips of them. They are sorted along a Hilbert curve and packed into nodes of eight
//! children (Kamel and Faloutsos 1993, "On Packing R-trees"). So the number of nodes follows from
//! the number of casters.
//!
//! Receivers are not known beforehand. Rays are lifted off them for all receivers within a few
//! times the casters' distance.

use super::{
    CASTER_CUT_OUT, CASTER_OPAQUE, ExactUniforms, FRAME_POINT, cut_out_table,
    light_frame::{LEAST_MARGIN, LightFrame, POSITION_MARGIN},
    recipe_from_tables,
};
use std::sync::Arc;
use umbrage_core::{
    Aabb, CutOuts, DeviceHierarchy, DeviceRecipe, Inputs, Kernel, MATH, Module, ReceiveKernel,
    Recipe, RecipeError, Span, Table, UniformBlock, Uniforms, View,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    glam::{DVec2, DVec3, Vec2, Vec3, Vec4},
    light_sample::{LIGHT_SAMPLE, ray_origin, segment},
    math::dot3,
    module, uniforms,
};

/// Greatest distance of receivers from the camera, as a multiple of that of the farthest casters.
const RECEIVERS_REACH: f32 = 4.0;

uniforms! {
    /// The light's view. Twin of `LightView` in view.wgsl.
    pub struct LightView {
        /// 1 if the light has a position; half the size of a face, across and down; w is unused. It
        /// is the first field: see `STEADY_FIRST_WORD` in umbrage-wgpu's drivers.rs.
        pub face: Vec4,
        /// World position of frame space's origin; w: error of the triangle test for the farthest
        /// receivers.
        pub origin: Vec4,
        /// First row of the matrix from the world, relative to the origin, to frame space; w: the
        /// least margin.
        pub across: Vec4,
        /// Second row; w: the margin in depth from a point light, as a fraction of depth.
        pub down: Vec4,
        /// Third row; w: value subtracted from a directional light's depth.
        pub away: Vec4,
    }
}

/// Returns the recipe for casters of which only the bounding box is known, and the records of
/// alpha-tested ones.
pub(super) fn device_recipe(
    view: &View<'_>,
    cut_outs: Option<&CutOuts>,
) -> Result<DeviceRecipe, RecipeError> {
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
    // A hierarchy has no tiles.
    let frame = LightFrame::around_casters(view.light, upright_pair, &casters, &everything, 1);
    let kernel = HierarchyKernel {
        uniforms: ExactUniforms::new(view, &frame, reach, 2.0 * reach),
        has_cut_outs: cut_outs.is_some(),
    };
    Ok(DeviceRecipe {
        recipe: recipe_without_casters(kernel, cut_outs),
        hierarchy: DeviceHierarchy {
            modules: modules(),
            uniforms_name: LightView::NAME,
            uniforms: light_view(&frame, &casters).to_bytes(),
            faces: frame.faces(),
        },
    })
}

/// Returns an upper bound of the distance between two points of the scene, metres. It is a power of
/// two, so that it stays the same while camera and casters move a little.
fn reach_around(view: &View<'_>) -> f32 {
    let around = view.casters.union(&Aabb::from_points([view.camera.eye()]));
    let farthest = RECEIVERS_REACH * around.diagonal();
    farthest.max(1e-3).log2().ceil().exp2().min(1e18)
}

fn light_view(frame: &LightFrame, casters: &Aabb) -> LightView {
    let [across, down, away] = frame.rows;
    let least_margin = if frame.is_lamp {
        LEAST_MARGIN
    } else {
        // Coordinates round in proportion to the distance from the origin, which is at most half
        // the diagonal of the casters.
        let radius = 0.5 * casters.diagonal() * away.length();
        POSITION_MARGIN * radius.max(1.0)
    };
    let is_lamp = f32::from(u8::from(frame.is_lamp));
    LightView {
        face: Vec4::new(is_lamp, frame.half.x, frame.half.y, 0.0),
        origin: frame.origin.extend(frame.rounding),
        across: across.extend(least_margin),
        down: down.extend(frame.depth_margin()),
        away: away.extend(frame.nearest),
    }
}

/// Returns two unit vectors across a unit vector and each other. The world's vertical has no part
/// along the first one, so upright edges, which most scenes have, have narrow boxes.
///
/// Lists of the CPU don't use it: they are 27 to 30 % shorter in `nave` and `valley`, and 15 %
/// longer in `street`.
fn upright_pair(away: DVec3) -> (DVec3, DVec3) {
    let (across, down) = away.any_orthonormal_pair();
    let Some(up) = DVec2::new(across.y, down.y).try_normalize() else {
        return (across, down);
    };
    (across * up.y - down * up.x, across * up.x + down * up.y)
}

/// Modules of the passes.
fn modules() -> Vec<Module> {
    vec![
        MATH,
        module!("view", "on_device/view.wgsl"),
        module!("shapes", "on_device/shapes.wgsl"),
        module!("place", "on_device/place.wgsl"),
        module!("pieces", "on_device/pieces.wgsl"),
        module!("keys", "on_device/keys.wgsl"),
        module!("blocks", "on_device/blocks.wgsl"),
        module!("nodes", "on_device/nodes.wgsl"),
    ]
}

/// Returns a recipe with the hierarchy of no casters: a header with one level, and a node without
/// children. The device's hierarchy replaces it.
fn recipe_without_casters(kernel: HierarchyKernel, cut_outs: Option<&CutOuts>) -> Recipe {
    let mut hierarchy = vec![[0; 4]; 8];
    hierarchy[0][0] = 1;
    let table = |label, rows: Vec<[u32; 4]>| Table {
        label,
        rows: rows.into(),
    };
    let mut tables = vec![
        table("hierarchy", hierarchy),
        table("corners", vec![[0; 4]; 3]),
    ];
    tables.extend(cut_outs.map(cut_out_table));
    recipe_from_tables(Arc::new(kernel), tables)
}

/// Kernel that queries the hierarchy.
#[derive(Clone, Debug)]
struct HierarchyKernel {
    uniforms: ExactUniforms,
    /// True if there are alpha-tested casters.
    has_cut_outs: bool,
}

impl Kernel for HierarchyKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = vec![RAY_BOX, RAY_TRIANGLE, LIGHT_SAMPLE];
        if self.has_cut_outs {
            modules.extend([CUT_OUT, HOLE, CASTER_CUT_OUT]);
            modules.push(module!("hierarchy_records", "hierarchy_records.wgsl"));
        } else {
            modules.push(CASTER_OPAQUE);
        }
        modules.extend([module!("hierarchy", "hierarchy.wgsl"), FRAME_POINT]);
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for HierarchyKernel {
    /// Only a device has casters: receivers that face the light are lit.
    fn receive(&self, _: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let u = &self.uniforms;
        for (i, out) in out.iter_mut().enumerate() {
            let n = span.normal(i);
            let origin = ray_origin(span.position(i), n, u.eye.truncate(), u.grid.w);
            let ray = segment(&u.light, origin, Vec2::ZERO, u.far);
            *out = f32::from(u8::from(dot3(n, ray) > 0.0));
        }
    }

    fn in_compute(&self) -> bool {
        true
    }
}
