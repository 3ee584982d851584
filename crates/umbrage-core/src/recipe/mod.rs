//! Recipes: shadow algorithms as plain data that any backend can execute.
//!
//! A recipe has these stages:
//!
//! * **cast**: draws a *source* from a light space. The source is casters, all geometry, or faces
//!   computed by the technique, in homogeneous coordinates so that they may extend to infinity. The
//!   image keeps the nearest depth, the nearest depth behind another image (peeling), or a count of
//!   faces behind the visible surface (stencil).
//! * **hierarchy**, on devices only: compute passes build it over the casters.
//! * **filter**: a kernel computes an image from images: moments, midpoints, packed depth.
//! * **receive**: a kernel computes the visibility of each receiver, 0 to 1. It may use comparison
//!   samplers.
//! * **shade**, for colour images only: a kernel computes the colour of each pixel, given the
//!   visibility. Colours are linear; `picture.rs` encodes sRGB.

pub(crate) mod device_hierarchy;
pub(crate) mod image;
pub(crate) mod kernel;
pub(crate) mod shader;
pub(crate) mod table_rows;
#[cfg(feature = "testing")]
pub(crate) mod twin;

use crate::{
    geometry::Geometry,
    invalid::{self, Invalid},
    light_space::{LightSpace, caster_set::CasterSet},
    recipe::{
        device_hierarchy::DeviceHierarchy,
        image::{Format, ImageDesc},
        kernel::{FilterKernel, ReceiveKernel, ShadeKernel},
        shader::UniformBlock,
        table_rows::TableRows,
    },
};
use glam::Vec4;
use std::{any::Any, ops::Range, sync::Arc};

/// Index into [`Recipe::images`].
pub type ImageId = usize;
/// Index into [`Recipe::tables`].
pub type TableId = usize;

/// Stages, executed in order: casts, the hierarchy if any, filters, receive, and optional shading.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The images that the stages write. Depth images start at 1, others at 0.
    pub images: Vec<ImageDesc>,
    /// Constant data for kernels, on the GPU read-only storage buffers.
    pub tables: Vec<Table>,
    /// Geometry drawn into images.
    pub casts: Vec<Cast>,
    /// Filter passes, which compute images from images.
    pub filters: Vec<Filter>,
    /// Computes the visibility of each receiver.
    pub receive: Receive,
    /// Shades visible geometry; `None` if only the mask is needed.
    pub shade: Option<Shade>,
    /// The hierarchy that devices build for the receive kernel's first tables, if any. Backends on
    /// the CPU don't need it.
    pub hierarchy: Option<DeviceHierarchy>,
    /// True to return the images in [`Shadows::images`](crate::Shadows::images).
    pub keep_images: bool,
}

/// Face culling of casters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Cull {
    /// Draw both sides.
    #[default]
    None,
    /// Cull faces towards the light; requires closed casters.
    Front,
    /// Cull faces away from the light; requires closed casters.
    Back,
}

/// Polygon offset, as in Vulkan and WebGPU: depth grows by `constant * r + slope * m`. Here m is
/// the greater of the triangle's depth slopes in x and y (clip depth per texel), and r the spacing
/// of floats at its greatest depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct RasterBias {
    /// Constant offset in units of r. For 32-bit images r is about 6e-8 near depth 1; for 16-bit
    /// images, one or two steps of 1/65536, depending on the device.
    #[cfg_attr(feature = "serde", serde(default))]
    pub constant: i32,
    /// Slope-scaled offset in units of m.
    #[cfg_attr(feature = "serde", serde(default))]
    pub slope: f32,
    /// Bound of the sum, clip depth; 0 for none, negative for a lower bound.
    #[cfg_attr(feature = "serde", serde(default))]
    pub clamp: f32,
}

/// A draw of geometry into one layer of an image, from a light or the camera.
#[derive(Clone, Debug)]
pub struct Cast {
    /// The target image: depth, or for [`CastMode::StencilDepthFail`] a [`Format::Stencil8`].
    pub image: ImageId,
    /// The target layer.
    pub layer: u32,
    /// View and projection.
    pub space: LightSpace,
    /// Geometry to draw.
    pub source: Source,
    /// Result to keep in the image.
    pub mode: CastMode,
    /// Face culling.
    pub cull: Cull,
    /// Polygon offset.
    pub bias: RasterBias,
}

