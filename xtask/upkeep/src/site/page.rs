//! A page of Markdown: its links, and the headings that others may link to.

use pulldown_cmark::{Event, LinkType, Options, Parser, Tag, TagEnd};
use std::{collections::BTreeSet, ops::Range};

/// A Markdown file of the repository.
#[derive(Clone, Debug, Default)]
pub(super) struct MarkdownPage {
    /// From the repository's top folder, with `/` between its parts.
    pub(super) path: String,
    pub(super) text: String,
    /// Links and pictures, in the order of their places.
    pub(super) links: Vec<PageLink>,
    /// The headings as addresses name them: `#far-from-the-origin` without `#`.
    pub(super) anchors: BTreeSet<String>,
    /// What is written in a way that can't be checked, each as `path:line: what, and what to do`.
    pub(super) faults: Vec<String>,
}

/// A link or a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PageLink {
    /// What it names, as written: `soft.md#the-idea`.
    pub(super) target: String,
    /// Where that stands in the page's text, bytes.
    pub(super) place: Range<usize>,
    /// Counted from 1.
    pub(super) line: usize,
    pub(super) is_picture: bool,
    /// The words that are linked. Empty for pictures.
    pub(super) words: String,
}

impl PageLink {
    /// Returns whether it leads out of the repository.
    pub(super) fn is_external(&self) -> bool {
        ["https://", "http://", "mailto:"]
            .iter()
            .any(|scheme| self.target.starts_with(scheme))
    }
}

impl MarkdownPage {
    /// Reads a page's text.
    pub(super) fn of(path: &str, text: String) -> Self {
        let mut page = Self {
            path: path.to_owned(),
            ..Self::default()
        };
        let mut heading: Option<String> = None;
        // Links that have begun and not ended, by their numbers in `page.links`.
        let mut open_links: Vec<usize> = Vec::new();
        let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
        for (event, place) in Parser::new_ext(&text, options).into_offset_iter() {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    let words = heading.take().unwrap_or_default();
                    page.add_anchor(&words);
                }
                Event::Start(Tag::Link {
                    link_type,
                    dest_url,
                    ..
                }) => {
                    open_links.push(page.links.len());
                    page.add_link(&text, place, link_type, &dest_url, false);
                }
                Event::End(TagEnd::Link) => {
                    open_links.pop();
                }
                Event::Start(Tag::Image {
                    link_type,
                    dest_url,
                    ..
                }) => page.add_link(&text, place, link_type, &dest_url, true),
                Event::Text(words) | Event::Code(words) => {
                    if let Some(heading) = &mut heading {
                        *heading += &words;
                    }
                    if let Some(&open) = open_links.last() {
                        page.links[open].words += &words;
                    }
                }
                Event::Html(html) | Event::InlineHtml(html) => {
                    page.refuse_html_links(&text, place, &html);
                }
                _ => {}
            }
        }
        page.text = text;
        page
    }

    /// Notes a heading. A second one of the same words gets a number, as mdBook and GitHub do.
    fn add_anchor(&mut self, words: &str) {
        let plain = anchor_of(words);
        let mut anchor = plain.clone();
        let mut number = 0;
        while !self.anchors.insert(anchor.clone()) {
            number += 1;
            anchor = format!("{plain}-{number}");
        }
    }

    fn add_link(
        &mut self,
        text: &str,
        place: Range<usize>,
        kind: LinkType,
        target: &str,
        is_picture: bool,
    ) {
        let written = &text[place.clone()];
        let line = line_of(text, place.start);
        let start = written.rfind(&format!("]({target}"));
        let mut link = PageLink {
            target: target.to_owned(),
            place: place.clone(),
            line,
            is_picture,
            words: String::new(),
        };
        match (kind, start) {
            (LinkType::Inline, Some(start)) => {
                let start = place.start + start + "](".len();
                link.place = start..start + target.len();
            }
            _ if link.is_external() => {}
            _ => {
                let path = &self.path;
                let fault = format!(
                    "{path}:{line}: `{target}` is not linked as [words](address); write it so"
                );
                self.faults.push(fault);
            }
        }
        self.links.push(link);
    }

    /// Notes links in HTML, whose files nobody would look for.
    fn refuse_html_links(&mut self, text: &str, place: Range<usize>, html: &str) {
        if [" src=", " href="].iter().any(|link| html.contains(link)) {
            let line = line_of(text, place.start);
            let path = &self.path;
            let fault = format!("{path}:{line}: a link or a picture as HTML; write it as Markdown");
            self.faults.push(fault);
        }
    }
}

/// Returns how addresses name a heading: in small letters, blanks as hyphens, without what is neither letter nor digit. GitHub and
/// mdBook agree on that.
fn anchor_of(words: &str) -> String {
    let mut out = String::new();
    for letter in words.chars() {
        if letter.is_alphanumeric() || letter == '_' || letter == '-' {
            out.extend(letter.to_lowercase());
        } else if letter.is_whitespace() {
            out.push('-');
        }
    }
    out
}

fn line_of(text: &str, byte: usize) -> usize {
    1 + text[..byte].matches('\n').count()
}

#[cfg(test)]
mod tests {
    use super::MarkdownPage;

    #[test]
    fn links_pictures_and_headings_are_found() {
        let text = "# One `two`, 3: *four*!\n\nA [word `b`](c.md#d) and ![p](q.png).\n\n## Again\n## Again\n\n\
                    [![in](e.png)](f.md)\n\n```\n[no](link.md)\n```\n\n<https://x.org>\n";
        let page = MarkdownPage::of("docs/a.md", text.to_owned());
        let anchors: Vec<&str> = page.anchors.iter().map(String::as_str).collect();
        assert_eq!(anchors, ["again", "again-1", "one-two-3-four"]);
        let targets: Vec<(&str, bool, usize)> = page
            .links
            .iter()
            .map(|l| (l.target.as_str(), l.is_picture, l.line))
            .collect();
        assert_eq!(
            targets,
            [
                ("c.md#d", false, 3),
                ("q.png", true, 3),
                ("f.md", false, 8),
                ("e.png", true, 8),
                ("https://x.org", false, 14),
            ]
        );
        assert_eq!(page.links[0].words, "word b");
        for link in &page.links[..4] {
            assert_eq!(text[link.place.clone()], link.target);
        }
        assert!(page.faults.is_empty(), "{:?}", page.faults);
    }

    #[test]
    fn links_that_cannot_be_checked_are_refused() {
        for text in ["[a][b]\n\n[b]: c.md\n", "<img src=\"a.png\">\n"] {
            let page = MarkdownPage::of("a.md", text.to_owned());
            assert_eq!(page.faults.len(), 1, "{text}");
        }
    }
}
