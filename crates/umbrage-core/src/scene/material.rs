//! Materials and textures for colour images and detailed surfaces. Masks only depend on their
//! displacement and alpha.

use crate::{
    invalid::{Invalid, finite, not_negative},
    picture,
};
use glam::{UVec2, Vec3};
use std::sync::Arc;

/// Texels of any kind: colour, tangent-space normals, height, alpha.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Texture {
    /// Name for error messages.
    pub name: String,
    /// Size in texels.
    pub size: UVec2,
    /// Rows from the top.
    pub texels: Texels,
}

/// Texels of a texture. Images of 8 bits a channel keep their bytes, a quarter of the memory of
/// floats; their values are computed on each access. Clones share the memory.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Texels {
    /// Colours encoded as sRGB, and linear alpha: [`picture::decode`] returns a colour's value.
    Srgb8(Arc<Vec<[u8; 4]>>),
    /// Linear values, in units of 1/255.
    Unorm8(Arc<Vec<[u8; 4]>>),
    /// Linear values.
    Float(Arc<Vec<[f32; 4]>>),
}

impl Texels {
    /// Returns the number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb8(texels) | Self::Unorm8(texels) => texels.len(),
            Self::Float(texels) => texels.len(),
        }
    }

    /// Returns whether there are no texels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the linear values of texel `i`.
    ///
    /// # Panics
    /// Panics if there is no such texel.
    #[inline]
    pub fn get(&self, i: usize) -> [f32; 4] {
        let unorm = |byte: u8| f32::from(byte) / 255.0;
        match self {
            Self::Srgb8(texels) => {
                let [red, green, blue, alpha] = texels[i];
                let [red, green, blue] = [red, green, blue].map(picture::decode);
                [red, green, blue, unorm(alpha)]
            }
            Self::Unorm8(texels) => texels[i].map(unorm),
            Self::Float(texels) => texels[i],
        }
    }

    /// Returns the linear values of all texels.
    pub fn iter(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Returns the stored bytes, in the machine's byte order.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            Self::Srgb8(texels) | Self::Unorm8(texels) => texels.as_flattened(),
            Self::Float(texels) => bytemuck::cast_slice(texels),
        }
    }
}

impl Default for Texels {
    fn default() -> Self {
        Self::Float(Arc::default())
    }
}

impl From<Vec<[f32; 4]>> for Texels {
    fn from(texels: Vec<[f32; 4]>) -> Self {
        Self::Float(Arc::new(texels))
    }
}

impl FromIterator<[f32; 4]> for Texels {
    fn from_iter<I: IntoIterator<Item = [f32; 4]>>(texels: I) -> Self {
        Self::Float(Arc::new(texels.into_iter().collect()))
    }
}

/// Appearance of a surface. Colours are linear, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Colour of diffuse reflection, multiplied by the texture, if any.
    pub diffuse: Vec3,
    /// Index into [`Scene::textures`](crate::Scene::textures): colour over the mesh's uvs.
    pub diffuse_texture: Option<usize>,
    /// Colour of the highlight.
    pub specular: Vec3,
    /// Base-2 logarithm of the highlight's exponent: 5 for 32. Powers of two are computed by
    /// repeated squaring, which is the same on every driver.
    pub shininess_log2: u32,
    /// Emitted light, unaffected by shadows: used for light markers.
    pub emissive: Vec3,
    /// Index into the scene's textures: tangent-space normals as `(n + 1) / 2`, green up (OpenGL
    /// convention).
    pub normal_map: Option<usize>,
    /// Displacement of the surface.
    pub displacement: Option<Displacement>,
    /// Alpha test, for leaves and fences.
    pub alpha: Option<AlphaCutout>,
}