impl Cast {
    /// Returns a cast that keeps the least depth of all casters, without culling and bias.
    pub fn nearest(image: ImageId, layer: u32, space: LightSpace) -> Self {
        Self {
            image,
            layer,
            space,
            source: Source::Casters,
            mode: CastMode::Depth,
            cull: Cull::None,
            bias: RasterBias::default(),
        }
    }
}

/// Geometry drawn by a cast.
#[derive(Clone, Debug, Default)]
pub enum Source {
    /// All casters.
    #[default]
    Casters,
    /// Some casters: rising ranges of the geometry's list of triangles, with gaps between them. The
    /// other casters are not visible in the image, so a backend without ranges may draw all.
    SomeCasters(Arc<[Range<u32>]>),
    /// All geometry that the camera may see: casters, receivers, and the rest.
    Everything,
    /// Faces that the technique computes from the casters, such as shadow volumes.
    Faces(Arc<Faces>),
}

impl Source {
    /// Returns the ranges of a geometry's list of triangles to draw, rising; empty for faces of a
    /// technique. Ranges are clipped to the casters.
    pub fn runs(&self, geometry: &Geometry) -> Vec<Range<u32>> {
        let casters = geometry.casters();
        let everything = 0..geometry.triangles().len() as u32;
        match self {
            Self::Casters => Vec::from([casters]),
            Self::Everything => Vec::from([everything]),
            Self::SomeCasters(runs) => runs
                .iter()
                .map(|run| run.start.max(casters.start)..run.end.min(casters.end))
                .filter(|run| !run.is_empty())
                .collect(),
            Self::Faces(_) => Vec::new(),
        }
    }
}

impl From<&CasterSet> for Source {
    fn from(casters: &CasterSet) -> Self {
        match casters {
            CasterSet::All => Self::Casters,
            CasterSet::Runs(runs) => Self::SomeCasters(runs.clone()),
        }
    }
}

/// Triangles computed by a technique. Backends may identify them by their address.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faces {
    /// Homogeneous world positions: (x, y, z, 1) is a point, (x, y, z, 0) a point at infinity in a
    /// direction.
    pub vertices: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Faces {
    /// Checks that the faces can be drawn.
    ///
    /// # Errors
    /// Errors if an index is beyond the vertices, or a vertex is not finite.
    pub fn validate(&self) -> Result<(), Invalid> {
        let count = self.vertices.len();
        let are_finite = self.vertices.iter().all(|v| v.is_finite());
        let mut indices = self.triangles.iter().flatten();
        let are_in_range = indices.all(|&v| (v as usize) < count);
        if are_finite && are_in_range {
            return Ok(());
        }
        let why = format!(
            "draws faces with an index beyond their {count} vertices, or a vertex that is not finite"
        );
        Err(Invalid::new("cast", why, "correct the faces"))
    }
}

/// Result of a cast that an image keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CastMode {
    /// The least depth at each texel.
    #[default]
    Depth,
    /// The least depth that is greater than that of this image at the same texel and layer: depth
    /// peeling (Everitt 2001, "Interactive order-independent transparency"). The image has the same
    /// size and format. No bias.
    DepthPeel(ImageId),
    /// Depth-fail counting (Everitt and Kilgard 2002, "Practical and robust stenciled shadow
    /// volumes"): the number of back faces minus front faces that are not in front of the depth in
    /// another image, modulo 256. The other image is a [`Format::Depth32`] of the same size and
    /// layer. No bias, no culling.
    StencilDepthFail {
        /// Depth image drawn earlier, in the same space.
        depth: ImageId,
    },
}

/// A pass that computes all layers of an image from other images.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The kernel.
    pub kernel: Arc<dyn FilterKernel>,
    /// Input images.
    pub inputs: Vec<ImageId>,
    /// Input tables.
    pub tables: Vec<TableId>,
    /// Output image; not among the inputs.
    pub output: ImageId,
}

