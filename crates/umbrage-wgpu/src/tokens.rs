//! WGSL as words and what stands between them: all that is rewritten in a text is rewritten word by word.

/// A piece of WGSL: an identifier or keyword, or what stands between two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token<'a> {
    pub(crate) text: &'a str,
    pub(crate) is_identifier: bool,
}

/// Splits a text into identifiers and what stands between them. Numbers and comments are not identifiers.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_identifier = first.is_ascii_alphabetic() || first == '_';
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if is_identifier || first.is_ascii_digit() {
            // `1.0f` is a number with a suffix: its letters belong to it.
            rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
                .unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(length);
        out.push(Token {
            text: token,
            is_identifier,
        });
        rest = after;
    }
    out
}
