//! Whether every link and picture of the pages leads to something.

use super::page::{MarkdownPage, PageLink};
use anyhow::{Result, bail};
use std::{collections::BTreeMap, path::Path};

/// The list of the site's pages.
pub(super) const SUMMARY: &str = "docs/SUMMARY.md";
/// The page that shows the viewer. It alone is linked with a query, which the viewer reads.
pub(super) const LIVE: &str = "docs/live.md";

/// All Markdown pages of the repository, by their paths.
#[derive(Debug, Default)]
pub(super) struct MarkdownPages {
    pub(super) all: BTreeMap<String, MarkdownPage>,
}

/// What a link leads to inside the repository.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LinkTarget {
    /// From the top folder.
    pub(super) path: String,
    /// From `?` on, or empty.
    pub(super) query: String,
    /// From `#` on, or empty.
    pub(super) anchor: String,
}

impl MarkdownPages {
    /// Reads all pages of the repository at `root`.
    pub(super) fn read(root: &Path) -> Result<Self> {
        let mut out = Self::default();
        for source in crate::tidy::files::read_all(root)? {
            if source.extension() == "md" {
                out.add(MarkdownPage::of(&source.path, source.text));
            }
        }
        Ok(out)
    }

    pub(super) fn add(&mut self, page: MarkdownPage) {
        self.all.insert(page.path.clone(), page);
    }

    /// Returns the site's pages with their titles, in the order of the list.
    pub(super) fn of_site(&self) -> Vec<(&str, &MarkdownPage)> {
        let mut out = Vec::new();
        let Some(summary) = self.all.get(SUMMARY) else {
            return out;
        };
        for link in &summary.links {
            let target = resolve(summary, link);
            if let Some(page) = target.and_then(|target| self.all.get(&target.path)) {
                out.push((link.words.as_str(), page));
            }
        }
        out
    }

    /// Errors, naming every fault, unless all links lead to something and the list names all pages of `docs`.
    pub(super) fn check(&self, root: &Path) -> Result<()> {
        let mut faults = Vec::new();
        for page in self.all.values() {
            faults.extend(page.faults.iter().cloned());
            for link in page.links.iter().filter(|link| !link.is_external()) {
                if let Err(why) = self.check_link(root, page, link) {
                    let PageLink { target, line, .. } = link;
                    faults.push(format!("{}:{line}: `{target}`: {why}", page.path));
                }
            }
        }
        faults.extend(self.unlisted());
        if faults.is_empty() {
            return Ok(());
        }
        bail!("broken links:\n  {}", faults.join("\n  "))
    }

    fn check_link(&self, root: &Path, page: &MarkdownPage, link: &PageLink) -> Result<()> {
        let Some(target) = resolve(page, link) else {
            bail!("leads out of the repository; link a file in it");
        };
        if !root.join(&target.path).is_file() {
            bail!("there is no file {}", target.path);
        }
        if !target.query.is_empty() && target.path != LIVE {
            bail!("only {LIVE} takes what stands behind `?`; leave it out");
        }
        if target.anchor.is_empty() {
            return Ok(());
        }
        let Some(linked) = self.all.get(&target.path) else {
            bail!("only pages have places to link to; leave out what stands behind `#`");
        };
        let anchor = target.anchor.trim_start_matches('#');
        if !linked.anchors.contains(anchor) {
            let known: Vec<&str> = linked.anchors.iter().map(String::as_str).collect();
            bail!(
                "{} has no heading `{anchor}`; it has {}",
                target.path,
                known.join(", ")
            );
        }
        Ok(())
    }

    /// Returns a fault for each page in `docs` that the list doesn't name.
    fn unlisted(&self) -> Vec<String> {
        let listed: Vec<&str> = self
            .of_site()
            .iter()
            .map(|(_, page)| page.path.as_str())
            .collect();
        let mut faults = Vec::new();
        for path in self.all.keys() {
            let is_doc = path.starts_with("docs/") && path != SUMMARY;
            if is_doc && !listed.contains(&path.as_str()) {
                faults.push(format!(
                    "{SUMMARY}: does not list {path}; add a line for it"
                ));
            }
        }
        faults
    }
}

