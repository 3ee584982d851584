//! The viewer as a web page: built, optimised for size, and served.

use crate::{
    ci::{BROWSER_TARGET, install_browser_target},
    cli::WebOptions,
    run::{cargo, root, run, target_folder},
    serve::{Server, take_port},
    tools::Tool,
};
use anyhow::{Context as _, Result, bail};
use comfy_table::Table;
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

const PACKAGE: &str = "umbrage-viewer";
/// Profile of the build: 4 MB compressed, half of [`MOST_COMPRESSED`]. With optimisation across
/// crates at link time (`lto = "fat"`) the build had not ended after 15 minutes on two shared
/// cores.
const PROFILE: &str = "release";
/// Name that the page's script imports: `umbrage.js`, which loads `umbrage_bg.wasm`.
const STEM: &str = "umbrage";
const PAGE: &str = "examples/viewer/web/index.html";
/// Script of the page's workers.
const WORKER: &str = "examples/viewer/web/worker.js";

/// Images that the page shows if it can't run.
const PICTURES: [&str; 1] = ["docs/failures/acne.png"];

/// Greatest compressed size of the page without the images, bytes.
const MOST_COMPRESSED: u64 = 8_000_000;

/// Builds the page and, unless disabled, serves it until it is stopped.
pub(crate) fn web(options: &WebOptions) -> Result<()> {
    let target = target_folder()?;
    let out = match &options.out {
        Some(folder) => folder.clone(),
        None => target.join("web"),
    };
    // Report a port in use before minutes of building.
    let serve = &options.serve;
    let port = (!serve.no_serve)
        .then(|| take_port(serve.port))
        .transpose()?;
    build_page(&target, &out)?;
    println!("the page is in {}", out.display());
    match port {
        Some(port) => Server::start(port, &out)?.run(),
        None => Ok(()),
    }
}

/// Builds the page into a folder.
pub(crate) fn build_page(target: &Path, out: &Path) -> Result<()> {
    install_browser_target()?;
    let mut build = cargo();
    build.args(["build", "--package", PACKAGE, "--profile", PROFILE]);
    run(build.args(["--target", BROWSER_TARGET]))?;
    let built = target.join(BROWSER_TARGET).join(PROFILE);
    let wasm = built.join(format!("{PACKAGE}.wasm"));
    fs::create_dir_all(out).with_context(|| format!("cannot make {}", out.display()))?;
    bind(target, &wasm, out)?;
    optimise(&out.join(format!("{STEM}_bg.wasm")))?;
    copy(&root().join(PAGE), out)?;
    copy(&root().join(WORKER), out)?;
    let pictures = out.join("pictures");
    fs::create_dir_all(&pictures).with_context(|| format!("cannot make {}", pictures.display()))?;
    for picture in PICTURES {
        copy(&root().join(picture), &pictures)?;
    }
    print_sizes(out)
}

/// Writes the module that browsers load, and the script that loads it.
fn bind(target: &Path, wasm: &Path, out: &Path) -> Result<()> {
    let mut command = Command::new(bindgen(target)?);
    command.args(["--target", "web", "--no-typescript", "--out-name", STEM]);
    // Remove the names of functions, which are a tenth of the page.
    command.args(["--remove-name-section", "--remove-producers-section"]);
    run(command.arg("--out-dir").arg(out).arg(wasm))
}

/// Returns the program `wasm-bindgen` in the version that the viewer is built with; installs it if
/// needed.
fn bindgen(target: &Path) -> Result<PathBuf> {
    let version = locked_version(&fs::read_to_string(root().join("Cargo.lock"))?)?;
    let tool = Tool {
        package: "wasm-bindgen-cli",
        program: "wasm-bindgen",
        version: &version,
        reason: "it writes the script that loads the viewer, and must have the version in Cargo.lock",
        minutes: 3,
        options: &[],
    };
    tool.find_or_install(target)
}

