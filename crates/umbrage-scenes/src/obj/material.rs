//! Materials of a model: `.mtl` files.
//!
//! The reader supports `Kd`, `Ks`, `Ke`, `Ns`, `map_Kd`, `map_d` for alpha tests, and `norm` or
//! `map_Bump` for normals. Materials without opacity (`d` of 0, or else `Tr` of 1) cast no shadows;
//! partial opacity is ignored. It ignores the rest of the format. Ignored keys with an effect on shadows
//! or colours are listed for the materials that faces use.

use crate::{
    Files, SceneError,
    detail::{Meaning, TextureFiles, USUAL_CUTOFF, picture_format},
    error::Place,
};
use std::{
    collections::{BTreeMap, BTreeSet},
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
    /// Share of light that passes through, of `d` or else of `Tr`.
    transparency: f32,
    has_opacity: bool,
    /// Ignored keys and options with an effect on colours, and those with one on shadows.
    ignored: [BTreeSet<String>; 2],
}

/// Ignored parts of materials, as items by reason.
pub(super) type Losses = BTreeMap<&'static str, BTreeSet<String>>;

/// Reasons of [`Losses`].
pub(super) const UNDEFINED: &str = "undefined materials";
const OPAQUE: &str =
    "transparency (`d`, `Tr`) below 1 is ignored; these materials cast full shadows";
const CLEAR: &str = "materials without opacity (`d`, `Tr`) cast no shadows";
const KEYS: &str = "ignored keys of materials";
const UNMAPPED: &str =
    "textures of these materials are ignored, since their faces have no texture coordinates";
const MISSING: &str = "textures are missing";
const OTHER_KIND: &str = if cfg!(feature = "gltf") {
    "textures other than PNG and JPEG are ignored"
} else {
    "textures other than PNG are ignored"
};
const GREY: &str = "grey bump maps are ignored (heights without a scale)";

