//! Measures the density of Rust code in tokens a line. Functions that are short because their lines are packed are harder to read
//! than longer plain ones, so lengths are bounded in tokens, too.

use super::files::Source;
use anyhow::{Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::BTreeSet;

/// The lines on which a file's tokens stand, in order, without those of doc comments.
pub(super) struct Tokens {
    lines: Vec<usize>,
}

impl Tokens {
    pub(super) fn of(source: &Source) -> Result<Self> {
        let stream: TokenStream = source
            .text
            .parse()
            .map_err(|e| anyhow!("{}: {e}", source.path))?;
        let mut lines = Vec::new();
        collect(stream, &mut lines);
        Ok(Self { lines })
    }

    /// Returns how many tokens stand on lines `first` to `last`.
    pub(super) fn within(&self, first: usize, last: usize) -> usize {
        let start = self.lines.partition_point(|&line| line < first);
        let end = self.lines.partition_point(|&line| line <= last);
        end - start
    }

    /// Returns the number of tokens, and of lines that have some.
    pub(super) fn counts(&self) -> (usize, usize) {
        let lines: BTreeSet<usize> = self.lines.iter().copied().collect();
        (self.lines.len(), lines.len())
    }
}

fn collect(stream: TokenStream, lines: &mut Vec<usize>) {
    let mut trees = stream.into_iter().peekable();
    while let Some(tree) = trees.next() {
        if is_punct(&tree, '#') {
            let inner = trees.next_if(|tree| is_punct(tree, '!'));
            if trees.next_if(is_doc).is_some() {
                continue;
            }
            lines.push(tree.span().start().line);
            lines.extend(inner.map(|tree| tree.span().start().line));
            continue;
        }
        match tree {
            TokenTree::Group(group) => {
                lines.push(group.span_open().start().line);
                collect(group.stream(), lines);
                lines.push(group.span_close().start().line);
            }
            other => lines.push(other.span().start().line),
        }
    }
}

fn is_punct(tree: &TokenTree, wanted: char) -> bool {
    matches!(tree, TokenTree::Punct(punct) if punct.as_char() == wanted)
}

/// Returns whether a group is what follows the `#` of a doc comment: `[doc = ".."]`.
fn is_doc(tree: &TokenTree) -> bool {
    let TokenTree::Group(group) = tree else {
        return false;
    };
    let first = group.stream().into_iter().next();
    group.delimiter() == Delimiter::Bracket
        && matches!(first, Some(TokenTree::Ident(ident)) if ident == "doc")
}

#[cfg(test)]
mod tests {
    use super::{Source, Tokens};

    #[test]
    fn tokens_are_counted_without_comments() {
        let text = "//! Doc.\n\n/// Doc.\n#[inline]\nfn f(a: u8) {\n    // Why.\n    g(a, 1);\n}\n";
        let source = Source {
            path: "x.rs".to_owned(),
            text: text.to_owned(),
        };
        let tokens = Tokens::of(&source).expect("good code");
        // `# [ inline ]`, `fn f ( a : u8 ) {`, `g ( a , 1 ) ;`, `}`
        assert_eq!(tokens.counts(), (4 + 8 + 7 + 1, 4));
        assert_eq!(tokens.within(5, 8), 16);
    }
}