/// Alpha test of a surface: light and camera rays pass through its holes. A point is a hole if the
/// fourth channel of the texel nearest to its uv (repeating) is less than the cut-off.
/// [`Geometry::bake`](crate::Geometry::bake) ignores textures without such texels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AlphaCutout {
    /// Index into [`Scene::textures`](crate::Scene::textures); its fourth channel is alpha, 0 clear
    /// to 1 opaque.
    pub texture: usize,
    /// Least alpha of an opaque texel, 0 to 1. With 0, a texture whose alpha is not negative has no
    /// holes.
    pub cutoff: f32,
    /// Filter for images whose pixels are larger than the texels.
    #[cfg_attr(feature = "serde", serde(default))]
    pub filter: AlphaFilter,
}

/// Alpha filter of the camera's image and shadow maps where their pixels are larger than a texel.
/// Rays, and therefore truth, always use the nearest texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AlphaFilter {
    /// The texel at the pixel's centre, as for rays: no approximation. Distant edges are as noisy
    /// as with one ray per pixel.
    #[default]
    Nearest,
    /// The mean coverage of about a pixel, compared with a threshold hashed from the position on
    /// the triangle. Distant geometry keeps its mean coverage, and doesn't flicker when the camera
    /// moves. This is an approximation (Wyman and McGuire 2017, "Hashed Alpha Testing", see
    /// [`hashed_alpha`](crate::hashed_alpha)).
    Hashed,
}

impl AlphaCutout {
    /// Returns whether a texel is opaque.
    pub(crate) fn is_there(&self, texel: &[f32; 4]) -> bool {
        texel[3] >= self.cutoff
    }

    fn validate(&self) -> Result<(), Invalid> {
        let what = "cut-off of the alpha texture";
        finite(what, &[self.cutoff])?;
        if (0.0..=1.0).contains(&self.cutoff) {
            return Ok(());
        }
        Err(Invalid::new(
            what,
            format!("is {}", self.cutoff),
            "use 0 to 1; .5 is usual",
        ))
    }
}

/// Displacement: each vertex moves along its unit normal by `lambda (2 h - 1)`, where h is the
/// first channel of the texture at its uv, bilinear and repeating. It is baked into the geometry,
/// so camera and light see the same relief.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Displacement {
    /// Index into the scene's textures.
    pub texture: usize,
    /// Scale, metres in mesh space; negative inverts the relief.
    pub lambda: f32,
    /// Number of times that each triangle is first split in four, 0 to 8. A coarse mesh cannot show
    /// relief.
    pub subdivisions: u32,
}

/// Greatest number of subdivisions: each triangle becomes 65,536.
pub const MAX_SUBDIVISIONS: u32 = 8;
/// Greatest [`Material::shininess_log2`].
pub const MAX_SHININESS_LOG2: u32 = 12;

impl Default for Material {
    fn default() -> Self {
        Self {
            diffuse: Vec3::splat(0.5),
            diffuse_texture: None,
            specular: Vec3::splat(0.15),
            shininess_log2: 5,
            emissive: Vec3::ZERO,
            normal_map: None,
            displacement: None,
            alpha: None,
        }
    }
}

impl Texture {
    /// Checks that the texture can be read.
    ///
    /// # Errors
    /// Errors with the first fault found: a size that doesn't match the number of texels, a texel
    /// that is not finite.
    pub fn validate(&self) -> Result<(), Invalid> {
        let what = format!("texture `{}`", self.name);
        let texels = u64::from(self.size.x) * u64::from(self.size.y);
        if texels == 0 || texels != self.texels.len() as u64 {
            let why = format!(
                "has {} texels and a size of {} x {}",
                self.texels.len(),
                self.size.x,
                self.size.y
            );
            let help = "use width times height texels, at least one";
            return Err(Invalid::new(what, why, help));
        }
        let Texels::Float(floats) = &self.texels else {
            return Ok(());
        };
        for (i, texel) in floats.iter().enumerate() {
            // Format names only for texels that are not finite: formatting one for each texel is
            // slow.
            if texel.iter().any(|v| !v.is_finite()) {
                finite(&format!("texel {i}"), texel).map_err(|e| e.within_context(&what))?;
            }
        }
        Ok(())
    }
}