impl Filter {
    /// Returns whether another filter computes the same texels from the same images and tables.
    /// Kernels are equal if they have the same type, WGSL and uniforms.
    pub fn is_like(&self, other: &Self) -> bool {
        // Destructure by name, so that a new field can't be forgotten here.
        let Self {
            kernel,
            inputs,
            tables,
            output,
        } = self;
        let bytes = |kernel: &dyn FilterKernel| kernel.uniforms().map(UniformBlock::uniform_bytes);
        let [own_type, other_type]: [&dyn Any; 2] = [&**kernel, &*other.kernel];
        *inputs == other.inputs
            && *tables == other.tables
            && *output == other.output
            && own_type.type_id() == other_type.type_id()
            && kernel.modules() == other.kernel.modules()
            && bytes(&**kernel) == bytes(&*other.kernel)
    }
}

/// The receive stage, which runs a kernel for each receiver.
#[derive(Clone, Debug)]
pub struct Receive {
    /// Computes the light's visibility.
    pub kernel: Arc<dyn ReceiveKernel>,
    /// Input images.
    pub inputs: Vec<ImageId>,
    /// Input tables.
    pub tables: Vec<TableId>,
}

/// The shade stage, which computes the colour of every pixel with a triangle, whether it receives
/// or not.
#[derive(Clone, Debug)]
pub struct Shade {
    /// The kernel.
    pub kernel: Arc<dyn ShadeKernel>,
    /// Input tables.
    pub tables: Vec<TableId>,
    /// Linear colour of empty pixels.
    pub background: [f32; 4],
}

/// Constant data: rows of four words. Cheap to clone; backends may identify it by its address.
#[derive(Clone, Debug)]
pub struct Table {
    /// Label for error messages.
    pub label: &'static str,
    /// The rows; at least one.
    pub rows: TableRows,
}

impl Table {
    /// Returns the rows; computes them on first use.
    pub fn rows(&self) -> &Arc<[[u32; 4]]> {
        self.rows.get()
    }
}

/// Limits of a backend.
#[derive(Clone, Copy, Debug)]
pub struct BackendLimits {
    /// Greatest image side, texels.
    pub image_side: u32,
    /// Greatest number of layers.
    pub layers: u32,
    /// Greatest table, bytes.
    pub table_bytes: u64,
}

impl Recipe {
    /// Returns the bytes of all images.
    pub fn image_bytes(&self) -> u64 {
        self.images.iter().map(ImageDesc::bytes).sum()
    }

    /// Returns the bytes of all tables; computes those that are not yet computed.
    pub fn table_bytes(&self) -> u64 {
        let bytes = |table: &Table| size_of_val::<[[u32; 4]]>(table.rows()) as u64;
        self.tables.iter().map(bytes).sum()
    }

    /// Returns the bytes of the tables computed so far.
    pub fn made_table_bytes(&self) -> u64 {
        let made = self
            .tables
            .iter()
            .filter_map(|table| table.rows.made_rows());
        made.map(|rows| size_of_val::<[[u32; 4]]>(rows) as u64)
            .sum()
    }

    /// Computes all tables that are not yet computed.
    pub fn make_tables(&self) {
        for table in &self.tables {
            table.rows();
        }
    }

    /// Checks that a backend with these limits can execute the recipe. Only checks tables that were
    /// computed already: call [`make_tables`](Self::make_tables) first to check all.
    ///
    /// # Errors
    /// Errors with the first fault found: sizes of zero or beyond the limits, invalid ids, formats
    /// that don't fit a stage, numbers that are not finite.
    pub fn validate(&self, limits: &BackendLimits) -> Result<(), Invalid> {
        // Check images and tables against the limits.
        for image in &self.images {
            check_image(image, limits)?;
        }
        for table in &self.tables {
            let Some(rows) = table.rows.made_rows() else {
                continue;
            };
            let bytes = size_of_val::<[[u32; 4]]>(rows) as u64;
            if bytes == 0 || bytes > limits.table_bytes {
                let why = format!(
                    "takes {bytes} bytes, and this backend supports 1 to {}",
                    limits.table_bytes
                );
                return Err(Invalid::new(
                    format!("table `{}`", table.label),
                    why,
                    "use a smaller scene",
                ));
            }
        }
        // Check the stages.
        for (i, cast) in self.casts.iter().enumerate() {
            check_numbers(cast).map_err(|e| e.within_context(format!("cast {i}")))?;
            self.check_cast(cast)?;
        }
        for filter in &self.filters {
            self.check_filter(filter)?;
        }
        self.check_ids("receive", &self.receive.inputs, &self.receive.tables)?;
        self.check_hierarchy()?;
        self.check_compared()?;
        match &self.shade {
            Some(shade) => self.check_ids("shading", &[], &shade.tables),
            None => Ok(()),
        }
    }

