//! Recipes: a shadow algorithm as plain data, to be played by any backend.

use crate::{FilterKernel, Format, ImageDesc, Invalid, LightSpace, ReceiveKernel};
use std::sync::Arc;

/// Index into [`Recipe::images`].
pub type ImageId = usize;
/// Index into [`Recipe::tables`].
pub type TableId = usize;

/// Three stages, played in order: casts, filters, receive.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The images that the stages write. Depth images start at 1, others at 0.
    pub images: Vec<ImageDesc>,
    /// Constant data for kernels, on the GPU read-only storage buffers.
    pub tables: Vec<Table>,
    /// Geometry drawn into images.
    pub casts: Vec<Cast>,
    /// Images made from images.
    pub filters: Vec<Filter>,
    /// The question asked at each receiver.
    pub receive: Receive,
    /// Whether the backend is to hand the images back in [`Shadows::images`](crate::Shadows::images).
    pub keep_images: bool,
}

/// Which casters' faces are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cull {
    /// Draw both sides.
    #[default]
    None,
    /// Leave out faces turned to the light: needs closed casters.
    Front,
    /// Leave out faces turned away from the light: needs closed casters.
    Back,
}

/// Polygon offset, as Vulkan and WebGPU define it: depth grows by `constant * r + slope * m`, where m is the greater of
/// the triangle's depth slopes in x and y (clip depth a texel) and r the spacing of floats at its greatest depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RasterBias {
    /// In units of r: about 6e-8 near depth 1.
    #[serde(default)]
    pub constant: i32,
    /// In units of m.
    #[serde(default)]
    pub slope: f32,
    /// Bound of the sum, clip depth; 0 for none, negative for a lower bound.
    #[serde(default)]
    pub clamp: f32,
}

/// Draws the casters, seen from a light, into one layer of a depth image; the least depth stays.
#[derive(Clone, Debug)]
pub struct Cast {
    /// The depth image.
    pub image: ImageId,
    /// Its layer.
    pub layer: u32,
    /// Where it is seen from.
    pub space: LightSpace,
    /// Faces left out.
    pub cull: Cull,
    /// Polygon offset.
    pub bias: RasterBias,
}

/// Makes all layers of an image from other images.
#[derive(Clone, Debug)]
pub struct Filter {
    /// What it does.
    pub kernel: Arc<dyn FilterKernel>,
    /// Images read.
    pub inputs: Vec<ImageId>,
    /// Tables read.
    pub tables: Vec<TableId>,
    /// Image written; not among the inputs.
    pub output: ImageId,
}

/// Asks each receiver.
#[derive(Clone, Debug)]
pub struct Receive {
    /// What is asked.
    pub kernel: Arc<dyn ReceiveKernel>,
    /// Images read.
    pub inputs: Vec<ImageId>,
    /// Tables read.
    pub tables: Vec<TableId>,
}

/// Constant data: rows of four words. Cheap to clone; backends may recognise it by its address.
#[derive(Clone, Debug)]
pub struct Table {
    /// For error messages.
    pub label: &'static str,
    /// The rows; at least one.
    pub rows: Arc<[[u32; 4]]>,
}

/// What a backend can hold.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Greatest image side, texels.
    pub image_side: u32,
    /// Greatest number of layers.
    pub layers: u32,
    /// Greatest table, bytes.
    pub table_bytes: u64,
}

impl Recipe {
    /// Bytes of all images.
    pub fn image_bytes(&self) -> u64 {
        self.images.iter().map(ImageDesc::bytes).sum()
    }

    /// Bytes of all tables.
    pub fn table_bytes(&self) -> u64 {
        self.tables.iter().map(|t| 16 * t.rows.len() as u64).sum()
    }

    /// Objects to what no player could play: sizes of zero or beyond the limits, and ids that name nothing.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self, limits: &Limits) -> Result<(), Invalid> {
        self.images.iter().try_for_each(|i| check_image(i, limits))?;
        for table in &self.tables {
            let bytes = 16 * table.rows.len() as u64;
            if bytes == 0 || bytes > limits.table_bytes {
                let why = format!("takes {bytes} bytes, and this backend holds 1 to {}", limits.table_bytes);
                return Err(Invalid::new(format!("table `{}`", table.label), why, "use a smaller scene"));
            }
        }
        for cast in &self.casts {
            let image = self.images.get(cast.image);
            if !image.is_some_and(|i| i.format == Format::Depth32 && cast.layer < i.layers) {
                let why = format!("names layer {} of image {}", cast.layer, cast.image);
                return Err(Invalid::new("cast", why, "name a layer of a Depth32 image of the recipe"));
            }
        }
        for filter in &self.filters {
            self.check_ids("filter", &filter.inputs, &filter.tables)?;
            let image = self.images.get(filter.output);
            if filter.inputs.contains(&filter.output) || !image.is_some_and(|i| i.format != Format::Depth32) {
                let why = format!("writes image {}", filter.output);
                return Err(Invalid::new("filter", why, "write an image that it doesn't read and that holds no depth"));
            }
        }
        self.check_ids("receive", &self.receive.inputs, &self.receive.tables)
    }

    fn check_ids(&self, what: &str, images: &[ImageId], tables: &[TableId]) -> Result<(), Invalid> {
        let missing = |ids: &[usize], count: usize| ids.iter().find(|&&i| i >= count).copied();
        for (kind, ids, count) in [("image", images, self.images.len()), ("table", tables, self.tables.len())] {
            if let Some(i) = missing(ids, count) {
                return Err(Invalid::new(what, format!("reads {kind} {i} of {count}"), "name one of the recipe's"));
            }
        }
        Ok(())
    }
}

fn check_image(image: &ImageDesc, limits: &Limits) -> Result<(), Invalid> {
    let what = || format!("image `{}`", image.label);
    if image.size.min_element() == 0 || image.size.max_element() > limits.image_side {
        let why = format!("is {} x {} texels", image.size.x, image.size.y);
        return Err(Invalid::new(what(), why, format!("use 1 to {} on each side", limits.image_side)));
    }
    if image.layers == 0 || image.layers > limits.layers {
        return Err(Invalid::new(
            what(),
            format!("has {} layers", image.layers),
            format!("use 1 to {}", limits.layers),
        ));
    }
    Ok(())
}
