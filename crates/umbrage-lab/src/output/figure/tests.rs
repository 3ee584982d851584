//! Charts are complete, escape all names, and omit values that an axis can't show.

use super::*;

fn figure() -> Figure {
    let label = "best & <b>".to_owned();
    let points = vec![
        Point {
            x_range: Some([5.0, 20.0]),
            label,
            ..Point::at_position(10.0, 0.01)
        },
        Point::at_position(0.0, 1.0),
        Point::at_position(f64::NAN, 1.0),
        Point::at_position(1000.0, 0.001),
    ];
    let line = Series {
        style: Style::Dashed(1.0),
        ..Series::line("front", "#000000", points.clone())
    };
    Figure::new("T <i>", "ms", "RMSE")
        .log(true, true)
        .with(Series::points("pcf", "#3b82e0", Marker::Star, points))
        .with(line)
        .with(Series::line("nothing", "#000000", Vec::new()))
}

#[test]
fn svg_is_whole_and_escapes_names() {
    let svg = figure().svg();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(
        svg.contains("RMSE") && svg.contains("pcf") && !svg.contains("<b>") && !svg.contains("<i>")
    );
    assert!(
        !svg.contains("NaN") && !svg.contains("inf"),
        "values that no axis can show are omitted"
    );
    assert!(!svg.contains("href"), "it is self-contained");
    assert_eq!(svg, figure().svg(), "the same each time");
}

#[test]
fn png_is_a_picture_of_twice_the_size() {
    let png = figure().png().expect("rendered");
    let picture = image::load_from_memory(&png).expect("a picture").to_rgb8();
    assert!(
        picture.width() > 1500 && picture.height() > 900,
        "{:?}",
        picture.dimensions()
    );
    let blue = picture
        .pixels()
        .filter(|p| p.0[2] > 180 && p.0[0] < 120)
        .count();
    assert!(blue > 50, "the markers are drawn: {blue} pixels");
}

#[test]
fn degenerate_figures_are_no_panic() {
    let same = Point::at_position(3.0, 3.0);
    for points in [
        vec![],
        vec![same.clone()],
        vec![same.clone(); 3],
        vec![same, Point::at_position(3.0, 1e9)],
    ] {
        for log in [false, true] {
            let series = Series::points("s", "#3b82e0", Marker::Cross, points.clone());
            let figure = Figure::new("", "", "").log(log, log).with(series);
            assert!(
                figure.svg().starts_with("<svg") && figure.png().is_ok(),
                "{points:?}"
            );
        }
    }
}

#[test]
fn references_are_drawn_where_an_axis_can_show_them() {
    let with = |references: &[Reference]| {
        Figure {
            references: references.to_vec(),
            ..figure()
        }
        .svg()
    };
    let dashes = |svg: &str| svg.matches(REFERENCE).count();
    let [across, up] = [
        Reference::Across(20.0, "best <1>".to_owned()),
        Reference::Up(0.01, "limit".to_owned()),
    ];
    let svg = with(&[across, up]);
    assert!(svg.contains("limit") && svg.contains("best") && !svg.contains("<1>"));
    assert!(dashes(&svg) >= 2 && dashes(&with(&[])) == 0);
    let nowhere = [
        Reference::Across(0.0, String::new()),
        Reference::Up(f64::NAN, String::new()),
    ];
    assert_eq!(with(&nowhere), with(&[]));
}

#[test]
fn ticks_are_short() {
    assert_eq!(
        [0.001, 0.5, 20.0, 1e6, 0.0].map(plain),
        ["0.001", "0.5", "20", "1e6", "0"]
    );
}
