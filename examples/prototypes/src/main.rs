//! Three structures for exact shadows on a device, compared by what they move and test.
//!
//! Each answers all receivers of a frame, with making and lookup on the device, and is compared
//! with the library's rays bit by bit. `docs/exact.md` has the results.

mod device;
mod frame;
mod grid;
mod lookup;
mod outcome;
mod rays;
mod receivers;
mod sort;
mod tree;

use anyhow::{Result, ensure};
use clap::{Parser, ValueEnum};
use device::Device;
use frame::Frame;
use outcome::Outcome;
use std::time::Instant;
use tree::Space;
use umbrage::glam::UVec2;

/// Frames of `hardware.md`, and one with alpha-tested casters.
const FRAMES: [&str; 6] = ["night-room", "dancer", "street", "nave", "valley", "forest"];

/// Compares structures for exact shadows on a device.
#[derive(Parser)]
struct Options {
    /// Scene; may be repeated. All six without it.
    #[arg(long)]
    frame: Vec<String>,
    /// Candidate; may be repeated. All without it.
    #[arg(long)]
    candidate: Vec<Candidate>,
    /// Width and height of the image, pixels.
    #[arg(long, num_args = 2, default_values_t = [1280, 720])]
    size: Vec<u32>,
    /// Leaves out a receiver's casters, and fails unless the comparison reports it.
    #[arg(long)]
    spoil: bool,
}

/// A structure.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Candidate {
    /// Today's rays, for comparison.
    Rays,
    /// Lists of a grid of two levels.
    Grid,
    /// Irregular z-buffer.
    Receivers,
    /// Hierarchy in the world.
    World,
    /// Hierarchy over the light's view.
    View,
}

fn main() -> Result<()> {
    let options = Options::parse();
    let device = Device::open()?;
    let size = UVec2::new(options.size[0], options.size[1]);
    println!("{}, {} x {}", device.name, size.x, size.y);
    print_head();
    let names = if options.frame.is_empty() {
        FRAMES.map(str::to_owned).to_vec()
    } else {
        options.frame.clone()
    };
    let candidates = if options.candidate.is_empty() {
        Candidate::value_variants().to_vec()
    } else {
        options.candidate.clone()
    };
    let mut differing = 0;
    for name in &names {
        let start = Instant::now();
        let frame = Frame::load(&device, name, size, options.spoil)?;
        let [cast, look_up] = frame.hard.map(|time| 1e3 * time.as_secs_f64());
        eprintln!(
            "{name}: loaded in {:.1} s; hard 2048: cast {cast:.0} ms, lookup {look_up:.0} ms",
            start.elapsed().as_secs_f64()
        );
        for candidate in &candidates {
            let outcome = match candidate {
                // The hierarchy of the CPU has all casters.
                Candidate::Rays if options.spoil => continue,
                Candidate::Rays => {
                    let Some(outcome) = rays::run(&device, &frame)? else {
                        eprintln!("{name}: the hierarchy of the CPU exceeds a binding");
                        continue;
                    };
                    outcome
                }
                Candidate::Grid => grid::run(&device, &frame)?,
                Candidate::Receivers => receivers::run(&device, &frame)?,
                Candidate::World => tree::run(&device, &frame, Space::World)?,
                Candidate::View => tree::run(&device, &frame, Space::View)?,
            };
            let differ = print_row(&frame, &outcome);
            if options.spoil {
                ensure!(differ > 0, "a missing caster was not noticed");
            }
            differing += differ;
        }
    }
    if !options.spoil {
        ensure!(differing == 0, "{differing} answers differ from the rays'");
    }
    Ok(())
}

fn print_head() {
    println!(
        "| frame | casters | asking | candidate | differ | items/c | bytes/c | atomics/c | kept/c | scratch/c | tests | worst block | most tests | walked | longest | lockstep tests | lockstep walk | bytes/r | make ms | look up ms |"
    );
    println!("|---|{}", "--:|".repeat(19));
}

/// Prints a row of the table. Returns the number of answers that differ from those of rays.
fn print_row(frame: &Frame, outcome: &Outcome) -> usize {
    let counts = outcome.counts(frame);
    let asking = frame.faces_light.iter().filter(|&&f| f).count();
    let made = &outcome.made;
    println!(
        "| {} | {} | {asking} | {} | {} | {:.2} | {:.0} | {:.2} | {:.0} | {:.0} | {:.2} | {:.1} | {} | {:.1} | {} | {:.1} | {:.1} | {:.0} | {:.0} | {:.0} |",
        frame.name,
        frame.casters,
        outcome.candidate,
        counts.differing,
        made.items,
        made.bytes,
        made.atomics,
        made.kept,
        made.scratch,
        counts.tests,
        counts.worst_block,
        counts.most_tests,
        counts.walked,
        counts.longest_walk,
        counts.lockstep_tests,
        counts.lockstep_walk,
        counts.bytes,
        1e3 * outcome.make.as_secs_f64(),
        1e3 * outcome.look_up.as_secs_f64(),
    );
    counts.differing
}
