//! Size of text and buttons, in addition to the display's scale factor.

use egui::Vec2;

/// Window size with the usual text size, pixels.
const USUAL: Vec2 = Vec2::new(1600.0, 1080.0);
/// Steps of the automatic zoom in 1.
const STEPS: f32 = 4.0;
/// Greatest automatic zoom, sufficient for 8K displays.
const MOST: f32 = 4.0;

/// Returns the zoom for a window of this size, in pixels divided by the display's scale factor.
/// Displays of many pixels with a scale factor of 1 would have tiny text. Small windows keep the
/// usual size, since smaller text is illegible.
pub(crate) fn automatic(size: Vec2) -> f32 {
    let times = (size / USUAL).min_elem();
    ((times * STEPS).floor() / STEPS).clamp(1.0, MOST)
}

/// Sets the window's zoom to the user's choice, or else to the automatic one.
pub(crate) fn update(ctx: &egui::Context, chosen: Option<f32>) {
    let wanted = chosen.unwrap_or_else(|| {
        let points = ctx.viewport_rect().size();
        automatic(points * ctx.zoom_factor())
    });
    if (wanted - ctx.zoom_factor()).abs() > 1e-3 {
        ctx.set_zoom_factor(wanted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_windows_have_large_text_and_small_ones_the_usual() {
        for (size, zoom) in [
            ([640.0, 480.0], 1.0),
            ([1280.0, 720.0], 1.0),
            ([1920.0, 1080.0], 1.0),
            ([2560.0, 1440.0], 1.25),
            ([3840.0, 2160.0], 2.0),
            ([1000.0, 2160.0], 1.0),
        ] {
            assert_eq!(automatic(size.into()), zoom, "{size:?}");
        }
    }
}
