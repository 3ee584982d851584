//! The caller's input for one frame: casters in its own buffers, and the G-buffer of its camera.

use crate::device::later_errors::ApiErrors;
use glam::{Affine3A, UVec2};
use std::ops::Range;
use umbrage_core::{BackendError, Invalid, Recipe, Source, invalid};
use wgpu::{
    Buffer, BufferUsages, IndexFormat, Limits, Texture, TextureFormat, TextureUsages, TextureView,
    VertexFormat,
};

/// Options of a renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RendererOptions {
    /// Index of the bind group of the receive kernel's resources, so that
    /// [`receive_wgsl`](crate::receive_wgsl) and
    /// [`ShadowRenderer::receive_bind_group`](crate::ShadowRenderer::receive_bind_group) can be
    /// used in the caller's shaders.
    pub kernel_group: u32,
    /// Time at which errors of the graphics API are reported.
    pub errors: ApiErrors,
}

impl RendererOptions {
    /// Returns the index of the G-buffer's bind group: 0, or 1 if the kernel's is 0.
    pub(crate) fn gbuffer_group(self) -> u32 {
        u32::from(self.kernel_group == 0)
    }
}

/// One frame's casters and receivers.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs<'a> {
    /// Size of the mask and of the receivers' textures, pixels.
    pub size: UVec2,
    /// Casters, drawn by casts of [`Source::Casters`].
    pub casters: &'a [Drawable<'a>],
    /// All visible geometry: casters, receivers, and the rest. Drawn by casts of
    /// [`Source::Everything`]; may be empty for recipes without such casts.
    pub everything: &'a [Drawable<'a>],
    /// The visible surface points.
    pub receivers: GBuffer<'a>,
}

/// Triangles in the caller's buffers.
#[derive(Clone, Debug)]
pub struct Drawable<'a> {
    /// Vertices, usage `VERTEX`.
    pub vertices: &'a Buffer,
    /// Layout of the positions in the vertex buffer.
    pub layout: VertexLayout,
    /// Vertex indices; `None` if every three vertices are a triangle.
    pub indices: Option<Indices<'a>>,
    /// Range of indices to draw, or of vertices if there are no indices.
    pub range: Range<u32>,
    /// Transform to world space; `None` if the vertices are already in world space, which is
    /// cheaper.
    pub world_from_local: Option<Affine3A>,
    /// Ids of the triangles in `range`, in the same order, in the
    /// [`Geometry`](umbrage_core::Geometry) for which the technique was planned. Casts that need
    /// only some casters then draw only these. `None` to always draw all triangles.
    pub triangles: Option<Range<u32>>,
}

/// Indices in the caller's buffer.
#[derive(Clone, Copy, Debug)]
pub struct Indices<'a> {
    /// Usage `INDEX`.
    pub buffer: &'a Buffer,
    /// 16 or 32 bits.
    pub format: IndexFormat,
}

/// Format of positions in a vertex buffer. A fourth component is not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PositionFormat {
    /// Three 32-bit floats, 12 bytes.
    #[default]
    Float32x3,
    /// Four 16-bit floats, 8 bytes.
    Float16x4,
    /// Four 16-bit normalized integers for -1..=1, 8 bytes.
    Snorm16x4,
}

impl PositionFormat {
    /// Returns the bytes of a position.
    pub const fn bytes(self) -> u64 {
        match self {
            Self::Float32x3 => 12,
            Self::Float16x4 | Self::Snorm16x4 => 8,
        }
    }

    pub(crate) const fn vertex_format(self) -> VertexFormat {
        match self {
            Self::Float32x3 => VertexFormat::Float32x3,
            Self::Float16x4 => VertexFormat::Float16x4,
            Self::Snorm16x4 => VertexFormat::Snorm16x4,
        }
    }
}

/// Layout of positions in a vertex buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VertexLayout {
    /// Format of a position.
    pub format: PositionFormat,
    /// Bytes from one vertex to the next: a multiple of 4, at least the size of a position.
    pub stride: u64,
    /// Bytes from the start of a vertex to its position: a multiple of 4, at most the stride minus
    /// the size of a position.
    pub position_offset: u64,
}

impl VertexLayout {
    /// Tightly packed positions of three 32-bit floats.
    pub const PACKED: Self = Self {
        format: PositionFormat::Float32x3,
        stride: 12,
        position_offset: 0,
    };
}

