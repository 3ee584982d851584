//! Speed against accuracy: where the two sides are, with what a plan found; and the least for this view.

use crate::{app::App, measure::cost::Cost, plan_job::PlannedFor, render::SIDES};
use egui_plot::{Legend, MarkerShape, Plot, PlotPoints, Points};
use umbrage::plan::{Plan, Setting, motion::FrameMotion};

/// Errors below this are drawn there: a logarithm has no zero.
const LEAST_ERROR: f64 = 1e-4;
const COLORS: [egui::Color32; 2] = [
    egui::Color32::from_rgb(230, 159, 0),
    egui::Color32::from_rgb(86, 180, 233),
];

/// Draws the planner's part of the panel.
pub(crate) fn show(app: &mut App, ui: &mut egui::Ui) {
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("The least for this view");
        let mut percent = 100.0 * app.settings.plan_error;
        let drag = egui::DragValue::new(&mut percent)
            .range(0.0..=100.0)
            .suffix(" %")
            .max_decimals(1);
        ui.add(drag)
            .on_hover_text("Greatest error, as a share of that of no shadow at all");
        app.settings.plan_error = percent / 100.0;
    });
    ui.horizontal(|ui| {
        for motion in [
            FrameMotion::Still,
            FrameMotion::CameraMoves,
            FrameMotion::AllMoves,
        ] {
            ui.selectable_value(&mut app.settings.motion, motion, motion.words());
        }
    });
    match app.plan_job.at() {
        Some(at) => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(at);
                if ui.button("Cancel").clicked() {
                    app.plan_job.cancel();
                }
            });
        }
        None => {
            if ui.button("Find it").clicked() {
                app.start_plan(ui.ctx());
            }
        }
    }
    if let Some((plan, planned_for)) = app.plan.clone() {
        if app.plan_wanted().as_ref() != Some(&planned_for) {
            ui.weak("Made for another view, light or setting: find it again.");
        }
        outcome(app, ui, &plan);
    }
    plot(app, ui);
}

fn outcome(app: &mut App, ui: &mut egui::Ui, plan: &Plan) {
    let Some(chosen) = &plan.chosen else {
        let reason = plan.miss.as_ref().map_or("", |miss| miss.reason.as_str());
        ui.label(reason);
        return;
    };
    ui.strong(chosen.label());
    ui.label(format!(
        "RMSE {:.4}, {:.2} ms by counts",
        chosen.estimate.error, chosen.milliseconds
    ));
    ui.horizontal(|ui| {
        for (i, name) in SIDES.iter().enumerate() {
            if ui.button(format!("Show it on the {name}")).clicked() {
                app.settings.sides[i].take(&chosen.preset);
                app.forget_mask(i);
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

fn plot(app: &App, ui: &mut egui::Ui) {
    let motion = app.settings.motion;
    let wanted = app.plan_wanted();
    let powers =
        |mark: egui_plot::GridMark, _: &std::ops::RangeInclusive<f64>| power_of_ten(mark.value);
    Plot::new("speed against accuracy")
        .height(190.0)
        .x_axis_label("ms: circles by counts, crosses measured")
        .y_axis_label("RMSE")
        .x_axis_formatter(powers)
        .y_axis_formatter(powers)
        .x_grid_spacer(|input| within(decades(-3..=4), input.bounds))
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
            // What was planned for something else is not beside these points.
            let is_of_now = |planned: &&(Plan, PlannedFor)| wanted.as_ref() == Some(&planned.1);
            if let Some((plan, _)) = app.plan.as_ref().filter(is_of_now) {
                let others = plan.runners_up.iter().chain(&plan.chosen);
                for setting in others {
                    plot.points(of_plan(setting, plan.chosen.as_ref() == Some(setting)));
                }
            }
            for (i, name) in SIDES.iter().enumerate() {
                let figures = &app.figures.sides[i];
                let compared = figures.error.filter(|error| error.pixels > 0);
                if let (Some(cost), Some(error)) = (figures.cost, compared) {
                    let at = point(cost.milliseconds(motion), error.rmse);
                    let marker = Points::new(*name, PlotPoints::from(vec![at]))
                        .shape(MarkerShape::Circle)
                        .radius(6.0)
                        .color(COLORS[i]);
                    plot.points(marker);
                    if let Some(measured) = measured(app, i, &cost) {
                        let at = point(measured, error.rmse);
                        let marker = Points::new(*name, PlotPoints::from(vec![at]))
                            .shape(MarkerShape::Cross)
                            .radius(6.0)
                            .color(COLORS[i]);
                        plot.points(marker);
                    }
                }
            }
        });
}

/// Returns what a side's shadows of the chosen light took on the device, milliseconds; none where that has no clock. What is drawn is timed
/// for all lights together, so that it is known of a single light alone.
fn measured(app: &App, side: usize, cost: &Cost) -> Option<f64> {
    let lookups = app.figures.sides[side].lookup_ms?;
    if !cost.draws(app.settings.motion) {
        return Some(lookups);
    }
    let lights = app.settings.lights.iter().filter(|light| light.is_on);
    let drawn = app.renderer.drawn_ms(side)?;
    (lights.count() == 1).then_some(lookups + drawn)
}

fn of_plan(setting: &Setting, is_chosen: bool) -> Points<'static> {
    let at = point(setting.milliseconds, setting.estimate.error);
    let (shape, color) = if is_chosen {
        (MarkerShape::Asterisk, egui::Color32::WHITE)
    } else {
        (MarkerShape::Diamond, egui::Color32::GRAY)
    };
    let name = if is_chosen { "chosen" } else { "front" };
    Points::new(name, PlotPoints::from(vec![at]))
        .shape(shape)
        .radius(4.5)
        .color(color)
}

/// Grid lines at powers of ten.
fn decades(range: std::ops::RangeInclusive<i32>) -> Vec<egui_plot::GridMark> {
    range
        .map(|power| egui_plot::GridMark {
            value: f64::from(power),
            step_size: 1.0,
        })
        .collect()
}

/// Returns how the number with this logarithm is written.
fn power_of_ten(logarithm: f64) -> String {
    let value = 10_f64.powf(logarithm);
    if value >= 1.0 {
        format!("{value:.0}")
    } else {
        format!("{value}")
    }
}

/// Keeps the grid lines whose numbers, which stand below their middles, do not stick out of the chart: they would be cut off.
fn within(mut marks: Vec<egui_plot::GridMark>, bounds: (f64, f64)) -> Vec<egui_plot::GridMark> {
    let (least, most) = bounds;
    // Half of a digit has 3.5 of the chart's 260 points.
    let half_digit = 0.0135 * (most - least);
    marks.retain(|mark| {
        let half = half_digit * power_of_ten(mark.value).len() as f64;
        least + half < mark.value && mark.value < most - half
    });
    marks
}
