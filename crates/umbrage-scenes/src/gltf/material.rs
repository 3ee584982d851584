//! Materials: base colours, normal maps, and alpha tests.

use super::{
    document::{broken_element, element_name},
    file_bytes::FileBytes,
    picture::Pictures,
    wrap::Wraps,
};
use crate::detail::{Meaning, USUAL_CUTOFF};
use gltf::{
    Document, Material as FileMaterial, Primitive, Semantic,
    json::extensions::texture::TextureTransform, material::AlphaMode, texture::WrappingMode,
};
use std::collections::HashMap;
use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{AlphaCutout, AlphaFilter, Invalid, Material, Scene};

/// The materials of a file that were read.
#[derive(Debug)]
pub(super) struct Materials<'a> {
    /// `true` if looks are read.
    has_looks: bool,
    pictures: Pictures<'a>,
    /// Looks by number, and by whether the primitive has coordinates for the base colour and for
    /// the normal map.
    known: HashMap<(usize, [bool; 2]), Option<SurfaceLook>>,
}

/// The look of a primitive that is at least partly visible.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceLook {
    /// Index of a material of the scene.
    pub(super) material: Option<usize>,
    /// The texture coordinates, if it has textures.
    pub(super) coordinates: Option<Coordinates>,
    pub(super) casts: bool,
    /// The wrapping of the base colour's texture, and so of its alpha test.
    pub(super) wraps: Wraps,
}

/// The look of primitives without a material.
const PLAIN: SurfaceLook = SurfaceLook {
    material: None,
    coordinates: None,
    casts: true,
    wraps: [WrappingMode::Repeat; 2],
};

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document, has_looks: bool) -> Self {
        Self {
            has_looks,
            pictures: Pictures::new(document),
            known: HashMap::new(),
        }
    }

    /// Decodes the images of all textures so far.
    pub(super) fn decode_images(&mut self, scene: &mut Scene) -> Result<(), Invalid> {
        self.pictures.decode(&mut scene.textures)
    }

    /// Returns a line for each ignored image.
    pub(super) fn notices(self) -> impl Iterator<Item = String> {
        self.pictures.notices.into_iter()
    }

    /// Returns the look of a primitive; `None` if the alpha test removes all of it.
    pub(super) fn look_of(
        &mut self,
        primitive: &Primitive<'_>,
        data: &mut FileBytes<'_>,
        scene: &mut Scene,
    ) -> Result<Option<SurfaceLook>, Invalid> {
        if !self.has_looks {
            let first = Some(Coordinates::new(0, None)).filter(|at| at.has(primitive));
            return Ok(Some(SurfaceLook {
                coordinates: first,
                ..PLAIN
            }));
        }
        let material = primitive.material();
        let Some(index) = material.index() else {
            return Ok(Some(PLAIN));
        };
        let is_shown = data.files.color_side() > 0;
        let color = color_map(&material);
        let maps = [
            color.filter(|_| is_shown || material.alpha_mode() != AlphaMode::Opaque),
            normal_map(&material)?.filter(|_| is_shown),
        ]
        .map(|map| map.filter(|map| map.coordinates.has(primitive)));
        let key = (index, maps.map(|map| map.is_some()));
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let look = self
            .read(&material, maps, data, scene)
            .map_err(|e| e.within_context(element_name("material", index, material.name())))?;
        self.known.insert(key, look);
        Ok(look)
    }

    fn read(
        &mut self,
        file: &FileMaterial<'_>,
        maps: [Option<TextureMap>; 2],
        data: &mut FileBytes<'_>,
        scene: &mut Scene,
    ) -> Result<Option<SurfaceLook>, Invalid> {
        let mut load = |map: Option<TextureMap>, meaning| match map {
            Some(map) => {
                let texture =
                    self.pictures
                        .texture(map.picture, meaning, data, &mut scene.textures)?;
                Ok(texture.map(|texture| (texture, map.coordinates)))
            }
            None => Ok(None),
        };
        let meaning = match file.alpha_mode() {
            AlphaMode::Opaque => Meaning::Color,
            AlphaMode::Mask | AlphaMode::Blend => Meaning::CutOut,
        };
        let color = load(maps[0], meaning)?;
        let normals = load(maps[1], Meaning::Normals)?;
        let coordinates = color.or(normals).map(|(_, coordinates)| coordinates);
        let color = color.map(|(texture, _)| texture);
        let (alpha, casts) = match alpha_test(file, color)? {
            AlphaTest::Nothing => (None, true),
            AlphaTest::Some(cutout) => (Some(cutout), true),
            AlphaTest::Everything if file.alpha_mode() == AlphaMode::Mask => return Ok(None),
            // Panes of glass are visible and receive shadows.
            AlphaTest::Everything => (None, false),
        };
        // A mask keeps its size. Read larger colours again, at theirs.
        let color_side = data.files.color_side();
        let is_larger = |texture: &usize| scene.textures[*texture].size.max_element() > color_side;
        let shown = match maps[0].filter(|_| color_side > 0 && color.iter().any(is_larger)) {
            Some(map) if meaning == Meaning::CutOut => self.pictures.texture(
                map.picture,
                Meaning::CutOutColor,
                data,
                &mut scene.textures,
            )?,
            _ => color,
        };
        let surface = file.pbr_metallic_roughness();
        let [red, green, blue, _] = surface.base_color_factor();
        // A texture that is not read restricts emission to a part of the surface.
        let emits_evenly = file.emissive_texture().is_none();
        scene.materials.push(Material {
            diffuse: clamp_color(Vec3::new(red, green, blue)),
            diffuse_texture: shown,
            emissive: match emits_evenly {
                true => clamp_color(Vec3::from_array(file.emissive_factor())),
                false => Vec3::ZERO,
            },
            // Meshes have one set of coordinates here.
            normal_map: normals
                .filter(|(_, at)| Some(*at) == coordinates)
                .map(|(texture, _)| texture),
            alpha,
            ..Material::default()
        });
        let sampler = surface
            .base_color_texture()
            .map(|info| info.texture().sampler());
        Ok(Some(SurfaceLook {
            material: Some(scene.materials.len() - 1),
            coordinates,
            casts,
            wraps: sampler.map_or(PLAIN.wraps, |sampler| [sampler.wrap_s(), sampler.wrap_t()]),
        }))
    }
}

