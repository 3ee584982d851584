//! The caller's input for one frame: casters in its own buffers, and the G-buffer of its camera.

use crate::device::later_errors::ApiErrors;
use glam::{Affine3A, UVec2};
use std::ops::Range;
use umbrage_core::{BackendError, Invalid, Recipe, Source, invalid};
use wgpu::{
    Buffer, BufferUsages, IndexFormat, Limits, Texture, TextureFormat, TextureUsages, TextureView,
    VertexFormat,
};

/// Options that hold for all that a renderer does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RendererOptions {
    /// Index of the bind group that holds what the receive kernel reads, so that
    /// [`receive_wgsl`](crate::receive_wgsl) and
    /// [`ShadowRenderer::receive_bind_group`](crate::ShadowRenderer::receive_bind_group) fit into
    /// the caller's own shaders.
    pub kernel_group: u32,
    /// When errors of the graphics API are reported.
    pub errors: ApiErrors,
}

impl RendererOptions {
    /// Returns the index of the G-buffer's bind group: 0, or 1 where the kernel's is 0.
    pub(crate) fn gbuffer_group(self) -> u32 {
        u32::from(self.kernel_group == 0)
    }
}

/// One frame's casters and receivers.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs<'a> {
    /// Size of the mask and of the receivers' textures, pixels.
    pub size: UVec2,
    /// Drawn by the recipe's casts of [`Source::Casters`].
    pub casters: &'a [Drawable<'a>],
    /// Casters, receivers, and what is neither: drawn by casts of [`Source::Everything`]. Recipes
    /// without such casts need none.
    pub everything: &'a [Drawable<'a>],
    /// What the camera sees.
    pub receivers: GBuffer<'a>,
}

/// Triangles in the caller's buffers.
#[derive(Clone, Debug)]
pub struct Drawable<'a> {
    /// Vertices, usage `VERTEX`.
    pub vertices: &'a Buffer,
    /// Where positions are in it.
    pub layout: VertexLayout,
    /// Vertex indices; none when every three vertices are a triangle.
    pub indices: Option<Indices<'a>>,
    /// Which indices are drawn, or which vertices when there are none.
    pub range: Range<u32>,
    /// Places the vertices into the world; none when they are there already, which is cheaper.
    pub world_from_local: Option<Affine3A>,
    /// Ids of the triangles that `range` draws, in its order, where they are a part of the
    /// [`Geometry`](umbrage_core::Geometry) that the technique was planned for: then casts that
    /// need only some casters draw only those of them. None to draw all of them always.
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

/// How a vertex buffer holds positions. A fourth component is not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PositionFormat {
    /// Three 32-bit floats, 12 bytes.
    #[default]
    Float32x3,
    /// Four 16-bit floats, 8 bytes.
    Float16x4,
    /// Four 16-bit whole numbers that stand for -1..=1, 8 bytes.
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

/// Where a vertex buffer holds positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VertexLayout {
    /// How a position is written.
    pub format: PositionFormat,
    /// Bytes from one vertex to the next; a multiple of 4, at least those of a position.
    pub stride: u64,
    /// Bytes from the vertex to its position; a multiple of 4, at most the stride less those of a
    /// position.
    pub position_offset: u64,
}

impl VertexLayout {
    /// Positions of three 32-bit floats and nothing else.
    pub const PACKED: Self = Self {
        format: PositionFormat::Float32x3,
        stride: 12,
        position_offset: 0,
    };
}

