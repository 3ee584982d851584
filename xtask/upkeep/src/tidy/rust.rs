//! Measures Rust files, and finds names that break the house style.
//!
//! A short function with dense lines is harder to read than a longer plain one, so the number of
//! tokens is limited, too.

use super::{Findings, Length, files::SourceFile, lines_of};
use anyhow::{Result, anyhow};
use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};
use std::collections::BTreeSet;
use syn::{
    Block, FnArg, Pat, Signature, Visibility,
    visit::{self, Visit},
};

/// Least number of lines of code for which density is measured.
const LINES_FOR_DENSITY: usize = 30;

/// Adds a file's sizes, type names and faults.
pub(super) fn examine(source: &SourceFile, out: &mut Findings) -> Result<()> {
    let SourceFile { path, text } = source;
    let fault = |e: syn::Error| anyhow!("{path}:{}: {e}", e.span().start().line);
    let file = syn::parse_file(text).map_err(fault)?;
    let stream: TokenStream = text.parse().map_err(|e| anyhow!("{path}: {e}"))?;
    let mut tokens = Vec::new();
    collect(stream, &mut tokens);
    let lines: BTreeSet<usize> = tokens.iter().copied().collect();
    out.lengths[2].push(lines_of(source));
    if lines.len() >= LINES_FOR_DENSITY {
        out.lengths[3].push(Length {
            size: (tokens.len() as f64 / lines.len() as f64).round() as usize,
            place: path.clone(),
        });
    }
    Visitor { path, tokens, out }.visit_file(&file);
    Ok(())
}

/// Collects the lines of all tokens in order, except doc comments.
fn collect(stream: TokenStream, lines: &mut Vec<usize>) {
    let is_punct = |tree: &TokenTree, wanted: char| matches!(tree, TokenTree::Punct(punct) if punct.as_char() == wanted);
    let mut trees = stream.into_iter().peekable();
    while let Some(tree) = trees.next() {
        if is_punct(&tree, '#') {
            let inner = trees.next_if(|tree| is_punct(tree, '!'));
            if trees.next_if(is_doc).is_none() {
                let tokens = [Some(tree), inner].into_iter().flatten();
                lines.extend(tokens.map(|token| token.span().start().line));
            }
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

/// Reports whether a group is the part of a doc comment after `#`: `[doc = ".."]`.
fn is_doc(tree: &TokenTree) -> bool {
    let TokenTree::Group(group) = tree else {
        return false;
    };
    let first = group.stream().into_iter().next();
    group.delimiter() == Delimiter::Bracket
        && matches!(first, Some(TokenTree::Ident(ident)) if ident == "doc")
}

struct Visitor<'a> {
    path: &'a str,
    /// Lines of all tokens.
    tokens: Vec<usize>,
    out: &'a mut Findings,
}

impl Visitor<'_> {
    fn add_function(&mut self, signature: &Signature, block: &Block) {
        let first = signature.fn_token.span.start().line;
        let last = block.brace_token.span.close().start().line;
        let start = self.tokens.partition_point(|&line| line < first);
        let end = self.tokens.partition_point(|&line| line <= last);
        for (kind, size) in [end - start, last - first + 1].into_iter().enumerate() {
            self.out.lengths[kind].push(Length {
                size,
                place: format!("{}:{first} {}", self.path, signature.ident),
            });
        }
    }

    fn add_type(&mut self, visibility: &Visibility, name: &Ident) {
        if matches!(visibility, Visibility::Public(_)) {
            let place = format!("{}:{}", self.path, name.span().start().line);
            let places = self.out.types.entry(name.to_string());
            places.or_default().push(place);
        }
    }
}

impl<'ast> Visit<'ast> for Visitor<'_> {
    fn visit_item_fn(&mut self, f: &'ast syn::ItemFn) {
        self.add_function(&f.sig, &f.block);
        visit::visit_item_fn(self, f);
    }

    fn visit_impl_item_fn(&mut self, f: &'ast syn::ImplItemFn) {
        self.add_function(&f.sig, &f.block);
        visit::visit_impl_item_fn(self, f);
    }

    fn visit_trait_item_fn(&mut self, f: &'ast syn::TraitItemFn) {
        if let Some(block) = &f.default {
            self.add_function(&f.sig, block);
        }
        visit::visit_trait_item_fn(self, f);
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.add_type(&item.vis, &item.ident);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.add_type(&item.vis, &item.ident);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.add_type(&item.vis, &item.ident);
        visit::visit_item_trait(self, item);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.add_type(&item.vis, &item.ident);
    }

    fn visit_signature(&mut self, signature: &'ast Signature) {
        for input in &signature.inputs {
            let FnArg::Typed(typed) = input else { continue };
            if matches!(*typed.pat, Pat::Tuple(_) | Pat::Slice(_)) {
                let name = &signature.ident;
                let place = format!("{}:{}", self.path, name.span().start().line);
                self.out.faults.push(format!(
                    "{place}: `{name}` destructures a parameter; use plain parameters or a struct"
                ));
            }
        }
    }
}