/// Clamps a colour to 0 to 1.
fn clamp_color(v: Vec3) -> Vec3 {
    v.clamp(Vec3::ZERO, Vec3::ONE)
}

/// The part of a surface that an alpha test removes.
enum AlphaTest {
    Nothing,
    Some(AlphaCutout),
    Everything,
}

/// Returns the alpha test of a material with this base colour texture. Alpha is the texture's times
/// the factor's.
fn alpha_test(file: &FileMaterial<'_>, texture: Option<usize>) -> Result<AlphaTest, Invalid> {
    let is_mask = file.alpha_mode() == AlphaMode::Mask;
    let cutoff = match file.alpha_mode() {
        AlphaMode::Opaque => return Ok(AlphaTest::Nothing),
        AlphaMode::Mask => file.alpha_cutoff().unwrap_or(USUAL_CUTOFF),
        // Surfaces that are more opaque than this cast.
        AlphaMode::Blend => USUAL_CUTOFF,
    };
    let surface = file.pbr_metallic_roughness();
    if texture.is_none() && surface.base_color_texture().is_some() && is_mask {
        return Err(Invalid::new(
            "alpha mask",
            "needs the texture of its colours, which is missing, unknown or without coordinates",
            "provide the image as PNG or JPEG together with the model, and export texture coordinates",
        ));
    }
    let factor = surface.base_color_factor()[3];
    let cutoff_of_texture = cutoff / factor.max(0.0);
    Ok(match texture {
        _ if cutoff <= 0.0 => AlphaTest::Nothing,
        None if factor >= cutoff => AlphaTest::Nothing,
        Some(texture) if cutoff_of_texture <= 1.0 => AlphaTest::Some(AlphaCutout {
            texture,
            cutoff: cutoff_of_texture,
            filter: AlphaFilter::Nearest,
        }),
        _ => AlphaTest::Everything,
    })
}

/// An image of the file, and its coordinates on a mesh.
#[derive(Clone, Copy, Debug)]
struct TextureMap {
    /// Index of the image.
    picture: usize,
    coordinates: Coordinates,
}

/// A set of texture coordinates, and the transform that `KHR_texture_transform` applies to them.
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
        let is_transformed = transform.is_some();
        let transform = transform.cloned().unwrap_or_default();
        Self {
            set: transform.tex_coord.unwrap_or(set),
            is_transformed,
            offset: Vec2::from_array(transform.offset.0),
            rotation: transform.rotation.0,
            scale: Vec2::from_array(transform.scale.0),
        }
    }

    /// Reports whether a primitive has them.
    fn has(&self, primitive: &Primitive<'_>) -> bool {
        primitive.get(&Semantic::TexCoords(self.set)).is_some()
    }

    /// Returns the coordinates for the texture lookup: scaled, turned counter-clockwise (v points
    /// down), then moved.
    pub(super) fn transformed_uv(&self, uv: [f32; 2]) -> Vec2 {
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
    // The crate's view of a transform has no access to the data behind it.
    let transform = info.texture_transform().map(|view| {
        let mut transform = TextureTransform {
            tex_coord: view.tex_coord(),
            ..TextureTransform::default()
        };
        transform.offset.0 = view.offset();
        transform.rotation.0 = view.rotation();
        transform.scale.0 = view.scale();
        transform
    });
    Some(TextureMap {
        picture: info.texture().source()?.index(),
        coordinates: Coordinates::new(info.tex_coord(), transform.as_ref()),
    })
}

fn normal_map(material: &FileMaterial<'_>) -> Result<Option<TextureMap>, Invalid> {
    let Some(map) = material.normal_texture() else {
        return Ok(None);
    };
    let Some(picture) = map.texture().source() else {
        return Ok(None);
    };
    // The crate leaves this transform as JSON.
    let transform = map.extension_value("KHR_texture_transform");
    let transform: Option<TextureTransform> = transform
        .map(|value| serde_json::from_value(value.clone()))
        .transpose()
        .map_err(|e| {
            broken_element("transform of the normal map", format!("can't be read: {e}"))
        })?;
    Ok(Some(TextureMap {
        picture: picture.index(),
        coordinates: Coordinates::new(map.tex_coord(), transform.as_ref()),
    }))
}
