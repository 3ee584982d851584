//! The documentation as a site: mdBook's pages of `docs`, and the viewer in a separate folder.

mod links;
mod source;
mod stage;

use crate::{
    cli::SiteOptions,
    run::{Usage, root, run, target_folder},
    serve::{Server, take_port},
    tools::Tool,
    web,
};
use anyhow::{Context as _, Result};
use links::MarkdownPages;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Converter of Markdown to pages with a table of contents and a search. It is built without the
/// features for serving and watching.
const MDBOOK: Tool<'_> = Tool {
    package: "mdbook",
    program: "mdbook",
    version: "0.5.4",
    reason: "it builds the pages; another version may name headings differently",
    minutes: 2,
    options: &["--no-default-features", "--features", "search"],
};

/// Checker of links in the built pages, since mdBook has its own rules for the names of headings.
/// It is a Python package, which installs in seconds.
const LINK_CHECKER: &str = "LinkChecker==10.6.0";
/// Configuration of the link checker: it checks headings, too, but not the viewer's page.
const LINK_RULES: &str = "[AnchorCheck]\n[checking]\nmaxrequestspersecond=1000\n[filtering]\nnofollow=\n  /viewer/\n[output]\nstatus=0\n";

/// File that marks a folder with a site, so that the next one may replace it.
const MARK: &str = ".umbrage-site";

/// Builds the site and, unless disabled, serves it until it is stopped.
pub(crate) fn site(options: &SiteOptions) -> Result<()> {
    // Check the output folder, the pages and the port before minutes of building.
    let target = target_folder()?;
    let out = match &options.out {
        Some(folder) => std::path::absolute(folder)
            .with_context(|| format!("cannot find {}", folder.display()))?,
        None => target.join("site"),
    };
    check_out(&out)?;
    // Check links of the Markdown pages.
    let pages = MarkdownPages::read(root())?;
    pages.check(root())?;
    let port = take_port(if options.serve.no_serve {
        0
    } else {
        options.serve.port
    })?;
    // Stage the pages, and build the book.
    let mdbook = MDBOOK.find_or_install(&target)?;
    let link_checker = find_or_install_link_checker(&target)?;
    let has_viewer = !options.without_viewer;
    let staged = target.join("site-pages");
    empty(&staged)?;
    stage::write(root(), &pages, &staged, has_viewer)?;
    empty(&out)?;
    // Mark the folder now, so that the next run may replace it after a failure.
    mark(&out)?;
    let mut book = Command::new(mdbook);
    book.arg("build").arg("--dest-dir").arg(&out).arg(&staged);
    run(&mut book)?;
    // Mark it again: mdBook empties the folder first.
    mark(&out)?;
    if has_viewer {
        web::build_page(&target, &out.join(stage::VIEWER))?;
    }
    // Check the links of the built pages on a server.
    let server = Server::start(port, &out)?;
    println!("checking all links of the built pages: about a minute");
    let rules = target.join("linkcheckerrc");
    fs::write(&rules, LINK_RULES)?;
    let mut check = Command::new(link_checker);
    check.arg("--config").arg(&rules).arg(&server.address);
    run(&mut check).context("the built pages have broken links")?;
    println!("the site is in {}; all links are valid", out.display());
    match options.serve.no_serve {
        true => Ok(()),
        false => server.run(),
    }
}

/// Returns LinkChecker of that version in its own Python environment; installs it if needed.
fn find_or_install_link_checker(target: &Path) -> Result<PathBuf> {
    let folder = target.join("tools").join(LINK_CHECKER);
    let programs = folder.join(if cfg!(windows) { "Scripts" } else { "bin" });
    let program = programs.join("linkchecker");
    if Command::new(&program).arg("--version").output().is_ok() {
        return Ok(program);
    }
    println!(
        "installing {LINK_CHECKER} into {}, once: about 10 s; it checks the links of the built pages",
        folder.display()
    );
    let mut environment = Command::new("python3");
    run(environment.args(["-m", "venv"]).arg(&folder))
        .context("install python3 with its module venv (Debian's package python3-venv)")?;
    let mut install = Command::new(programs.join("pip"));
    run(install.args(["install", "--quiet", LINK_CHECKER])).context("connect to pypi.org")?;
    Ok(program)
}

/// Rejects a folder with files other than an earlier site's, since those would be lost.
fn check_out(out: &Path) -> Result<()> {
    let Ok(mut entries) = fs::read_dir(out) else {
        return Ok(());
    };
    if entries.next().is_none() || out.join(MARK).is_file() {
        return Ok(());
    }
    Err(Usage(format!(
        "{} contains other files than a site's, which would be lost: pass a new folder with --out",
        out.display()
    ))
    .into())
}

/// Marks a folder as a site's.
fn mark(folder: &Path) -> Result<()> {
    fs::write(folder.join(MARK), "")
        .with_context(|| format!("cannot write to {}", folder.display()))
}

/// Creates an empty folder, or empties an existing one.
fn empty(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::{MARK, check_out};
    use std::fs;

    #[test]
    fn a_folder_with_other_files_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(check_out(&folder.path().join("new")).is_ok());
        assert!(check_out(folder.path()).is_ok(), "an empty one");
        fs::write(folder.path().join("letter.txt"), "").expect("written");
        let error = check_out(folder.path()).expect_err("not a site");
        assert!(error.to_string().contains("--out"), "{error}");
        assert!(error.is::<crate::run::Usage>());
        fs::write(folder.path().join(MARK), "").expect("written");
        assert!(check_out(folder.path()).is_ok(), "an earlier site");
    }
}
