//! Materials on the device.

use super::pipelines::{self, Layouts, group};
use anyhow::{Context as _, Result};
use umbrage::{
    Material, Texture,
    glam::{UVec2, Vec4},
    picture::encode,
};
use wgpu::util::DeviceExt as _;

/// Returns a bind group for each material, and one for triangles without a material.
///
/// # Errors
/// Returns an error if a material refers to a missing texture.
pub(super) fn groups(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    layouts: &Layouts,
    materials: &[Material],
    textures: &[Texture],
) -> Result<Vec<wgpu::BindGroup>> {
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    // Upload the used textures, and a white one.
    let white = upload(
        device,
        queue,
        &Texture {
            name: "white".to_owned(),
            size: UVec2::ONE,
            texels: vec![[1.0; 4]].into(),
        },
    );
    let is_used = |i: usize| materials.iter().any(|m| m.diffuse_texture == Some(i));
    let views: Vec<_> = (0..)
        .zip(textures)
        .map(|(i, texture)| is_used(i).then(|| upload(device, queue, texture)))
        .collect();
    let none = Material::default();
    // Build a bind group for each material.
    let one = |material: &Material| -> Result<wgpu::BindGroup> {
        let shininess = (1_u32 << material.shininess_log2) as f32;
        let numbers: [[f32; 4]; 3] = [
            material.diffuse.extend(1.0).to_array(),
            material.specular.extend(shininess).to_array(),
            material.emissive.extend(0.0).to_array(),
        ];
        let uniforms = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("material"),
            contents: bytemuck::cast_slice(&numbers),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let view = match material.diffuse_texture {
            Some(index) => views.get(index).and_then(Option::as_ref),
            None => Some(&white),
        };
        let view = view.context("a material refers to a missing texture")?;
        let resources = [
            uniforms.as_entire_binding(),
            wgpu::BindingResource::TextureView(view),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        Ok(group(device, &layouts.material, resources))
    };
    materials.iter().chain([&none]).map(one).collect()
}

/// Uploads a texture of colours with all of its mipmaps.
fn upload(device: &wgpu::Device, queue: &wgpu::Queue, texture: &Texture) -> wgpu::TextureView {
    let most = device.limits().max_texture_dimension_2d;
    let mut size = texture.size;
    let mut texels: Vec<[f32; 4]> = texture.texels.iter().collect();
    while size.max_element() > most {
        (size, texels) = half_image(size, &texels);
    }
    let levels = 32 - size.max_element().leading_zeros();
    let uploaded = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&texture.name),
        size: pipelines::extent(size),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for level in 0..levels {
        let encoded = |&[r, g, b, _]: &[f32; 4]| [encode(r), encode(g), encode(b), 255];
        let bytes: Vec<u8> = texels.iter().flat_map(encoded).collect();
        pipelines::write(queue, &uploaded, level, size, &bytes);
        (size, texels) = half_image(size, &texels);
    }
    uploaded.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Returns an image of half the size, from means of four texels.
fn half_image(size: UVec2, texels: &[[f32; 4]]) -> (UVec2, Vec<[f32; 4]>) {
    let smaller = (size / 2).max(UVec2::ONE);
    let at = |x: u32, y: u32| {
        let x = x.min(size.x - 1);
        let y = y.min(size.y - 1);
        Vec4::from(texels[(y * size.x + x) as usize])
    };
    let mut out = Vec::with_capacity((smaller.x * smaller.y) as usize);
    for y in 0..smaller.y {
        for x in 0..smaller.x {
            let upper = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y);
            let lower = at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
            out.push((0.25 * (upper + lower)).to_array());
        }
    }
    (smaller, out)
}
