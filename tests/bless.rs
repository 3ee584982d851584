//! Says which golden images differ from what is rendered now, or writes those named: `cargo xtask bless`.

use std::process::ExitCode;
use umbrage_tests::golden::{Golden, all};

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let known: Vec<String> = all().iter().map(Golden::name).collect();
    if let Some(unknown) = names.iter().find(|n| *n != "--all" && !known.contains(n)) {
        eprintln!(
            "error: there is no golden image `{unknown}`; use some of {}",
            known.join(", ")
        );
        return ExitCode::from(2);
    }
    let faults = all()
        .iter()
        .filter_map(|g| visit(g, &names).err())
        .map(|why| eprintln!("error: {why}"))
        .count();
    if faults == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn visit(golden: &Golden, names: &[String]) -> Result<(), String> {
    let (name, path) = (golden.name(), golden.path());
    let Err(why) = golden.check() else {
        println!("same     {}", path.display());
        return Ok(());
    };
    if names.iter().all(|n| *n != name && n != "--all") {
        println!(
            "differs  {} ({why}); to keep what is rendered now: cargo xtask bless {name}",
            path.display()
        );
        return Ok(());
    }
    golden.bless()?;
    println!(
        "written  {}: look at it before you commit it",
        path.display()
    );
    Ok(())
}
