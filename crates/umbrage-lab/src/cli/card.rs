//! `card`: measures a graphics adapter, or writes the page of all measured adapters.

use crate::{
    card::{Card, CardTime, FRAMES, measure_agreement, measure_times, page, read, read_all, write},
    cli::{
        args::shared::BackendName, costs, inputs, program::Program, progress::Progress,
        usage::Usage,
    },
    compare::Backends,
};
use anyhow::{Context as _, Result, bail};
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets::UTF8_FULL_CONDENSED};
use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};
use umbrage_plan::cost::fit;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask card                             all parts on the best adapter, in three minutes
  cargo xtask card --adapter nvidia --by 'Ada L.' --out docs/cards/my-card.json
  cargo xtask card --parts adapter,agreement   how it rounds, and whether its masks match the CPU's
  cargo xtask card --page                      write docs/cards.md from the files in docs/cards
  cargo xtask card --pack card                 a folder for a machine without compiler or network")]
pub(crate) struct CardArguments {
    /// Graphics adapter, by part of its name, such as nvidia. Default: that of WGPU_ADAPTER_NAME,
    /// else the best one
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Parts to measure. Default: all
    #[arg(long, value_name = "PART", value_delimiter = ',', value_enum)]
    pub(crate) parts: Vec<CardPart>,
    /// Output file (JSON), rewritten after each part. Default: target/card/card.json in the
    /// repository
    ///
    /// Parts that are not measured are kept from the file if adapter, driver and commit are the
    /// same. A file named here must not hold the figures of another adapter.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Name of the person who measures, for the page
    #[arg(long, value_name = "NAME")]
    pub(crate) by: Option<String>,
    /// Commit that was built; needed outside a repository
    #[arg(long, value_name = "HASH")]
    pub(crate) commit: Option<String>,
    /// Write the page of all cards instead: FOLDER.md from the files in FOLDER
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/cards", conflicts_with_all = ["adapter", "parts", "out", "by", "commit"])]
    pub(crate) page: Option<PathBuf>,
    /// Instead build, and pack the programs, a Vulkan loader and a run script into a folder
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["adapter", "parts", "out", "by", "commit", "page"])]
    pub(crate) pack: Option<PathBuf>,
}

/// A part of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CardPart {
    /// Name, driver, limits and rounding: takes seconds
    Adapter,
    /// Agreement of its masks with those of the CPU
    Agreement,
    /// Frame times of the representative settings of each technique
    Times,
    /// A light set compared with a hand-written program
    LightSet,
    /// Prices of work, for the planner
    Prices,
}

/// Maximum number of runs of each recipe in the price measurement.
const PRICED_RUNS: u32 = 20;

pub(crate) fn card(program: &Program, arguments: &CardArguments) -> Result<()> {
    if arguments.pack.is_some() {
        bail!(Usage(
            "--pack needs the repository of umbrage: run `cargo xtask card --pack FOLDER` there"
                .to_owned()
        ));
    }
    match &arguments.page {
        Some(folder) => write_page(folder),
        None => measure(program, arguments),
    }
}

/// Writes `FOLDER.md` from the cards in a folder.
fn write_page(folder: &Path) -> Result<()> {
    let cards = read_all(folder)?;
    if cards.is_empty() {
        let why = format!("--page: there is no card in `{}`", folder.display());
        bail!(Usage(why));
    }
    let Some(name) = folder.file_name() else {
        let why = format!("--page: `{}` has no name for a page", folder.display());
        bail!(Usage(why + "; name a folder such as docs/cards"));
    };
    let mut name = name.to_owned();
    name.push(".md");
    let file = folder.with_file_name(name);
    fs::write(&file, page(&cards)).with_context(|| format!("`{}`", file.display()))?;
    println!("page: {} ({} adapters)", file.display(), cards.len());
    Ok(())
}

