//! `docs/cards.md`: measurements of all adapters.

use super::{
    agreement::exact_techniques,
    data::{Card, CardTime},
};
use crate::compare::thousands;
use std::fmt::Write as _;
use umbrage_core::Fusing;

const HEAD: &str = "# Graphics cards

Measurements of umbrage on various adapters. `cargo xtask card --page` writes this page from the files in `docs/cards`; a dash
means not measured.

Software drivers are listed for the comparison of pixels only: their times are not representative of cards.

";

const TAIL: &str = "## Add your own

```sh
cargo xtask card --by 'Your Name' --out docs/cards/your-card.json
cargo xtask card --page
```

The first command takes about three minutes after it is built, and prints its results. `WGPU_ADAPTER_NAME` or `--adapter` chooses one of several
adapters. For a machine without a compiler or a network, `cargo xtask card --pack FOLDER` creates a folder with all required files.

`--prices docs/cards/your-card.json` of `compare` and `plan` uses the prices of that card.
";

/// Returns the page of cards as Markdown.
pub fn page(cards: &[Card]) -> String {
    let mut text = HEAD.to_owned();
    add_adapters(&mut text, cards);
    add_agreement(&mut text, cards);
    for card in cards {
        if let Some(times) = &card.times {
            add_times(&mut text, card, times);
        }
    }
    add_ratios(&mut text, cards);
    text + TAIL
}

fn add_adapters(text: &mut String, cards: &[Card]) {
    *text += "| adapter | driver | API | measured | vertices and depths | one rounding |\n|---|---|---|---|---|---|\n";
    for card in cards {
        let by = card.measured_by.as_deref().unwrap_or("-");
        let date = card.date.as_deref().unwrap_or("-");
        let commit = card.commit.as_deref().unwrap_or("-");
        let row = [
            &*card.adapter,
            &card.driver,
            &card.api,
            &format!("{date}, {by}, at {commit}"),
            card.grid.as_deref().unwrap_or("-"),
            &one_rounding(card.fusing),
        ];
        add_row(text, &row);
    }
}

/// Returns the operations that are rounded once.
fn one_rounding(fusing: Option<Fusing>) -> String {
    let Some(fusing) = fusing else {
        return "-".to_owned();
    };
    let mut fused = Vec::new();
    for (is_fused, what) in [
        (fusing.product_and_sum, "`a * b + c`"),
        (fusing.fma, "`fma`"),
        (fusing.guarded_product == Some(true), "`product(a, b) + c`"),
    ] {
        if is_fused {
            fused.push(what);
        }
    }
    if fused.is_empty() {
        return "nothing".to_owned();
    }
    fused.join(", ")
}

fn add_agreement(text: &mut String, cards: &[Card]) {
    let mut techniques = exact_techniques()
        .map(|technique| technique.name())
        .to_vec();
    // `exact` occurs with both structures.
    techniques.dedup();
    *text += "\n## Agreement with the CPU\n\nBits are those of masks where both backends see the same triangle. Techniques whose results don't depend on a rasteriser must have none that
differ. A decided pixel is one that rounding does not explain.\n\n";
    *text += &format!(
        "| adapter | pixels of the same triangle | bits that differ in `{}` | masks of all techniques | decided pixels that differ |\n|---|---:|---:|---:|---:|\n",
        techniques.join("`, `")
    );
    for card in cards {
        let agreement = card.agreement.clone().unwrap_or_default();
        let or_dash = |count: Option<u64>| count.map_or_else(|| "-".to_owned(), thousands);
        let bits_of = |name: &&str| or_dash(agreement.differing_bits.get(*name).copied());
        let bits: Vec<String> = techniques.iter().map(bits_of).collect();
        let row = [
            &*card.adapter,
            &or_dash(agreement.same_triangle_pixels),
            &bits.join(", "),
            &or_dash(agreement.masks),
            &or_dash(agreement.decided_pixels_off),
        ];
        add_row(text, &row);
    }
    for card in cards {
        for (i, finding) in card.findings().iter().enumerate() {
            if i == 0 {
                *text += &format!("\nFound on {}:\n\n", card.adapter);
            }
            *text += &format!("* {finding}\n");
        }
    }
    *text += "\n";
}

/// Adds a table of milliseconds: a row per setting, a column per frame.
fn add_times(text: &mut String, card: &Card, times: &[CardTime]) {
    let mut frames: Vec<&str> = Vec::new();
    let mut settings: Vec<[&str; 2]> = Vec::new();
    for time in times {
        if !frames.contains(&&*time.frame) {
            frames.push(&time.frame);
        }
        let setting = [&*time.technique, &*time.settings];
        if !settings.contains(&setting) {
            settings.push(setting);
        }
    }
    let clock = if card.is_software {
        "a software driver"
    } else {
        "at full clock"
    };
    *text += &format!(
        "## Milliseconds on {}, {clock}\n\nCasts, filters and lookup of one frame. Times in brackets were measured while the clock varied.\n\n| technique |",
        card.adapter
    );
    for frame in &frames {
        *text += &format!(" {frame} |");
    }
    *text += "\n|---|";
    *text += &"---:|".repeat(frames.len());
    *text += "\n";
    for [technique, setting] in settings {
        let mut cells = vec![format!("{technique} ({setting})")];
        for frame in &frames {
            let time = times.iter().find(|t| {
                t.frame == *frame && [&*t.technique, &*t.settings] == [technique, setting]
            });
            cells.push(match time {
                None => "-".to_owned(),
                Some(time) => match time.milliseconds {
                    Some(ms) => format!("{ms:.3}"),
                    None => format!("({:.3})", time.measured_milliseconds),
                },
            });
        }
        let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
        add_row(text, &cells);
    }
    *text += "\n";
}

fn add_ratios(text: &mut String, cards: &[Card]) {
    if cards.iter().all(|card| card.ratios.is_none()) {
        return;
    }
    *text += "## Times of umbrage over times of others\n\nRun in turn on the same adapter. Below 1, umbrage is faster.\n\n| adapter | timed | ratio |\n|---|---|---:|\n";
    for card in cards {
        for (what, ratio) in card.ratios.iter().flatten() {
            add_row(text, &[&card.adapter, what, &format!("{ratio:.2}")]);
        }
    }
    *text += "\n";
}

fn add_row(text: &mut String, cells: &[&str]) {
    *text += "|";
    for cell in cells {
        // Replace bars, which would end the cell.
        let cell = cell.replace('|', "/");
        // Writing to a string can't fail.
        let _ = write!(text, " {cell} |");
    }
    *text += "\n";
}