impl Material {
    /// Checks that the material can be used in a scene with `textures` textures.
    ///
    /// # Errors
    /// Errors with the first fault found: an invalid texture index, a number that is negative or
    /// not finite, a setting or a cut-off out of range.
    pub fn validate(&self, textures: usize) -> Result<(), Invalid> {
        // Check colours.
        for (what, color) in [
            ("diffuse colour", self.diffuse),
            ("specular colour", self.specular),
            ("emission", self.emissive),
        ] {
            for component in color.to_array() {
                not_negative(what, component)?;
            }
        }
        let relief = self.displacement;
        // Check texture indices.
        for (what, id) in [
            ("diffuse texture", self.diffuse_texture),
            ("normal map", self.normal_map),
            ("displacement map", relief.map(|d| d.texture)),
            ("alpha texture", self.alpha.map(|a| a.texture)),
        ] {
            if let Some(id) = id.filter(|&id| id >= textures) {
                let why = format!("is texture {id} of {textures}");
                return Err(Invalid::new(
                    what,
                    why,
                    "use the index of a texture of this scene",
                ));
            }
        }
        // Check the other settings.
        at_most(
            "shininess",
            self.shininess_log2,
            MAX_SHININESS_LOG2,
            "as a power of two",
        )?;
        if let Some(alpha) = self.alpha {
            alpha.validate()?;
        }
        let Some(Displacement {
            lambda,
            subdivisions,
            ..
        }) = relief
        else {
            return Ok(());
        };
        finite("lambda of the displacement", &[lambda])?;
        at_most(
            "displacement",
            subdivisions,
            MAX_SUBDIVISIONS,
            "subdivisions",
        )
    }
}

fn at_most(what: &str, value: u32, most: u32, unit: &str) -> Result<(), Invalid> {
    if value <= most {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("is {value} {unit}"),
        format!("use 0 to {most}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes have the values of the formulas: the inverse transfer function, and quotients.
    #[test]
    fn texels_of_bytes_have_the_values_of_floats() {
        let bytes: Vec<[u8; 4]> = (0..=255_u8).map(|i| [i, 255 - i, i / 2, i]).collect();
        let unorm = |byte: u8| f32::from(byte) / 255.0;
        let srgb = Texels::Srgb8(Arc::new(bytes.clone()));
        let linear = Texels::Unorm8(Arc::new(bytes.clone()));
        for (i, byte) in bytes.into_iter().enumerate() {
            let [red, green, blue, alpha] = byte;
            let colors = [red, green, blue].map(picture::decode);
            assert_eq!(srgb.get(i)[..3], colors);
            assert_eq!(srgb.get(i)[3], unorm(alpha));
            assert_eq!(linear.get(i), byte.map(unorm));
        }
        let values: Texels = srgb.iter().collect();
        assert_eq!((values.len(), values.get(77)), (256, srgb.get(77)));
        assert_eq!(srgb.as_bytes()[4 * 77..][..4], [77, 178, 38, 77]);
        assert_eq!(values.as_bytes()[..4], srgb.get(0)[0].to_ne_bytes());
    }

    #[test]
    fn cut_outs_that_cannot_be_queried_are_refused() {
        let with = |texture, cutoff| {
            let alpha = Some(AlphaCutout {
                texture,
                cutoff,
                filter: AlphaFilter::Nearest,
            });
            let material = Material {
                alpha,
                ..Material::default()
            };
            material.validate(2).map_err(|e| e.to_string())
        };
        assert_eq!(with(1, 0.0), Ok(()));
        assert_eq!(with(0, 1.0), Ok(()));
        let missing = "alpha texture: is texture 2 of 2; use the index of a texture of this scene";
        assert_eq!(with(2, 0.5), Err(missing.into()));
        for cutoff in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
            let error = with(0, cutoff).unwrap_err();
            assert!(
                error.starts_with("cut-off of the alpha texture: "),
                "{error}"
            );
        }
    }
}
