//! How long Rust functions are.

use super::{Length, files::Source};
use anyhow::{Result, anyhow};
use proc_macro2::Span;
use syn::{
    Block, Signature,
    visit::{self, Visit},
};

/// The lines of every function with a body, from its `fn` to its closing brace.
pub(super) fn lengths(source: &Source) -> Result<Vec<Length>> {
    let file = syn::parse_file(&source.text)
        .map_err(|e| anyhow!("{}:{}: {e}", source.path, e.span().start().line))?;
    let mut visitor = Visitor {
        path: &source.path,
        out: Vec::new(),
    };
    visitor.visit_file(&file);
    Ok(visitor.out)
}

struct Visitor<'a> {
    path: &'a str,
    out: Vec<Length>,
}

impl Visitor<'_> {
    fn add(&mut self, signature: &Signature, block: &Block) {
        let first = line(signature.fn_token.span);
        let lines = line(block.brace_token.span.close()) - first + 1;
        self.out.push(Length {
            lines,
            place: format!("{}:{first} {}", self.path, signature.ident),
        });
    }
}

fn line(span: Span) -> usize {
    span.start().line
}

impl<'ast> Visit<'ast> for Visitor<'_> {
    fn visit_item_fn(&mut self, f: &'ast syn::ItemFn) {
        self.add(&f.sig, &f.block);
        visit::visit_item_fn(self, f);
    }

    fn visit_impl_item_fn(&mut self, f: &'ast syn::ImplItemFn) {
        self.add(&f.sig, &f.block);
        visit::visit_impl_item_fn(self, f);
    }

    fn visit_trait_item_fn(&mut self, f: &'ast syn::TraitItemFn) {
        if let Some(block) = &f.default {
            self.add(&f.sig, block);
        }
        visit::visit_trait_item_fn(self, f);
    }
}

#[cfg(test)]
mod tests {
    use super::{Source, lengths};

    #[test]
    fn functions_of_every_kind_are_found() {
        let text = "/// Doc.\nfn a() {}\nimpl T {\n    fn b(\n        x: u8,\n    ) {\n        fn c() {\n        }\n    }\n}\n\
                    trait U {\n    fn d();\n    fn e() {\n        \"fn f() {\";\n    }\n}\n";
        let source = Source {
            path: "x.rs".to_owned(),
            text: text.to_owned(),
        };
        let found: Vec<_> = lengths(&source)
            .expect("good code")
            .into_iter()
            .map(|l| format!("{} {}", l.lines, l.place))
            .collect();
        assert_eq!(
            found,
            ["1 x.rs:2 a", "6 x.rs:4 b", "2 x.rs:7 c", "3 x.rs:13 e"]
        );
    }
}