/// Returns what a page's link leads to; none if that is outside the repository.
pub(super) fn resolve(page: &MarkdownPage, link: &PageLink) -> Option<LinkTarget> {
    let (address, anchor) = split_at(&link.target, '#');
    let (path, query) = split_at(address, '?');
    let mut parts: Vec<&str> = page.path.split('/').collect();
    if !path.is_empty() {
        parts.pop();
        for part in path.split('/') {
            match part {
                "." => {}
                ".." => {
                    parts.pop()?;
                }
                _ => parts.push(part),
            }
        }
    }
    Some(LinkTarget {
        path: parts.join("/"),
        query: query.to_owned(),
        anchor: anchor.to_owned(),
    })
}

/// Splits a text before the first `mark`; the second part is empty without one.
fn split_at(text: &str, mark: char) -> (&str, &str) {
    text.split_at(text.find(mark).unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::root;

    #[test]
    fn every_link_of_the_repository_leads_to_something() {
        let pages = MarkdownPages::read(root()).expect("readable");
        assert!(pages.of_site().len() > 15, "the site's pages");
        let pictures = |page: &MarkdownPage| page.links.iter().filter(|l| l.is_picture).count();
        assert!(pages.all.values().map(pictures).sum::<usize>() > 80);
        pages.check(root()).expect("no broken links");
    }

    /// Pages in a folder: `docs/a.md` with the given text, which the list names, and `docs/b.md`.
    fn faults_of(text: &str) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("docs")).expect("made");
        let list = "- [A](a.md)\n- [B](b.md)\n- [Live](live.md)\n";
        let mut pages = MarkdownPages::default();
        for (path, text) in [
            (SUMMARY, list),
            ("docs/a.md", text),
            ("docs/b.md", "# Some heading\n"),
            (LIVE, "# Live\n"),
            ("top.md", "# Top\n"),
        ] {
            std::fs::write(folder.path().join(path), text).expect("written");
            pages.add(MarkdownPage::of(path, text.to_owned()));
        }
        std::fs::write(folder.path().join("docs/p.png"), "").expect("written");
        match pages.check(folder.path()) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn good_links_pass() {
        let good = "# A\n[b](b.md) [h](b.md#some-heading) [a](#a) ![p](p.png) [t](../top.md#top)\n\
                    [l](live.md?scene=cubes&left=hard) [x](https://example.org/none)\n";
        assert_eq!(faults_of(good), "");
    }

    #[test]
    fn every_kind_of_broken_link_is_an_error() {
        for (bad, told) in [
            (
                "[c](c.md)",
                "docs/a.md:1: `c.md`: there is no file docs/c.md",
            ),
            (
                "\n![q](q.png)",
                "docs/a.md:2: `q.png`: there is no file docs/q.png",
            ),
            ("[b](b.md#other)", "no heading `other`; it has some-heading"),
            ("[a](#b)", "no heading `b`"),
            ("![p](p.png#b)", "only pages have places"),
            ("[b](b.md?scene=cubes)", "only docs/live.md takes"),
            ("[o](../../etc/passwd)", "leads out of the repository"),
            ("[d](../docs)", "there is no file docs"),
            ("[b][c]\n\n[c]: b.md", "is not linked as"),
            ("<a href=\"b.md\">", "as HTML"),
        ] {
            let faults = faults_of(bad);
            assert!(faults.contains(told), "{bad}: {faults}");
            assert_eq!(faults.lines().count(), 2, "{bad}: {faults}");
        }
    }

    #[test]
    fn a_page_that_is_not_listed_is_an_error() {
        let mut pages = MarkdownPages::default();
        pages.add(MarkdownPage::of(SUMMARY, String::new()));
        pages.add(MarkdownPage::of("docs/lost.md", String::new()));
        pages.add(MarkdownPage::of("README.md", String::new()));
        let error = pages.check(root()).expect_err("not listed").to_string();
        assert!(error.contains("does not list docs/lost.md"), "{error}");
        assert!(!error.contains("README.md"), "{error}");
    }
}
