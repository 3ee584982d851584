//! Checks that every link, image and heading anchor of the Markdown pages is valid.

use anyhow::{Result, bail};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// List of the site's pages.
pub(super) const SUMMARY: &str = "docs/SUMMARY.md";
/// Page with the viewer. Only links to it may have a query, which the viewer reads.
pub(super) const LIVE: &str = "docs/live.md";

/// A Markdown file of the repository.
#[derive(Clone, Debug, Default)]
pub(super) struct MarkdownPage {
    pub(super) text: String,
    /// Targets of links and images as written, such as `soft.md#the-idea`, with their lines.
    pub(super) links: Vec<(String, usize)>,
    /// Anchors of the headings as in addresses: `far-from-the-origin`.
    anchors: BTreeSet<String>,
    /// Links that can't be checked as written: message and line.
    faults: Vec<(&'static str, usize)>,
}

/// The target of a link inside the repository.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LinkTarget {
    /// Path from the top folder, with `/` between its parts.
    pub(super) path: String,
    /// Query from `?` on, or empty.
    pub(super) query: String,
    /// Anchor from `#` on, or empty.
    pub(super) anchor: String,
}

impl MarkdownPage {
    pub(super) fn new(text: String) -> Self {
        let mut page = Self::default();
        let mut heading = String::new();
        let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
        for (event, place) in Parser::new_ext(&text, options).into_offset_iter() {
            let line = 1 + text[..place.start].matches('\n').count();
            match event {
                Event::Start(Tag::Heading { .. }) => heading.clear(),
                Event::End(TagEnd::Heading(_)) => page.add_anchor(&heading),
                Event::Text(words) | Event::Code(words) => heading += &words,
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    let is_inline = text[place].contains(&format!("]({dest_url}"));
                    if is_external(&dest_url) {
                        continue;
                    }
                    if !is_inline {
                        page.faults
                            .push(("a link that is not inline: write [words](address)", line));
                    }
                    page.links.push((dest_url.into_string(), line));
                }
                Event::Html(html) | Event::InlineHtml(html)
                    if html.contains(" src=") || html.contains(" href=") =>
                {
                    let fault = "a link or an image as HTML: write it as Markdown";
                    page.faults.push((fault, line));
                }
                _ => {}
            }
        }
        page.text = text;
        page
    }

    /// Adds a heading's anchor: lower case with hyphens. Repeated ones are numbered, as in mdBook
    /// and on GitHub.
    fn add_anchor(&mut self, words: &str) {
        let kept = |c: &char| c.is_alphanumeric() || "_- ".contains(*c);
        let plain: String = words.chars().filter(kept).collect();
        let plain = plain.to_lowercase().replace(' ', "-");
        let mut anchor = plain.clone();
        let mut number = 0;
        while !self.anchors.insert(anchor) {
            number += 1;
            anchor = format!("{plain}-{number}");
        }
    }

    /// Returns the target of a link of this page; `None` for external links and for code that looks
    /// like a link.
    pub(super) fn resolve_link(&self, path: &str, target: &str) -> Option<LinkTarget> {
        let is_link = self.links.iter().any(|(link, _)| link == target);
        resolve(path, target).filter(|_| is_link)
    }
}

fn is_external(target: &str) -> bool {
    ["https://", "http://", "mailto:"]
        .iter()
        .any(|scheme| target.starts_with(scheme))
}

/// All Markdown pages of the repository, by their paths.
#[derive(Debug, Default)]
pub(super) struct MarkdownPages(pub(super) BTreeMap<String, MarkdownPage>);

impl MarkdownPages {
    /// Reads all pages of the repository at `root`.
    pub(super) fn read(root: &Path) -> Result<Self> {
        let mut out = Self::default();
        for source in crate::tidy::files::read_all(root)? {
            if source.extension() == "md" {
                out.0.insert(source.path, MarkdownPage::new(source.text));
            }
        }
        Ok(out)
    }

    /// Returns the paths of the site's pages.
    pub(super) fn of_site(&self) -> BTreeSet<String> {
        let links = self.0.get(SUMMARY).map_or(&[][..], |page| &page.links);
        let targets = links.iter().filter_map(|(link, _)| resolve(SUMMARY, link));
        targets.map(|target| target.path).collect()
    }

    /// Checks that all links are valid and that the list contains all pages of `docs`. The error
    /// lists every fault.
    pub(super) fn check(&self, root: &Path) -> Result<()> {
        let listed = self.of_site();
        let mut faults = Vec::new();
        for (path, page) in &self.0 {
            for (fault, line) in &page.faults {
                faults.push(format!("{path}:{line}: {fault}"));
            }
            for (target, line) in &page.links {
                if let Err(why) = self.check_link(root, path, target) {
                    faults.push(format!("{path}:{line}: `{target}`: {why}"));
                }
            }
            if path.starts_with("docs/") && path != SUMMARY && !listed.contains(path) {
                faults.push(format!(
                    "{SUMMARY}: does not list {path}; add a line for it"
                ));
            }
        }
        if faults.is_empty() {
            return Ok(());
        }
        bail!("broken links:\n  {}", faults.join("\n  "))
    }