/// Returns the version of `wasm-bindgen` in a lock file.
fn locked_version(lock: &str) -> Result<String> {
    let mut lines = lock.lines();
    lines
        .find(|line| *line == "name = \"wasm-bindgen\"")
        .and_then(|_| {
            lines
                .next()?
                .strip_prefix("version = \"")?
                .strip_suffix('"')
        })
        .map(str::to_owned)
        .context("Cargo.lock has no wasm-bindgen: run `cargo check -p umbrage-viewer`")
}

/// Reduces the size of a module if `wasm-opt` is installed. Old releases of it don't support the
/// output of current compilers; then the module stays unchanged.
fn optimise(wasm: &Path) -> Result<()> {
    if Command::new("wasm-opt").arg("--version").output().is_err() {
        println!(
            "wasm-opt is not on the PATH: the page is a few percent larger without it (Debian's package binaryen)"
        );
        return Ok(());
    }
    let smaller = wasm.with_extension("smaller");
    let mut command = Command::new("wasm-opt");
    command.args(["-O2", "--all-features"]).arg(wasm);
    match run(command.arg("-o").arg(&smaller)) {
        Ok(()) => {
            fs::rename(&smaller, wasm).with_context(|| format!("cannot replace {}", wasm.display()))
        }
        Err(error) => {
            println!("{error:#}; the page works without it, a few percent larger");
            Ok(())
        }
    }
}

fn copy(file: &Path, folder: &Path) -> Result<()> {
    let name = file
        .file_name()
        .context("the path to copy has no file name")?;
    let to = folder.join(name);
    fs::copy(file, &to)
        .with_context(|| format!("cannot copy {} to {}", file.display(), to.display()))?;
    Ok(())
}

/// Prints the sizes of the files to load before the first image.
fn print_sizes(out: &Path) -> Result<()> {
    let mut table = Table::new();
    table.set_header(["file", "bytes", "compressed (gzip)"]);
    let mut sum = Some(0);
    for name in ["index.html", "worker.js", "umbrage.js", "umbrage_bg.wasm"] {
        let file = out.join(name);
        let bytes = fs::metadata(&file)
            .with_context(|| format!("cannot read {}", file.display()))?
            .len();
        let small = compressed_bytes(&file);
        sum = sum.zip(small).map(|(sum, small)| sum + small);
        table.add_row([name, &bytes.to_string(), &bytes_label(small)]);
    }
    table.add_row(["all", "", &bytes_label(sum)]);
    println!("{table}");
    match sum {
        Some(sum) if sum > MOST_COMPRESSED => bail!(
            "the page has {sum} bytes compressed, limit {MOST_COMPRESSED}: find the file that grew in {}",
            out.display()
        ),
        _ => Ok(()),
    }
}

fn bytes_label(bytes: Option<u64>) -> String {
    bytes.map_or("gzip is missing".to_owned(), |bytes| bytes.to_string())
}

/// Returns the compressed size of a file as servers send it, bytes; `None` without `gzip`.
fn compressed_bytes(file: &Path) -> Option<u64> {
    let mut gzip = Command::new("gzip");
    gzip.args(["-9", "-c"]).arg(file).stderr(Stdio::null());
    let output = gzip.output().ok()?;
    output
        .status
        .success()
        .then_some(output.stdout.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_file_tells_the_version() {
        let lock = "[[package]]\nname = \"wasm-bindgen\"\nversion = \"0.2.130\"\n";
        assert_eq!(locked_version(lock).expect("told"), "0.2.130");
        assert!(locked_version("name = \"wasm-bindgen-futures\"").is_err());
    }

    #[test]
    fn the_page_and_its_pictures_are_there() {
        let page = fs::read_to_string(root().join(PAGE)).expect("readable");
        for picture in PICTURES {
            let file = root().join(picture);
            assert!(file.is_file(), "{picture}");
            let name = file.file_name().expect("a name").to_string_lossy();
            assert!(page.contains(&format!("pictures/{name}")), "{picture}");
        }
        let worker = fs::read_to_string(root().join(WORKER)).expect("readable");
        for script in [page, worker] {
            assert!(script.contains(&format!("./{STEM}.js")));
        }
    }
}
