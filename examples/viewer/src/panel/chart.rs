//! The planner, and a chart of speed against accuracy with both sides and the settings of a plan.

use crate::{measure::cost::Cost, plan::PlanRequest, side::SIDES, viewer::Viewer};
use egui::Color32;
use egui_plot::{Legend, MarkerShape, Plot, PlotPoints, Points};
use umbrage::plan::{Plan, motion::FrameMotion};

/// Least error in the chart, since a logarithm has no zero.
const LEAST_ERROR: f64 = 1e-4;
const COLORS: [Color32; 2] = [
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(86, 180, 233),
];

/// Draws the planner's part of the panel.
pub(crate) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Cheapest technique for this view");
        let mut percent = 100.0 * viewer.settings.plan_error();
        let drag = egui::DragValue::new(&mut percent)
            .range(0.0..=100.0)
            .suffix(" %")
            .max_decimals(1);
        ui.add(drag)
            .on_hover_text("Greatest error, relative to the error without shadows");
        viewer.settings.plan_error = Some(percent / 100.0);
    });
    ui.horizontal(|ui| {
        for motion in [
            FrameMotion::Still,
            FrameMotion::CameraMoves,
            FrameMotion::AllMoves,
        ] {
            ui.selectable_value(&mut viewer.settings.motion, motion, motion.words());
        }
    });
    match &viewer.planning {
        Some((job, _)) => {
            let step = job.step();
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(step);
                if ui.button("Cancel").clicked() {
                    viewer.planning = None;
                }
            });
        }
        None => {
            if ui.button("Find it").clicked() {
                viewer.start_plan(ui.ctx());
            }
        }
    }
    if let Some((plan, request)) = viewer.plan.clone() {
        if viewer.plan_request().as_ref() != Some(&request) {
            ui.weak("Outdated: view, light or settings changed. Search again.");
        }
        outcome(viewer, ui, &plan);
    }
    plot(viewer, ui);
}

fn outcome(viewer: &mut Viewer, ui: &mut egui::Ui, plan: &Plan) {
    let Some(chosen) = &plan.chosen else {
        let reason = plan.miss.as_ref().map_or("", |miss| miss.reason.as_str());
        ui.label(reason);
        return;
    };
    ui.strong(chosen.label());
    ui.label(format!(
        "RMSE {:.4}, {:.2} ms estimated",
        chosen.estimate.error, chosen.milliseconds
    ));
    ui.horizontal(|ui| {
        for (i, name) in SIDES.iter().enumerate() {
            if ui.button(format!("Show it on the {name}")).clicked() {
                viewer.settings.sides[i].take(&chosen.preset);
                viewer.forget_side(i);
            }
        }
    });
    egui::CollapsingHeader::new("Why").show(ui, |ui| {
        for reason in &plan.reasons {
            ui.label(reason);
        }
    });
}

fn point(milliseconds: f64, error: f64) -> [f64; 2] {
    [
        milliseconds.max(1e-3).log10(),
        error.max(LEAST_ERROR).log10(),
    ]
}

fn plot(viewer: &Viewer, ui: &mut egui::Ui) {
    let motion = viewer.settings.motion;
    let wanted = viewer.plan_request();
    let powers =
        |mark: egui_plot::GridMark, _: &std::ops::RangeInclusive<f64>| power_of_ten(mark.value);
    Plot::new("speed against accuracy")
        .height(190.0)
        .x_axis_label("ms: circles estimated, crosses measured")
        .y_axis_label("RMSE")
        .x_axis_formatter(powers)
        .y_axis_formatter(powers)
        .x_grid_spacer(|input| marks_within(decades(-3..=4), input.bounds))
        .y_grid_spacer(|_| decades(-4..=0))
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .include_x(0.0)
        .include_x(2.0)
        .include_y(-4.0)
        .include_y(0.0)
        .legend(Legend::default().text_style(egui::TextStyle::Small))
        .show(ui, |plot| {
            // Ignore a plan of another request, which is not comparable with these points.
            let is_current = |plan: &&(Plan, PlanRequest)| wanted.as_ref() == Some(&plan.1);
            if let Some((plan, _)) = viewer.plan.as_ref().filter(is_current) {
                for setting in plan.runners_up.iter().chain(&plan.chosen) {
                    let at = point(setting.milliseconds, setting.estimate.error);
                    plot.points(if plan.chosen.as_ref() == Some(setting) {
                        marker("chosen", at, MarkerShape::Asterisk, 4.5, Color32::WHITE)
                    } else {
                        marker("front", at, MarkerShape::Diamond, 4.5, Color32::GRAY)
                    });
                }
            }
            for (i, name) in SIDES.iter().enumerate() {
                let figures = &viewer.figures.sides[i];
                let compared = figures.error.filter(|error| error.pixels > 0);
                let (Some(cost), Some(error)) = (figures.cost, compared) else {
                    continue;
                };
                let at = point(cost.milliseconds(motion), error.rmse);
                plot.points(marker(name, at, MarkerShape::Circle, 6.0, COLORS[i]));
                if let Some(measured) = measured_cost(viewer, i, &cost) {
                    let at = point(measured, error.rmse);
                    plot.points(marker(name, at, MarkerShape::Cross, 6.0, COLORS[i]));
                }
            }
        });
}

/// Returns the device time of a side's shadows of the selected light, milliseconds. `None` without
/// timestamps, and on software adapters. Map times are measured for all lights together, and
/// therefore only known for a single light.
fn measured_cost(viewer: &Viewer, side: usize, cost: &Cost) -> Option<f64> {
    let lookups = viewer.figures.sides[side].lookup_ms?;
    if !cost.draws(viewer.settings.motion) {
        return Some(lookups);
    }
    let lights = viewer.settings.lights.iter().filter(|light| light.is_on);
    let drawn = viewer.renderer.clock.as_ref()?.drawn_ms[side]?;
    (lights.count() == 1).then_some(lookups + drawn)
}

fn marker(
    name: &str,
    at: [f64; 2],
    shape: MarkerShape,
    radius: f32,
    color: Color32,
) -> Points<'static> {
    Points::new(name, PlotPoints::from(vec![at]))
        .shape(shape)
        .radius(radius)
        .color(color)
}

/// Returns grid lines at powers of ten.
fn decades(range: std::ops::RangeInclusive<i32>) -> Vec<egui_plot::GridMark> {
    range
        .map(|power| egui_plot::GridMark {
            value: f64::from(power),
            step_size: 1.0,
        })
        .collect()
}

/// Returns the label of a number with this logarithm.
fn power_of_ten(logarithm: f64) -> String {
    let value = 10_f64.powf(logarithm);
    if value >= 1.0 {
        format!("{value:.0}")
    } else {
        format!("{value}")
    }
}

/// Removes grid lines whose labels, centred below them, would exceed the edge of the chart.
fn marks_within(
    mut marks: Vec<egui_plot::GridMark>,
    bounds: (f64, f64),
) -> Vec<egui_plot::GridMark> {
    let (least, most) = bounds;
    // Half of a digit is 3.5 of the chart's 260 points.
    let half_digit = 0.0135 * (most - least);
    marks.retain(|mark| {
        let half = half_digit * power_of_ten(mark.value).len() as f64;
        least + half < mark.value && mark.value < most - half
    });
    marks
}
