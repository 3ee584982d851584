//! Rules for what a file may not hold.

use super::files::Source;
use syn::{Attribute, visit::Visit};

/// Words for work that is put off, in pieces so that this file may be tidy, too.
const LATER: [&str; 6] = [
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("to", "do!("),
    concat!("unimple", "mented!("),
    concat!("#[ig", "nore"),
];

/// Everything wrong with a file, each as `path:line: what, and what to do`.
pub(super) fn faults(source: &Source) -> Vec<String> {
    let mut out = lines(source);
    if !source.text.ends_with('\n') || source.text.ends_with("\n\n") {
        out.push(format!("{}: end the file with one line break", source.path));
    }
    if source.extension() == "rs" {
        out.extend(silent_allows(source));
    }
    out
}

fn lines(source: &Source) -> Vec<String> {
    let code = matches!(source.extension(), "rs" | "wgsl");
    let mut out = Vec::new();
    for (i, line) in source.text.lines().enumerate() {
        let place = format!("{}:{}", source.path, i + 1);
        if line.contains('\t') {
            out.push(format!("{place}: a tab; indent with blanks"));
        }
        if line.ends_with(' ') {
            out.push(format!(
                "{place}: a blank at the end of the line; remove it"
            ));
        }
        for word in LATER.iter().filter(|w| code && line.contains(**w)) {
            out.push(format!("{place}: `{word}`; do it, or leave it out"));
        }
    }
    out
}

/// `allow` and `expect` attributes that don't say why.
fn silent_allows(source: &Source) -> Vec<String> {
    let mut visitor = Allows(Vec::new());
    // A file that doesn't parse has been refused by then.
    if let Ok(file) = syn::parse_file(&source.text) {
        visitor.visit_file(&file);
    }
    let path = &source.path;
    let mut out = Vec::new();
    for line in visitor.0 {
        out.push(format!(
            "{path}:{line}: an `allow` or `expect` without `reason = ..`; give one"
        ));
    }
    out
}

/// Collects the lines of such attributes.
struct Allows(Vec<usize>);

impl Visit<'_> for Allows {
    fn visit_attribute(&mut self, attribute: &Attribute) {
        let silences = attribute.path().is_ident("allow") || attribute.path().is_ident("expect");
        let reason = attribute
            .meta
            .require_list()
            .is_ok_and(|l| l.tokens.to_string().contains("reason ="));
        if silences && !reason {
            self.0.push(attribute.pound_token.span.start().line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Source, faults};

    fn count(path: &str, text: &str) -> usize {
        faults(&Source {
            path: path.to_owned(),
            text: text.to_owned(),
        })
        .len()
    }

    #[test]
    fn a_tidy_file_passes() {
        assert_eq!(
            count(
                "x.rs",
                "#[expect(dead_code, reason = \"why\")]\nfn f() {}\n"
            ),
            0
        );
        assert_eq!(count("x.wgsl", "fn f() {}\n"), 0);
    }

    #[test]
    fn every_rule_objects() {
        for bad in [
            "fn f() {}",
            "fn f() {}\n\n",
            "\tfn f() {}\n",
            "fn f() {} \n",
            concat!("// TO", "DO\n"),
            concat!("// FIX", "ME\n"),
            concat!("// XX", "X\n"),
            concat!("fn f() { to", "do!() }\n"),
            concat!("fn f() { unimple", "mented!() }\n"),
            concat!("#[ig", "nore]\nfn f() {}\n"),
            "#[allow(dead_code)]\nfn f() {}\n",
            "mod m {\n    #![expect(dead_code)]\n}\n",
        ] {
            assert_eq!(count("x.rs", bad), 1, "{bad}");
        }
    }
}
