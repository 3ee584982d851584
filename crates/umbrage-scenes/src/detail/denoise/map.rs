//! Displacement maps: measured from a noisy mesh, applied to a mesh.

use super::{deltas::Surface, fill::nearest_vertices};
use umbrage_core::glam::UVec2;
use umbrage_core::{Invalid, Mesh, Texture, displacement};

/// Valid range of texels along a side.
const SIDES: std::ops::RangeInclusive<u32> = 2..=8192;

/// Offsets of a mesh's surface from its surroundings over its texture, in metres:
/// `bias + scale (2 h - 1)`, where h is the grey of a texel over 65535.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacementMap {
    /// Size in texels, each side 2 to 8192.
    pub(super) size: UVec2,
    /// Grey values, rows from the top: 0 for the least offset, 65535 for the greatest.
    pub(super) greys: Vec<u16>,
    /// Half of the range of offsets, metres.
    pub(super) scale: f32,
    /// Centre of the range of offsets, metres.
    pub(super) bias: f32,
}

impl DisplacementMap {
    /// Measures a closed mesh. The value of a vertex is its offset from the mean of its neighbours,
    /// along the vertex normal; other texels have the value of the nearest vertex in the texture. A
    /// `size` with two or more texels between neighbouring vertices keeps their offsets separate;
    /// [`DisplacementMap::largest_error`] measures the difference.
    ///
    /// # Errors
    /// Returns an error if the mesh is invalid or open, if it has no texture coordinates or some
    /// outside 0 to 1, or if a side is not 2 to 8192.
    pub fn from_noisy(noisy: &Mesh, size: UVec2) -> Result<Self, Invalid> {
        Self::from_noisy_keeping_shape(noisy, size, 0)
    }

    /// Measures a closed mesh like [`DisplacementMap::from_noisy`], and preserves its shape. It
    /// subtracts from the offsets their local average, computed by averaging each vertex with its
    /// neighbours `rounds` times. Noise differs between neighbours; the average is the curvature,
    /// and denoising by it would shrink the shape. 8 rounds are a good default, 0 subtract nothing.
    ///
    /// # Errors
    /// Returns an error if [`DisplacementMap::from_noisy`] does.
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

    /// Returns the mesh with each vertex moved along its normal by `factor` times the map's offset
    /// in metres. -1 removes the measured offsets, 1 doubles them. Vertices with equal positions
    /// stay together. Shading normals are recomputed as averages.
    ///
    /// # Errors
    /// Returns an error if [`DisplacementMap::from_noisy`] does, or if the factor is not finite.
    pub fn apply_to_mesh(&self, mesh: &Mesh, factor: f32) -> Result<Mesh, Invalid> {
        let surface = Surface::new(mesh, 0)?;
        // Textures repeat, but opposite borders of a map are seldom neighbours. Inset by half a
        // texel to keep them apart.
        let border = 0.5 / self.size.as_vec2();
        let mut inset = mesh.clone();
        for uv in &mut inset.uvs {
            *uv = uv.clamp(border, 1.0 - border);
        }
        inset.normals = surface.vertex_normals();
        inset.tangents = Vec::new();
        let (texture, lambda) = self.texture();
        let mut moved = inset.displace_mesh(&texture, factor * lambda)?;
        moved.uvs = mesh.uvs.clone();
        Ok(moved)
    }

    /// Returns the map as a material's displacement: a texture, and the lambda for which
    /// `lambda (2 h - 1)` is the map's offset in metres. Minus lambda denoises. The texture
    /// includes the bias.
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
            texels: texels.into(),
        };
        (texture, lambda)
    }

    fn metres(&self, grey: u16) -> f32 {
        self.bias + self.scale * (2.0 * f32::from(grey) / 65535.0 - 1.0)
    }

    /// Returns the greatest difference, in metres, between the map at a vertex and the offset
    /// measured at that vertex. A difference of more than a few per cent of
    /// [`DisplacementMap::scale`] means that the map has too few texels, or that positions share
    /// texels. `rounds` must be that of the map's construction.
    ///
    /// # Errors
    /// Returns an error if [`DisplacementMap::from_noisy`] does.
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

    /// Returns the size of the map, texels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Returns half of the range of offsets, metres.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Returns the centre of the range of offsets, metres.
    pub fn bias(&self) -> f32 {
        self.bias
    }
}

/// Returns a mesh after `passes` passes of denoising, each with a map of the current mesh. `rounds`
/// is that of [`DisplacementMap::from_noisy_keeping_shape`]. Each pass removes remaining noise;
/// with 0 rounds it also shrinks the shape again.
///
/// # Errors
/// Returns an error if [`DisplacementMap::from_noisy`] does.
pub fn denoise_mesh(noisy: &Mesh, size: UVec2, passes: u32, rounds: u32) -> Result<Mesh, Invalid> {
    let mut mesh = noisy.clone();
    for _ in 0..passes {
        let map = DisplacementMap::from_noisy_keeping_shape(&mesh, size, rounds)?;
        mesh = map.apply_to_mesh(&mesh, -1.0)?;
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
