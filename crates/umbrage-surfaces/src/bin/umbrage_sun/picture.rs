//! An image of the facets, coloured by an answer, with a legend.

use crate::answer::FacetTable;
use anyhow::{Context as _, Result};
use kuva::{
    backend::png::PngBackend,
    render::render::{Primitive, Scene as Drawing, TextAnchor},
};
use umbrage_surfaces::{
    Facets, direction_at,
    glam::{DVec2, DVec3},
};

/// Size of an image, pixels.
const SIZE: [usize; 2] = [1280, 760];
/// Rows of the image below the facets.
const LEGEND: usize = 120;
/// Direction to the eye: azimuth and height, degrees.
const EYE: [f64; 2] = [155.0, 38.0];
/// Number of colours in the legend.
const STEPS: usize = 64;
/// Characters in a line of text.
const LINE: usize = 170;

/// Colours of numbers from 0 to the greatest.
pub(crate) struct Scale {
    most: f64,
}

impl Scale {
    pub(crate) fn of_answer(answer: &FacetTable) -> Self {
        let most = answer.shades().iter().copied().fold(0.0, f64::max);
        // All facets may be dark.
        Self {
            most: if most > 0.0 { most } else { 1.0 },
        }
    }

    /// Returns a colour in sRGB. The map's lightness rises, also for the colour-blind (Nuñez,
    /// Anderton, Renslow 2018, "Optimizing colormaps with consideration for color vision
    /// deficiency").
    pub(crate) fn color(&self, value: f64) -> [u8; 3] {
        let color = colorous::CIVIDIS.eval_continuous((value / self.most).clamp(0.0, 1.0));
        [color.r, color.g, color.b]
    }
}

/// Returns the image as a PNG, whose text chunk has the totals and the stated accuracy.
pub(crate) fn png(facets: &Facets, answer: &FacetTable) -> Result<Vec<u8>> {
    let scale = Scale::of_answer(answer);
    let report = answer.report(facets);
    let mut pixels = legend(&scale, answer, &report)?;
    draw_facets(&mut pixels, facets, answer, &scale);
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, SIZE[0] as u32, SIZE[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.add_text_chunk("Comment".to_owned(), report.join("\n"))?;
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(out)
}

/// Returns a white image with the legend and the report, three bytes a pixel.
fn legend(scale: &Scale, answer: &FacetTable, report: &[String]) -> Result<Vec<u8>> {
    let mut drawing = Drawing::new(SIZE[0] as f64, SIZE[1] as f64);
    drawing.background_color = Some("white".to_owned());
    let top = (SIZE[1] - LEGEND) as f64;
    let mut write = |x: f64, y: f64, content: String| {
        drawing.elements.push(Primitive::Text {
            x,
            y,
            content,
            size: 13,
            anchor: TextAnchor::Start,
            rotate: None,
            bold: false,
            color: None,
        });
    };
    write(20.0, top + 14.0, answer.shade_name().replace('_', " "));
    for i in 0..=4 {
        let value = scale.most * f64::from(i) / 4.0;
        write(
            110.0 + 80.0 * f64::from(i),
            top + 36.0,
            format!("{value:.2}"),
        );
    }
    for (line, text) in (0..).zip(report) {
        let short: String = text.chars().take(LINE).collect();
        write(20.0, top + 56.0 + 16.0 * f64::from(line), short);
    }
    for i in 0..STEPS {
        let [r, g, b] = scale.color(scale.most * (i as f64 + 0.5) / STEPS as f64);
        let fill = format!("#{r:02x}{g:02x}{b:02x}");
        drawing.elements.push(Primitive::Rect {
            x: 110.0 + 5.0 * i as f64,
            y: top,
            width: 5.0,
            height: 20.0,
            fill: fill.as_str().into(),
            stroke: None,
            stroke_width: None,
            opacity: None,
        });
    }
    let drawn = PngBackend { scale: 1.0 }.render_scene(&drawing);
    let bytes = drawn.ok().context("the legend can't be drawn")?;
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info()?;
    let mut buffer = vec![0; reader.output_buffer_size().context("too large")?];
    let info = reader.next_frame(&mut buffer)?;
    let samples = info.color_type.samples();
    let mut pixels = vec![255; SIZE[0] * SIZE[1] * 3];
    for y in 0..SIZE[1].min(info.height as usize) {
        for x in 0..SIZE[0].min(info.width as usize) {
            let from = (y * info.width as usize + x) * samples;
            let to = (y * SIZE[0] + x) * 3;
            pixels[to..to + 3].copy_from_slice(&buffer[from..from + 3]);
        }
    }
    Ok(pixels)
}

/// Draws facets with a depth buffer, in a parallel projection.
fn draw_facets(pixels: &mut [u8], facets: &Facets, answer: &FacetTable, scale: &Scale) {
    let up = facets.options().up;
    let eye = direction_at(EYE[0], EYE[1], up);
    let right = direction_at(EYE[0], EYE[1] + 90.0, up).cross(eye);
    let above = eye.cross(right);
    let across = |p: DVec3| DVec3::new(p.dot(right), -p.dot(above), p.dot(eye));
    // Fit all facets into the upper part.
    let rows = 0..facets.count();
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for p in rows.clone().flat_map(|row| facets.corners_m(row)) {
        low = low.min(across(p));
        high = high.max(across(p));
    }
    let area = DVec2::new(SIZE[0] as f64 - 40.0, (SIZE[1] - LEGEND) as f64 - 40.0);
    let extent = (high - low).truncate().max(DVec2::splat(f64::MIN_POSITIVE));
    let zoom = (area / extent).min_element();
    let shift = (area + 40.0 - extent * zoom) / 2.0;
    let mut depths = vec![f64::NEG_INFINITY; SIZE[0] * SIZE[1]];
    for row in rows {
        let corners = facets.corners_m(row).map(|p| {
            let q = across(p) - low;
            (q.truncate() * zoom + shift).extend(q.z)
        });
        let color = scale.color(answer.shades()[row]);
        fill(pixels, &mut depths, corners, color);
    }
}

/// Fills the pixels whose centre is in a triangle, where it is the nearest to the eye.
fn fill(pixels: &mut [u8], depths: &mut [f64], corners: [DVec3; 3], color: [u8; 3]) {
    let [a, b, c] = corners;
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    let edge = |p: DVec3, q: DVec3, at: DVec2| (q - p).truncate().perp_dot(at - p.truncate());
    let twice_area = edge(a, b, c.truncate());
    // Facets that are edge-on have no pixels.
    if twice_area == 0.0 {
        return;
    }
    let range = |axis: usize| {
        let first = (low[axis] - 0.5).ceil().max(0.0) as usize;
        let last = (high[axis] - 0.5).floor().min(SIZE[axis] as f64 - 1.0);
        first..(last + 1.0) as usize
    };
    for y in range(1) {
        for x in range(0) {
            let at = DVec2::new(x as f64, y as f64) + 0.5;
            let weights = DVec3::new(edge(b, c, at), edge(c, a, at), edge(a, b, at)) / twice_area;
            if weights.min_element() < 0.0 {
                continue;
            }
            let depth = weights.dot(DVec3::new(a.z, b.z, c.z));
            let pixel = y * SIZE[0] + x;
            if depth > depths[pixel] {
                depths[pixel] = depth;
                pixels[3 * pixel..3 * pixel + 3].copy_from_slice(&color);
            }
        }
    }
}
