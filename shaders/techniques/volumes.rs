//! Shadow volumes: the region that each caster hides from the light is a solid. A visible point is
//! lit if it is in none of them.
//!
//! Crow 1977, "Shadow algorithms for computer graphics". Counting uses depth-fail, which is
//! independent of the eye's position: Everitt and Kilgard 2002, "Practical and robust stenciled
//! shadow volumes for hardware-accelerated rendering"; McGuire et al. 2003, "Fast, practical and
//! robust shadows". Along a pixel's ray, only faces that are not before the visible surface count.
//! The number of back faces minus the number of front faces is the number of volumes around the
//! surface. Volumes extend beyond all geometry, and the view has no far plane to cut them.
//!
//! - Closed casters extrude the edges between faces turned to the light and faces turned away. All
//!   others, and those with the light inside their bounds, extrude each triangle. Edges that two of
//!   these share cancel (Bergeron 1986, "A general version of Crow's shadow volumes"). Triangles
//!   are split where a corner of one is on another's edge.
//! - A lit surface is its own volume's cap. The depth image holds every cap as it is drawn. So no
//!   cap is ever before the visible surface, and no bias is needed.
//! - Edges are as sharp as pixels; there is no map. Area lights count as their centre.
//!
//! Known failures:
//!
//! - The fill cost of the volumes' faces dominates; they often cover the image many times. So this
//!   is a reference technique: silhouettes found on the device would draw the same faces.
//! - Alpha-tested casters are refused, since outlines ignore textures.
//! - Counts wrap, so a point under exactly 256 surfaces (or 512, ..) is lit.
//! - At grazing light, the volume's side is within the rounding of the surface's depth, about 2^-23
//!   w^2 / near metres at distance w. Pixels there are noise. If the light grazes whole planes, it
//!   is lifted off them, and refused if that is not enough: `grazing.rs`.
//! - A closed mesh that is turned inside out in one part is lit inside that part.

mod clip_window;
mod depth_clamp;
mod extrusion;
mod grazing;
mod silhouette;
mod t_junctions;

use crate::{
    listing::ListedTechnique,
    shading::facing::{FACING, homogeneous, turned_away},
    techniques::{
        check_no_holes,
        infinite_far::InfiniteFarView,
        volumes::{
            clip_window::ClipWindow,
            depth_clamp::flatten,
            extrusion::{beyond_all, caps_not_in_scene, extrude},
            grazing::{LiftedLight, MIN_SHARE},
            silhouette::CasterShells,
        },
    },
};
use glam::Vec4;
use std::sync::Arc;
use umbrage_core::{
    Cast, CastMode, Faces, Format, ImageDesc, Inputs, Kernel, Module, RasterBias, Receive,
    ReceiveKernel, Recipe, RecipeError, ShadowTechnique, Source, Span, UniformBlock, View, module,
    uniforms,
};

/// Offset of the volumes' faces away from the eye. A wall that begins at the edge of a visible
/// surface has the surface's depth there, and rounding must not move it before the surface. On
/// devices that snap vertices to a coarse grid, pixel centres are often exactly on edges. A slope
/// of 1/1024 moves faces as 1/1024 pixel on the image would; 4 units cover their own rounding.
const BEHIND: RasterBias = RasterBias {
    constant: 4,
    slope: 1.0 / 1024.0,
    clamp: 0.0,
};

/// Stencil shadow volumes. There are no settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ShadowVolumes {}

