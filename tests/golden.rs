//! Golden images: masks of 128 x 128 pixels that were reviewed by a person, compared exactly.

use image::{GrayImage, ImageFormat};
use std::{fs, io::Cursor, path::PathBuf};
use umbrage_core::{Backend as _, Fit, Geometry, Layout, ShadowTechnique, View, glam::UVec2};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    BeyondFar, Bias, Border, Hard, MapFilter as _, MapFormat, Pcf, PcfDithered, ShadowMap, Surface,
    Traced,
};

/// Sides, pixels.
pub const SIDE: u32 = 128;
/// Greatest size of a golden image, bytes. The repository keeps every version of each.
pub const MAX_BYTES: usize = 16 * 1024;

/// Constructor of a technique.
pub type Make = fn() -> Box<dyn ShadowTechnique>;

/// A scene and a technique with a kept mask.
#[derive(Clone, Copy, Debug)]
pub struct Golden {
    /// The built-in scene.
    pub scene: &'static str,
    /// Creates the technique.
    pub technique: Make,
}

/// An offset that is large enough for the kernels here, up to 3 texels wide, to have no acne on
/// planes. Acne would dominate the image and change with every bit.
const BIAS: Bias = Bias {
    normal_offset: 3.0,
    ..Bias::NONE
};

const MAP: ShadowMap = ShadowMap {
    size: 512,
    fit: Fit::Tight,
    bias: BIAS,
    layout: Layout::Auto,
    surface: Surface::Nearest,
    format: MapFormat::Depth32,
    border: Border::Lit,
    beyond_far: BeyondFar::Clamped,
};

/// Returns all golden images. Each shows something that no other does; they are few, because all
/// must be reviewed when they change.
pub fn all() -> Vec<Golden> {
    let list: [(&str, Make); 11] = [
        ("cubes", hard),
        ("cubes", pcf),
        ("cubes", dithered_pcf),
        ("cubes", traced_shadows),
        ("figure", pcf),
        ("teapot-lamp", pcf),
        ("teapot-lamp", traced_shadows),
        ("thin-plate", hard),
        ("bar-at-lamp", hard),
        ("low-sun-5", unbiased_hard),
        ("stairs", pcf),
    ];
    list.into_iter()
        .map(|(scene, technique)| Golden { scene, technique })
        .collect()
}

fn hard() -> Box<dyn ShadowTechnique> {
    let bias = Bias::SLOPE;
    Box::new(Hard {}.on(ShadowMap { bias, ..MAP }))
}

fn unbiased_hard() -> Box<dyn ShadowTechnique> {
    let bias = Bias::NONE;
    Box::new(Hard {}.on(ShadowMap { bias, ..MAP }))
}

fn pcf() -> Box<dyn ShadowTechnique> {
    Box::new(Pcf::new(1).on(MAP))
}

fn dithered_pcf() -> Box<dyn ShadowTechnique> {
    Box::new(PcfDithered {}.on(MAP))
}

fn traced_shadows() -> Box<dyn ShadowTechnique> {
    Box::new(Traced { samples: 16 })
}

impl Golden {
    /// Returns the name: `scene.technique`.
    pub fn name(&self) -> String {
        format!("{}.{}", self.scene, (self.technique)().name())
    }

    /// Returns the path of the file.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("goldens")
            .join(format!("{}.png", self.name()))
    }

    /// Renders the current mask on the CPU.
    ///
    /// # Errors
    /// Returns an error message if the scene or the recipe can't be made or rendered.
    pub fn render(&self) -> Result<GrayImage, String> {
        let say = |e: &dyn std::fmt::Display| format!("{}: {e}", self.name());
        let entry = umbrage_scenes::find(self.scene).ok_or_else(|| say(&"no such scene"))?;
        let scene = (entry.build)();
        let geometry = Geometry::bake(&scene).map_err(|e| say(&e))?;
        let camera = scene.cameras[0].with_size(UVec2::splat(SIDE));
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let recipe = (self.technique)().recipe(&view).map_err(|e| say(&e))?;
        let shadows = Cpu::new().render(&view, &recipe).map_err(|e| say(&e))?;
        let pixels = shadows
            .mask
            .iter()
            .map(|lit| (lit * 255.0).round() as u8)
            .collect();
        GrayImage::from_raw(SIDE, SIDE, pixels).ok_or_else(|| say(&"the mask has another size"))
    }

    /// Checks the golden image.
    ///
    /// # Errors
    /// Returns a message with the differences from the current mask.
    pub fn check(&self) -> Result<(), String> {
        let bytes = fs::read(self.path()).map_err(|e| format!("{}: {e}", self.path().display()))?;
        compare(&bytes, &self.render()?).map_err(|e| format!("{}: {e}", self.name()))
    }

    /// Rewrites the golden image.
    ///
    /// # Errors
    /// Returns an error message if it can't be rendered or written, or would be too large.
    pub fn bless(&self) -> Result<(), String> {
        let bytes = encode(&self.render()?)?;
        if bytes.len() > MAX_BYTES {
            return Err(format!(
                "{} takes {} bytes, over {MAX_BYTES}: use a plainer scene",
                self.name(),
                bytes.len()
            ));
        }
        fs::write(self.path(), bytes).map_err(|e| format!("{}: {e}", self.path().display()))
    }
}

/// Encodes an image as a PNG file.
///
/// # Errors
/// Returns an error message if the encoder fails.
pub fn encode(image: &GrayImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

/// Checks that a PNG file has exactly this image, and is small enough.
///
/// # Errors
/// Returns a message with the differences.
pub fn compare(png: &[u8], now: &GrayImage) -> Result<(), String> {
    let kept = image::load_from_memory_with_format(png, ImageFormat::Png)
        .map_err(|e| e.to_string())?
        .into_luma8();
    if png.len() > MAX_BYTES || kept.dimensions() != now.dimensions() {
        return Err(format!(
            "{} bytes, {:?} pixels: too large",
            png.len(),
            kept.dimensions()
        ));
    }
    let differing = kept
        .pixels()
        .zip(now.pixels())
        .filter(|(a, b)| a != b)
        .count();
    let most = kept
        .pixels()
        .zip(now.pixels())
        .map(|(a, b)| a.0[0].abs_diff(b.0[0]))
        .max()
        .unwrap_or(0);
    if differing == 0 {
        Ok(())
    } else {
        Err(format!("{differing} pixels differ, by up to {most} of 255"))
    }
}
