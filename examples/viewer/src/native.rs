//! The program on the desktop: its command line, and the window.

use crate::{
    app::{App, Reports},
    bookmarks,
    device::device_descriptor,
    settings::Start,
};
use anyhow::{Context as _, Result};
use clap::Parser;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::{
    panic::{self, AssertUnwindSafe},
    process::ExitCode,
    sync::Arc,
};
use umbrage::{glam::UVec2, scenes, techniques};

const EXAMPLES: &str = "\
In the window:
  right mouse button, held   look around (or orbit, in orbit mode)
  W A S D, E Q               fly; faster with Shift
  mouse wheel                move ahead and back
  left mouse button          select a light by its marker, drag its handles, drag the divider
  F2                         open a scene or a file by part of its name; 1 and 2: the techniques
  N, arrows                  select the next light, move the selected one
  Tab                        move through the panel
  Ctrl plus, Ctrl minus      larger and smaller text
  F                          switch between the two sides
  F1                         all keys

Examples:
  umbrage-viewer                    the scene of the last session, or a town
  umbrage-viewer street             a built-in scene
  umbrage-viewer fence --failure    an artefact and its fix, side by side
  umbrage-viewer hills-pan --failure    an artefact in motion, with a moving camera
  umbrage-viewer model.obj          a model on a floor in the sun
  umbrage-viewer scene.toml --left exact --right pcf";

/// Shows a scene with its shadows: two techniques side by side, their errors against rays, and
/// their costs.
#[derive(Parser)]
#[command(name = "umbrage-viewer", after_help = EXAMPLES)]
struct Options {
    /// A built-in scene, a scene file (.toml), or a model (.obj, .glb, .gltf).
    scene: Option<String>,
    /// Technique of the left side.
    #[arg(long, value_name = "NAME", value_parser = technique_names())]
    left: Option<String>,
    /// Technique of the right side.
    #[arg(long, value_name = "NAME", value_parser = technique_names())]
    right: Option<String>,
    /// Shows the artefact of this scene on the left, and its fix on the right; also of scenes in
    /// motion, such as hills-pan.
    #[arg(long, requires = "scene", conflicts_with_all = ["left", "right"])]
    failure: bool,
    /// Size of the window, points.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: UVec2,
    /// Ignores the settings of the last session.
    #[arg(long)]
    fresh: bool,
    /// Writes the displayed and measured values to this file, as JSON, for tests.
    #[arg(long, value_name = "FILE")]
    report: Option<std::path::PathBuf>,
    /// Simulates the loss of the graphics device after this number of seconds, for tests.
    #[arg(long, value_name = "SECONDS", hide = true)]
    lose_device_after: Option<f32>,
    /// Lists the built-in scenes.
    #[arg(long)]
    list: bool,
}

fn technique_names() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(techniques::all().iter().map(|entry| entry.name))
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let help = || format!("`{text}` is not a size; write it as 1280x720");
    let (width, height) = text.split_once('x').ok_or_else(help)?;
    let width: u32 = width.parse().map_err(|_| help())?;
    let height: u32 = height.parse().map_err(|_| help())?;
    if width < 320 || height < 240 {
        return Err("the panel needs 320x240 or more".to_owned());
    }
    Ok(UVec2::new(width, height))
}

pub(crate) fn main() -> ExitCode {
    let options = Options::parse();
    if options.list {
        for entry in scenes::all() {
            println!("{:<24} {}", entry.name, entry.summary);
        }
        return ExitCode::SUCCESS;
    }
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<()> {
    if let Some(scene) = options.scene.as_ref().filter(|_| !options.failure) {
        // Report a missing scene before the window opens. An existing one may take long, and is
        // read in the background.
        let is_there = scenes::file_of(scene).is_some_and(|file| file.is_file());
        if scenes::find(scene).is_none() && !is_there {
            scenes::by_argument(scene)?;
        }
    }
    if options.failure
        && let Some(scene) = &options.scene
        && bookmarks::find(scene).is_none()
    {
        let known: Vec<_> = bookmarks::all()
            .iter()
            .map(|bookmark| bookmark.name)
            .collect();
        anyhow::bail!(
            "`{scene}` has no failure to show; choose one of {}",
            known.join(", ")
        );
    }
    let mut start = Start {
        scene: options.scene.clone(),
        techniques: [options.left.clone(), options.right.clone()],
        shows_failure: options.failure,
        is_fresh: options.fresh,
        loses_device_after: options.lose_device_after,
        ..Start::default()
    };
    loop {
        start.report = options.report.clone();
        let Some(Loss { why, unfinished }) = open(options, start)? else {
            return Ok(());
        };
        // Reopen the window with another device and its saved settings.
        start = Start {
            scene: unfinished,
            message: Some(format!("{why} It was opened again.")),
            ..Start::default()
        };
    }
}

/// Reason to reopen a window.
struct Loss {
    /// Reason of the loss.
    why: String,
    /// The scene that was loading.
    unfinished: Option<String>,
}

/// Opens the window and runs until it is closed. Returns the reason to reopen it if the graphics
/// device was lost.
fn open(options: &Options, start: Start) -> Result<Option<Loss>> {
    let size = options.size.as_vec2();
    let viewport = egui::ViewportBuilder::default()
        .with_title("umbrage")
        .with_app_id("umbrage-viewer")
        .with_inner_size([size.x, size.y])
        .with_min_inner_size([320.0, 240.0]);
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends =
        wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    setup.device_descriptor = Arc::new(device_descriptor);
    let reports = Reports::default();
    let reports_of_app = reports.clone();
    let native = eframe::NativeOptions {
        viewport,
        run_and_return: true,
        persist_window: false,
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::NativeOptions::default()
    };
    let creator: eframe::AppCreator<'_> =
        Box::new(move |context| Ok(Box::new(App::new(context, start, reports_of_app)?)));
    // The panel's painter panics if the device is lost while it paints, and leaves an unusable
    // event loop.
    let run = AssertUnwindSafe(|| eframe::run_native("umbrage-viewer", native, creator));
    let outcome = panic::catch_unwind(run);
    let loss = reports.lost.take();
    match outcome {
        Ok(outcome) => outcome
            .map_err(|error| anyhow::anyhow!("{error}"))
            .context("can't open a window; it requires a display and a graphics driver, such as Debian's mesa-vulkan-drivers")?,
        Err(panicked) => match loss {
            Some(loss) => anyhow::bail!("{loss} Start the program again: its settings are kept."),
            None => panic::resume_unwind(panicked),
        },
    }
    Ok(loss.map(|why| Loss {
        why,
        unfinished: reports.unfinished.take(),
    }))
}