    fn check_link(&self, root: &Path, path: &str, target: &str) -> Result<()> {
        let Some(target) = resolve(path, target) else {
            bail!("leads out of the repository: link a file in it");
        };
        if !root.join(&target.path).is_file() {
            bail!("there is no file {}", target.path);
        }
        if !target.query.is_empty() && target.path != LIVE {
            bail!("only {LIVE} takes a query: remove `?` and the rest");
        }
        let Some(anchor) = target.anchor.strip_prefix('#') else {
            return Ok(());
        };
        let Some(linked) = self.0.get(&target.path) else {
            bail!("only pages have anchors: remove `#` and the rest");
        };
        if !linked.anchors.contains(anchor) {
            let known: Vec<&str> = linked.anchors.iter().map(String::as_str).collect();
            let known = known.join(", ");
            bail!(
                "{} has no heading `{anchor}`; its headings: {known}",
                target.path
            );
        }
        Ok(())
    }
}

/// Returns the target of a link on the page at `path`; `None` if it is outside the repository.
fn resolve(path: &str, target: &str) -> Option<LinkTarget> {
    let (address, anchor) = target.split_at(target.find('#').unwrap_or(target.len()));
    let (address, query) = address.split_at(address.find('?').unwrap_or(address.len()));
    let mut parts: Vec<&str> = path.split('/').collect();
    if !address.is_empty() {
        parts.pop();
    }
    for part in address.split('/').filter(|part| !["", "."].contains(part)) {
        match part {
            ".." => drop(parts.pop()?),
            _ => parts.push(part),
        }
    }
    Some(LinkTarget {
        path: parts.join("/"),
        query: query.to_owned(),
        anchor: anchor.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::root;

    #[test]
    fn every_link_of_the_repository_leads_to_something() {
        let pages = MarkdownPages::read(root()).expect("readable");
        assert!(pages.of_site().len() > 15, "the site's pages");
        let links: usize = pages.0.values().map(|page| page.links.len()).sum();
        assert!(links > 300, "{links}");
        pages.check(root()).expect("no broken links");
    }

    /// Returns the errors of `docs/a.md` with the given text, among other pages.
    fn faults_of(text: &str) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("docs")).expect("made");
        let list = "- [A](a.md)\n- [B](b.md)\n- [Live](live.md)\n";
        let mut pages = MarkdownPages::default();
        for (path, text) in [
            (SUMMARY, list),
            ("docs/a.md", text),
            ("docs/b.md", "# One `two`, 3: *four*!\n## Again\n## Again\n"),
            (LIVE, "# Live\n"),
            ("top.md", "# Top\n"),
            ("docs/p.png", ""),
        ] {
            std::fs::write(folder.path().join(path), text).expect("written");
            if path.ends_with(".md") {
                let page = MarkdownPage::new(text.to_owned());
                pages.0.insert(path.to_owned(), page);
            }
        }
        match pages.check(folder.path()) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn good_links_pass() {
        let good = "# A\n[b](b.md) [h](b.md#one-two-3-four) [n](b.md#again-1) [a](#a) ![p](p.png) [t](../top.md#top)\n\
                    [![in](p.png)](b.md) [l](live.md?scene=cubes&left=hard) [x](https://x.org/none)\n\
                    <https://x.org>\n\n```\n[no](link.md)\n```\n";
        assert_eq!(faults_of(good), "");
    }

    #[test]
    fn every_kind_of_broken_link_is_an_error() {
        for (bad, reported) in [
            (
                "[c](c.md)",
                "docs/a.md:1: `c.md`: there is no file docs/c.md",
            ),
            (
                "\n![q](q.png)",
                "docs/a.md:2: `q.png`: there is no file docs/q.png",
            ),
            (
                "[b](b.md#other)",
                "no heading `other`; its headings: again, again-1, one",
            ),
            ("[a](#b)", "no heading `b`"),
            ("![p](p.png#b)", "only pages have anchors"),
            ("[b](b.md?scene=cubes)", "only docs/live.md takes"),
            ("[o](../../etc/passwd)", "leads out of the repository"),
            (
                "[a][b]\n\n[b]: b.md\n",
                "docs/a.md:1: a link that is not inline",
            ),
            (
                "<img src=\"p.png\">\n",
                "docs/a.md:1: a link or an image as HTML",
            ),
        ] {
            let faults = faults_of(bad);
            assert!(faults.contains(reported), "{bad}: {faults}");
            assert_eq!(faults.lines().count(), 2, "{bad}: {faults}");
        }
    }

    #[test]
    fn a_page_that_is_not_listed_is_an_error() {
        let mut pages = MarkdownPages::default();
        for path in [SUMMARY, "docs/lost.md", "README.md"] {
            pages.0.insert(path.to_owned(), MarkdownPage::default());
        }
        let error = pages.check(root()).expect_err("not listed").to_string();
        assert!(error.contains("does not list docs/lost.md"), "{error}");
        assert!(!error.contains("README.md"), "{error}");
    }
}
