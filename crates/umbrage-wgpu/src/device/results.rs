//! Readback of masks, colour images, recipe images and receivers.

use crate::{
    device::readback::{ReadBack, Ticket},
    gbuffer::ReceiverTextures,
    renderer::ShadowRenderer,
    resources::images::GpuImage,
};
use glam::Vec3;
use umbrage_core::{
    BackendError, Format, Image, NO_TRIANGLE, Receivers, Recipe, View, math::dot3,
    resolve::at_pixel,
};
use wgpu::CommandEncoder;

/// Copies of the mask, of the colour image and of kept images.
#[derive(Debug)]
pub(crate) struct Tickets {
    mask: Option<Ticket>,
    picture: Option<Ticket>,
    images: Vec<Ticket>,
}

impl Tickets {
    /// Records the copies. `kept` are the recipe's images from the
    /// [`Converter`](crate::device::convert::Converter), or empty.
    pub(crate) fn record(
        encoder: &mut CommandEncoder,
        back: &mut ReadBack<'_>,
        renderer: &ShadowRenderer,
        kept: &[GpuImage],
    ) -> Self {
        let mut copy = |image: &GpuImage| back.image(encoder, image);
        Self {
            mask: renderer.mask().map(&mut copy),
            picture: renderer.gpu_picture().map(&mut copy),
            images: kept.iter().map(&mut copy).collect(),
        }
    }

    pub(crate) fn mask(&self, back: &ReadBack<'_>) -> Result<Vec<f32>, BackendError> {
        self.mask.map_or_else(|| Ok(Vec::new()), |t| back.read(t))
    }

    pub(crate) fn picture(
        &self,
        back: &ReadBack<'_>,
    ) -> Result<Option<Vec<[f32; 4]>>, BackendError> {
        self.picture.map(|t| back.read(t)).transpose()
    }

    pub(crate) fn images(
        &self,
        back: &ReadBack<'_>,
        recipe: &Recipe,
    ) -> Result<Vec<Image>, BackendError> {
        let mut images = Vec::with_capacity(self.images.len());
        for (&ticket, &desc) in self.images.iter().zip(&recipe.images) {
            let texels = texels(desc.format, back, ticket)?;
            images.push(Image { desc, texels });
        }
        Ok(images)
    }
}

fn texels(format: Format, back: &ReadBack<'_>, ticket: Ticket) -> Result<Vec<f32>, BackendError> {
    match format {
        Format::Stencil8 => {
            let counts: Vec<u8> = back.read(ticket)?;
            Ok(counts.into_iter().map(f32::from).collect())
        }
        Format::Rg16 | Format::Rgba16 => {
            let steps: Vec<u16> = back.read(ticket)?;
            let channel = |step: u16| f32::from(step) * (1.0 / 65_535.0);
            Ok(steps.into_iter().map(channel).collect())
        }
        _ => back.read(ticket),
    }
}

/// Copies of receivers.
#[derive(Debug)]
pub(crate) struct ReceiverTickets {
    position: Ticket,
    normal: Ticket,
    triangle: Ticket,
    depth: Ticket,
}

impl ReceiverTextures {
    pub(crate) fn record(
        &self,
        encoder: &mut CommandEncoder,
        back: &mut ReadBack<'_>,
    ) -> ReceiverTickets {
        let mut copy = |texture| back.texture(encoder, texture);
        ReceiverTickets {
            position: copy(&self.position.0),
            normal: copy(&self.normal.0),
            triangle: copy(&self.triangle.0),
            depth: copy(&self.depth.0),
        }
    }
}

impl ReceiverTickets {
    pub(crate) fn read(
        &self,
        back: &ReadBack<'_>,
        view: &View<'_>,
    ) -> Result<Receivers, BackendError> {
        let positions: Vec<[f32; 4]> = back.read(self.position)?;
        let normals: Vec<[f32; 4]> = back.read(self.normal)?;
        let triangles: Vec<u32> = back.read(self.triangle)?;
        let depths: Vec<f32> = back.read(self.depth)?;
        let size = view.camera.size;
        let rays = view.camera.rays();
        let mut out = Receivers::empty(size);
        for i in 0..out.len() {
            let [x, y, z, receives] = positions[i];
            // `t` is the position of the hit with the triangle's plane, in multiples of the ray's
            // direction.
            let [nx, ny, nz, t] = normals[i];
            // As in `resolve`, a huge `t` means that the ray is parallel to the triangle's plane.
            if triangles[i] == NO_TRIANGLE || t.abs() >= 3.0e38 {
                continue;
            }
            let column = i as u32 % size.x;
            let row = i as u32 / size.x;
            let direction: Vec3 = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, column, row);
            out.x[i] = x;
            out.y[i] = y;
            out.z[i] = z;
            out.nx[i] = nx;
            out.ny[i] = ny;
            out.nz[i] = nz;
            out.distance[i] = t * dot3(direction, direction).sqrt();
            out.depth[i] = depths[i];
            out.triangle[i] = triangles[i];
            out.receives[i] = receives != 0.0;
        }
        Ok(out)
    }
}
