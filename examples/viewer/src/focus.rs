//! Keyboard focus: scrolls the focused part of the panel into view, and frames it.

use egui::{Color32, Id, LayerId, Order, Rect, Stroke};

/// The part with the keyboard focus.
#[derive(Default)]
pub(crate) struct Focus {
    last: Option<Id>,
    /// Rectangle of the part in the window, points.
    pub at: Option<Rect>,
}

fn focused_response(ctx: &egui::Context) -> Option<egui::Response> {
    let id = ctx.memory(|memory| memory.focused())?;
    ctx.read_response(id)
}

impl Focus {
    /// Scrolls the panel to a newly focused part. Must be called in the panel's scroll area.
    pub(crate) fn scroll(&mut self, ui: &egui::Ui) {
        let response = focused_response(ui.ctx());
        let id = response.as_ref().map(|response| response.id);
        self.at = response.as_ref().map(|response| response.rect);
        if id == self.last {
            return;
        }
        self.last = id;
        if let Some(response) = response.filter(|response| response.layer_id == ui.layer_id()) {
            // Leave a margin, so that neighbours are visible.
            ui.scroll_to_rect(response.rect.expand2(egui::vec2(0.0, 24.0)), None);
        }
    }

    /// Draws the frame, within `area` if the part is in the panel.
    pub(crate) fn draw(ctx: &egui::Context, panel: LayerId, area: Rect) {
        let Some(response) = focused_response(ctx) else {
            return;
        };
        let layer = LayerId::new(Order::Tooltip, Id::unique("focus"));
        let mut painter = ctx.layer_painter(layer);
        if response.layer_id == panel {
            painter.set_clip_rect(area);
        }
        let stroke = Stroke::new(2.0, Color32::from_rgb(255, 200, 60));
        let around = response.rect.expand(2.0);
        painter.rect_stroke(around, 3.0, stroke, egui::StrokeKind::Outside);
    }
}