/// Measures the parts. Writes the file after each of them.
fn measure(program: &Program, arguments: &CardArguments) -> Result<()> {
    let start = Instant::now();
    let gpu = inputs::gpu(arguments.adapter.as_ref())?;
    let mut card = Card::of_adapter(&gpu)?;
    drop(gpu);
    if let Some(commit) = arguments.commit.as_ref().filter(|c| !c.is_empty()) {
        card.commit = Some(commit.clone());
    }
    card.measured_by.clone_from(&arguments.by);
    let file = file_of(program, arguments)?;
    keep_other_parts(&mut card, &file, arguments.out.is_some())?;
    println!("on {} ({}; {})", card.adapter, card.api, card.driver);
    let parts = match &*arguments.parts {
        [] => CardPart::value_variants(),
        chosen => chosen,
    };
    for part in parts {
        measure_part(*part, program, arguments, &mut card)?;
        write(&file, &card)?;
    }
    println!("\n{}", table(&card));
    for line in card.findings() {
        println!("{line}");
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("card: {} ({seconds:.0} s)", file.display());
    Ok(())
}

fn measure_part(
    part: CardPart,
    program: &Program,
    arguments: &CardArguments,
    card: &mut Card,
) -> Result<()> {
    let name = part.to_possible_value().map(|v| v.get_name().to_owned());
    println!("measuring: {}", name.unwrap_or_default());
    let open = |backend: BackendName| inputs::open(backend, arguments.adapter.as_ref());
    match part {
        CardPart::Adapter => {}
        CardPart::Agreement => {
            let mut backends = open(BackendName::Both)?;
            card.agreement = Some(measure_agreement(&mut backends)?);
        }
        CardPart::Times => {
            let mut backends: Backends = open(BackendName::Wgpu)?;
            let progress = Progress::new();
            let times = measure_times(&FRAMES, &mut backends, &|event| progress.note(event));
            progress.finish();
            card.times = Some(times?);
        }
        CardPart::LightSet => match program.light_set_ratios {
            Some(measure) => {
                let ratios = measure(&inputs::adapter(arguments.adapter.as_ref()))?;
                card.ratios.get_or_insert_default().extend(ratios);
            }
            None => println!("skipped: this program has no light set benchmark"),
        },
        CardPart::Prices => {
            let mut backends = open(BackendName::Wgpu)?;
            if let Some(device) = backends.backends.first_mut() {
                let samples = costs::time_stages(&mut **device, PRICED_RUNS)?;
                card.prices = Some(fit(samples).model);
            }
        }
    }
    Ok(())
}

/// Returns the path of the output file. Creates its folder.
fn file_of(program: &Program, arguments: &CardArguments) -> Result<PathBuf> {
    let file = match &arguments.out {
        Some(file) => file.clone(),
        None => program.folder(None, "card").join("card.json"),
    };
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).with_context(|| format!("`{}`", folder.display()))?;
    }
    Ok(file)
}

/// Keeps the other parts of an earlier run with the same adapter, driver and commit. Any other file
/// is replaced, or refused if the user named it.
fn keep_other_parts(card: &mut Card, file: &Path, is_named: bool) -> Result<()> {
    if !file.exists() {
        return Ok(());
    }
    let subject = |card: &Card| {
        let commit = card.commit.as_deref().unwrap_or("no known commit");
        format!(
            "{} ({}; {}) at {commit}",
            card.adapter, card.api, card.driver
        )
    };
    let before = match read(file) {
        Ok(before) if subject(&before) == subject(card) => before,
        other => {
            let found = other.map_or_else(
                |e| format!("no card of this version ({})", e.why),
                |c| subject(&c),
            );
            if is_named {
                let why = format!(
                    "--out: `{}` holds {found}; name another file",
                    file.display()
                );
                bail!(Usage(why));
            }
            println!("replaced: {}, which held {found}", file.display());
            return Ok(());
        }
    };
    card.agreement = before.agreement;
    card.times = before.times;
    card.ratios = before.ratios;
    card.prices = before.prices;
    if card.measured_by.is_none() {
        card.measured_by = before.measured_by;
    }
    Ok(())
}

