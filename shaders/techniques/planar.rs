//! Planar projected shadows: casters flattened onto each flat receiver, rendered from the camera.
//!
//! Blinn 1988, "Me and my (fake) shadow": [`planar_shadow_matrix`] maps a caster to its shadow on a
//! plane. Each visible plane that faces the light has a layer of the camera's image size. The
//! flattened casters are drawn into it. A pixel is dark if its own plane's layer is covered there.
//! So shadows end at the border of their receiver, and adjacent receivers have their own. Casters
//! are first clipped to the slab between plane and light. Otherwise, those behind the light would
//! cast anti-shadows, and those below the plane would be projected up to it.
//!
//! Exact on flat receivers, without bias. Area lights count as their centre. Known failures: curved
//! receivers need one plane per triangle (not supported beyond [`Planar::planes`]). Alpha-tested
//! casters are refused. Every plane draws all casters again.

mod flatten;
mod matrix;
mod planes;

pub use matrix::planar_shadow_matrix;

use crate::{
    listing::ListedTechnique,
    shading::facing::{FACING, homogeneous, turned_away},
    techniques::{
        check_no_holes,
        infinite_far::InfiniteFarView,
        planar::{
            flatten::flatten_casters,
            planes::{NO_PLANE, Planes},
        },
    },
};
use glam::Vec4;
use std::sync::Arc;
use umbrage_core::{
    Cast, Format, Geometry, ImageDesc, Inputs, Invalid, Kernel, Module, Receive, ReceiveKernel,
    Recipe, RecipeError, ShadowTechnique, Source, Span, Table, UniformBlock, View, module,
    uniforms,
};

/// Maximum number of planes accepted, the number of layers that every device supports.
pub const MAX_PLANES: u32 = 256;

/// Casters flattened onto planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Planar {
    /// Maximum number of visible planes that face the light, 1 to [`MAX_PLANES`]. Each uses a layer
    /// of the camera's size.
    pub planes: u32,
}

impl Default for Planar {
    fn default() -> Self {
        Self { planes: 16 }
    }
}

impl ShadowTechnique for Planar {
    fn name(&self) -> &'static str {
        "planar"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        if !(1..=MAX_PLANES).contains(&self.planes) {
            let why = format!("are {}", self.planes);
            return Err(
                Invalid::new("planar planes", why, format!("use 1 to {MAX_PLANES}")).into(),
            );
        }
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles to find planes in: make it with `View::new`",
            ));
        };
        check_no_holes(geometry, "since casters are flattened as opaque")?;
        let light = homogeneous(view.light);
        let planes = Planes::find(view, geometry, light, self.planes as usize);
        if planes.planes.len() > self.planes as usize {
            return Err(RecipeError::unsupported_because(format!(
                "the visible lit receivers are in more than {} planes: raise `planes`, or use another technique for curved receivers",
                self.planes
            )));
        }
        Ok(recipe(view, geometry, &planes, light))
    }
}

impl ListedTechnique for Planar {
    const SUMMARY: &'static str = "casters flattened onto flat receivers, exact (Blinn 1988)";

    fn settings(&self) -> String {
        format!("up to {} planes", self.planes)
    }
}

/// Returns the recipe with one layer for each plane.
fn recipe(view: &View<'_>, geometry: &Geometry, planes: &Planes, light: Vec4) -> Recipe {
    // Flatten the casters onto each plane's layer.
    let space = InfiniteFarView::new(view, geometry).space;
    let mut casts = Vec::with_capacity(planes.planes.len());
    for (layer, &plane) in (0..).zip(&planes.planes) {
        let faces = flatten_casters(geometry, plane, light.as_dvec4(), planes.tolerance);
        casts.push(Cast {
            source: Source::Faces(Arc::new(faces)),
            ..Cast::nearest(0, layer, space)
        });
    }
    let layers = planes.planes.len().max(1) as u32;
    let rows = rows(&planes.of_triangle);
    let uniforms = PlanarUniforms {
        light,
        first: geometry.receivers().start,
    };
    Recipe {
        images: vec![ImageDesc {
            label: "flat shadows",
            size: view.camera.size,
            layers,
            format: Format::Depth32,
        }],
        tables: vec![Table {
            label: "planes of triangles",
            rows: rows.clone().into(),
        }],
        casts,
        filters: Vec::new(),
        receive: Receive {
            kernel: Arc::new(PlanarKernel { uniforms, rows }),
            inputs: vec![0],
            tables: vec![0],
        },
        shade: None,
        hierarchy: None,
        keep_images: false,
    }
}

/// Returns the triangles' plane numbers as a table, four in each row, with at least one row.
fn rows(of_triangle: &[u32]) -> Arc<[[u32; 4]]> {
    if of_triangle.is_empty() {
        return [[NO_PLANE; 4]].into();
    }
    let mut rows = Vec::with_capacity(of_triangle.len().div_ceil(4));
    for four in of_triangle.chunks(4) {
        let mut row = [NO_PLANE; 4];
        row[..four.len()].copy_from_slice(four);
        rows.push(row);
    }
    rows.into()
}

uniforms! {
    /// Uniforms of [`PlanarKernel`].
    pub struct PlanarUniforms {
        /// Centre of the light, homogeneous: a unit direction to it (w = 0) or its position (w =
        /// 1).
        pub light: Vec4,
        /// Id of the first receiving triangle, which is the first entry of the table.
        pub first: u32,
    }
}

/// Receive kernel: dark if the layer of the pixel's plane is covered or the surface faces away.
#[derive(Clone, Debug)]
pub struct PlanarKernel {
    uniforms: PlanarUniforms,
    rows: Arc<[[u32; 4]]>,
}

impl PlanarKernel {
    /// Returns the number of a triangle's plane, or [`NO_PLANE`].
    fn plane(&self, triangle: u32) -> u32 {
        let i = triangle.wrapping_sub(self.uniforms.first) as usize;
        self.rows.get(i / 4).map_or(NO_PLANE, |row| row[i % 4])
    }
}

impl Kernel for PlanarKernel {
    fn modules(&self) -> Vec<Module> {
        vec![FACING, module!("planar")]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }

    fn needs_triangles(&self) -> bool {
        true
    }
}

impl ReceiveKernel for PlanarKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let x = span.first.x as i32;
        let y = span.first.y as i32;
        for (i, out) in out.iter_mut().enumerate() {
            let away = turned_away(self.uniforms.light, span.position(i), span.normal(i));
            let plane = self.plane(span.triangle[i]);
            let is_lit = away == 0
                && (plane == NO_PLANE || inputs.images[0].load(x + i as i32, y, plane) >= 1.0);
            *out = if is_lit { 1.0 } else { 0.0 };
        }
    }
}
