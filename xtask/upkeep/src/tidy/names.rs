//! One public type name means one thing in the whole workspace; parameters are plain names.

use super::files::Source;
use std::collections::BTreeMap;
use syn::{
    FnArg, Ident, Pat, Signature, Visibility,
    visit::{self, Visit},
};

/// Returns every public type name that several places define, and every parameter that is a pattern of an array or a tuple.
pub(super) fn faults(sources: &[Source]) -> Vec<String> {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut out = Vec::new();
    for source in sources.iter().filter(|source| source.extension() == "rs") {
        // A file that doesn't parse has been refused by then.
        let Ok(file) = syn::parse_file(&source.text) else {
            continue;
        };
        let mut found = Found {
            path: &source.path,
            types: Vec::new(),
            patterns: Vec::new(),
        };
        found.visit_file(&file);
        out.append(&mut found.patterns);
        for (name, place) in found.types {
            places.entry(name).or_default().push(place);
        }
    }
    for (name, places) in places.iter().filter(|(_, places)| places.len() > 1) {
        out.push(format!(
            "{}: the type name `{name}` is defined here, too: {}; one name means one thing",
            places[0],
            places[1..].join(", ")
        ));
    }
    out
}

struct Found<'a> {
    path: &'a str,
    /// Public type names, and where they stand.
    types: Vec<(String, String)>,
    patterns: Vec<String>,
}

impl Found<'_> {
    fn add_type(&mut self, visibility: &Visibility, name: &Ident) {
        if matches!(visibility, Visibility::Public(_)) {
            let line = name.span().start().line;
            let place = format!("{}:{line}", self.path);
            self.types.push((name.to_string(), place));
        }
    }
}

impl<'ast> Visit<'ast> for Found<'_> {
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
                let line = signature.ident.span().start().line;
                self.patterns.push(format!(
                    "{}:{line}: `{}` takes a parameter apart; give it plain parameters, or a struct",
                    self.path, signature.ident
                ));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Source, faults};

    fn count(texts: &[&str]) -> usize {
        let sources: Vec<Source> = (0..)
            .zip(texts)
            .map(|(i, text)| Source {
                path: format!("{i}.rs"),
                text: (*text).to_owned(),
            })
            .collect();
        faults(&sources).len()
    }

    #[test]
    fn a_name_may_be_defined_once() {
        assert_eq!(count(&["pub struct A;", "pub enum B {}", "struct A;"]), 0);
        assert_eq!(count(&["pub struct A;", "pub enum A {}"]), 1);
        assert_eq!(count(&["pub trait A {} pub mod m { pub type A = u8; }"]), 1);
    }

    #[test]
    fn parameters_are_names() {
        assert_eq!(count(&["fn f(a: [u8; 2], S { x }: S) {}"]), 0);
        assert_eq!(count(&["fn f([a, b]: [u8; 2]) {}"]), 1);
        assert_eq!(
            count(&["impl T { fn f((a, b): (u8, u8), [c]: [u8; 1]) {} }"]),
            2
        );
    }
}