/// Keys of textures with an effect on colours that the reader ignores.
const COLOR_KEYS: [&str; 9] = [
    "decal", "map_ke", "map_ks", "map_ns", "map_pm", "map_pr", "map_refl", "refl", "map_ps",
];
/// Keys with an effect on shadows that the reader ignores.
const SHADOW_KEYS: [&str; 3] = ["disp", "map_disp", "map_tr"];

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
                transparency: 0.0,
                has_opacity: false,
                ignored: Default::default(),
            });
        } else if let Some(entry) = entries.last_mut() {
            entry
                .set(keyword, rest.trim(), folder)
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
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => self.material.diffuse = color(rest)?,
            "ks" => self.material.specular = color(rest)?,
            "ke" => self.material.emissive = color(rest)?,
            "ns" => self.material.shininess_log2 = shininess(numbers(rest)?[0]),
            "map_kd" => {
                // Alpha of the texture may cast.
                self.list_options(keyword, rest, true);
                self.color_map = file(rest, folder);
            }
            "map_d" => {
                self.list_options(keyword, rest, true);
                self.alpha_map = file(rest, folder);
            }
            "norm" | "map_bump" | "bump" => {
                // Prefer a usable map to others.
                let map = file(rest, folder);
                if self.normal_map.is_none() || map.as_deref().is_some_and(is_read) {
                    self.list_options(keyword, rest, false);
                    self.normal_map = map;
                }
            }
            // Dissolve: 1 is opaque. `-halo` has another number behind it.
            "d" => {
                self.transparency = last_number(rest).map_or(0.0, |d| 1.0 - d);
                self.has_opacity = true;
            }
            "tr" if !self.has_opacity => self.transparency = last_number(rest).unwrap_or(0.0),
            key if COLOR_KEYS.contains(&key) => self.ignore(keyword.to_owned(), false),
            key if SHADOW_KEYS.contains(&key) => self.ignore(keyword.to_owned(), true),
            _ => {}
        }
        Ok(())
    }

    fn ignore(&mut self, key: String, casts: bool) {
        self.ignored[usize::from(casts)].insert(key);
    }

    /// Lists the options of a texture that would move, scale or select its texels.
    fn list_options(&mut self, keyword: &str, rest: &str, casts: bool) {
        let mut words = rest.split_whitespace().peekable();
        while let Some(word) = words.next() {
            let values = std::iter::from_fn(|| {
                words.next_if(|word| !word.starts_with('-') || word.parse::<f32>().is_ok())
            });
            let values: Vec<&str> = values.collect();
            let differ = |usual: &[f32]| {
                let mut numbers = values
                    .iter()
                    .map_while(|value| value.parse::<f32>().ok())
                    .zip(usual);
                numbers.any(|(number, usual)| number != *usual)
            };
            let has_effect = match word {
                "-o" | "-t" => differ(&[0.0; 3]),
                "-s" => differ(&[1.0; 3]),
                "-mm" => differ(&[0.0, 1.0]),
                "-bm" => differ(&[1.0]),
                "-clamp" => values.first() == Some(&"on"),
                "-imfchan" => true,
                _ => false,
            };
            if has_effect {
                self.ignore(format!("{keyword} {word}"), casts);
            }
        }
    }

    /// Returns the material with its textures, which are added if their files exist and the mesh is
    /// `mapped`, so that it can show them. Adds ignored parts to `losses`.
    pub(super) fn textured(
        &self,
        mapped: bool,
        files: &mut TextureFiles<'_>,
        textures: &mut Vec<Texture>,
        losses: &mut Losses,
    ) -> Result<TexturedEntry, SceneError> {
        let shows_colors = files.files.color_side() > 0;
        self.list_losses(shows_colors, losses);
        let mut material = self.material;
        let mut alpha_texture = None;
        // JPEG files have no alpha.
        let may_cast = |path: &Path| !is_jpeg(path);
        let map = self
            .color_map
            .as_deref()
            .filter(|path| shows_colors || may_cast(path));
        if let Some(path) = self.usable_map(map, mapped, files.files, losses) {
            [material.diffuse_texture, alpha_texture] = files.indices_of_colors(path, textures)?;
        }
        let map = self.alpha_map.as_deref();
        if let Some(path) = self.usable_map(map, mapped, files.files, losses) {
            alpha_texture = files.index(path, Meaning::Alpha, textures)?;
        }
        let map = self.normal_map.as_deref().filter(|_| shows_colors);
        if let Some(path) = self.usable_map(map, mapped, files.files, losses) {
            material.normal_map = files.index(path, Meaning::Normals, textures)?;
        }
        Ok(TexturedEntry {
            material,
            alpha_texture,
            casts: self.casts(),
        })
    }

    /// Returns whether faces cast shadows: not if all light passes through.
    fn casts(&self) -> bool {
        self.transparency < 1.0
    }

    fn list_losses(&self, shows_colors: bool, losses: &mut Losses) {
        if self.transparency > 0.0 {
            let reason = if self.casts() { OPAQUE } else { CLEAR };
            losses.entry(reason).or_default().insert(self.name.clone());
        }
        let [of_colors, of_shadows] = &self.ignored;
        let keys = of_colors.iter().filter(|_| shows_colors).chain(of_shadows);
        for key in keys {
            losses.entry(KEYS).or_default().insert(key.clone());
        }
    }

    /// Returns a texture's path if it is set, the file is an image that is read and exists, and the mesh can
    /// show it. Otherwise adds the reason to `losses`.
    fn usable_map<'a>(
        &self,
        map: Option<&'a Path>,
        mapped: bool,
        files: &dyn Files,
        losses: &mut Losses,
    ) -> Option<&'a Path> {
        let path = map?;
        let (reason, item) = match () {
            () if !mapped => (UNMAPPED, self.name.clone()),
            () if !is_read(path) => (OTHER_KIND, path.display().to_string()),
            () if !files.has(path) => (MISSING, path.display().to_string()),
            () => return Some(path),
        };
        losses.entry(reason).or_default().insert(item);
        None
    }
}

/// A material whose images may not be decoded yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct TexturedEntry {
    material: Material,
    /// The texture whose alpha may have holes.
    alpha_texture: Option<usize>,
    /// `false` if all light passes through.
    pub(super) casts: bool,
}

impl TexturedEntry {
    /// Returns the material, given the decoded textures. Adds ignored parts to `losses`.
    pub(super) fn material(&self, textures: &[Texture], losses: &mut Losses) -> Material {
        // Grey bump maps are heights of unknown scale.
        let is_grey =
            |texture: &Texture| texture.texels.iter().all(|t| t[0] == t[1] && t[1] == t[2]);
        let mut normal_map = self.material.normal_map;
        if let Some(texture) = normal_map
            .map(|map| &textures[map])
            .filter(|map| is_grey(map))
        {
            losses.entry(GREY).or_default().insert(texture.name.clone());
            normal_map = None;
        }
        Material {
            alpha: self
                .alpha_texture
                .and_then(|texture| cut_out(texture, textures)),
            normal_map,
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

/// Returns the last number of a statement, if it is one.
fn last_number(rest: &str) -> Option<f32> {
    rest.split_whitespace().last()?.parse().ok()
}

/// Returns the path of a texture's file after its options.
fn file(rest: &str, folder: &Path) -> Option<PathBuf> {
    let name = if rest.starts_with('-') {
        rest.split_whitespace().last()?
    } else {
        rest
    };
    (!name.is_empty()).then(|| folder.join(name.replace('\\', "/")))
}

fn is_read(path: &Path) -> bool {
    picture_format(path).is_some()
}

fn is_jpeg(path: &Path) -> bool {
    let kinds = ["jpg", "jpeg"];
    path.extension()
        .is_some_and(|e| kinds.iter().any(|kind| e.eq_ignore_ascii_case(kind)))
}
