//! The folder that mdBook makes the site from. Pages keep their links as they are in the repository, where they may lead out of `docs`;
//! here each page and file has its place on the site, and every link leads there.

use super::{
    links::{LIVE, LinkTarget, MarkdownPages, SUMMARY, resolve},
    page::{MarkdownPage, PageLink},
    source,
};
use anyhow::{Context as _, Result, bail};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// The folder of the viewer on the site.
pub(super) const VIEWER: &str = "viewer";
/// mdBook's settings, and the site's own style.
const SETTINGS: [&str; 2] = ["docs/book.toml", "docs/site.css"];
/// Stands before what the page shows in place of the viewer; behind it the viewer's query.
const VIEWER_BEGINS: &str = "<!-- viewer: ";
const VIEWER_ENDS: &str = "<!-- end of viewer -->";
/// Told where the viewer would be.
const LEFT_OUT: &str = "**This site was built without the viewer** (`cargo xtask site --without-viewer`), so a picture stands \
                        here: `cargo xtask site` builds it with the viewer.\n\n";

/// Writes the folder. Links to the viewer's page with a query lead to the viewer itself if the site has it.
pub(super) fn write(
    root: &Path,
    pages: &MarkdownPages,
    folder: &Path,
    has_viewer: bool,
) -> Result<()> {
    let listed: BTreeMap<&str, &str> = pages
        .of_site()
        .into_iter()
        .map(|(title, page)| (page.path.as_str(), title))
        .collect();
    let stage = Stage { listed, has_viewer };
    let mut files = BTreeSet::new();
    let summary = pages.all.get(SUMMARY);
    let summary = summary.with_context(|| format!("there is no {SUMMARY}"))?;
    let of_site = stage.listed.keys().filter_map(|path| pages.all.get(*path));
    for page in of_site.chain([summary]) {
        let mut text = stage.with_links_of_site(page, &mut files);
        if page.path == LIVE {
            text = stage.live_page(&text)?;
        }
        put(
            folder,
            &format!("src/{}", place_of(&page.path)),
            text.as_bytes(),
        )?;
    }
    for file in files {
        let place = format!("src/{}", stage.place_of_file(&file));
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

/// What links are changed by.
struct Stage<'a> {
    /// The titles of the site's pages, by their paths in the repository.
    listed: BTreeMap<&'a str, &'a str>,
    has_viewer: bool,
}

impl Stage<'_> {
    /// Returns a page's text with links to places on the site, and notes the files that it needs.
    fn with_links_of_site(&self, page: &MarkdownPage, files: &mut BTreeSet<String>) -> String {
        let mut links: Vec<&PageLink> = page.links.iter().filter(|l| !l.is_external()).collect();
        links.sort_by_key(|link| link.place.start);
        let mut text = String::new();
        let mut copied = 0;
        for link in links {
            let Some(target) = resolve(page, link) else {
                continue;
            };
            if !self.listed.contains_key(target.path.as_str()) {
                files.insert(target.path.clone());
            }
            text += &page.text[copied..link.place.start];
            text += &self.address(page, &target);
            copied = link.place.end;
        }
        text + &page.text[copied..]
    }

    /// Returns how a page names a target on the site.
    fn address(&self, page: &MarkdownPage, target: &LinkTarget) -> String {
        let LinkTarget {
            path,
            query,
            anchor,
        } = target;
        let up = "../".repeat(place_of(&page.path).matches('/').count());
        if !query.is_empty() && self.has_viewer {
            return format!("{up}{VIEWER}/index.html{query}");
        }
        let place = match self.listed.contains_key(path.as_str()) {
            true => place_of(path).to_owned(),
            false => self.place_of_file(path),
        };
        format!("{up}{place}{anchor}")
    }

    /// Returns the place of a file that is no page: pictures stay what they are, all others become pages that show their text.
    fn place_of_file(&self, path: &str) -> String {
        let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending);
        match ending {
            "png" | "svg" => place_of(path).to_owned(),
            _ => format!("source/{path}.html"),
        }
    }

    /// Returns the viewer's page: with the viewer in a frame, or with a word that it was left out.
    fn live_page(&self, text: &str) -> Result<String> {
        let parts = text.split_once(VIEWER_BEGINS).and_then(|(before, rest)| {
            let (query, rest) = rest.split_once(" -->\n")?;
            let (instead, after) = rest.split_once(VIEWER_ENDS)?;
            Some((before, query, instead, after))
        });
        let Some((before, query, instead, after)) = parts else {
            bail!(
                "{LIVE} has no place for the viewer: put `{VIEWER_BEGINS}scene=cubes -->` before what stands there without it, \
                 and `{VIEWER_ENDS}` behind"
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
         [Open the viewer on a page of its own]({VIEWER}/index.html?{query})\n"
    )
}

/// Returns a page's or file's place on the site.
fn place_of(path: &str) -> &str {
    path.strip_prefix("docs/").unwrap_or(path)
}

fn put(folder: &Path, place: &str, bytes: &[u8]) -> Result<()> {
    let file = folder.join(place);
    let told = || format!("cannot write {}", file.display());
    if let Some(parent) = file.parent() {
        fs::create_dir_all(parent).with_context(told)?;
    }
    fs::write(&file, bytes).with_context(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(has_viewer: bool) -> Stage<'static> {
        Stage {
            listed: BTreeMap::from([
                ("docs/a.md", "A"),
                (LIVE, "Live"),
                ("notes/README.md", "Notes"),
            ]),
            has_viewer,
        }
    }

    fn text_of(has_viewer: bool, path: &str, text: &str) -> (String, Vec<String>) {
        let page = MarkdownPage::of(path, text.to_owned());
        let mut files = BTreeSet::new();
        let text = stage(has_viewer).with_links_of_site(&page, &mut files);
        (text, files.into_iter().collect())
    }

    #[test]
    fn links_lead_to_places_on_the_site() {
        let (text, files) = text_of(
            true,
            "notes/README.md",
            "[a](../docs/a.md#x) ![p](../docs/p.png) [s](../src/lib.rs) [e](https://x.org) [n](#n)",
        );
        assert_eq!(
            text,
            "[a](../a.md#x) ![p](../p.png) [s](../source/src/lib.rs.html) [e](https://x.org) [n](../notes/README.md#n)"
        );
        assert_eq!(files, ["docs/p.png", "src/lib.rs"]);
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

    /// Every link of the pages as mdBook gets them leads to a page or a file beside them, or to the viewer.
    #[test]
    fn the_repositorys_pages_hold_together() {
        let root = crate::run::root();
        let pages = MarkdownPages::read(root).expect("readable");
        for has_viewer in [true, false] {
            let folder = tempfile::tempdir().expect("a folder");
            write(root, &pages, folder.path(), has_viewer).expect("written");
            let src = folder.path().join("src");
            let mut links = 0;
            for (_, page) in pages.of_site() {
                let place = place_of(&page.path);
                let text = fs::read_to_string(src.join(place)).expect("a page");
                let staged = MarkdownPage::of(place, text);
                for link in staged.links.iter().filter(|link| !link.is_external()) {
                    let target = resolve(&staged, link).expect("on the site");
                    let is_viewer = target.path == format!("{VIEWER}/index.html");
                    let is_there = is_viewer && has_viewer || src.join(&target.path).is_file();
                    assert!(is_there, "{place}: {}", link.target);
                    links += 1;
                }
            }
            assert!(links > 150, "{links}");
            let live = fs::read_to_string(src.join("live.md")).expect("a page");
            assert_eq!(live.contains("<iframe"), has_viewer);
        }
    }
}
