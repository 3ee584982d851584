//! A document of text, tables and images, written as Markdown and as HTML.

use crate::output::html::{self, document, escape};

/// A piece of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Inline {
    Text(String),
    Bold(String),
    Code(String),
    /// Text and target.
    Link(String, String),
    /// Alternative text, and the file relative to the page.
    Image(String, String),
    /// A line break.
    Break,
}

/// A part of the page.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Block {
    /// A heading: its level, from 1 on, and its text, from which its anchor is derived.
    Heading(usize, String),
    Paragraph(Vec<Inline>),
    List(Vec<Vec<Inline>>),
    Table {
        head: Vec<String>,
        rows: Vec<Vec<Vec<Inline>>>,
    },
}

/// The whole page.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Document {
    pub(super) blocks: Vec<Block>,
}

pub(super) fn text(words: impl Into<String>) -> Inline {
    Inline::Text(words.into())
}

/// Returns a heading's anchor as GitHub makes it: lowercase letters, digits, dashes and
/// underscores; dashes for spaces.
pub(super) fn anchor(heading: &str) -> String {
    let mut out = String::new();
    for c in heading.to_lowercase().chars() {
        match c {
            ' ' => out.push('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => out.push(c),
            _ => {}
        }
    }
    out
}

const STYLE: &str = include_str!("page.css");

impl Document {
    /// Returns the page as Markdown in GitHub's dialect.
    pub(super) fn markdown(&self) -> String {
        let parts: Vec<String> = self.blocks.iter().map(block_markdown).collect();
        parts.join("\n\n") + "\n"
    }

    /// Returns the page as HTML.
    pub(super) fn html(&self) -> String {
        let body: String = self.blocks.iter().map(block_html).collect();
        let title = self.blocks.iter().find_map(|block| match block {
            Block::Heading(1, words) => Some(words.as_str()),
            _ => None,
        });
        document(
            title.unwrap_or_default(),
            &format!("{}{STYLE}", html::STYLE),
            &body,
        )
    }
}

fn block_markdown(block: &Block) -> String {
    match block {
        Block::Heading(level, words) => format!("{} {}", "#".repeat(*level), plain(words)),
        Block::Paragraph(line) => line_markdown(line),
        Block::List(lines) => {
            let lines: Vec<String> = lines
                .iter()
                .map(|l| format!("* {}", line_markdown(l)))
                .collect();
            lines.join("\n")
        }
        Block::Table { head, rows } => {
            let head: Vec<String> = head.iter().map(|h| plain(h)).collect();
            let mut lines = vec![
                format!("| {} |", head.join(" | ")),
                format!("|{}", "---|".repeat(head.len())),
            ];
            for row in rows {
                let cells: Vec<String> = row.iter().map(|cell| line_markdown(cell)).collect();
                lines.push(format!("| {} |", cells.join(" | ")));
            }
            lines.join("\n")
        }
    }
}

fn line_markdown(line: &[Inline]) -> String {
    let pieces = line.iter().map(|piece| match piece {
        Inline::Text(words) => plain(words),
        Inline::Bold(words) => format!("**{}**", plain(words)),
        Inline::Code(words) => format!("`{}`", words.replace(['`', '|', '\n'], " ")),
        Inline::Link(words, to) => format!("[{}]({to})", plain(words)),
        Inline::Image(what, file) => format!("![{}]({file})", plain(what)),
        Inline::Break => "<br>".to_owned(),
    });
    pieces.collect()
}

/// Escapes text so that no character is read as markup and a table's cell stays one cell.
fn plain(words: &str) -> String {
    let mut out = String::with_capacity(words.len());
    for c in words.chars() {
        match c {
            '\n' => out.push(' '),
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '#' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

fn block_html(block: &Block) -> String {
    match block {
        Block::Heading(level, words) => {
            let (id, words) = (escape(&anchor(words)), escape(words));
            format!("<h{level} id=\"{id}\">{words}</h{level}>\n")
        }
        Block::Paragraph(line) => format!("<p>{}</p>\n", line_html(line)),
        Block::List(lines) => {
            let lines: String = lines
                .iter()
                .map(|l| format!("<li>{}</li>\n", line_html(l)))
                .collect();
            format!("<ul>\n{lines}</ul>\n")
        }
        Block::Table { head, rows } => {
            let head: String = head
                .iter()
                .map(|h| format!("<th>{}</th>", escape(h)))
                .collect();
            let mut lines = String::new();
            for row in rows {
                let cells: String = row
                    .iter()
                    .map(|c| format!("<td>{}</td>", line_html(c)))
                    .collect();
                lines += &format!("<tr>{cells}</tr>\n");
            }
            format!(
                "<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{lines}</tbody></table></div>\n"
            )
        }
    }
}

fn line_html(line: &[Inline]) -> String {
    let pieces = line.iter().map(|piece| match piece {
        Inline::Text(words) => escape(words),
        Inline::Bold(words) => format!("<b>{}</b>", escape(words)),
        Inline::Code(words) => format!("<code>{}</code>", escape(words)),
        Inline::Link(words, to) => format!("<a href=\"{}\">{}</a>", escape(to), escape(words)),
        Inline::Image(what, file) => {
            let (what, file) = (escape(what), escape(file));
            format!("<img src=\"{file}\" alt=\"{what}\" loading=\"lazy\">")
        }
        Inline::Break => "<br>".to_owned(),
    });
    pieces.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_say_the_same_and_names_are_no_markup() {
        let document = Document {
            blocks: vec![
                Block::Heading(1, "Which *one*? <b>".to_owned()),
                Block::Paragraph(vec![
                    text("a | b"),
                    Inline::Bold("pcf_disc".to_owned()),
                    Inline::Link("there".to_owned(), "#which-one-b".to_owned()),
                ]),
                Block::List(vec![vec![Inline::Code("x".to_owned())]]),
                Block::Table {
                    head: vec!["h".to_owned()],
                    rows: vec![vec![vec![
                        Inline::Image("a [picture]".to_owned(), "which/a.png".to_owned()),
                        Inline::Break,
                        text("below"),
                    ]]],
                },
            ],
        };
        let expected = "# Which \\*one\\*? \\<b\\>\n\na \\| b**pcf\\_disc**[there](#which-one-b)\n\n* `x`\n\n\
             | h |\n|---|\n| ![a \\[picture\\]](which/a.png)<br>below |\n";
        assert_eq!(document.markdown(), expected);
        let html = document.html();
        let parts = [
            "<h1 id=\"which-one-b\">Which *one*? &lt;b&gt;</h1>",
            "<b>pcf_disc</b><a href=\"#which-one-b\">there</a>",
            "<li><code>x</code></li>",
            "<td><img src=\"which/a.png\" alt=\"a [picture]\" loading=\"lazy\"><br>below</td>",
        ];
        for part in parts {
            assert!(html.contains(part), "{part}: {html}");
        }
    }

    #[test]
    fn anchors_are_those_of_github() {
        assert_eq!(
            anchor("Sun, ideal: over 1 million triangles"),
            "sun-ideal-over-1-million-triangles"
        );
    }
}