    /// Checks that all casts support the geometry's alpha-tested triangles.
    ///
    /// # Errors
    /// Errors if a cast counts faces of alpha-tested triangles: counts have no triangle ids for the
    /// alpha test.
    pub fn check_holes(&self, geometry: &Geometry) -> Result<(), Invalid> {
        let counts = |cast: &Cast| {
            let is_counted = matches!(cast.mode, CastMode::StencilDepthFail { .. });
            is_counted && !matches!(cast.source, Source::Faces(_))
        };
        if geometry.cut_outs().is_none() || !self.casts.iter().any(counts) {
            return Ok(());
        }
        let why = "counts faces of alpha-tested triangles";
        let help = "count faces computed by the technique, or remove `Material::alpha`";
        Err(Invalid::new("cast", why, help))
    }

    /// Errors if the hierarchy is not valid, or the receive kernel lacks its tables. `check_ids` has
    /// checked the ids.
    fn check_hierarchy(&self) -> Result<(), Invalid> {
        let Some(hierarchy) = &self.hierarchy else {
            return Ok(());
        };
        let refuse = |why: String, help: &str| Err(Invalid::new("recipe", why, help));
        let [first, corners, ..] = self.receive.tables[..] else {
            let tables = self.receive.tables.len();
            let why = format!("has a hierarchy, and its receive kernel reads {tables} tables");
            let help =
                "give the kernel a table for the hierarchy, and one with the casters' corners";
            return refuse(why, help);
        };
        if first == corners {
            let why =
                format!("has its hierarchy and the casters' corners in the same table, {first}");
            return refuse(why, "use two tables");
        }
        let rows = self.tables[corners].rows.made_rows();
        let rows = rows.map_or(0, |rows| rows.len());
        if !rows.is_multiple_of(3) {
            let why = format!("has {rows} rows of casters' corners for its hierarchy");
            return refuse(why, "use three rows a caster");
        }
        let bytes = hierarchy.uniforms.len();
        if bytes == 0 || !bytes.is_multiple_of(16) {
            let why = format!("has {bytes} bytes of uniforms for its hierarchy");
            return refuse(why, "use those of a `UniformBlock`");
        }
        Ok(())
    }

    fn check_filter(&self, filter: &Filter) -> Result<(), Invalid> {
        self.check_ids("filter", &filter.inputs, &filter.tables)?;
        let can_write = match self.images.get(filter.output) {
            Some(image) => !image.format.is_cast_only(),
            None => false,
        };
        if can_write && !filter.inputs.contains(&filter.output) {
            return Ok(());
        }
        let why = format!("writes image {}", filter.output);
        let help = "write an image that is no input and has neither a depth nor a stencil format";
        Err(Invalid::new("filter", why, help))
    }

    fn check_cast(&self, cast: &Cast) -> Result<(), Invalid> {
        let Some(image) = self.image_with_layer(cast.image, cast.layer) else {
            let why = format!("refers to layer {} of image {}", cast.layer, cast.image);
            let help = "use a layer of an image of the recipe";
            return Err(Invalid::new("cast", why, help));
        };
        let fits_mode = match cast.mode {
            CastMode::Depth => {
                if !image.format.is_depth() {
                    let why = format!("writes image {}", cast.image);
                    return Err(Invalid::new("cast", why, "use an image of depth format"));
                }
                true
            }
            CastMode::DepthPeel(other) => self.can_peel(cast, image, other),
            CastMode::StencilDepthFail { depth } => self.can_count(cast, image, depth),
        };
        if !fits_mode {
            let why = format!(
                "into image {} uses {:?} with {:?} and {:?}",
                cast.image, cast.mode, cast.cull, cast.bias
            );
            let help = "peel behind another depth image of the same kind, or count into a Stencil8 image against a \
                        Depth32 image of its size; peels without bias, counts without culling";
            return Err(Invalid::new("cast", why, help));
        }
        match &cast.source {
            Source::Casters | Source::Everything => Ok(()),
            Source::SomeCasters(runs) => check_runs(runs),
            Source::Faces(faces) => faces.validate(),
        }
    }

