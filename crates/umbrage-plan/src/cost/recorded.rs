//! The built-in prices, and the times that they are fitted to.
//!
//! `recorded.csv` has lines of the `work.csv` of one whole `cargo xtask compare` on the idle
//! machine that [`CostModel::CPU`] names, each with the least times of its runs. It has all rows of
//! full-size scenes. It also has a seventh of the rows of small scenes with 100 triangles or
//! more. `record.sh` makes such lines from one or several `work.csv` files.

use super::{
    CostModel, KIND_NAMES,
    calibrate::{Calibration, CostSample, fit},
    counts,
    price_list::PriceList,
    ranks::rank_correlation,
    work::Work,
};
use std::collections::BTreeMap;

const RECORDED: &str = include_str!("recorded.csv");

/// Least rank correlation of counted cost and time over the rows of a frame of real size.
const LEAST: f64 = 0.9;

/// Frames with a lower rank correlation, each with its own bound.
///
/// Rays, and the points of `soft`, have one price per level of the hierarchy. In `valley`, rays
/// graze hills and `traced` takes longer than its counted cost. In `leaf-cards`, leaves end shafts
/// early and `soft` takes half. In `forest-soft`, 2.4 million triangles dominate the time of every
/// map, so many rows have similar times.
const RANKED_WORSE: [(&str, &str, f64); 3] = [
    ("valley", "cpu", 0.83),
    ("leaf-cards", "cpu", 0.87),
    ("forest-soft", "wgpu", 0.89),
];

/// Row of the table.
struct RecordedRow {
    section: String,
    scene: String,
    backend: String,
    label: String,
    work: Work,
    draw_ms: f64,
    lookup_ms: f64,
}

fn recorded_rows() -> Vec<RecordedRow> {
    let mut lines = RECORDED.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut out = Vec::new();
    for line in lines {
        let fields: BTreeMap<&str, &str> = header.iter().copied().zip(line.split(',')).collect();
        let count = |name: &str| fields[name].parse::<u64>().expect("a count");
        let time = |name: &str| fields[name].parse::<f64>().expect("a time");
        let work = Work {
            listed: 0,
            passes: count("passes"),
            triangles: count("triangles"),
            covered: count("covered"),
            cut_out: count("cut_out"),
            cleared: count("cleared"),
            filtered: count("filtered"),
            filter_taps: count("filter_taps"),
            receivers: count("receivers"),
            taps: count("taps"),
            samples: count("samples"),
            rays: count("rays"),
            casters: count("casters"),
            placed: count("placed"),
            walks: count("walks"),
            faces: count("faces"),
            counted: count("counted"),
            bytes: 0,
        };
        out.push(RecordedRow {
            section: fields["section"].to_owned(),
            scene: fields["scene"].to_owned(),
            backend: fields["backend"].to_owned(),
            label: fields["slug"].to_owned(),
            work,
            draw_ms: time("draw_ms"),
            lookup_ms: time("lookup_ms"),
        });
    }
    out
}

/// Returns the rows of full-size scenes, by scene and backend.
fn frames(rows: &[RecordedRow]) -> BTreeMap<[&str; 2], Vec<&RecordedRow>> {
    let mut out: BTreeMap<[&str; 2], Vec<&RecordedRow>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.section == "content") {
        let key = [row.scene.as_str(), row.backend.as_str()];
        out.entry(key).or_default().push(row);
    }
    out
}

/// Fits prices to all rows of a backend.
fn fit_rows(rows: &[RecordedRow], backend: &str) -> Calibration {
    let mut samples = Vec::new();
    for row in rows.iter().filter(|row| row.backend == backend) {
        let label = format!("{} {}", row.scene, row.label);
        let parts = CostSample::of_parts(&label, &row.work, row.draw_ms, row.lookup_ms);
        samples.extend(parts);
    }
    fit(samples)
}

fn correlation(rows: &[&RecordedRow], prices: &CostModel) -> f64 {
    let pair = |row: &&RecordedRow| [prices.milliseconds(&row.work), row.draw_ms + row.lookup_ms];
    let pairs: Vec<[f64; 2]> = rows.iter().map(pair).collect();
    rank_correlation(&pairs).expect("enough rows")
}

#[test]
fn built_in_prices_are_those_that_fit() {
    let rows = recorded_rows();
    for backend in ["cpu", "wgpu"] {
        let found = fit_rows(&rows, backend);
        let built_in = PriceList::default().model_for_backend(backend).nanoseconds;
        let reported = format!(
            "{backend}: {:?}, half within {:.2}, nine of ten within {:.2}",
            found.model.nanoseconds, found.typical_factor, found.factor_of_nine_in_ten
        );
        let has_work = |k: usize| {
            let mut of_backend = rows.iter().filter(|row| row.backend == backend);
            of_backend.any(|row| counts(&row.work)[k] > 0.0)
        };
        for (k, name) in KIND_NAMES.iter().enumerate().filter(|&(k, _)| has_work(k)) {
            let fits = found.model.nanoseconds[k];
            // Built-in prices are rounded to three digits.
            let near = (built_in[k] - fits).abs() <= 0.006 * fits + 1e-3;
            assert!(near, "{name} is {}, not {fits}; {reported}", built_in[k]);
        }
        let factor = CostModel::factor_of_nine_in_ten(backend);
        let near = (factor - found.factor_of_nine_in_ten).abs() < 0.02;
        assert!(near, "{factor}; {reported}");
    }
}

#[test]
fn prices_rank_recorded_times() {
    let rows = recorded_rows();
    let frames = frames(&rows);
    assert_eq!(frames.len(), 28, "14 frames on 2 backends");
    let prices = PriceList::default();
    let mut low = Vec::new();
    for ([scene, backend], rows) in &frames {
        assert!(rows.len() >= 12, "{scene} on {backend}: {}", rows.len());
        let found = correlation(rows, &prices.model_for_backend(backend));
        let named = RANKED_WORSE
            .iter()
            .find(|(s, b, _)| s == scene && b == backend);
        let least = named.map_or(LEAST, |(_, _, least)| *least);
        if found < least {
            low.push(format!("{scene} on {backend}: {found:.3}"));
        }
    }
    assert!(low.is_empty(), "{low:#?}");
}

/// The rank correlation detects wrong prices.
#[test]
fn wrong_prices_rank_badly() {
    let rows = recorded_rows();
    let mut of_taps_alone = CostModel {
        nanoseconds: [0.0; super::KINDS],
    };
    of_taps_alone.nanoseconds[6] = 1.0;
    let mut of_triangles_alone = CostModel {
        nanoseconds: [0.0; super::KINDS],
    };
    of_triangles_alone.nanoseconds[1] = 1.0;
    for prices in [of_taps_alone, of_triangles_alone] {
        let frames = frames(&rows);
        let low = frames
            .values()
            .filter(|rows| correlation(rows, &prices) < LEAST);
        assert!(low.count() >= 12, "{prices:?}");
    }
}
