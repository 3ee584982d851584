//! Focus of the keyboard: the panel's part is scrolled into view, and a frame is drawn around it.

use egui::{Color32, Id, LayerId, Order, Rect, Stroke};

/// The part that has the keyboard.
#[derive(Default)]
pub(crate) struct Focus {
    last: Option<Id>,
    /// Its rectangle in the window, points.
    pub at: Option<Rect>,
}

fn focused(ctx: &egui::Context) -> Option<egui::Response> {
    let id = ctx.memory(|memory| memory.focused())?;
    ctx.read_response(id)
}

impl Focus {
    /// Scrolls the panel to a part that has received the focus. Must be called in the panel's
    /// scroll area.
    pub(crate) fn scroll(&mut self, ui: &egui::Ui) {
        let response = focused(ui.ctx());
        let id = response.as_ref().map(|response| response.id);
        self.at = response.as_ref().map(|response| response.rect);
        if id == self.last {
            return;
        }
        self.last = id;
        if let Some(response) = response.filter(|response| response.layer_id == ui.layer_id()) {
            // A margin, so that neighbours show which way it goes on.
            ui.scroll_to_rect(response.rect.expand2(egui::vec2(0.0, 24.0)), None);
        }
    }

    /// Draws the frame, within `area` if the part is in the panel.
    pub(crate) fn draw(ctx: &egui::Context, panel: LayerId, area: Rect) {
        let Some(response) = focused(ctx) else {
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
