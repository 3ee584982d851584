//! Finds Rust functions and their lines.

use super::files::Source;
use anyhow::{Result, anyhow};
use proc_macro2::Span;
use syn::{
    Block, Signature,
    visit::{self, Visit},
};

/// A function with a body.
pub(super) struct Function {
    /// Line of its `fn`.
    pub(super) first_line: usize,
    /// Line of its closing brace.
    pub(super) last_line: usize,
    /// `path:line name`
    pub(super) place: String,
}

/// Returns every function with a body.
pub(super) fn all(source: &Source) -> Result<Vec<Function>> {
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
    out: Vec<Function>,
}

impl Visitor<'_> {
    fn add(&mut self, signature: &Signature, block: &Block) {
        let first_line = line(signature.fn_token.span);
        self.out.push(Function {
            first_line,
            last_line: line(block.brace_token.span.close()),
            place: format!("{}:{first_line} {}", self.path, signature.ident),
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
    use super::{Source, all};

    #[test]
    fn functions_of_every_kind_are_found() {
        let text = "/// Doc.\nfn a() {}\nimpl T {\n    fn b(\n        x: u8,\n    ) {\n        fn c() {\n        }\n    }\n}\n\
                    trait U {\n    fn d();\n    fn e() {\n        \"fn f() {\";\n    }\n}\n";
        let source = Source {
            path: "x.rs".to_owned(),
            text: text.to_owned(),
        };
        let found: Vec<_> = all(&source)
            .expect("good code")
            .into_iter()
            .map(|f| format!("{} {}", f.last_line - f.first_line + 1, f.place))
            .collect();
        assert_eq!(
            found,
            ["1 x.rs:2 a", "6 x.rs:4 b", "2 x.rs:7 c", "3 x.rs:13 e"]
        );
    }
}
