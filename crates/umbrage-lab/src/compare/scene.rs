//! Compares all technique settings on one scene.

use super::{
    backends::Backends,
    enclosed::enclosed_light,
    event::{CompareEvent, OnEvent},
    map_uses::MapUses,
    options::{CompareOptions, SceneInput},
    result::{SceneResult, TruthSummary},
    row::{Judge, RowImages, SceneRun},
    seen::SceneView,
    settings::NamedSetting,
    timing::DeviceClock,
};
use crate::{color, error::LabError};
use umbrage_core::{Camera, Geometry, Invalid, Scene, metrics::Pixel};
use umbrage_plan::truth::{self, Truth, TruthOptions};

/// Images of one scene.
#[derive(Clone, Debug)]
pub struct SceneImages {
    /// Ray-traced truth.
    pub truth: Truth,
    /// Images of each row, in the result's order.
    pub rows: Vec<RowImages>,
}

/// Traces truth of a scene and executes all settings on all backends. With `heat`, keeps the
/// locations of each row's lookups.
pub(super) fn run(
    input: &SceneInput,
    settings: &[NamedSetting],
    options: &CompareOptions,
    heat: bool,
    backends: &mut Backends,
    on_event: &OnEvent<'_>,
) -> Result<(SceneResult, SceneImages), LabError> {
    // Trace truth.
    let scene = &input.scene;
    let (camera, light) = input.camera_and_light()?;
    let camera = options.camera(camera);
    let geometry = Geometry::bake(scene)?;
    let view = SceneView {
        camera: &camera,
        light,
        geometry: &geometry,
    };
    let truth = truth(&view, &options.truth, backends, on_event)?;
    let stage = if options.color {
        Some(color_stage(input, &camera)?)
    } else {
        None
    };
    // Execute all settings.
    let mut run = SceneRun {
        name: &scene.name,
        view,
        options,
        judge: Judge::new(&truth)?,
        stage,
        rows: Vec::new(),
        controls: Vec::new(),
        map_uses: MapUses::new(heat),
        executed: Vec::new(),
        scene_times: Vec::new(),
        seen: backends.backends.iter().map(|_| None).collect(),
    };
    backends.device_clock = DeviceClock::new(None);
    for setting in settings {
        run.add_setting(setting, backends, on_event)?;
    }
    // Collect the results.
    let truth_summary = summary(&truth, options);
    let rmse_of_none = [1.0, 0.0].map(|visibility| run.judge.rmse_of_constant(visibility));
    let (rows, images) = run.rows.into_iter().unzip();
    let mut result = SceneResult {
        name: scene.name.clone(),
        summary: input.summary.clone(),
        section: input.section,
        motion: options.motion,
        light: light.kind().to_owned(),
        is_ideal: light.is_ideal(),
        size: camera.size.to_array(),
        triangles: geometry.triangles().len() as u64,
        fingerprint: format!("{:016x}", truth.fingerprint),
        nothing_compared: nothing_compared(&truth_summary, truth.pixels.len()),
        truth: truth_summary,
        hint: hint(scene, rmse_of_none)?,
        rmse_of_none,
        rows,
        controls: run.controls,
    };
    if let Some(yardstick_ms) = backends.device_clock.least_yardstick() {
        result.set_full_clock(yardstick_ms);
    }
    let images = SceneImages {
        truth,
        rows: images,
    };
    Ok((result, images))
}

/// Returns stored truth, or traces and stores it.
fn truth(
    view: &SceneView<'_>,
    options: &TruthOptions,
    backends: &mut Backends,
    on_event: &OnEvent<'_>,
) -> Result<Truth, LabError> {
    let receivers = &mut backends.receivers;
    if let Some(kept) = &backends.kept_truth {
        let seen = receivers.receivers(view.camera, view.geometry)?;
        if let Some(truth) = kept.read(view, options, seen) {
            return Ok(truth);
        }
    }
    let truth = truth::trace(
        view.camera,
        view.light,
        view.geometry,
        options,
        &mut |camera, geometry| receivers.receivers(camera, geometry),
        &|done, total| on_event(CompareEvent::Truth { done, total }),
    )?;
    if let Some(kept) = &backends.kept_truth
        && let Err(why) = kept.write(view, options, &truth)
    {
        // Truth is available, and the next run can trace it again.
        let notice = format!("Truth is not kept for the next run: {why}.");
        backends.notices.push(notice);
        backends.kept_truth = None;
    }
    Ok(truth)
}

/// Returns the scene for colour images from this camera, with a marker at the light.
fn color_stage(input: &SceneInput, camera: &Camera) -> Result<color::ColorScene, Invalid> {
    let scene = Scene {
        cameras: vec![*camera],
        ..input.scene.clone()
    };
    color::ColorScene::new(scene, input.fit)
}

fn summary(truth: &Truth, options: &CompareOptions) -> TruthSummary {
    let [mean_error, largest_error] = truth.standard_error();
    TruthSummary {
        samples: options.truth.samples,
        mean_error,
        largest_error,
        counted: count(&truth.pixels, Pixel::Counted),
        ambiguous: count(&truth.pixels, Pixel::Ambiguous),
        shadowed: shadowed(truth, Pixel::Counted) + shadowed(truth, Pixel::Ambiguous),
        shadowed_ambiguous: shadowed(truth, Pixel::Ambiguous),
        unlit: count(&truth.pixels, Pixel::Unlit),
        unsampled: count(&truth.pixels, Pixel::Unsampled),
        seconds: options.runs.map(|_| truth.elapsed.as_secs_f64()),
    }
}

fn count(pixels: &[Pixel], kind: Pixel) -> u64 {
    pixels.iter().filter(|pixel| **pixel == kind).count() as u64
}

/// Returns how many pixels of a kind are in shadow.
fn shadowed(truth: &Truth, kind: Pixel) -> u64 {
    let pixels = truth.pixels.iter().zip(&truth.visibility);
    let is_shadowed = |(pixel, visibility): &(&Pixel, &f32)| **pixel == kind && **visibility < 0.5;
    pixels.filter(is_shadowed).count() as u64
}

/// Returns a likely mistake in a scene of which nothing is lit. `None` for other scenes.
fn hint(scene: &Scene, rmse_of_none: [f64; 2]) -> Result<Option<String>, Invalid> {
    let [lit, dark] = rmse_of_none;
    if lit > 0.0 && dark == 0.0 {
        enclosed_light(scene)
    } else {
        Ok(None)
    }
}

/// Returns why no pixel counts. `None` if one does.
fn nothing_compared(truth: &TruthSummary, pixels: usize) -> Option<String> {
    if truth.counted > 0 {
        return None;
    }
    let ambiguous = truth.ambiguous;
    let unlit = truth.unlit;
    let empty = pixels as u64 - ambiguous - unlit - truth.unsampled;
    let help = if ambiguous > 0 {
        "; bring the light nearer, or make the scene larger compared with its distances"
    } else {
        ""
    };
    Some(format!(
        "no pixel was compared: of {pixels}, {empty} show no receiver, {unlit} face away from the light or are \
         outside its cone, and {ambiguous} are ambiguous within rounding{help}"
    ))
}
