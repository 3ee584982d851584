//! Looks: base colours, normal maps, and what is cut out.

use super::{
    broken,
    budget::ReadBudget,
    buffers::Buffers,
    picture::{self, Pictures},
    told,
    wrap::Wraps,
};
use crate::detail::{Meaning, USUAL_CUTOFF};
use gltf::{
    Document, Material as FileMaterial, Primitive, Semantic, Texture as FileTexture,
    json::extensions::texture::TextureTransform,
    material::{AlphaMode, NormalTexture},
    texture::{Info, WrappingMode},
};
use std::collections::HashMap;
use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{AlphaCutout, AlphaFilter, Invalid, Material, Scene};

/// What textures do unless a file says otherwise.
const REPEATED: Wraps = [WrappingMode::Repeat; 2];

/// The materials of a file that were read.
#[derive(Debug)]
pub(super) struct Materials<'a> {
    /// Whether they are read at all.
    has_looks: bool,
    pictures: Pictures<'a>,
    known: HashMap<Mapped, SurfaceLook>,
}

/// A material by its number, and which of its textures a primitive has coordinates for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Mapped {
    material: usize,
    color: bool,
    normals: bool,
}

/// How a primitive looks.
#[derive(Clone, Copy, Debug)]
pub(super) enum SurfaceLook {
    /// All of it is cut out.
    CutAway,
    /// Some of it is there.
    Visible {
        /// Index of a material of the scene.
        material: Option<usize>,
        /// Where its textures lie, if it has any.
        coordinates: Option<Coordinates>,
        /// Whether it throws shadows.
        casts: bool,
        /// How the texture of its colours, and so of its holes, goes on beyond its edges.
        wraps: Wraps,
    },
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document, has_looks: bool) -> Self {
        Self {
            has_looks,
            pictures: Pictures::new(document),
            known: HashMap::new(),
        }
    }

    /// Returns how a primitive looks.
    pub(super) fn look_of(
        &mut self,
        primitive: &Primitive<'_>,
        buffers: &mut Buffers<'_>,
        budget: &mut ReadBudget,
        scene: &mut Scene,
    ) -> Result<SurfaceLook, Invalid> {
        if !self.has_looks {
            let first = Coordinates::new(0, None);
            return Ok(SurfaceLook::Visible {
                material: None,
                coordinates: Some(first).filter(|at| at.has(primitive)),
                casts: true,
                wraps: REPEATED,
            });
        }
        let material = primitive.material();
        let Some(index) = material.index() else {
            return Ok(SurfaceLook::Visible {
                material: None,
                coordinates: None,
                casts: true,
                wraps: REPEATED,
            });
        };
        let color = color_map(&material).filter(|map| map.coordinates.has(primitive));
        let normals = normal_map(&material)?.filter(|map| map.coordinates.has(primitive));
        let mapped = Mapped {
            material: index,
            color: color.is_some(),
            normals: normals.is_some(),
        };
        if let Some(known) = self.known.get(&mapped) {
            return Ok(*known);
        }
        let look = self
            .read(&material, color, normals, buffers, budget, scene)
            .map_err(|e| e.within(told("material", index, material.name())))?;
        self.known.insert(mapped, look);
        Ok(look)
    }

    fn read(
        &mut self,
        file: &FileMaterial<'_>,
        color: Option<TextureMap>,
        normals: Option<TextureMap>,
        buffers: &mut Buffers<'_>,
        budget: &mut ReadBudget,
        scene: &mut Scene,
    ) -> Result<SurfaceLook, Invalid> {
        let mut load = |map: Option<TextureMap>, meaning| match map {
            Some(map) => {
                let textures = &mut scene.textures;
                let texture =
                    self.pictures
                        .texture(map.picture, meaning, buffers, budget, textures)?;
                Ok::<_, Invalid>(texture.map(|texture| (texture, map.coordinates)))
            }
            None => Ok(None),
        };
        let color = load(color, Meaning::Color)?;
        let normals = load(normals, Meaning::Data)?;
        let coordinates = color.or(normals).map(|(_, coordinates)| coordinates);
        let factor = file.pbr_metallic_roughness().base_color_factor();
        let (holes, casts) = match cut_out(file, color.map(|(texture, _)| texture))? {
            Cut::Nothing => (None, true),
            Cut::Holes(holes) => (Some(holes), true),
            Cut::Everything if file.alpha_mode() == AlphaMode::Mask => {
                return Ok(SurfaceLook::CutAway);
            }
            // Panes of glass: they are seen, and shadows fall on them.
            Cut::Everything => (None, false),
        };
        let [red, green, blue, _] = factor;
        let glows_evenly = file.emissive_texture().is_none();
        scene.materials.push(Material {
            diffuse: colour(Vec3::new(red, green, blue)),
            diffuse_texture: color.map(|(texture, _)| texture),
            emissive: match glows_evenly {
                true => colour(Vec3::from_array(file.emissive_factor())),
                // Which part of the surface glows, is told by a texture that is not read.
                false => Vec3::ZERO,
            },
            // A mesh has one set of coordinates here.
            normal_map: normals
                .filter(|(_, at)| Some(*at) == coordinates)
                .map(|(texture, _)| texture),
            alpha: holes,
            ..Material::default()
        });
        Ok(SurfaceLook::Visible {
            material: Some(scene.materials.len() - 1),
            coordinates,
            casts,
            wraps: file
                .pbr_metallic_roughness()
                .base_color_texture()
                .map_or(REPEATED, |info| {
                    let sampler = info.texture().sampler();
                    [sampler.wrap_s(), sampler.wrap_t()]
                }),
        })
    }
}

