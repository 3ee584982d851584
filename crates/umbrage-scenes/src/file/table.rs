//! Tables of a scene file, with the positions of their values.

use crate::{
    SceneError,
    error::Place,
    nearest::{list_words, nearest},
};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use umbrage_core::Invalid;

/// The file's name and text.
#[derive(Clone, Debug)]
pub(super) struct TextSource<'a> {
    pub(super) file: String,
    pub(super) text: &'a str,
}

impl TextSource<'_> {
    /// Returns an error at a range of bytes.
    pub(super) fn fault(
        &self,
        at: Range<usize>,
        key: Option<&str>,
        why: &str,
        help: &str,
    ) -> SceneError {
        SceneError::Fault {
            place: self.place(at, key),
            why: why.to_owned(),
            help: help.to_owned(),
        }
    }

    pub(super) fn place(&self, at: Range<usize>, key: Option<&str>) -> Place {
        let before = &self.text.as_bytes()[..at.start.min(self.text.len())];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        Place {
            file: self.file.clone(),
            line: Some(line),
            key: key.map(str::to_owned),
        }
    }
}

/// A table, with its name for error messages.
#[derive(Clone, Debug)]
pub(super) struct Table<'a> {
    pub(super) source: &'a TextSource<'a>,
    /// Name such as `light`. Empty for the file itself.
    name: &'static str,
    entries: &'a DeTable<'a>,
    span: Range<usize>,
}

/// A key's value.
#[derive(Clone, Debug)]
pub(super) struct Item<'a> {
    source: &'a TextSource<'a>,
    /// Key with its table: `light.radius`.
    pub(super) key: String,
    pub(super) value: &'a DeValue<'a>,
    pub(super) span: Range<usize>,
}

impl<'a> Table<'a> {
    pub(super) fn root(source: &'a TextSource<'a>, document: &'a Spanned<DeTable<'a>>) -> Self {
        Self {
            source,
            name: "",
            entries: document.get_ref(),
            span: 0..0,
        }
    }

    /// Returns an error if the table has keys that are not `known`.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), SceneError> {
        // Report the first in the file, not in alphabetical order.
        let unknown = self
            .entries
            .keys()
            .filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else {
            return Ok(());
        };
        let name = key.get_ref();
        let near = nearest(name, known.iter().copied());
        let help = match near.is_empty() {
            true => format!("use {}", list_words(known)),
            false => format!("did you mean {}?", list_words(&near)),
        };
        Err(self.source.fault(
            key.span(),
            Some(&self.path(name)),
            "is not a known key here",
            &help,
        ))
    }

    fn path(&self, key: &str) -> String {
        if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        }
    }

    pub(super) fn get(&self, key: &str) -> Option<Item<'a>> {
        let value = self.entries.get(key)?;
        Some(Item {
            source: self.source,
            key: self.path(key),
            value: value.get_ref(),
            span: value.span(),
        })
    }

    /// Returns the value of a required key. `example` shows how to write it.
    pub(super) fn need(&self, key: &str, example: &str) -> Result<Item<'a>, SceneError> {
        self.get(key).ok_or_else(|| {
            let path = self.path(key);
            let help = format!("add `{key} = {example}`");
            self.source
                .fault(self.span.clone(), Some(&path), "is missing", &help)
        })
    }

    /// Returns an error about the table as a whole unless `holds`.
    pub(super) fn require(&self, holds: bool, why: &str, help: &str) -> Result<(), SceneError> {
        if holds {
            Ok(())
        } else {
            Err(self.fault(why, help))
        }
    }

    /// Returns an error about the table as a whole.
    pub(super) fn fault(&self, why: &str, help: &str) -> SceneError {
        let name = (!self.name.is_empty()).then_some(self.name);
        self.source.fault(self.span.clone(), name, why, help)
    }

    /// Adds the position of this table to an error of core's.
    pub(super) fn check<T>(&self, checked: Result<T, Invalid>) -> Result<T, SceneError> {
        checked.map_err(|e| self.fault(&format!("{} {}", e.what, e.why), &e.help))
    }

    /// Returns the table under a key: `[name]`.
    pub(super) fn table(&self, name: &'static str) -> Result<Option<Self>, SceneError> {
        let Some(item) = self.get(name) else {
            return Ok(None);
        };
        match item.value {
            DeValue::Table(entries) => Ok(Some(Self {
                source: self.source,
                name,
                entries,
                span: item.span,
            })),
            DeValue::Array(_) => Err(item.fault(
                "is a list, but there is only one",
                &format!("write [{name}]"),
            )),
            _ => Err(item.wrong_type("a table", &format!("write [{name}]"))),
        }
    }

    /// Returns the tables under a key: `[[name]]`.
    pub(super) fn tables(&self, name: &'static str) -> Result<Vec<Self>, SceneError> {
        let Some(item) = self.get(name) else {
            return Ok(Vec::new());
        };
        let help = format!("write [[{name}]]");
        let DeValue::Array(array) = item.value else {
            return Err(item.wrong_type("a list of tables", &help));
        };
        let mut tables = Vec::with_capacity(array.len());
        for value in array {
            let DeValue::Table(entries) = value.get_ref() else {
                return Err(item.wrong_type("a list of tables", &help));
            };
            tables.push(Self {
                source: self.source,
                name,
                entries,
                span: value.span(),
            });
        }
        Ok(tables)
    }
}

