//! A strip of images for a plan: truth, the chosen setting and cheaper ones, with their errors
//! below.

use crate::{error::LabError, output::png};
use glam::{UVec2, Vec3};
use kuva::{
    backend::png::PngBackend,
    render::render::{Primitive, Scene as Drawing, TextAnchor},
};
use umbrage_plan::{Look, Setting};

/// Maximum width of an image, pixels.
pub(super) const WIDTH: u32 = 426;
/// Gap between images, pixels.
const GAP: u32 = 6;
/// Height of a line of text, pixels.
const LINE: u32 = 18;
/// Font size, pixels.
const LETTERS: u32 = 13;
/// Average width of a character, pixels.
const LETTER_WIDTH: u32 = 7;

/// A column of the strip.
struct Column<'a> {
    /// Two lines of text above it.
    title: [String; 2],
    /// The mask. `None` if the setting can't be executed.
    mask: Option<&'a [f32]>,
    /// Whether its error is shown below.
    has_error: bool,
}

/// Returns the strip as a PNG. `look` has the masks of `chosen` and of `others` in this order.
/// `role` labels the others.
///
/// # Errors
/// Errors if the encoder fails.
pub(super) fn strip(
    look: &Look,
    chosen: &Setting,
    role: &str,
    others: &[&Setting],
) -> Result<Vec<u8>, LabError> {
    // Collect the columns.
    let mut columns = vec![Column {
        title: ["truth".to_owned(), "ray-traced".to_owned()],
        mask: Some(&look.truth),
        has_error: false,
    }];
    let settings: Vec<&Setting> = std::iter::once(chosen)
        .chain(others.iter().copied())
        .collect();
    // Show measured times only if all settings have them: predicted times are not comparable.
    let all_timed = settings.iter().all(|s| s.measured_ms.is_some());
    for (k, (setting, mask)) in settings.iter().zip(&look.masks).enumerate() {
        let role = if k == 0 { "chosen" } else { role };
        let time = match setting.measured_ms {
            Some(ms) if all_timed => format!("{ms:.2} ms"),
            _ => format!("about {:.2} ms", setting.milliseconds),
        };
        let figures = format!("{role}: error {:.3}, {time}", setting.estimate.error);
        columns.push(Column {
            title: [setting.label(), figures],
            mask: mask.as_deref(),
            has_error: true,
        });
    }
    // Draw the texts, and paste the images.
    let size = UVec2::new(
        columns.len() as u32 * (look.size.x + GAP) - GAP,
        2 * LINE + 2 * look.size.y + GAP,
    );
    let mut colors = text(size, look.size, &columns)?;
    for (k, column) in (0..).zip(&columns) {
        let left = k * (look.size.x + GAP);
        let Some(mask) = column.mask else { continue };
        let shown = png::mask_colors(mask, &look.pixels);
        paste(
            &mut colors,
            size,
            &shown,
            look.size,
            UVec2::new(left, 2 * LINE),
        );
        if column.has_error {
            let errors = png::error_colors(mask, &look.truth, &look.pixels);
            let top = 2 * LINE + look.size.y + GAP;
            paste(&mut colors, size, &errors, look.size, UVec2::new(left, top));
        }
    }
    png::encode(size, colors.into_iter())
}

