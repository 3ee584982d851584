//! `card`: measures one graphics adapter, or writes the page of those that were measured.

use crate::{
    args::{Backend, CardArguments, CardPart},
    costs, inputs,
    program::Program,
    progress::Progress,
    usage::Usage,
};
use anyhow::{Context as _, Result, bail};
use clap::ValueEnum as _;
use comfy_table::{CellAlignment, Table, presets::UTF8_FULL_CONDENSED};
use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};
use umbrage_lab::{card::*, compare::Backends};
use umbrage_plan::cost::fit;
use umbrage_wgpu::Gpu;

/// Runs of each recipe whose work is priced, at most.
const PRICED_RUNS: u32 = 20;

pub(crate) fn card(program: &Program, arguments: &CardArguments) -> Result<()> {
    if arguments.pack.is_some() {
        bail!(Usage(
            "--pack builds this repository's programs: run `cargo xtask card --pack FOLDER` in it"
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
        let why = format!("--page: no card is in `{}`", folder.display());
        bail!(Usage(why));
    }
    let file = folder.with_extension("md");
    fs::write(&file, page(&cards)).with_context(|| format!("`{}`", file.display()))?;
    println!("page: {} ({} adapters)", file.display(), cards.len());
    Ok(())
}

/// Measures the parts, and keeps the figures after each.
fn measure(program: &Program, arguments: &CardArguments) -> Result<()> {
    let start = Instant::now();
    let adapter = inputs::adapter(arguments.adapter.as_ref());
    let gpu = Gpu::new(&adapter)?;
    let mut card = Card::of_adapter(&gpu)?;
    drop(gpu);
    if let Some(commit) = &arguments.commit {
        card.commit = Some(commit.clone());
    }
    card.measured_by.clone_from(&arguments.by);
    let file = file_of(program, arguments)?;
    keep_other_parts(&mut card, &file);
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
    if let Some(agreement) = &card.agreement {
        agreement
            .findings
            .iter()
            .for_each(|line| println!("{line}"));
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
    let open = |backend: Backend| inputs::open(backend, arguments.adapter.as_ref());
    match part {
        CardPart::Adapter => {}
        CardPart::Agreement => {
            let mut backends = open(Backend::Both)?;
            card.agreement = Some(measure_agreement(&mut backends)?);
        }
        CardPart::Times => {
            let mut backends: Backends = open(Backend::Wgpu)?;
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
            None => println!("this program has no light set to time"),
        },
        CardPart::Prices => {
            let mut backends = open(Backend::Wgpu)?;
            if let Some(device) = backends.playing.first_mut() {
                let samples = costs::time_stages(&mut **device, PRICED_RUNS)?;
                card.prices = Some(fit(samples).model);
            }
        }
    }
    Ok(())
}

/// Returns the file for the figures, in a folder that is there.
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

/// Takes over what an earlier run measured on the same adapter, driver and commit.
fn keep_other_parts(card: &mut Card, file: &Path) {
    let Ok(before) = read(file) else {
        return;
    };
    let subject = |card: &Card| [&card.adapter, &card.driver, &card.api].map(String::clone);
    if subject(&before) != subject(card) || before.commit != card.commit {
        return;
    }
    card.agreement = before.agreement;
    card.times = before.times;
    card.ratios = before.ratios;
    card.prices = before.prices;
    if card.measured_by.is_none() {
        card.measured_by = before.measured_by;
    }
}

/// Returns what was found, a line each.
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
    }
    if let Some(agreement) = &card.agreement {
        let count = |count: Option<u64>| count.map_or_else(|| "-".to_owned(), |n| n.to_string());
        add(
            "pixels of the same triangle",
            count(agreement.same_triangle_pixels),
        );
        for (technique, bits) in &agreement.differing_bits {
            add(&format!("  of other bits in {technique}"), bits.to_string());
        }
        add(
            "decided pixels off, all techniques",
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
            None => format!("{:.3} ms, no steady clock", time.measured_milliseconds),
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