/// The visible surface points: textures of [`FrameInputs::size`] with usage `TEXTURE_BINDING`.
///
/// The layout is plain, at the cost of two channels of unused precision. An engine with its own
/// G-buffer can copy it in one full-screen pass, or compute this one from depth with
/// [`GBufferFromDepth`](crate::GBufferFromDepth).
#[derive(Clone, Copy, Debug)]
pub struct GBuffer<'a> {
    /// `Rgba32Float`: world position; w is 1 for pixels that receive shadows and 0 for others.
    pub position: &'a TextureView,
    /// `Rgba32Float`: geometric unit normal in world space, turned to the camera, 0 for empty
    /// pixels; w is not read.
    pub normal: &'a TextureView,
    /// `R32Uint`: triangle ids, [`NO_TRIANGLE`](umbrage_core::NO_TRIANGLE) for empty pixels. Needed
    /// by kernels that read ids (ray tracing uses them to prevent self-shadowing), and by recipes
    /// that shade. These shade every pixel with an id, so its position and normal must be valid
    /// even if it doesn't receive shadows.
    pub triangle: Option<&'a TextureView>,
}

impl GBuffer<'_> {
    /// Errors if a texture has another format, size or usage.
    pub(crate) fn validate(&self, size: UVec2) -> Result<(), BackendError> {
        check(self.position, "position", TextureFormat::Rgba32Float, size)?;
        check(self.normal, "normal", TextureFormat::Rgba32Float, size)?;
        self.triangle.map_or(Ok(()), |triangle| {
            check(triangle, "triangle", TextureFormat::R32Uint, size)
        })
    }
}

impl FrameInputs<'_> {
    /// Errors if the device would fail. The device reports errors later and less clearly, some of
    /// them only when the caller submits.
    pub(crate) fn validate(&self, recipe: &Recipe, limits: &Limits) -> Result<(), BackendError> {
        for (what, drawables) in [("caster", self.casters), ("everything", self.everything)] {
            for (i, drawable) in drawables.iter().enumerate() {
                drawable
                    .validate(limits)
                    .map_err(|e| e.within_context(format!("{what} {i}")))?;
            }
        }
        self.check_everything(recipe)?;
        self.check_triangles(recipe)?;
        self.receivers.validate(self.size)?;
        Ok(())
    }

    /// Errors if a cast draws all geometry, but the frame only lists casters. A frame without
    /// casters is valid: the caller draws all casts itself.
    fn check_everything(&self, recipe: &Recipe) -> Result<(), Invalid> {
        let needed = recipe
            .casts
            .iter()
            .any(|c| matches!(c.source, Source::Everything));
        if !needed || !self.everything.is_empty() || self.casters.is_empty() {
            return Ok(());
        }
        let why = "has casters only, but a cast of the recipe draws all geometry";
        Err(Invalid::new(
            "frame",
            why,
            "list all that the camera may see in `FrameInputs::everything`",
        ))
    }

    fn check_triangles(&self, recipe: &Recipe) -> Result<(), Invalid> {
        let needed = recipe.shade.is_some() || recipe.receive.kernel.needs_triangles();
        if !needed || self.receivers.triangle.is_some() {
            return Ok(());
        }
        let help =
            "add triangle ids as `GBuffer::triangle`, or use a recipe that doesn't need them";
        Err(Invalid::new(
            "frame",
            "has no triangle ids, which this recipe needs",
            help,
        ))
    }
}

/// Triangles in the caller's buffers, without their placement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BufferedTriangles<'a> {
    pub(crate) vertices: &'a Buffer,
    pub(crate) layout: VertexLayout,
    pub(crate) indices: Option<Indices<'a>>,
    pub(crate) range: &'a Range<u32>,
}

impl BufferedTriangles<'_> {
    /// Returns the unit of the range: indices, or vertices if there are none.
    const fn unit_name(&self) -> &'static str {
        match self.indices {
            Some(_) => "indices",
            None => "vertices",
        }
    }

    /// Errors if a buffer lacks its usage, or doesn't contain the range.
    pub(crate) fn validate(&self, limits: &Limits) -> Result<(), Invalid> {
        self.layout.validate(limits)?;
        check_buffer(
            self.vertices,
            "vertex buffer",
            BufferUsages::VERTEX,
            "VERTEX",
        )?;
        if let Some(Indices { buffer, .. }) = self.indices {
            check_buffer(buffer, "index buffer", BufferUsages::INDEX, "INDEX")?;
        }
        self.check_range()
    }

    fn check_range(&self) -> Result<(), Invalid> {
        let range = self.range;
        let vertices = self.layout.vertices(self.vertices.size());
        let count = match &self.indices {
            Some(indices) => indices.buffer.size() / indices.format.byte_size() as u64,
            None => vertices,
        };
        if range.start > range.end {
            let why = format!("start at {} and end at {}", range.start, range.end);
            return Err(Invalid::new(self.unit_name(), why, "swap start and end"));
        }
        if u64::from(range.end) > count {
            let why = format!("end at {}, and the buffer holds {count}", range.end);
            return Err(Invalid::new(
                self.unit_name(),
                why,
                "use a range within the buffer",
            ));
        }
        let drawn = range.end - range.start;
        if !drawn.is_multiple_of(3) {
            let why = format!("are {drawn}, which is no multiple of three");
            let help = "use a range of whole triangles";
            return Err(Invalid::new(self.unit_name(), why, help));
        }
        if vertices == 0 && !range.is_empty() {
            return Err(Invalid::new(
                "vertex buffer",
                "holds no vertex",
                "remove the caster",
            ));
        }
        Ok(())
    }
}

