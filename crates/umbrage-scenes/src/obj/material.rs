//! Materials of a model: `.mtl` files.
//!
//! The reader supports `Kd`, `Ks`, `Ke`, `Ns`, `map_Kd`, `map_d` for alpha tests, and `norm` or
//! `map_Bump` for normals. It ignores the rest of the format.

use crate::{
    Files, SceneError,
    detail::{Meaning, TextureFiles, USUAL_CUTOFF},
    error::Place,
};
use std::{
    io::Read as _,
    path::{Path, PathBuf},
};
use umbrage_core::glam::Vec3;
use umbrage_core::{AlphaCutout, AlphaFilter, MAX_SHININESS_LOG2, Material, Texture};

/// Greatest length of a file, bytes.
const LONGEST: u64 = 16 << 20;

/// One `newmtl`, with textures as paths.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    material: Material,
    color_map: Option<PathBuf>,
    alpha_map: Option<PathBuf>,
    normal_map: Option<PathBuf>,
}

/// Returns the entries of a file. A missing file has none, since many models lack theirs.
pub(super) fn load(path: &Path, files: &dyn Files) -> Result<Vec<Entry>, SceneError> {
    if !files.has(path) {
        return Ok(Vec::new());
    }
    let read = || {
        let mut bytes = Vec::new();
        let source = files.open(path)?;
        // Read one more byte, to detect longer files.
        match source.take(LONGEST + 1).read_to_end(&mut bytes)? as u64 <= LONGEST {
            true => Ok(bytes),
            false => Err(std::io::Error::other("is over 16 MiB long")),
        }
    };
    let bytes = read().map_err(|e| SceneError::unreadable_file(path, &e, files))?;
    parse(&String::from_utf8_lossy(&bytes), path)
}

pub(super) fn parse(text: &str, path: &Path) -> Result<Vec<Entry>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut entries: Vec<Entry> = Vec::new();
    let text = text.trim_start_matches('\u{feff}');
    for (i, line) in text.replace("\r\n", "\n").split(['\n', '\r']).enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if keyword.eq_ignore_ascii_case("newmtl") {
            entries.push(Entry {
                name: rest.trim().to_owned(),
                material: Material::default(),
                color_map: None,
                alpha_map: None,
                normal_map: None,
            });
        } else if let Some(entry) = entries.last_mut() {
            entry
                .set(&keyword.to_ascii_lowercase(), rest.trim(), folder)
                .map_err(|why| SceneError::Fault {
                    place: Place {
                        file: path.display().to_string(),
                        line: Some(i + 1),
                        key: Some(keyword.to_owned()),
                    },
                    why,
                    help: "write numbers as 0.5, one or three".to_owned(),
                })?;
        }
    }
    Ok(entries)
}

impl Entry {
    fn set(&mut self, keyword: &str, rest: &str, folder: &Path) -> Result<(), String> {
        match keyword {
            "kd" => self.material.diffuse = color(rest)?,
            "ks" => self.material.specular = color(rest)?,
            "ke" => self.material.emissive = color(rest)?,
            "ns" => self.material.shininess_log2 = shininess(numbers(rest)?[0]),
            "map_kd" => self.color_map = file(rest, folder),
            "map_d" => self.alpha_map = file(rest, folder),
            "norm" | "map_bump" | "bump" => {
                self.normal_map = file(rest, folder).or(self.normal_map.take())
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns the material with its textures, which are added if their files exist and the mesh is
    /// `mapped`, so that it can show them.
    pub(super) fn textured(
        &self,
        mapped: bool,
        files: &mut TextureFiles<'_>,
        textures: &mut Vec<Texture>,
    ) -> Result<TexturedEntry, SceneError> {
        let mut material = self.material;
        if let Some(path) = usable_map(self.color_map.as_deref(), mapped, files.files) {
            material.diffuse_texture = files.index_of_colors(path, textures)?;
        }
        let mut alpha_texture = material.diffuse_texture;
        if let Some(path) = usable_map(self.alpha_map.as_deref(), mapped, files.files) {
            alpha_texture = files.index(path, Meaning::Alpha, textures)?;
        }
        if let Some(path) = usable_map(self.normal_map.as_deref(), mapped, files.files) {
            material.normal_map = files.index(path, Meaning::Normals, textures)?;
        }
        Ok(TexturedEntry {
            material,
            alpha_texture,
        })
    }
}

/// A material whose images may not be decoded yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct TexturedEntry {
    material: Material,
    /// The texture whose alpha may have holes.
    alpha_texture: Option<usize>,
}

impl TexturedEntry {
    /// Returns the material, given the decoded textures.
    pub(super) fn material(&self, textures: &[Texture]) -> Material {
        // Grey bump maps are heights of unknown scale.
        let is_grey = |map: &usize| {
            let mut texels = textures[*map].texels.iter();
            texels.all(|t| t[0] == t[1] && t[1] == t[2])
        };
        Material {
            alpha: self
                .alpha_texture
                .and_then(|texture| cut_out(texture, textures)),
            normal_map: self.material.normal_map.filter(|map| !is_grey(map)),
            ..self.material
        }
    }
}

/// Returns the alpha test of a texture at the usual cut-off. `None` if it removes nothing.
fn cut_out(texture: usize, textures: &[Texture]) -> Option<AlphaCutout> {
    let mut texels = textures[texture].texels.iter();
    let has_holes = texels.any(|texel| texel[3] < USUAL_CUTOFF);
    has_holes.then_some(AlphaCutout {
        texture,
        cutoff: USUAL_CUTOFF,
        filter: AlphaFilter::Nearest,
    })
}

/// Returns a texture's path if it is set, the file exists, and the mesh can show it.
fn usable_map<'a>(map: Option<&'a Path>, mapped: bool, files: &dyn Files) -> Option<&'a Path> {
    map.filter(|path| mapped && files.has(path))
}

/// Parses one or three numbers, clamped to 0 to 1.
fn color(rest: &str) -> Result<Vec3, String> {
    let numbers = numbers(rest)?;
    let color = if numbers.len() < 3 {
        Vec3::splat(numbers[0])
    } else {
        Vec3::from_slice(&numbers)
    };
    Ok(color.clamp(Vec3::ZERO, Vec3::ONE))
}

/// Parses one to three finite numbers.
fn numbers(rest: &str) -> Result<Vec<f32>, String> {
    let words: Vec<&str> = rest.split_whitespace().take(3).collect();
    let parsed = words
        .iter()
        .map(|w| w.parse().ok().filter(|x: &f32| x.is_finite()).ok_or(*w));
    match parsed.collect::<Result<Vec<_>, _>>() {
        Ok(numbers) if numbers.is_empty() => Err("holds nothing".to_owned()),
        Ok(numbers) => Ok(numbers),
        Err(word) => Err(format!("holds `{word}`, which is not a number")),
    }
}

/// Returns the exponent of the nearest power of two.
fn shininess(power: f32) -> u32 {
    (0..=MAX_SHININESS_LOG2)
        .find(|&n| power < (1_u32 << n) as f32 * std::f32::consts::SQRT_2)
        .unwrap_or(MAX_SHININESS_LOG2)
}

/// Returns the path of a PNG file after its options. `None` for other kinds of images.
fn file(rest: &str, folder: &Path) -> Option<PathBuf> {
    let name = if rest.starts_with('-') {
        rest.split_whitespace().last()?
    } else {
        rest
    };
    let path = folder.join(name.replace('\\', "/"));
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        .then_some(path)
}
