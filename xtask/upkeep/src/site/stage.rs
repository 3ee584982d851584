//! The folder that mdBook builds the site from. In the repository, links may lead out of `docs`.
//! Here every page and file has a place on the site, and every link is changed to it.

use super::{
    links::{LIVE, LinkTarget, MarkdownPage, MarkdownPages, SUMMARY},
    source,
};
use anyhow::{Context as _, Result, bail};
use std::{collections::BTreeSet, fs, path::Path};

/// Folder of the viewer on the site.
pub(super) const VIEWER: &str = "viewer";
/// Settings of mdBook, and the site's own style.
const SETTINGS: [&str; 2] = ["docs/book.toml", "docs/site.css"];
/// Start of the part that the viewer replaces, followed by the viewer's query.
const VIEWER_BEGINS: &str = "<!-- viewer: ";
const VIEWER_ENDS: &str = "<!-- end of viewer -->";
/// Text for a site without the viewer.
const LEFT_OUT: &str = "**This site was built without the viewer** (`cargo xtask site --without-viewer`), so it shows an image instead. \
                        `cargo xtask site` builds it with the viewer.\n\n";

/// Writes the folder. Links to the viewer's page with a query lead to the viewer itself if the site
/// has it.
pub(super) fn write(
    root: &Path,
    pages: &MarkdownPages,
    folder: &Path,
    has_viewer: bool,
) -> Result<()> {
    let stage = SiteLinks {
        pages: pages.of_site(),
        has_viewer,
    };
    // Write the pages, and collect the files that they link to.
    let mut files = BTreeSet::new();
    for path in stage.pages.iter().map(String::as_str).chain([SUMMARY]) {
        let page = pages.0.get(path);
        let page = page.with_context(|| format!("there is no {path}"))?;
        let mut text = stage.with_links_of_site(path, page, &mut files);
        if path == LIVE {
            text = stage.live_page(&text)?;
        }
        put(folder, &format!("src/{}", place_of(path)), text.as_bytes())?;
    }
    // Copy images, and write all other files as pages.
    for file in files {
        let place = format!("src/{}", place_of_file(&file));
        let bytes = fs::read(root.join(&file)).with_context(|| format!("cannot read {file}"))?;
        if place.starts_with("src/source/") {
            let text = String::from_utf8_lossy(&bytes);
            put(folder, &place, source::page(&file, &text).as_bytes())?;
        } else {
            put(folder, &place, &bytes)?;
        }
    }
    for file in SETTINGS {
        let bytes = fs::read(root.join(file)).with_context(|| format!("cannot read {file}"))?;
        put(folder, place_of(file), &bytes)?;
    }
    Ok(())
}

/// Data that determines the addresses of links.
struct SiteLinks {
    /// Pages of the site, by their paths in the repository.
    pages: BTreeSet<String>,
    has_viewer: bool,
}

impl SiteLinks {
    /// Returns a page's text with links for the site, and adds the files that it needs.
    fn with_links_of_site(
        &self,
        path: &str,
        page: &MarkdownPage,
        files: &mut BTreeSet<String>,
    ) -> String {
        let mut pieces = page.text.split("](");
        let mut text = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            let (target, rest) = piece.split_at(piece.find([')', ' ']).unwrap_or(piece.len()));
            let address = match page.resolve_link(path, target) {
                Some(resolved) => self.address(path, &resolved),
                None => target.to_owned(),
            };
            if let Some(file) = page.resolve_link(path, target)
                && !self.pages.contains(&file.path)
            {
                files.insert(file.path);
            }
            text += &format!("]({address}{rest}");
        }
        text
    }

    /// Returns the address of a target on the site, from the page at `path`.
    fn address(&self, path: &str, target: &LinkTarget) -> String {
        let up = "../".repeat(place_of(path).matches('/').count());
        if !target.query.is_empty() && self.has_viewer {
            return format!("{up}{VIEWER}/index.html{}", target.query);
        }
        // Other files are shown as text, which has line numbers but no headings to lead to.
        if !self.pages.contains(&target.path) {
            return format!("{up}{}", place_of_file(&target.path));
        }
        format!("{up}{}{}", place_of(&target.path), target.anchor)
    }

    /// Returns the viewer's page: with the viewer in a frame, or with a note that it was skipped.
    fn live_page(&self, text: &str) -> Result<String> {
        let parts = text.split_once(VIEWER_BEGINS).and_then(|(before, rest)| {
            let (query, rest) = rest.split_once(" -->\n")?;
            let (instead, after) = rest.split_once(VIEWER_ENDS)?;
            Some((before, query, instead, after))
        });
        let Some((before, query, instead, after)) = parts else {
            bail!(
                "{LIVE} has no place for the viewer: put `{VIEWER_BEGINS}scene=cubes -->` before the part that the viewer replaces, \
                 and `{VIEWER_ENDS}` after it"
            );
        };
        let middle = match self.has_viewer {
            true => frame(query),
            false => format!("{LEFT_OUT}{instead}"),
        };
        Ok(format!("{before}{middle}{after}"))
    }
}

