//! A renderer as anyone's: its own meshes, shaders, G-buffer and window. All that it does with the library is in `shadows.rs`, and between
//! `prepare` and `encode_masks` in `renderer.rs`.

mod fly_camera;
mod gpu;
mod meshes;
mod panel;
mod picture;
mod pipelines;
mod renderer;
mod scene;
mod settings;
mod shadows;
mod window;

use anyhow::{Context as _, Result};
use clap::{Parser, builder::PossibleValuesParser};
use settings::Settings;
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};
use umbrage::{glam::UVec2, techniques};

const EXAMPLES: &str = "\
In the window:
  the right mouse button, held, looks around; W A S D fly, E or space up, Q or shift down; the wheel changes the speed;
  Ctrl+V takes a preset that was copied elsewhere

Examples:
  embed                                          a window
  embed --png plaza.png                          a picture, without a display
  embed --png plaza.png --size 1920x1080 --deferred --technique pcss --time 3
  embed --preset cubes.preset.toml               with what `cargo xtask plan cubes` has found";

/// A plaza with a sun in cascades, eight spots and two lanterns, whose shadows come from one light set.
#[derive(Parser)]
#[command(after_help = EXAMPLES)]
struct Options {
    /// Writes a picture to this file instead of opening a window.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Size of the picture or window, pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: UVec2,
    /// Begins with deferred shading.
    #[arg(long)]
    deferred: bool,
    /// Begins with this technique.
    #[arg(long, value_name = "NAME", default_value = "pcf", value_parser = technique_names())]
    technique: String,
    /// Begins with the settings in this file, as `cargo xtask plan` writes them.
    #[arg(long, value_name = "FILE", conflicts_with = "technique")]
    preset: Option<PathBuf>,
    /// Shows the scene as it is after this many seconds, and begins with it standing still.
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    time: Option<f32>,
}

fn technique_names() -> PossibleValuesParser {
    PossibleValuesParser::new(techniques::all().iter().map(|entry| entry.name))
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let help = || format!("`{text}` is no size; write it as 1280x720");
    let (width, height) = text.split_once('x').ok_or_else(help)?;
    let width: u32 = width.parse().map_err(|_| help())?;
    let height: u32 = height.parse().map_err(|_| help())?;
    if width == 0 || height == 0 {
        return Err("a side has no pixels; use 1 or more".to_owned());
    }
    Ok(UVec2::new(width, height))
}

fn parse_seconds(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(seconds) if seconds.is_finite() => Ok(seconds),
        _ => Err(format!("`{text}` is no number of seconds; write it as 2.5")),
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn take_preset(settings: &mut Settings, file: &Path) -> Result<()> {
    let text = std::fs::read_to_string(file)
        .with_context(|| format!("{} can't be read", file.display()))?;
    settings
        .paste(&text)
        .with_context(|| format!("{} can't be used", file.display()))
}

fn run(options: &Options) -> Result<()> {
    let technique = techniques::find(&options.technique).context("the technique is in no list")?;
    let mut settings = Settings::new(technique);
    if let Some(file) = &options.preset {
        take_preset(&mut settings, file)?;
    }
    settings.deferred = options.deferred;
    settings.moving = options.time.is_none();
    match &options.png {
        Some(file) => picture::write(options, &settings, file),
        None => window::run(options, settings),
    }
}