/// What the camera sees: textures of [`FrameInputs::size`] with usage `TEXTURE_BINDING`.
///
/// Two channels of unused precision are the price of a plain layout; an engine that keeps its own
/// G-buffer copies from it in one full-screen pass, or makes this one from depth with
/// [`GBufferFromDepth`](crate::GBufferFromDepth).
#[derive(Clone, Copy, Debug)]
pub struct GBuffer<'a> {
    /// `Rgba32Float`: world position, and in w 1 where a shadow may fall and 0 elsewhere.
    pub position: &'a TextureView,
    /// `Rgba32Float`: geometric unit normal in world space, turned to the camera, 0 where nothing
    /// is seen; w is unread.
    pub normal: &'a TextureView,
    /// `R32Uint`: triangle ids, [`NO_TRIANGLE`](umbrage_core::NO_TRIANGLE) where nothing is seen.
    /// For kernels that read them (ray tracing does, so that a triangle doesn't shadow itself) and
    /// for recipes that shade: they colour every pixel with an id, for which position and normal
    /// must then be right even where no shadow may fall.
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
    /// Errors if the device would fail: that would say so later, in other words, and in part only
    /// when the caller submits.
    pub(crate) fn validate(&self, recipe: &Recipe, limits: &Limits) -> Result<(), BackendError> {
        for (what, drawables) in [("caster", self.casters), ("everything", self.everything)] {
            for (i, drawable) in drawables.iter().enumerate() {
                drawable
                    .validate(limits)
                    .map_err(|e| e.within(format!("{what} {i}")))?;
            }
        }
        self.check_everything(recipe)?;
        self.check_triangles(recipe)?;
        self.receivers.validate(self.size)?;
        Ok(())
    }

    /// Errors if a cast draws everything and the frame lists casters only. A frame without casters
    /// either is fine: there the caller draws all casts itself.
    fn check_everything(&self, recipe: &Recipe) -> Result<(), Invalid> {
        let needed = recipe
            .casts
            .iter()
            .any(|c| matches!(c.source, Source::Everything));
        if !needed || !self.everything.is_empty() || self.casters.is_empty() {
            return Ok(());
        }
        let why = "has casters but not everything, which a cast of the recipe draws";
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
            "hand in triangle ids in `GBuffer::triangle`, or take a recipe that does without";
        Err(Invalid::new(
            "frame",
            "has no triangle ids, which tell this recipe what is seen",
            help,
        ))
    }
}

/// Triangles in buffers of the caller's, however they are placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BufferedTriangles<'a> {
    pub(crate) vertices: &'a Buffer,
    pub(crate) layout: VertexLayout,
    pub(crate) indices: Option<Indices<'a>>,
    pub(crate) range: &'a Range<u32>,
}

impl BufferedTriangles<'_> {
    /// Returns what the range counts: indices, or vertices where there are none.
    const fn counted(&self) -> &'static str {
        match self.indices {
            Some(_) => "indices",
            None => "vertices",
        }
    }

    /// Errors if a buffer lacks its usage, or doesn't hold what the range draws.
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
            return Err(Invalid::new(self.counted(), why, "put the first one first"));
        }
        if u64::from(range.end) > count {
            let why = format!("end at {}, and the buffer holds {count}", range.end);
            return Err(Invalid::new(
                self.counted(),
                why,
                "draw what is in the buffer",
            ));
        }
        if vertices == 0 && !range.is_empty() {
            return Err(Invalid::new(
                "vertex buffer",
                "holds no vertex",
                "leave the caster out",
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
        self.check_triangles(triangles.counted())
    }

    /// Errors if there are ids, but not as many as triangles are drawn.
    fn check_triangles(&self, what: &str) -> Result<(), Invalid> {
        let Some(triangles) = &self.triangles else {
            return Ok(());
        };
        let named = 3 * u64::from(triangles.end.saturating_sub(triangles.start));
        let drawn = u64::from(self.range.end - self.range.start);
        if named == drawn {
            return Ok(());
        }
        let why = format!("are {drawn}, and their triangles {triangles:?} have {named}");
        Err(Invalid::new(
            what,
            why,
            "name the triangles that the range draws, or none",
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

    /// Returns how many vertices fit in a buffer of this many bytes. The last one may end with its
    /// position.
    fn vertices(self, bytes: u64) -> u64 {
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
    let why = format!("was made without the usage `BufferUsages::{usage_name}`");
    Err(Invalid::new(what, why, "add it where the buffer is made"))
}

/// Errors if a texture of the G-buffer, `what`, has another format or size or can't be read.
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
            "make it {format:?} of {} x {}, as the frame says",
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
    let why = "was made without the usage `TextureUsages::TEXTURE_BINDING`";
    Err(Invalid::new(what, why, "add it where the texture is made"))
}

/// Errors if a frame is empty or has more than `most` pixels on a side.
pub(crate) fn check_size(size: UVec2, most: u32) -> Result<(), BackendError> {
    if size.min_element() > 0 && size.max_element() <= most {
        return Ok(());
    }
    let why = format!("is {} x {} pixels", size.x, size.y);
    Err(Invalid::new("frame", why, format!("use 1 to {most} on each side")).into())
}
