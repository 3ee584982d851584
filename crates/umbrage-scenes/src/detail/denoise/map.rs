//! The map: made from a noisy mesh, applied to a mesh.

use super::{deltas::Surface, fill::nearest_vertices};
use umbrage_core::glam::UVec2;
use umbrage_core::{Invalid, Mesh, Texture, displacement};

/// Least and greatest number of texels a side.
const SIDES: std::ops::RangeInclusive<u32> = 2..=8192;

/// How far a mesh's surface stands out from its surroundings, in metres over its texture:
/// `bias + scale (2 h - 1)`, where h is the grey of a texel over 65535.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacementMap {
    /// Texels, each 2 to 8192.
    pub(super) size: UVec2,
    /// 0 for the least offset, 65535 for the greatest; rows from the top.
    pub(super) greys: Vec<u16>,
    /// Half of the range of offsets, metres.
    pub(super) scale: f32,
    /// The middle of the range, metres.
    pub(super) bias: f32,
}

impl DisplacementMap {
    /// Measures a closed mesh: at each vertex the offset from the mean of its neighbours, along the
    /// vertex normal; between them, that of the nearest vertex in the texture. `size` texels: two
    /// or more between neighbouring vertices keep each vertex's offset apart from its neighbours';
    /// [`DisplacementMap::largest_error`] tells.
    ///
    /// # Errors
    /// Errors if the mesh is invalid or open, has no texture coordinates or some beyond 0 to 1;
    /// when a side is not 2 to 8192.
    pub fn from_noisy(noisy: &Mesh, size: UVec2) -> Result<Self, Invalid> {
        Self::from_noisy_keeping_shape(noisy, size, 0)
    }

    /// [`DisplacementMap::from_noisy`] without what neighbours share: the offsets less their
    /// average, taken `rounds` times over each vertex and its neighbours. Noise differs from vertex
    /// to vertex; what remains of the average is the curvature, and denoising would shrink the
    /// shape by it. 8 rounds serve well, 0 leave nothing out.
    ///
    /// # Errors
    /// Errors if [`DisplacementMap::from_noisy`] does.
    pub fn from_noisy_keeping_shape(
        noisy: &Mesh,
        size: UVec2,
        rounds: u32,
    ) -> Result<Self, Invalid> {
        check_size(size)?;
        let surface = Surface::new(noisy, rounds)?;
        let least = surface.deltas.iter().copied().fold(f32::INFINITY, f32::min);
        let most = surface
            .deltas
            .iter()
            .copied()
            .fold(f32::NEG_INFINITY, f32::max);
        let scale = 0.5 * (most - least);
        let bias = 0.5 * (most + least);
        let range = f64::from(most) - f64::from(least);
        let grey = |delta: f32| match range > 0.0 {
            true => ((f64::from(delta) - f64::from(least)) / range * 65535.0).round() as u16,
            false => 0,
        };
        let vertices = nearest_vertices(noisy, size)?;
        let greys = vertices
            .into_iter()
            .map(|v| grey(surface.vertex_delta(v as usize)))
            .collect();
        Ok(Self {
            size,
            greys,
            scale,
            bias,
        })
    }

    /// Returns the mesh with each vertex moved along its normal by `factor` times the map's metres
    /// there: -1 takes away what the map was made from, 1 doubles it. Vertices of one place stay
    /// together. Shading normals are averaged anew.
    ///
    /// # Errors
    /// Errors if [`DisplacementMap::from_noisy`] does, or if the factor is not finite.
    pub fn applied(&self, mesh: &Mesh, factor: f32) -> Result<Mesh, Invalid> {
        let surface = Surface::new(mesh, 0)?;
        // Textures repeat, and the border of a map is seldom the other border's neighbour: half a
        // texel keeps them apart.
        let border = 0.5 / self.size.as_vec2();
        let mut inset = mesh.clone();
        for uv in &mut inset.uvs {
            *uv = uv.clamp(border, 1.0 - border);
        }
        inset.normals = surface.vertex_normals();
        inset.tangents = Vec::new();
        let (texture, lambda) = self.texture();
        let mut moved = inset.displaced(&texture, factor * lambda)?;
        moved.uvs = mesh.uvs.clone();
        Ok(moved)
    }

    /// Returns the map as a material's displacement: a texture, and the lambda that makes
    /// `lambda (2 h - 1)` the map's metres; minus lambda denoises. The bias is part of the texture.
    pub fn texture(&self) -> (Texture, f32) {
        let lambda = self.scale + self.bias.abs();
        let mut texels = Vec::with_capacity(self.greys.len());
        for &grey in &self.greys {
            let height = if lambda > 0.0 {
                0.5 + 0.5 * self.metres(grey) / lambda
            } else {
                0.5
            };
            texels.push([height, height, height, 1.0]);
        }
        let texture = Texture {
            name: "displacement map".to_owned(),
            size: self.size,
            texels,
        };
        (texture, lambda)
    }

    fn metres(&self, grey: u16) -> f32 {
        self.bias + self.scale * (2.0 * f32::from(grey) / 65535.0 - 1.0)
    }

    /// The greatest difference, in metres, between the map at a vertex and the offset measured
    /// there: more than a few per cent of [`DisplacementMap::scale`] says that the map has too few
    /// texels, or that places share some. `rounds` as the map was made with.
    ///
    /// # Errors
    /// Errors if [`DisplacementMap::from_noisy`] does.
    pub fn largest_error(&self, noisy: &Mesh, rounds: u32) -> Result<f32, Invalid> {
        let surface = Surface::new(noisy, rounds)?;
        let (texture, lambda) = self.texture();
        let border = 0.5 / self.size.as_vec2();
        let mut largest = 0.0_f32;
        for (vertex, uv) in noisy.uvs.iter().enumerate() {
            let height = displacement::height(&texture, uv.clamp(border, 1.0 - border));
            let stored = lambda * (2.0 * height - 1.0);
            largest = largest.max((stored - surface.vertex_delta(vertex)).abs());
        }
        Ok(largest)
    }

    /// Returns the map's size, texels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Returns half of the range of offsets, metres.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Returns the middle of the range of offsets, metres.
    pub fn bias(&self) -> f32 {
        self.bias
    }
}

/// Returns a mesh from which a map of it was taken away, `passes` times; `rounds` as in
/// [`DisplacementMap::from_noisy_keeping_shape`]. Each pass removes noise that the one before left;
/// without rounds it also shrinks the shape once more.
///
/// # Errors
/// Errors if [`DisplacementMap::from_noisy`] does.
pub fn denoised(noisy: &Mesh, size: UVec2, passes: u32, rounds: u32) -> Result<Mesh, Invalid> {
    let mut mesh = noisy.clone();
    for _ in 0..passes {
        let map = DisplacementMap::from_noisy_keeping_shape(&mesh, size, rounds)?;
        mesh = map.applied(&mesh, -1.0)?;
    }
    Ok(mesh)
}

pub(super) fn check_size(size: UVec2) -> Result<(), Invalid> {
    if size.to_array().iter().all(|side| SIDES.contains(side)) {
        return Ok(());
    }
    let why = format!("is {} x {} texels", size.x, size.y);
    Err(Invalid::new(
        "displacement map",
        why,
        format!("use {} to {} a side", SIDES.start(), SIDES.end()),
    ))
}