impl<'a> Item<'a> {
    pub(super) fn fault(&self, why: &str, help: &str) -> SceneError {
        self.source
            .fault(self.span.clone(), Some(&self.key), why, help)
    }

    pub(super) fn place(&self) -> Place {
        self.source.place(self.span.clone(), Some(&self.key))
    }

    pub(super) fn wrong_type(&self, wanted: &str, help: &str) -> SceneError {
        let found = self.value.type_str();
        let article = if found.starts_with(['a', 'i']) {
            "an"
        } else {
            "a"
        };
        self.fault(&format!("is {article} {found}, not {wanted}"), help)
    }

    pub(super) fn require(&self, holds: bool, why: &str, help: &str) -> Result<(), SceneError> {
        if holds {
            Ok(())
        } else {
            Err(self.fault(why, help))
        }
    }

    /// Adds the position of this value to an error of core's.
    pub(super) fn check<T>(&self, checked: Result<T, Invalid>) -> Result<T, SceneError> {
        checked.map_err(|e| self.fault(&e.why, &e.help))
    }

    pub(super) fn text(&self) -> Result<&'a str, SceneError> {
        self.value
            .as_str()
            .ok_or_else(|| self.wrong_type("text", "put it in quotes"))
    }

    pub(super) fn flag(&self) -> Result<bool, SceneError> {
        self.value
            .as_bool()
            .ok_or_else(|| self.wrong_type("true or false", "write true or false"))
    }

    /// Reads one of these words.
    pub(super) fn word(&self, known: &[&str]) -> Result<&'a str, SceneError> {
        let word = self.text()?;
        if known.contains(&word) {
            return Ok(word);
        }
        Err(self.fault(
            &format!("is \"{word}\""),
            &format!("use {}", list_words(known)),
        ))
    }

    /// Reads the values of a list of `n`.
    pub(super) fn list(&self, n: usize, example: &str) -> Result<Vec<Item<'a>>, SceneError> {
        let help = format!("write {example}");
        let array = self
            .value
            .as_array()
            .ok_or_else(|| self.wrong_type(&format!("a list of {n}"), &help))?;
        self.require(
            array.len() == n,
            &format!("has {} entries, not {n}", array.len()),
            &help,
        )?;
        let mut items = Vec::with_capacity(n);
        for value in array {
            items.push(Item {
                source: self.source,
                key: self.key.clone(),
                value: value.get_ref(),
                span: value.span(),
            });
        }
        Ok(items)
    }
}
