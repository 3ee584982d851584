//! A hierarchy over the light's view that a device builds by the passes in `on_device/`, and its
//! lookup.
//!
//! A receiver is a point over the light's view. Leaves are rectangles with a least depth, around
//! casters or strips of them. They are sorted along a Hilbert curve and packed into nodes of eight
//! children (Kamel and Faloutsos 1993, "On Packing R-trees"). So the number of nodes follows from
//! the number of casters.
//!
//! If only the device has the vertices, receivers are not known beforehand. Rays are then lifted off
//! them for all receivers within a few times the casters' distance.

use super::{
    CASTER_CUT_OUT, CASTER_OPAQUE, ExactKernel, ExactUniforms, FRAME_POINT, cut_out_table,
    light_frame::{LEAST_MARGIN, LightFrame, POSITION_MARGIN},
    lists::CornerRows,
    recipe_from_tables,
};
use std::sync::Arc;
use umbrage_core::{
    Aabb, CutOuts, DeviceHierarchy, Geometry, Inputs, Kernel, MATH, Module, ReceiveKernel,
    Receivers, Recipe, RecipeError, Simd, Span, Table, TableRows, UniformBlock, Uniforms, View,
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

/// Returns the recipe for the casters of a geometry. Its result has the bits of `on_cpu`, which
/// computes it on the CPU.
pub(super) fn recipe_with_triangles(
    view: &View<'_>,
    geometry: &Geometry,
    on_cpu: ExactKernel,
) -> Recipe {
    let casters = box_or_origin(&geometry.caster_bounds());
    let frame = upright_frame(view, &casters, &geometry.bounds());
    let ExactUniforms { grid, far, .. } = on_cpu.uniforms;
    let cut_outs = on_cpu.cut_outs.clone();
    let mut uniforms = ExactUniforms::new(view, &frame, grid.w, far);
    uniforms.tiles.w = 1;
    let kernel = HierarchyKernel {
        uniforms,
        has_cut_outs: cut_outs.is_some(),
        on_cpu: Some(on_cpu),
    };
    let geometry = geometry.clone();
    let corners = TableRows::on_first_use(move || CornerRows::of_geometry(&geometry));
    let hierarchy = device_hierarchy(&frame, &casters);
    hierarchy_recipe(kernel, corners, cut_outs.as_deref(), hierarchy)
}

/// Returns the recipe for casters of which only the bounding box is known, and the records of
/// alpha-tested ones.
pub(super) fn device_recipe(
    view: &View<'_>,
    cut_outs: Option<&CutOuts>,
) -> Result<Recipe, RecipeError> {
    view.validate()?;
    let reach = reach_around(view);
    let casters = box_or_origin(&view.casters);
    // Use a cube whose diagonal is the reach.
    let half = Vec3::splat(0.5 * reach / 3.0_f32.sqrt());
    let everything = Aabb {
        min: casters.center() - half,
        max: casters.center() + half,
    };
    let frame = upright_frame(view, &casters, &everything);
    let kernel = HierarchyKernel {
        uniforms: ExactUniforms::new(view, &frame, reach, 2.0 * reach),
        has_cut_outs: cut_outs.is_some(),
        on_cpu: None,
    };
    let no_corners = vec![[0; 4]; 3].into();
    let hierarchy = device_hierarchy(&frame, &casters);
    Ok(hierarchy_recipe(kernel, no_corners, cut_outs, hierarchy))
}

/// Returns a box, or the origin if it is empty.
fn box_or_origin(casters: &Aabb) -> Aabb {
    if casters.is_empty() {
        Aabb::from_points([Vec3::ZERO])
    } else {
        *casters
    }
}

/// Returns the frame of a view's light. `everything` is the box around casters and ray origins.
fn upright_frame(view: &View<'_>, casters: &Aabb, everything: &Aabb) -> LightFrame {
    // A hierarchy has no tiles.
    let tiles = 1;
    LightFrame::around_casters(view.light, upright_pair, casters, everything, tiles)
}

fn device_hierarchy(frame: &LightFrame, casters: &Aabb) -> DeviceHierarchy {
    DeviceHierarchy {
        modules: modules(),
        uniforms_name: LightView::NAME,
        uniforms: light_view(frame, casters).to_bytes(),
        faces: frame.faces(),
    }
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

/// Returns the recipe of a kernel. The table of its hierarchy is that of no casters: a header with one
/// level, and a node without children. The device's hierarchy replaces it.
fn hierarchy_recipe(
    kernel: HierarchyKernel,
    corners: TableRows,
    cut_outs: Option<&CutOuts>,
    hierarchy: DeviceHierarchy,
) -> Recipe {
    let mut empty = vec![[0; 4]; 8];
    empty[0][0] = 1;
    let table = |label, rows| Table { label, rows };
    let mut tables = vec![table("hierarchy", empty.into()), table("corners", corners)];
    tables.extend(cut_outs.map(cut_out_table));
    Recipe {
        hierarchy: Some(hierarchy),
        ..recipe_from_tables(Arc::new(kernel), tables)
    }
}

/// Kernel that queries the hierarchy.
#[derive(Clone, Debug)]
pub struct HierarchyKernel {
    uniforms: ExactUniforms,
    /// True if there are alpha-tested casters.
    has_cut_outs: bool,
    /// Computes the same on the CPU; `None` if only a device has the casters.
    on_cpu: Option<ExactKernel>,
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
    /// If only a device has casters, receivers that face the light are lit.
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        if let Some(on_cpu) = &self.on_cpu {
            return on_cpu.receive(inputs, span, out);
        }
        let u = &self.uniforms;
        for (i, out) in out.iter_mut().enumerate() {
            let n = span.normal(i);
            let origin = ray_origin(span.position(i), n, u.eye.truncate(), u.grid.w);
            let ray = segment(&u.light, origin, Vec2::ZERO, u.far);
            *out = f32::from(u8::from(dot3(n, ray) > 0.0));
        }
    }

    fn receive_all(&self, simd: Simd, receivers: &Receivers) -> Option<Vec<f32>> {
        self.on_cpu.as_ref()?.receive_all(simd, receivers)
    }

    fn in_compute(&self) -> bool {
        true
    }
}
