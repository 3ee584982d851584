//! An image of the facets, coloured by an answer, with a legend.

use crate::answer::FacetTable;
use anyhow::{Context as _, Result};
use image::{Rgb, RgbImage, imageops};
use kuva::{
    backend::png::PngBackend,
    render::render::{Primitive, Scene as Drawing, TextAnchor},
};
use rayon::prelude::*;
use umbrage_surfaces::{
    Facets, direction_at,
    glam::{DMat3, DVec2, DVec3},
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
    let drawn = image::load_from_memory(&bytes)?.to_rgb8();
    let [width, height] = SIZE.map(|size| size as u32);
    let mut image = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    imageops::replace(&mut image, &drawn, 0, 0);
    Ok(image.into_raw())
}

/// Draws the first facet along the ray of each pixel, in a parallel projection.
fn draw_facets(pixels: &mut [u8], facets: &Facets, answer: &FacetTable, scale: &Scale) {
    let up = facets.options().up;
    let eye = direction_at(EYE[0], EYE[1], up);
    let right = direction_at(EYE[0], EYE[1] + 90.0, up).cross(eye);
    let view = DMat3::from_cols(right, right.cross(eye), eye);
    // Fit all facets into the upper part.
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for p in (0..facets.count()).flat_map(|row| facets.corners_m(row)) {
        let p = view.transpose_mul_vec3(p);
        low = low.min(p);
        high = high.max(p);
    }
    let rows = SIZE[1] - LEGEND;
    let area = DVec2::new(SIZE[0] as f64, rows as f64);
    let extent = (high - low).truncate().max(DVec2::splat(f64::MIN_POSITIVE));
    let metres_per_pixel = (extent / (area - 40.0)).max_element();
    let middle = low.midpoint(high).truncate();
    // Rays begin and end beyond all facets, by more than any rounding.
    let beyond = 0.01 * (high - low).max_element();
    let step = eye * (low.z - high.z - 2.0 * beyond);
    let pixels = pixels.par_chunks_exact_mut(3).take(SIZE[0] * rows);
    pixels.enumerate().for_each(|(i, pixel)| {
        let at = DVec2::new((i % SIZE[0]) as f64, (i / SIZE[0]) as f64) + 0.5;
        let across = middle + (at - 0.5 * area) * metres_per_pixel;
        let start = view * across.extend(high.z + beyond);
        if let Some(row) = facets.first_along(start, step) {
            pixel.copy_from_slice(&scale.color(answer.shades()[row]));
        }
    });
}