    /// Returns whether a cast into `image` can peel the same layer of `other`.
    fn can_peel(&self, cast: &Cast, image: &ImageDesc, other: ImageId) -> bool {
        let Some(peeled) = self.image_with_layer(other, cast.layer) else {
            return false;
        };
        let is_like = peeled.size == image.size
            && peeled.layers == image.layers
            && peeled.format == image.format;
        // Reject a bias: a surface would be behind its own depth of the last peel, and would be
        // peeled repeatedly.
        let is_biased = cast.bias != RasterBias::default();
        is_like && image.format.is_depth() && other != cast.image && !is_biased
    }

    /// Returns whether a cast into `image` can count against the same layer of `depth`.
    fn can_count(&self, cast: &Cast, image: &ImageDesc, depth: ImageId) -> bool {
        let Some(depth) = self.image_with_layer(depth, cast.layer) else {
            return false;
        };
        let is_like = depth.size == image.size && depth.layers == image.layers;
        let fits = image.format == Format::Stencil8 && depth.format == Format::Depth32;
        is_like && fits && cast.cull == Cull::None
    }

    /// Returns an image, or `None` if the id is invalid or the image has no such layer.
    fn image_with_layer(&self, id: ImageId, layer: u32) -> Option<&ImageDesc> {
        self.images.get(id).filter(|image| layer < image.layers)
    }

    /// Errors if the receive kernel compares, but reads no depth image: comparison samplers only
    /// read depth.
    fn check_compared(&self) -> Result<(), Invalid> {
        let reads_depth = self
            .receive
            .inputs
            .iter()
            .filter_map(|&id| self.images.get(id))
            .any(|image| image.format.is_depth());
        if reads_depth || !self.receive.kernel.compares() {
            return Ok(());
        }
        Err(Invalid::new(
            "receive",
            "compares, but reads no depth image",
            "add a depth image to its inputs",
        ))
    }

    /// Errors if the stage `what` reads an image or a table that the recipe doesn't have.
    fn check_ids(&self, what: &str, images: &[ImageId], tables: &[TableId]) -> Result<(), Invalid> {
        check_ids_below(what, "image", images, self.images.len())?;
        check_ids_below(what, "table", tables, self.tables.len())
    }
}

fn check_ids_below(what: &str, kind: &str, ids: &[usize], count: usize) -> Result<(), Invalid> {
    match ids.iter().find(|&&id| id >= count) {
        None => Ok(()),
        Some(id) => {
            let why = format!("reads {kind} {id} of {count}");
            Err(Invalid::new(what, why, "use an index of the recipe"))
        }
    }
}

fn check_runs(runs: &[Range<u32>]) -> Result<(), Invalid> {
    let mut end = 0;
    for run in runs {
        if run.start < end || run.is_empty() {
            let why = format!("draws the triangles {runs:?}");
            return Err(Invalid::new(
                "cast",
                why,
                "use rising ranges that do not overlap and are not empty",
            ));
        }
        end = run.end;
    }
    Ok(())
}

fn check_numbers(cast: &Cast) -> Result<(), Invalid> {
    invalid::finite(
        "view from world",
        &cast.space.view_from_world.to_cols_array(),
    )?;
    invalid::finite("clip from view", &cast.space.clip_from_view.to_cols_array())?;
    // The product of two finite matrices may not be finite.
    invalid::finite(
        "clip from world",
        &cast.space.clip_from_world().to_cols_array(),
    )?;
    invalid::finite("bias", &[cast.bias.slope, cast.bias.clamp])
}

fn check_image(image: &ImageDesc, limits: &BackendLimits) -> Result<(), Invalid> {
    let what = format!("image `{}`", image.label);
    if image.size.min_element() == 0 || image.size.max_element() > limits.image_side {
        let why = format!("is {} x {} texels", image.size.x, image.size.y);
        let help = format!("use 1 to {} on each side", limits.image_side);
        return Err(Invalid::new(what, why, help));
    }
    if image.layers == 0 || image.layers > limits.layers {
        let why = format!("has {} layers", image.layers);
        let help = format!("use 1 to {}", limits.layers);
        return Err(Invalid::new(what, why, help));
    }
    Ok(())
}