impl Drawable<'_> {
    fn validate(&self, limits: &Limits) -> Result<(), Invalid> {
        let triangles = BufferedTriangles {
            vertices: self.vertices,
            layout: self.layout,
            indices: self.indices,
            range: &self.range,
        };
        triangles.validate(limits)?;
        if let Some(place) = self.world_from_local {
            invalid::finite("world from local", &place.to_cols_array())?;
        }
        self.check_triangles(triangles.unit_name())
    }

    /// Errors if there are ids, but not one for each drawn triangle.
    fn check_triangles(&self, what: &str) -> Result<(), Invalid> {
        let Some(triangles) = &self.triangles else {
            return Ok(());
        };
        let named = 3 * u64::from(triangles.end.saturating_sub(triangles.start));
        let drawn = u64::from(self.range.end - self.range.start);
        if named == drawn {
            return Ok(());
        }
        let why = format!("are {drawn}, but the triangles {triangles:?} have {named}");
        Err(Invalid::new(
            what,
            why,
            "list the ids of the triangles in the range, or none",
        ))
    }
}

impl VertexLayout {
    fn validate(self, limits: &Limits) -> Result<(), Invalid> {
        let stride = self.stride;
        let offset = self.position_offset;
        let position = self.format.bytes();
        let most = u64::from(limits.max_vertex_buffer_array_stride);
        if !stride.is_multiple_of(4) || stride < position || stride > most {
            let help = format!(
                "use a multiple of 4 from {position} to {most}: a position takes {position} bytes"
            );
            let why = format!("is {stride} bytes");
            return Err(Invalid::new("vertex layout's stride", why, help));
        }
        if !offset.is_multiple_of(4) || offset > stride - position {
            let why = format!("is {offset} bytes, in vertices of {stride}");
            let help = format!("use a multiple of 4 up to {}", stride - position);
            return Err(Invalid::new("vertex layout's position offset", why, help));
        }
        Ok(())
    }

    /// Returns the number of vertices that fit in a buffer of this size in bytes. The last one may
    /// end with its position.
    pub(crate) fn vertices(self, bytes: u64) -> u64 {
        bytes
            .checked_sub(self.position_offset + self.format.bytes())
            .map_or(0, |rest| rest / self.stride + 1)
    }
}

fn check_buffer(
    buffer: &Buffer,
    what: &str,
    usage: BufferUsages,
    usage_name: &str,
) -> Result<(), Invalid> {
    if buffer.usage().contains(usage) {
        return Ok(());
    }
    let why = format!("was created without the usage `BufferUsages::{usage_name}`");
    Err(Invalid::new(what, why, "add it when creating the buffer"))
}

/// Errors if a texture `what` of the G-buffer has another format or size, or can't be read.
pub(crate) fn check(
    view: &TextureView,
    what: &str,
    format: TextureFormat,
    size: UVec2,
) -> Result<(), BackendError> {
    let texture = view.texture();
    let what = format!("receivers' {what} texture");
    check_readable(texture, &what)?;
    let found = UVec2::new(texture.width(), texture.height());
    if (texture.format(), found) != (format, size) {
        let why = format!(
            "is {:?} of {} x {} pixels",
            texture.format(),
            found.x,
            found.y
        );
        let help = format!(
            "make it {format:?} of {} x {}, like the frame",
            size.x, size.y
        );
        return Err(Invalid::new(what, why, help).into());
    }
    Ok(())
}

/// Errors if shaders can't read the texture.
pub(crate) fn check_readable(texture: &Texture, what: &str) -> Result<(), Invalid> {
    if texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
        return Ok(());
    }
    let why = "was created without the usage `TextureUsages::TEXTURE_BINDING`";
    Err(Invalid::new(what, why, "add it when creating the texture"))
}

/// Errors if a frame is empty or has more than `most` pixels on a side.
pub(crate) fn check_size(size: UVec2, most: u32) -> Result<(), BackendError> {
    if size.min_element() > 0 && size.max_element() <= most {
        return Ok(());
    }
    let why = format!("is {} x {} pixels", size.x, size.y);
    Err(Invalid::new("frame", why, format!("use 1 to {most} on each side")).into())
}
