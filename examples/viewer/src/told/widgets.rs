//! Where the panel's parts lie, as screen readers are told: tests find what they click by its words.

use serde_json::{Value, json};

/// Notes each frame's parts, once it was asked for them.
#[derive(Default)]
pub(crate) struct Widgets {
    parts: Vec<Value>,
}

impl Widgets {
    /// Returns the parts of the last frame: role, label, value, and the rectangle in points as left, top, right and bottom. Nothing until
    /// the frame after the first call.
    pub(crate) fn told(ctx: &egui::Context) -> Value {
        ctx.add_plugin(Self::default());
        ctx.enable_accesskit();
        ctx.with_plugin(|widgets: &mut Self| Value::Array(widgets.parts.clone()))
            .unwrap_or_default()
    }
}

impl egui::Plugin for Widgets {
    fn debug_name(&self) -> &'static str {
        "widgets"
    }

    fn output_hook(&mut self, _: &egui::Context, output: &mut egui::FullOutput) {
        let Some(update) = output.platform_output.accesskit_update.take() else {
            return;
        };
        let told = |node: &egui::accesskit::Node| {
            let at = node.bounds()?;
            Some(json!({
                "role": format!("{:?}", node.role()),
                "label": node.label(),
                "value": node.value(),
                "at": [at.x0, at.y0, at.x1, at.y1],
            }))
        };
        self.parts = update.nodes.iter().filter_map(|(_, n)| told(n)).collect();
    }
}