/// Cuts a colour off at 0 and 1.
fn colour(v: Vec3) -> Vec3 {
    v.clamp(Vec3::ZERO, Vec3::ONE)
}

/// What of a surface is cut out.
enum Cut {
    Nothing,
    Holes(AlphaCutout),
    Everything,
}

/// Returns what a material cuts out, given its texture of colours. Alpha is the texture's times the factor's.
fn cut_out(file: &FileMaterial<'_>, texture: Option<usize>) -> Result<Cut, Invalid> {
    let cutoff = match file.alpha_mode() {
        AlphaMode::Opaque => return Ok(Cut::Nothing),
        AlphaMode::Mask => file.alpha_cutoff().unwrap_or(USUAL_CUTOFF),
        // What is more than half there casts.
        AlphaMode::Blend => USUAL_CUTOFF,
    };
    let named = file.pbr_metallic_roughness().base_color_texture();
    if texture.is_none() && named.is_some() && file.alpha_mode() == AlphaMode::Mask {
        return Err(Invalid::new(
            "alpha mask",
            "needs the texture of its colours, which is missing, unknown or without coordinates",
            "give the picture as PNG or JPEG together with the model, and export texture coordinates",
        ));
    }
    let factor = file.pbr_metallic_roughness().base_color_factor()[3];
    if cutoff <= 0.0 {
        return Ok(Cut::Nothing);
    }
    let least = match texture {
        Some(_) => cutoff / factor.max(0.0),
        None if factor >= cutoff => return Ok(Cut::Nothing),
        None => return Ok(Cut::Everything),
    };
    match texture {
        Some(texture) if least <= 1.0 => Ok(Cut::Holes(AlphaCutout {
            texture,
            cutoff: least,
            filter: AlphaFilter::Nearest,
        })),
        _ => Ok(Cut::Everything),
    }
}

/// A picture of the file, and where it lies on a mesh.
#[derive(Clone, Copy, Debug)]
struct TextureMap {
    /// Number of the picture.
    picture: usize,
    coordinates: Coordinates,
}

/// Which texture coordinates a texture has, and how they are moved: the extension `KHR_texture_transform`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    pub(super) set: u32,
    pub(super) is_transformed: bool,
    offset: Vec2,
    rotation: f32,
    scale: Vec2,
}

impl Coordinates {
    fn new(set: u32, transform: Option<&TextureTransform>) -> Self {
        let Some(transform) = transform else {
            return Self {
                set,
                is_transformed: false,
                offset: Vec2::ZERO,
                rotation: 0.0,
                scale: Vec2::ONE,
            };
        };
        Self {
            set: transform.tex_coord.unwrap_or(set),
            is_transformed: true,
            offset: Vec2::from_array(transform.offset.0),
            rotation: transform.rotation.0,
            scale: Vec2::from_array(transform.scale.0),
        }
    }

    /// Returns whether a primitive has them.
    fn has(&self, primitive: &Primitive<'_>) -> bool {
        primitive.get(&Semantic::TexCoords(self.set)).is_some()
    }

    /// Returns the coordinates that the texture is read at: scaled, turned counter-clockwise (v points down), then moved.
    pub(super) fn at(&self, uv: [f32; 2]) -> Vec2 {
        let uv = Vec2::from_array(uv);
        if !self.is_transformed {
            return uv;
        }
        let (sin, cos) = self.rotation.sin_cos();
        let scaled = uv * self.scale;
        let turned = Vec2::new(
            cos * scaled.x + sin * scaled.y,
            cos * scaled.y - sin * scaled.x,
        );
        turned + self.offset
    }
}

fn color_map(material: &FileMaterial<'_>) -> Option<TextureMap> {
    let info = material.pbr_metallic_roughness().base_color_texture()?;
    Some(TextureMap {
        picture: picture::of_texture(&info.texture())?,
        coordinates: Coordinates::new(info.tex_coord(), transform_of(&info).as_ref()),
    })
}

/// Returns the transform of a texture. The crate has a view of it alone, without the data.
fn transform_of(info: &Info<'_>) -> Option<TextureTransform> {
    let view = info.texture_transform()?;
    let mut transform = TextureTransform {
        tex_coord: view.tex_coord(),
        ..TextureTransform::default()
    };
    transform.offset.0 = view.offset();
    transform.rotation.0 = view.rotation();
    transform.scale.0 = view.scale();
    Some(transform)
}

fn normal_map(material: &FileMaterial<'_>) -> Result<Option<TextureMap>, Invalid> {
    let Some(map) = material.normal_texture() else {
        return Ok(None);
    };
    let Some(picture) = picture::of_texture(&map.texture() as &FileTexture<'_>) else {
        return Ok(None);
    };
    let transform = normal_transform(&map)?;
    Ok(Some(TextureMap {
        picture,
        coordinates: Coordinates::new(map.tex_coord(), transform.as_ref()),
    }))
}

/// Returns the transform of a normal map, which the crate leaves as text.
fn normal_transform(map: &NormalTexture<'_>) -> Result<Option<TextureTransform>, Invalid> {
    let Some(value) = map.extension_value("KHR_texture_transform") else {
        return Ok(None);
    };
    let transform = serde_json::from_value(value.clone());
    transform
        .map(Some)
        .map_err(|e| broken("transform of the normal map", format!("can't be read: {e}")))
}