impl ShadowTechnique for ShadowVolumes {
    fn name(&self) -> &'static str {
        "volumes"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles to build volumes from: make it with `View::new`",
            ));
        };
        check_no_holes(
            geometry,
            "since volumes are built from outlines of opaque casters",
        )?;
        // Lift the light off planes that it grazes.
        let light = homogeneous(view.light);
        let infinite_far = InfiniteFarView::new(view, geometry);
        let lifted = LiftedLight::new(geometry, light.as_dvec4());
        let lost = match view.receivers {
            Some(receivers) => lifted.share_lost(view, receivers, &infinite_far),
            None => 0.0,
        };
        if lost > MIN_SHARE {
            let reason = format!(
                "the light grazes the planes of {:.1} % of the visible receivers, and depth is too coarse to separate them from the \
                 volumes' sides: move the light, or use rays",
                100.0 * lost
            );
            return Err(RecipeError::unsupported_because(reason));
        }
        // Find the silhouette, and extrude it beyond the scene.
        let casters = geometry.derive_once(CasterShells::new);
        let mesh = &casters.mesh;
        let silhouette = casters.silhouette(lifted.light);
        let window = ClipWindow::new(&infinite_far.space, view.camera.size);
        let reach = beyond_all(&geometry.bounds(), mesh, &silhouette, lifted.light);
        let mut faces = extrude(mesh, &silhouette, lifted.light, Some(&window), reach);
        if let Some(clamp_plane) = &infinite_far.clamp_plane {
            faces = flatten(&faces, clamp_plane);
        }
        let missing_caps = caps_not_in_scene(mesh, &silhouette);
        Ok(recipe(view, &infinite_far, faces, missing_caps, light))
    }
}

impl ListedTechnique for ShadowVolumes {
    const SUMMARY: &'static str =
        "stencil shadow volumes, exact (Crow 1977; Everitt, Kilgard 2002)";

    fn settings(&self) -> String {
        "depth-fail".to_owned()
    }
}

/// Returns the recipe that counts `faces` behind the visible geometry. Image 0 holds the nearest
/// depths of the whole geometry and of `missing_caps`, image 1 the counts.
fn recipe(
    view: &View<'_>,
    infinite_far: &InfiniteFarView,
    faces: Faces,
    missing_caps: Faces,
    light: Vec4,
) -> Recipe {
    // Describe the images.
    let depth = ImageDesc {
        label: "seen depth",
        size: view.camera.size,
        layers: 1,
        format: Format::Depth32,
    };
    let counts = ImageDesc {
        label: "volume count",
        format: Format::Stencil8,
        ..depth
    };
    // Draw the nearest depths of the scene and of caps that it lacks.
    let space = infinite_far.space;
    let mut casts = vec![Cast {
        source: Source::Everything,
        ..Cast::nearest(0, 0, space)
    }];
    if !missing_caps.triangles.is_empty() {
        casts.push(Cast {
            source: Source::Faces(Arc::new(missing_caps)),
            ..Cast::nearest(0, 0, space)
        });
    }
    // Count the volumes' faces behind them.
    casts.push(Cast {
        source: Source::Faces(Arc::new(faces)),
        mode: CastMode::StencilDepthFail { depth: 0 },
        bias: BEHIND,
        ..Cast::nearest(1, 0, space)
    });
    Recipe {
        images: vec![depth, counts],
        tables: Vec::new(),
        casts,
        filters: Vec::new(),
        receive: Receive {
            kernel: Arc::new(VolumesKernel(VolumesUniforms { light })),
            inputs: vec![1],
            tables: Vec::new(),
        },
        shade: None,
        hierarchy: None,
        keep_images: false,
    }
}

uniforms! {
    /// Uniforms of [`VolumesKernel`].
    pub struct VolumesUniforms {
        /// Centre of the light, homogeneous: a unit direction to it (w = 0) or its position (w =
        /// 1).
        pub light: Vec4,
    }
}

/// Receive kernel: lit if the pixel's count is 0 and its surface does not face away.
#[derive(Clone, Copy, Debug)]
pub struct VolumesKernel(
    /// Direction or position of the light.
    pub VolumesUniforms,
);

impl Kernel for VolumesKernel {
    fn modules(&self) -> Vec<Module> {
        vec![FACING, module!("volumes")]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for VolumesKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let image = &inputs.images[0];
        let first = image.index(span.first.x as i32, span.first.y as i32, 0);
        let counts = &image.texels[first..first + out.len()];
        for (i, (out, &count)) in out.iter_mut().zip(counts).enumerate() {
            let away = turned_away(self.0.light, span.position(i), span.normal(i));
            *out = if away == 0 && count == 0.0 { 1.0 } else { 0.0 };
        }
    }
}
