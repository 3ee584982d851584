//! Charts as self-contained SVG and as PNG, with linear or logarithmic axes, error bars, labels and
//! a legend.
//!
//! ```
//! use umbrage_lab::output::figure::{Figure, Marker, Point, Series};
//! let points = [(1.0, 0.5), (10.0, 0.05), (100.0, 0.004)].map(|(x, y)| Point::at_position(x, y));
//! let series = Series::points("measured", "#3b82e0", Marker::Circle, points.to_vec());
//! let figure = Figure::new("Error falls with time", "milliseconds", "RMSE")
//!     .log(true, true)
//!     .with(series);
//! assert!(figure.svg().starts_with("<svg"));
//! # Ok::<(), umbrage_lab::LabError>(())
//! ```

use crate::error::LabError;
use kuva::prelude::{
    Layout, LegendPosition, LinePlot, MarkerShape, Plot, ReferenceLine, ScatterPlot, TickFormat,
};
use std::sync::Arc;

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The title.
    pub title: String,
    /// A smaller line below the title. May be empty.
    pub subtitle: String,
    /// Labels of the x and y axis, with units.
    pub labels: [String; 2],
    /// Whether the x and y axis are logarithmic.
    pub log: [bool; 2],
    /// Width and height without the legend, pixels.
    pub size: [f64; 2],
    /// The series, in drawing order.
    pub series: Vec<Series>,
    /// Additional markers of the legend, for series whose colours have another meaning.
    pub keys: Vec<Key>,
    /// Text labels, moved apart if they would overlap.
    pub notes: Vec<Point>,
    /// Reference lines for comparison.
    pub references: Vec<Reference>,
}

/// A dashed line across the whole chart with a label. Omitted if its axis can't show the value.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// A vertical line at an x value.
    Across(f64, String),
    /// A horizontal line at a y value.
    Up(f64, String),
}

/// A marker of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Meaning of the marker.
    pub name: String,
    /// Shape of the marker.
    pub marker: Marker,
    /// Colour as CSS, independent of the series.
    pub color: String,
}

/// Points with the same style.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend. Empty to omit it.
    pub name: String,
    /// Colour as CSS, such as `#3b82e0`.
    pub color: String,
    /// The style of its points.
    pub style: Style,
    /// The points. Those that an axis can't show (not finite, or not above 0 on a logarithmic axis)
    /// are omitted.
    pub points: Vec<Point>,
}

/// The style of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Style {
    /// Markers: shape, radius in pixels and opacity 0..=1.
    Points(Marker, f64, f64),
    /// A line through the points: width in pixels.
    Line(f64),
    /// A dashed line through the points: width in pixels.
    Dashed(f64),
}

/// Shapes of markers, distinguishable in black and white.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names are self-explanatory")]
pub enum Marker {
    Circle,
    Square,
    Diamond,
    Triangle,
    TriangleDown,
    Cross,
    Plus,
    Star,
    Pentagon,
    Hexagon,
}

impl Marker {
    /// All shapes. Neighbours in this order differ most.
    pub const ALL: [Self; 10] = [
        Self::Circle,
        Self::Diamond,
        Self::Square,
        Self::Triangle,
        Self::Star,
        Self::TriangleDown,
        Self::Hexagon,
        Self::Pentagon,
        Self::Cross,
        Self::Plus,
    ];

    fn shape(self) -> MarkerShape {
        match self {
            Self::Circle => MarkerShape::Circle,
            Self::Square => MarkerShape::Square,
            Self::Diamond => MarkerShape::Diamond,
            Self::Triangle => MarkerShape::Triangle,
            Self::TriangleDown => MarkerShape::TriangleDown,
            Self::Cross => MarkerShape::Cross,
            Self::Plus => MarkerShape::Plus,
            Self::Star => MarkerShape::Star,
            Self::Pentagon => MarkerShape::Pentagon,
            Self::Hexagon => MarkerShape::Hexagon,
        }
    }
}

/// One point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// X value.
    pub x: f64,
    /// Y value.
    pub y: f64,
    /// Ends of the horizontal error bar. `None` without one.
    pub x_range: Option<[f64; 2]>,
    /// Ends of the vertical error bar. `None` without one.
    pub y_range: Option<[f64; 2]>,
    /// Label next to it. May be empty.
    pub label: String,
}

impl Point {
    /// Returns a point without error bars and label.
    pub fn at_position(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }
}

