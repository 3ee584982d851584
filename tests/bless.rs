//! Lists the kept files (golden images, checksums of assembled WGSL, the README's table of
//! techniques) that differ from the current results, or rewrites the named ones:
//! `cargo xtask bless`.

use std::{path::PathBuf, process::ExitCode};
use umbrage_tests::{
    assembled::{self, Assembled},
    golden::{self, Golden},
    technique_table,
};

/// A kept file that can be regenerated.
enum Kept {
    Golden(Golden),
    Assembled(Assembled),
    TechniqueTable,
}

impl Kept {
    fn all() -> Vec<Self> {
        let goldens = golden::all().into_iter().map(Self::Golden);
        let assembled = assembled::all().into_iter().map(Self::Assembled);
        let all = goldens.chain(assembled).chain([Self::TechniqueTable]);
        all.collect()
    }

    fn name(&self) -> String {
        match self {
            Self::Golden(golden) => golden.name(),
            Self::Assembled(assembled) => assembled.name.clone(),
            Self::TechniqueTable => technique_table::NAME.to_owned(),
        }
    }

    fn path(&self) -> PathBuf {
        match self {
            Self::Golden(golden) => golden.path(),
            Self::Assembled(_) => assembled::path(),
            Self::TechniqueTable => technique_table::path(),
        }
    }

    fn check(&self) -> Result<(), String> {
        match self {
            Self::Golden(golden) => golden.check(),
            Self::Assembled(assembled) => assembled.check(),
            Self::TechniqueTable => technique_table::check(),
        }
    }

    fn bless(&self) -> Result<(), String> {
        match self {
            Self::Golden(golden) => golden.bless(),
            Self::Assembled(assembled) => assembled.bless(),
            Self::TechniqueTable => technique_table::bless(),
        }
    }
}

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let all = Kept::all();
    let known: Vec<String> = all.iter().map(Kept::name).collect();
    if let Some(unknown) = names.iter().find(|n| *n != "--all" && !known.contains(n)) {
        eprintln!(
            "error: no kept file is called `{unknown}`; use some of {}",
            known.join(", ")
        );
        return ExitCode::from(2);
    }
    let faults = all
        .iter()
        .filter_map(|kept| visit(kept, &names).err())
        .map(|why| eprintln!("error: {why}"))
        .count();
    if faults == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn visit(kept: &Kept, names: &[String]) -> Result<(), String> {
    let name = kept.name();
    let path = kept.path();
    let Err(why) = kept.check() else {
        println!("same     {}", path.display());
        return Ok(());
    };
    if names.iter().all(|n| *n != name && n != "--all") {
        println!(
            "differs  {} ({why}); to keep the current result: cargo xtask bless {name}",
            path.display()
        );
        return Ok(());
    }
    kept.bless()?;
    println!(
        "written  {}: review it before you commit it",
        path.display()
    );
    Ok(())
}
