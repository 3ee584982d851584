//! Uploads and readbacks of tests, like those of a program with its own renderer.

use crate::adapter::TestDevice;
use bytemuck::cast_slice;
use glam::{UVec2, Vec3};
use umbrage_core::Aabb;
use umbrage_wgpu::{CasterMesh, LightSet, MeshId, VertexLayout};
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, Extent3d, TexelCopyBufferInfo, TexelCopyBufferLayout,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
    util::{BufferInitDescriptor, DeviceExt},
};

/// Returns a buffer with these bytes.
pub fn buffer(d: &TestDevice, usage: BufferUsages, contents: &[u8]) -> Buffer {
    d.device.create_buffer_init(&BufferInitDescriptor {
        label: None,
        contents,
        usage,
    })
}

/// Adds a mesh of one triangle with these corners, local space, to a set. `usage` is that of its
/// vertices.
///
/// # Panics
/// Panics if the set refuses it.
pub fn add_triangle(
    d: &TestDevice,
    set: &mut LightSet,
    usage: BufferUsages,
    corners: [[f32; 3]; 3],
) -> MeshId {
    let vertices = buffer(d, usage, cast_slice(&corners));
    let mesh = CasterMesh {
        label: "triangle",
        vertices: &vertices,
        layout: VertexLayout::PACKED,
        indices: None,
        range: 0..3,
        base_vertex: 0,
        bounds: Aabb::from_points(corners.map(Vec3::from_array)),
    };
    set.add_mesh(&mesh).expect("valid")
}

/// Returns a texture with these texels, row by row, for shaders to read.
///
/// # Panics
/// Panics if the format has no known size.
pub fn upload(d: &TestDevice, size: UVec2, format: TextureFormat, data: &[u8]) -> TextureView {
    let texel = format
        .block_copy_size(None)
        .expect("a format of whole texels");
    let texture = texture(d, size, format, TextureUsages::COPY_DST);
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(texel * size.x),
        rows_per_image: None,
    };
    d.queue
        .write_texture(texture.as_image_copy(), data, layout, texture.size());
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Returns a texture that shaders read, with an additional usage.
pub fn texture(
    d: &TestDevice,
    size: UVec2,
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    d.device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | usage,
        view_formats: &[],
    })
}

/// Submits the encoder, and returns the resulting contents of an `R32Float` texture, layer by layer
/// and row by row.
///
/// # Panics
/// Panics if the device is lost.
pub fn read(d: &TestDevice, encoder: CommandEncoder, view: &TextureView) -> Vec<f32> {
    bytemuck::pod_collect_to_vec(&read_bytes(d, encoder, view))
}

/// Submits the encoder, and returns the resulting bytes of a texture, layer by layer and row by
/// row.
///
/// # Panics
/// Panics if the device is lost, or the format has no known size.
pub fn read_bytes(d: &TestDevice, mut encoder: CommandEncoder, view: &TextureView) -> Vec<u8> {
    let texture = view.texture();
    let texel = texture.format().block_copy_size(None);
    let width = texel.expect("a format of whole texels") * texture.width();
    let row = width.next_multiple_of(256);
    let buffer = d.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row)
            * u64::from(texture.height())
            * u64::from(texture.depth_or_array_layers()),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row),
        rows_per_image: Some(texture.height()),
    };
    let destination = TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    d.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    d.device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device lives");
    let bytes = buffer.get_mapped_range(..).expect("mapped");
    let rows = bytes.chunks_exact(row as usize);
    rows.flat_map(|r| &r[..width as usize]).copied().collect()
}
