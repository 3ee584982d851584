//! Whether the links of the pages that were built lead to something: mdBook names headings by rules of its own, and what it leaves
//! out it does not tell.

use anyhow::{Context as _, Result, bail};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// What is read of a page.
#[derive(Default)]
struct BuiltPage {
    /// The values of `href` and `src`.
    targets: Vec<String>,
    /// The values of `id`.
    ids: BTreeSet<String>,
}

/// Checks all pages in a folder and returns their number; errors if a link or a picture leads to nothing. Pages in a folder named
/// `left_out` are not read; links may lead there.
pub(super) fn check(folder: &Path, left_out: &str) -> Result<usize> {
    let mut pages = BTreeMap::new();
    read_folder(folder, &folder.join(left_out), &mut pages)?;
    let mut faults = Vec::new();
    for (file, page) in &pages {
        for target in &page.targets {
            if let Err(why) = check_target(folder, &pages, file, target) {
                faults.push(format!("{}: `{target}`: {why}", file.display()));
            }
        }
    }
    if faults.is_empty() {
        return Ok(pages.len());
    }
    bail!(
        "broken links in the pages that were built:\n  {}",
        faults.join("\n  ")
    )
}

fn read_folder(
    folder: &Path,
    left_out: &Path,
    pages: &mut BTreeMap<PathBuf, BuiltPage>,
) -> Result<()> {
    let told = || format!("cannot read {}", folder.display());
    for entry in fs::read_dir(folder).with_context(told)? {
        let path = entry.with_context(told)?.path();
        if path.is_dir() && path != left_out {
            read_folder(&path, left_out, pages)?;
        } else if path.extension().is_some_and(|ending| ending == "html") {
            let html = fs::read_to_string(&path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            pages.insert(path, built_page(&html));
        }
    }
    Ok(())
}

/// Reads the attributes of a page's elements. Text between elements holds no quoted attributes, since `<` is escaped in it.
fn built_page(html: &str) -> BuiltPage {
    let mut page = BuiltPage::default();
    for element in html.split('<').skip(1) {
        let element = element.split('>').next().unwrap_or(element);
        for (name, value) in attributes(element) {
            match name {
                "href" | "src" => page.targets.push(value.replace("&amp;", "&")),
                "id" => {
                    page.ids.insert(value.to_owned());
                }
                _ => {}
            }
        }
    }
    page
}

/// Returns the attributes of an element whose values stand between double quotes.
fn attributes(element: &str) -> Vec<(&str, &str)> {
    let mut out = Vec::new();
    let mut rest = element;
    while let Some((before, after)) = rest.split_once("=\"") {
        let Some((value, behind)) = after.split_once('"') else {
            break;
        };
        let name = before.split_whitespace().last().unwrap_or("");
        out.push((name, value));
        rest = behind;
    }
    out
}

fn check_target(
    folder: &Path,
    pages: &BTreeMap<PathBuf, BuiltPage>,
    page: &Path,
    target: &str,
) -> Result<()> {
    let schemes = ["https:", "http:", "mailto:", "data:", "javascript:"];
    // The page for addresses that do not exist names its files from the site's top.
    let is_absolute = target.starts_with('/');
    if is_absolute || schemes.iter().any(|scheme| target.starts_with(scheme)) {
        return Ok(());
    }
    let (address, anchor) = match target.split_once('#') {
        Some((address, anchor)) => (address, anchor),
        None => (target, ""),
    };
    let address = address.split('?').next().unwrap_or("");
    let file = match address {
        "" => page.to_owned(),
        _ => joined(page, address),
    };
    let file = if file.is_dir() {
        file.join("index.html")
    } else {
        file
    };
    if !file.starts_with(folder) || !file.is_file() {
        bail!("there is no {}", file.display());
    }
    match pages.get(&file) {
        Some(linked) if !anchor.is_empty() && !linked.ids.contains(anchor) => {
            bail!("{} has nothing named `{anchor}`", file.display())
        }
        _ => Ok(()),
    }
}

/// Returns the file that an address on a page means.
fn joined(page: &Path, address: &str) -> PathBuf {
    let mut file = page.parent().unwrap_or(page).to_owned();
    for part in address.split('/') {
        match part {
            "." | "" => {}
            ".." => {
                file.pop();
            }
            _ => file.push(part),
        }
    }
    file
}

#[cfg(test)]
mod tests {
    use super::check;
    use std::fs;

    fn faults_of(html: &str) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().expect("a folder")).expect("made");
            fs::write(file, text).expect("written");
        };
        write("a.html", html);
        write(
            "in/b.html",
            "<h1 id=\"top\">B</h1><a href=\"../a.html\">a</a>",
        );
        write("p.png", "");
        write("viewer/index.html", "<a href=\"nothing\">not read</a>");
        match check(folder.path(), "viewer") {
            Ok(pages) => format!("{pages} pages"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn good_links_pass() {
        let good = "<a class=\"x\" href=\"in/b.html#top\">b</a> <img src=\"p.png\"> <a id=\"here\" href=\"#here\">h</a>\
                    <iframe src=\"viewer/index.html?a=b&amp;c=d\"></iframe> <a href=\"viewer/\">v</a>\
                    <a href=\"https://example.org/x\">x</a><code>href=&quot;y&quot;</code>";
        assert_eq!(faults_of(good), "2 pages");
    }

    #[test]
    fn every_kind_of_broken_link_is_an_error() {
        for bad in [
            "<a href=\"c.html\">",
            "<img alt=\"q\" src=\"q.png\">",
            "<a href=\"in/b.html#other\">",
            "<a href=\"#other\">",
            "<a href=\"../outside.html\">",
            "<iframe src=\"viewers/index.html\">",
        ] {
            let faults = faults_of(bad);
            assert!(faults.contains("a.html: `"), "{bad}: {faults}");
        }
    }
}