impl Series {
    /// Returns a series of markers with the default size.
    pub fn points(
        name: impl Into<String>,
        color: &str,
        marker: Marker,
        points: Vec<Point>,
    ) -> Self {
        Self {
            name: name.into(),
            color: color.to_owned(),
            style: Style::Points(marker, 5.0, 0.9),
            points,
        }
    }

    /// Returns a series that is a line with the default width.
    pub fn line(name: impl Into<String>, color: &str, points: Vec<Point>) -> Self {
        Self {
            name: name.into(),
            color: color.to_owned(),
            style: Style::Line(2.0),
            points,
        }
    }
}

/// Colours for series, distinguishable with all kinds of colour vision (Okabe, Ito 2008, "Color
/// Universal Design").
pub const COLORS: [&str; 7] = [
    "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#555555",
];

/// Colour of reference lines, darker than all series.
const REFERENCE: &str = "#7a1f1a";

/// Colour of texts.
const INK: &str = "#4a5563";

/// PNG pixels per SVG pixel, for high-resolution screens.
const PNG_SCALE: f32 = 2.0;

impl Figure {
    /// Returns an empty chart with linear axes.
    pub fn new(title: impl Into<String>, x: impl Into<String>, y: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            labels: [x.into(), y.into()],
            log: [false; 2],
            size: [760.0, 500.0],
            series: Vec::new(),
            keys: Vec::new(),
            notes: Vec::new(),
            references: Vec::new(),
        }
    }

    /// Makes axes logarithmic.
    #[must_use]
    pub fn log(self, x: bool, y: bool) -> Self {
        Self {
            log: [x, y],
            ..self
        }
    }

    /// Adds a series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Returns the chart as a self-contained SVG.
    pub fn svg(&self) -> String {
        let (plots, layout) = self.plots();
        self.scale_svg(&kuva::render_to_svg(plots, layout))
    }

    /// Adds a view box to a rendered image: without it, pages that show it at another size would
    /// crop it.
    fn scale_svg(&self, svg: &str) -> String {
        let [width, height] = self.size;
        remove_numbers(svg).replacen(
            "<svg ",
            &format!("<svg viewBox=\"0 0 {width} {height}\" "),
            1,
        )
    }

    /// Returns the chart as a PNG.
    ///
    /// # Errors
    /// Errors if the renderer fails.
    pub fn png(&self) -> Result<Vec<u8>, LabError> {
        let (plots, layout) = self.plots();
        kuva::render_to_png(plots, layout, PNG_SCALE).map_err(|e| LabError::write("figure", e))
    }

    fn plots(&self) -> (Vec<Plot>, Layout) {
        let mut plots: Vec<Plot> = self.series.iter().filter_map(|s| self.plot(s)).collect();
        if plots.is_empty() {
            // The renderer needs data for the layout of its axes.
            let corners = vec![Point::at_position(1.0, 1.0), Point::at_position(10.0, 10.0)];
            plots.extend(self.plot(&unseen_series("", "#ffffff", Marker::Circle, corners)));
        }
        // Draw texts as labels of invisibly small markers.
        let notes = unseen_series("", INK, Marker::Circle, self.notes.clone());
        plots.extend(self.plot(&notes));
        // Draw a key as an invisibly small marker with a legend entry, at an existing point.
        let anywhere = self
            .series
            .iter()
            .flat_map(|s| &s.points)
            .find(|p| self.shows(p));
        if let Some(point) = anywhere {
            for key in &self.keys {
                let place = vec![Point::at_position(point.x, point.y)];
                plots.extend(self.plot(&unseen_series(&key.name, &key.color, key.marker, place)));
            }
        }
        let mut layout = Layout::auto_from_plots(&plots)
            .with_title(&self.title)
            .with_x_label(&self.labels[0])
            .with_y_label(&self.labels[1])
            .with_width(self.size[0])
            .with_height(self.size[1])
            .with_legend_position(LegendPosition::OutsideRightTop)
            .with_font_family("DejaVu Sans, Verdana, sans-serif");
        if !self.subtitle.is_empty() {
            layout = layout.with_subtitle(&self.subtitle);
        }
        for reference in self.references.iter().filter_map(|r| self.reference(r)) {
            layout = layout.with_reference_line(reference);
        }
        let plain = || TickFormat::Custom(Arc::new(plain));
        if self.log[0] {
            layout = layout.with_log_x().with_x_tick_format(plain());
        }
        if self.log[1] {
            layout = layout.with_log_y().with_y_tick_format(plain());
        }
        (plots, layout)
    }

    fn shows(&self, p: &Point) -> bool {
        fits(p.x, self.log[0]) && fits(p.y, self.log[1])
    }

    /// Returns the line of a reference. `None` if its axis can't show it.
    fn reference(&self, reference: &Reference) -> Option<ReferenceLine> {
        let (line, label) = match reference {
            Reference::Across(v, label) if fits(*v, self.log[0]) => {
                (ReferenceLine::vertical(*v), label)
            }
            Reference::Up(v, label) if fits(*v, self.log[1]) => {
                (ReferenceLine::horizontal(*v), label)
            }
            _ => return None,
        };
        Some(line.with_color(REFERENCE).with_label(label.clone()))
    }

    /// Returns a series for the renderer. `None` if no point can be shown.
    fn plot(&self, series: &Series) -> Option<Plot> {
        let points: Vec<&Point> = series.points.iter().filter(|p| self.shows(p)).collect();
        if points.is_empty() {
            return None;
        }
        let xy = points.iter().map(|p| (p.x, p.y));
        Some(match series.style {
            Style::Line(width) | Style::Dashed(width) => {
                let mut line = LinePlot::new()
                    .with_data(xy)
                    .with_color(&series.color)
                    .with_stroke_width(width);
                if matches!(series.style, Style::Dashed(_)) {
                    line = line.with_dashed();
                }
                if series.name.is_empty() {
                    line.into()
                } else {
                    line.with_legend(&series.name).into()
                }
            }
            Style::Points(marker, radius, opacity) => {
                let scatter = ScatterPlot::new()
                    .with_data(xy)
                    .with_color(&series.color)
                    .with_marker(marker.shape());
                let scatter = scatter.with_size(radius).with_marker_opacity(opacity);
                let scatter = annotate_points(scatter, &points);
                if series.name.is_empty() {
                    scatter.into()
                } else {
                    scatter.with_legend(&series.name).into()
                }
            }
        })
    }
}