/// Returns a white image with the columns' titles and, below truth, the legend of the error
/// colours.
fn text(size: UVec2, part: UVec2, columns: &[Column<'_>]) -> Result<Vec<Vec3>, LabError> {
    let mut drawing = Drawing::new(f64::from(size.x), f64::from(size.y));
    drawing.background_color = Some("white".to_owned());
    let most = (part.x / LETTER_WIDTH) as usize;
    let mut write = |left: u32, line_bottom: u32, words: &str| {
        drawing.elements.push(Primitive::Text {
            x: f64::from(left),
            y: f64::from(line_bottom) - 5.0,
            content: shorten_words(words, most),
            size: LETTERS,
            anchor: TextAnchor::Start,
            rotate: None,
            bold: false,
            color: None,
        });
    };
    for (k, column) in (0..).zip(columns) {
        let left = k * (part.x + GAP);
        write(left, LINE, &column.title[0]);
        write(left, 2 * LINE, &column.title[1]);
    }
    let top = 2 * LINE + part.y + GAP;
    let legend = [
        "Errors, each below its mask:",
        "blue: false shadow; orange: false light",
        "violet: excluded as ambiguous",
        "grey: faces away from the light",
    ];
    for (line, words) in (1..).zip(legend) {
        write(0, top + line * LINE, words);
    }
    let bytes = PngBackend { scale: 1.0 }
        .render_scene(&drawing)
        .map_err(|e| LabError::write("image", e))?;
    let picture = image::load_from_memory(&bytes).map_err(|e| LabError::write("image", e))?;
    let picture = picture.to_rgb8();
    let mut colors = vec![Vec3::ONE; (size.x * size.y) as usize];
    for (x, y, pixel) in picture.enumerate_pixels() {
        if x < size.x && y < size.y {
            let color = pixel.0.map(|component| f32::from(component) / 255.0);
            colors[(y * size.x + x) as usize] = Vec3::from_array(color);
        }
    }
    Ok(colors)
}

/// Returns a text shortened to this number of characters, with two dots at the end if it was cut.
fn shorten_words(words: &str, most: usize) -> String {
    if words.chars().count() <= most {
        return words.to_owned();
    }
    let kept: String = words.chars().take(most.saturating_sub(2)).collect();
    format!("{kept}..")
}

/// Copies an image into a larger one.
fn paste(into: &mut [Vec3], size: UVec2, picture: &[Vec3], part: UVec2, at: UVec2) {
    for y in 0..part.y {
        let start = ((at.y + y) * size.x + at.x) as usize;
        let source = (y * part.x) as usize;
        let width = part.x as usize;
        into[start..start + width].copy_from_slice(&picture[source..source + width]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::metrics::Pixel;
    use umbrage_plan::Estimate;
    use umbrage_techniques::TechniquePreset;

    fn setting() -> Setting {
        let preset = TechniquePreset::defaults()[0].clone();
        Setting {
            technique: preset.technique().name().to_owned(),
            preset,
            settings: "a very long list of settings that no picture is wide enough for".to_owned(),
            estimate: Estimate::default(),
            milliseconds: 1.0,
            draw_ms: 0.0,
            kept_as_camera_moves: None,
            bytes: 4,
            grain: None,
            shimmer: None,
            measured_ms: None,
            cameras: Vec::new(),
        }
    }

    #[test]
    fn a_strip_shows_masks_above_their_errors() {
        let size = UVec2::new(40, 30);
        let count = 40 * 30;
        let look = Look {
            size,
            pixels: vec![Pixel::Counted; count],
            truth: vec![1.0; count],
            masks: vec![Some(vec![1.0; count]), Some(vec![0.0; count]), None],
        };
        let chosen = setting();
        let bytes = strip(&look, &chosen, "cheaper", &[&chosen, &chosen]).expect("memory");
        let picture = image::load_from_memory(&bytes)
            .expect("a picture")
            .to_rgb8();
        assert_eq!(picture.dimensions(), (4 * 46 - 6, 36 + 66));
        let at = |column: u32, row: u32| picture.get_pixel(column * 46 + 20, 36 + row * 36 + 15).0;
        assert_eq!(at(0, 0), [255; 3], "truth is lit");
        assert_eq!(at(2, 0), [0; 3], "the second mask is dark");
        let false_shadow = at(2, 1);
        assert!(
            false_shadow[2] > 180 && false_shadow[0] < 20,
            "{false_shadow:?}"
        );
        let right = at(1, 1);
        assert!(right[0] > 240 && right[0] == right[2], "{right:?}");
        assert_eq!(at(3, 0), [255; 3], "what can't be executed is white");
        let title_has_ink = picture
            .enumerate_pixels()
            .any(|(_, y, p)| y < 36 && p.0[0] < 128);
        assert!(title_has_ink);
    }

    #[test]
    fn long_titles_are_cut() {
        assert_eq!(shorten_words("abcdefgh", 5), "abc..");
        assert_eq!(shorten_words("abc", 5), "abc");
    }
}