/// Returns the frame with the viewer.
fn frame(query: &str) -> String {
    let address = format!("{VIEWER}/index.html?{query}").replace('&', "&amp;");
    format!(
        "<iframe class=\"viewer\" title=\"The viewer\" src=\"{address}\" allow=\"fullscreen\" loading=\"lazy\"></iframe>\n\n\
         [Open the viewer on its own page]({VIEWER}/index.html?{query})\n"
    )
}

/// Returns the place of a file that is not a page: images are copied, all others become pages that
/// show their text.
fn place_of_file(path: &str) -> String {
    match path.rsplit_once('.') {
        Some((_, "png" | "svg")) => place_of(path).to_owned(),
        // mdBook would treat `.md.html` as one of its pages.
        Some((stem, "md")) => format!("source/{stem}.html"),
        _ => format!("source/{path}.html"),
    }
}

/// Returns the place of a page or a file on the site.
fn place_of(path: &str) -> &str {
    path.strip_prefix("docs/").unwrap_or(path)
}

fn put(folder: &Path, place: &str, bytes: &[u8]) -> Result<()> {
    let file = folder.join(place);
    let reported = || format!("cannot write {}", file.display());
    if let Some(parent) = file.parent() {
        fs::create_dir_all(parent).with_context(reported)?;
    }
    fs::write(&file, bytes).with_context(reported)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(has_viewer: bool) -> SiteLinks {
        SiteLinks {
            pages: ["docs/a.md", LIVE, "notes/README.md"]
                .map(str::to_owned)
                .into(),
            has_viewer,
        }
    }

    fn text_of(has_viewer: bool, path: &str, text: &str) -> (String, Vec<String>) {
        let page = MarkdownPage::new(text.to_owned());
        let mut files = BTreeSet::new();
        let text = stage(has_viewer).with_links_of_site(path, &page, &mut files);
        (text, files.into_iter().collect())
    }

    #[test]
    fn links_lead_to_places_on_the_site() {
        let (text, files) = text_of(
            true,
            "notes/README.md",
            "[a](../docs/a.md#x) ![p](../docs/p.png) [s](../src/lib.rs) [o](../o.md#x) [e](https://x.org) [n](#n)",
        );
        assert_eq!(
            text,
            "[a](../a.md#x) ![p](../p.png) [s](../source/src/lib.rs.html) [o](../source/o.html) [e](https://x.org) [n](../notes/README.md#n)"
        );
        assert_eq!(files, ["docs/p.png", "o.md", "src/lib.rs"]);
    }

    #[test]
    fn links_with_a_query_lead_to_the_viewer_if_it_is_there() {
        let link = "[l](live.md?scene=cubes&left=hard)";
        let (with, _) = text_of(true, "docs/a.md", link);
        assert_eq!(with, "[l](viewer/index.html?scene=cubes&left=hard)");
        let (without, files) = text_of(false, "docs/a.md", link);
        assert_eq!(without, "[l](live.md)");
        assert!(files.is_empty());
    }

    #[test]
    fn the_viewers_page_says_when_it_is_left_out() {
        let text =
            "# L\n<!-- viewer: scene=a&over=error -->\n![p](p.png)\n<!-- end of viewer -->\nend\n";
        let with = stage(true).live_page(text).expect("a place");
        assert!(
            with.contains("index.html?scene=a&amp;over=error\""),
            "{with}"
        );
        assert!(!with.contains("p.png") && with.ends_with("end\n"), "{with}");
        let without = stage(false).live_page(text).expect("a place");
        assert!(without.contains("without the viewer"), "{without}");
        assert!(without.contains("![p](p.png)") && !without.contains("iframe"));
        assert!(stage(true).live_page("# L\n").is_err());
    }

    /// Every link of the staged pages leads to a page or a file of the site.
    #[test]
    fn the_repositorys_pages_hold_together() {
        let root = crate::run::root();
        let pages = MarkdownPages::read(root).expect("readable");
        let folder = tempfile::tempdir().expect("a folder");
        let src = folder.path().join("src");
        for has_viewer in [false, true] {
            write(root, &pages, folder.path(), has_viewer).expect("written");
            let viewer = src.join(VIEWER);
            if has_viewer {
                fs::create_dir_all(&viewer).expect("a folder");
                fs::write(viewer.join("index.html"), "").expect("a page");
            }
            let staged = MarkdownPages::read(&src).expect("readable");
            let mut links = 0;
            for (path, page) in &staged.0 {
                for (link, _) in &page.links {
                    let target = page.resolve_link(path, link).expect("on the site");
                    assert!(src.join(&target.path).is_file(), "{path}: {link}");
                    links += 1;
                }
            }
            assert!(links > 150, "{links}");
            let live = fs::read_to_string(src.join("live.md")).expect("a page");
            assert_eq!(live.contains("<iframe"), has_viewer);
        }
    }
}