/// Returns a series of invisibly small markers.
fn unseen_series(name: &str, color: &str, marker: Marker, points: Vec<Point>) -> Series {
    Series {
        style: Style::Points(marker, 0.1, 1.0),
        ..Series::points(name, color, marker, points)
    }
}

/// Reports whether an axis can show a value.
fn fits(v: f64, log: bool) -> bool {
    v.is_finite() && (v > 0.0 || !log)
}

/// Returns the lengths of an error bar below and above a value. 0 without an error bar.
fn arms(value: f64, range: Option<[f64; 2]>) -> (f64, f64) {
    let [from, to] = range.unwrap_or([value; 2]);
    ((value - from).max(0.0), (to - value).max(0.0))
}

/// Adds error bars and labels.
fn annotate_points(mut scatter: ScatterPlot, points: &[&Point]) -> ScatterPlot {
    if points.iter().any(|p| p.x_range.is_some()) {
        scatter = scatter.with_x_err_asymmetric(points.iter().map(|p| arms(p.x, p.x_range)));
    }
    if points.iter().any(|p| p.y_range.is_some()) {
        scatter = scatter.with_y_err_asymmetric(points.iter().map(|p| arms(p.y, p.y_range)));
    }
    if points.iter().any(|p| !p.label.is_empty()) {
        scatter = scatter
            .with_labels(points.iter().map(|p| p.label.clone()))
            .with_repel_labels();
    }
    scatter
}

/// Removes the numbers of clip paths. The renderer numbers them throughout a run of the program,
/// and a chart must not depend on earlier ones.
fn remove_numbers(svg: &str) -> String {
    let mut parts = svg.split("kuva-clip-");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        out += "clip";
        out += part.trim_start_matches(|c: char| c.is_ascii_digit());
    }
    out
}

/// Formats a number as short as possible: `0.001`, `0.5`, `20`, `1e6`.
fn plain(v: f64) -> String {
    let decades = v.abs().max(f64::MIN_POSITIVE).log10();
    if v != 0.0 && !(-4.0..5.0).contains(&decades) {
        format!("{v:.0e}")
    } else {
        format!("{}", (v * 1e6).round() / 1e6)
    }
}

#[cfg(test)]
mod tests;