/// Returns a table with one line for each figure.
fn table(card: &Card) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_FULL_CONDENSED);
    table.set_header(["what", "found"]);
    let mut add = |what: &str, found: String| {
        table.add_row([what.to_owned(), found]);
    };
    if let Some(grid) = &card.grid {
        add("vertices and depths", grid.clone());
    }
    if let Some(fusing) = card.fusing {
        add(
            "one rounding for a * b + c",
            yes_or_no(fusing.product_and_sum),
        );
        add("one rounding for fma", yes_or_no(fusing.fma));
        if fusing.guarded_product == Some(true) {
            add(
                "one rounding for product(a, b) + c",
                "yes, an error".to_owned(),
            );
        }
    }
    if let Some(agreement) = &card.agreement {
        let count = |count: Option<u64>| count.map_or_else(|| "-".to_owned(), |n| n.to_string());
        add(
            "pixels of the same triangle",
            count(agreement.same_triangle_pixels),
        );
        for (technique, bits) in &agreement.differing_bits {
            add(
                &format!("  with different bits in {technique}"),
                bits.to_string(),
            );
        }
        add(
            "decided pixels that differ, all techniques",
            count(agreement.decided_pixels_off),
        );
    }
    for time in card.times.iter().flatten() {
        let CardTime {
            frame,
            technique,
            settings,
            ..
        } = time;
        let found = match time.milliseconds {
            Some(ms) => format!("{ms:.3} ms"),
            None => format!("{:.3} ms, unsteady clock", time.measured_milliseconds),
        };
        add(&format!("{frame}: {technique} ({settings})"), found);
    }
    for (what, ratio) in card.ratios.iter().flatten() {
        add(what, format!("{ratio:.2}"));
    }
    if let Some(prices) = &card.prices {
        for (kind, price) in umbrage_plan::cost::KIND_NAMES
            .iter()
            .zip(prices.nanoseconds)
        {
            add(&format!("price of a {kind}"), format!("{price:.3} ns"));
        }
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn yes_or_no(is_so: bool) -> String {
    if is_so { "yes" } else { "no" }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(adapter: &str) -> Card {
        Card {
            schema: crate::card::SCHEMA,
            adapter: adapter.to_owned(),
            commit: Some("292d276c".to_owned()),
            ..Card::default()
        }
    }

    #[test]
    fn a_named_file_of_another_card_is_kept() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("card.json");
        let mut mine = card("mine");
        keep_other_parts(&mut mine, &file, true).expect("there is none");
        let before = Card {
            ratios: Some([("light set".to_owned(), 1.25)].into()),
            ..card("mine")
        };
        write(&file, &before).expect("written");
        keep_other_parts(&mut mine, &file, true).expect("the same card");
        assert_eq!(mine, before);
        let mut other = card("other");
        let error = keep_other_parts(&mut other, &file, true).expect_err("another card");
        let text = error.to_string();
        assert!(error.is::<Usage>() && text.contains("holds mine"), "{text}");
        assert!(text.ends_with("at 292d276c; name another file"), "{text}");
        fs::write(&file, "no card").expect("written");
        keep_other_parts(&mut other, &file, true).expect_err("no card");
        keep_other_parts(&mut other, &file, false).expect("the usual file is replaced");
        assert_eq!(other, card("other"));
    }

    #[test]
    fn pages_are_called_as_their_folders() {
        let dir = tempfile::tempdir().expect("a folder");
        let folder = dir.path().join("my.cards");
        fs::create_dir(&folder).expect("a folder");
        write(&folder.join("a.json"), &card("mine")).expect("written");
        write_page(&folder).expect("a page");
        assert!(dir.path().join("my.cards.md").is_file());
        let cards_here = folder.join("..");
        fs::copy(folder.join("a.json"), dir.path().join("a.json")).expect("copied");
        let error = write_page(&cards_here).expect_err("no name");
        assert!(error.to_string().contains("has no name"), "{error}");
    }
}
